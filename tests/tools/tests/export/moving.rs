//! Exports of joints that stretch, and of curves.

use super::into::{Glb, export_into};
use super::plays::{NEAR, Played};
use super::scene::Scene;
use super::validator::valid;
use super::{arm, clip, export, farthest, model, only, pose, runtime_skin, set};
use models::shared;
use serde_json::{Value, json};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::{Envelope, Model, Skin};
use sinew_trainer::examples::{Examples, Loaded, Skeleton, Source, load};
use sinew_trainer::export::{Export, Placement, Playback, by_use, demo_glb};
use sinew_trainer::formats::appearance::Appearance;

/// Some frames of a set, whose meshes are joined.
fn some(file: &str, frames: impl Iterator<Item = usize>) -> Option<Examples> {
    Some(Examples { ranges: Vec::new(), ..only(&set(file)?, frames) })
}

#[test]
fn a_rig_whose_joints_stretch_plays_by_every_predictor() {
    let Some(examples) = some("stretchy/set.npz", 0..35) else { return };
    let clips = [clip("a", 0, 20), clip("b", 20, 15)];
    for predictor in Predictor::ALL {
        let played = Played::new(&examples, model(&examples, predictor, 12, 4), &clips);
        let at_keys = played.off_at_keys();
        println!("stretchy, {}: off by {at_keys:.1e}", predictor.name());
        assert!(at_keys < NEAR, "{}: {at_keys}", predictor.name());
        if predictor == Predictor::Rotational {
            // Its palette has no joints.
            continue;
        }
        let between = played.off_between_keys();
        println!("half way {between:.1e}");
        assert!(between < 2e-3, "{between}");
        for (joint, name) in examples.skeleton.names.iter().enumerate() {
            let strains =
                (0..examples.frame_len()).map(|frame| strain(&examples.pose(frame)[joint]));
            let most = strains.fold(0.0, f64::max);
            let has_chain = played.scene.find(&format!("{name}_axes")).is_some();
            assert!(!(5e-5..=4e-4).contains(&most), "{name}: the set has no joint between, {most}");
            assert_eq!(has_chain, most > 4e-4, "{name}");
        }
    }
}

#[test]
fn joints_that_stretch_in_other_frames_alone_have_no_nodes_for_it() {
    let mut examples = arm(300);
    let bytes = model(&examples, Predictor::Kernel, 4, 4);
    // Joint 1 widens by a fifth in frame 5.
    let at = 5 * examples.joint_len() + 1;
    examples.transforms[at].iter_mut().for_each(|row| row[0] *= 1.2);
    let axes = format!("{}_axes", examples.skeleton.names[1]);
    for (first, stretches) in [(0, false), (4, true)] {
        let clips = [clip("few", first, 3)];
        let exported = export(&bytes, None, &examples, &clips, &[], Placement::AsModel);
        let scene = Scene::read(&exported.unwrap().glb);
        assert_eq!(scene.find(&axes).is_some(), stretches, "from frame {first}");
    }
}

/// Returns the largest entry of LᵀL - I.
fn strain(map: &[[f64; 4]; 3]) -> f64 {
    let product = |a: usize, b: usize| (0..3).map(|r| map[r][a] * map[r][b]).sum::<f64>();
    let off = |(a, b)| f64::abs(product(a, b) - f64::from(u8::from(a == b)));
    [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].map(off).into_iter().fold(0.0, f64::max)
}

/// Between the frames of a scene more keys hold the skin to its bound.
#[test]
fn between_frames_a_stretching_rig_stays_within_the_bound() {
    // Every tenth frame: steps that need keys.
    let Some(examples) = some("stretchy/set.npz", (0..140).step_by(10)) else { return };
    let len = examples.frame_len();
    let bytes = model(&examples, Predictor::Kernel, 12, 4);
    let clips = &[clip("all", 0, len)];
    let off = |between: bool| {
        let (model, examples) = (&bytes[..], &examples);
        let playback = Playback { model, skin: None, examples, clips, between, levels: &[] };
        let appearance = &Appearance::default();
        let exported = Export { playback, appearance, placement: Placement::AsModel }.run();
        let scene = Scene::read(&exported.unwrap().glb);
        let loaded = Model::from_bytes(&bytes[..]).unwrap();
        let name = loaded.first::<Skin>().unwrap().name().to_owned();
        let keys = scene.times(0).len();
        let mut most: f64 = 0.0;
        for key in 1..keys {
            for part in [0.25, 0.5, 0.75] {
                let worlds = scene.worlds(Some((0, key - 1, part)));
                let expected =
                    runtime_skin(&loaded, &scene.pose(&examples.skeleton.names, &worlds));
                let found = scene.skinned(&name, &scene.palette(&worlds));
                most = most.max(farthest(&found, &expected));
            }
        }
        println!("{keys} keys for {len} frames: off by {:.1e}", most / examples.diagonal());
        (keys, most / examples.diagonal())
    };
    let ((few, without), (many, with)) = (off(false), off(true));
    assert!(few == len && many > few && without > 1e-3 && with < 1e-3, "{without} {with}");
}

/// Exports a file's own clip into the file, and returns the largest distance from the runtime's
/// skin in diagonals.
fn off_in_own_file(test: &str, glb: &Glb) -> f64 {
    let file = glb.save(test);
    let Loaded { examples, clips, .. } = load(&Source::file(&file)).unwrap();
    let bytes = model(&examples, Predictor::Kernel, 3, 4);
    let grafted = export_into(&bytes, &examples, &clips, &[], &file).unwrap();
    std::fs::remove_file(file).unwrap();
    valid(test, &grafted.glb);
    let (scene, loaded) = (Scene::read(&grafted.glb), Model::from_bytes(&bytes[..]).unwrap());
    let animation = scene.gltf.animations().len() - 1;
    let mut most: f64 = 0.0;
    for key in 0..clips[0].times.len() {
        let found = scene.posed("tube", &scene.worlds(Some((animation, key, 0.0))));
        most = most.max(farthest(&found, &runtime_skin(&loaded, &pose(&examples, key))));
    }
    most / examples.diagonal()
}

#[test]
fn a_joint_that_is_scaled_by_its_file_plays_in_it() {
    let Some(path) = shared("../cases/gltf/squash_leaf.glb") else { return };
    let mut glb = Glb::read(&std::fs::read(path).unwrap());
    let off = off_in_own_file("squash-leaf", &glb);
    assert!(off < 1e-6, "{off}");
    // Its parent is scaled instead: the leaf, which turns, is sheared in the model and scaled in
    // the file.
    glb.json["animations"][0]["channels"][3]["target"]["node"] = json!(1);
    let off = off_in_own_file("squash-parent", &glb);
    assert!(off < 1e-6, "{off}");
}

#[test]
fn a_joint_that_no_node_of_the_file_can_hold_is_refused() {
    let (mut examples, _) = by_use(arm(300));
    let clips = [clip("all", 0, 3)];
    let file = Glb::read(&demo_glb(&examples, &clips).unwrap());
    let bytes = model(&examples, Predictor::Kernel, 4, 4);
    let file = file.save("sheared");
    // A shear by 0.2 after the motion of joint 1, in frame 1.
    let at = examples.joint_len() + 1;
    let second = examples.transforms[at][1];
    examples.transforms[at][0].iter_mut().zip(second).for_each(|(x, y)| *x += 0.2 * y);
    let refused = export_into(&bytes, &examples, &clips, &[], &file).map(|done| done.animations);
    let exported = export(&bytes, None, &examples, &clips, &[], Placement::AsModel);
    std::fs::remove_file(file).unwrap();
    assert!(exported.is_ok());
    let error = refused.unwrap_err().to_string();
    let name = &examples.skeleton.names[1];
    assert!(error.contains(&format!("joint {name} is sheared relative to its parent")), "{error}");
    assert!(
        error.contains("at 0.033333335 s") && error.contains("export without --into"),
        "{error}"
    );
}

/// Reads the curves in the extras of an animation: their names, the key times, and the values key by key.
fn curves(scene: &Scene, animation: usize) -> (Vec<String>, Vec<f32>, Vec<Vec<f32>>) {
    let extras = scene.gltf.animations().nth(animation).unwrap().extras().clone().unwrap();
    let mut curves: Value = serde_json::from_str(extras.get()).unwrap();
    let mut take = |member: &str| curves["curves"][member].take();
    let names = serde_json::from_value(take("names")).unwrap();
    let times = serde_json::from_value(take("times")).unwrap();
    (names, times, serde_json::from_value(take("values")).unwrap())
}

#[test]
fn curves_are_written_at_the_keys() {
    let Some(examples) = some("curves/set.npz", 0..40) else { return };
    let clips = [clip("a", 0, 12), clip("b", 12, 28)];
    let bytes = model(&examples, Predictor::Kernel, 8, 4);
    let played = Played::new(&examples, bytes, &clips);
    assert!(played.off_at_keys() < NEAR);
    for (number, clip) in clips.iter().enumerate() {
        let (names, times, values) = curves(&played.scene, number);
        assert_eq!(names, examples.curve_names);
        assert_eq!(times, played.scene.times(number));
        let frames = clip.first..clip.first + clip.times.len();
        let expected = frames.map(|frame| pose(&examples, frame).curves);
        assert_eq!(values, expected.collect::<Vec<_>>());
    }
    let plain = arm(300);
    let glb = export(
        &model(&plain, Predictor::Kernel, 4, 4),
        None,
        &plain,
        &clips[..1],
        &[],
        Placement::AsModel,
    );
    assert_eq!(Glb::read(&glb.unwrap().glb).json["animations"][0].get("extras"), None);
}

/// A key between two frames has the curves between those of the frames.
#[test]
fn curves_are_written_at_the_keys_between_frames() {
    let Some(examples) = some("curves/set.npz", (0..140).step_by(10)) else { return };
    let (model, clips) = (&model(&examples, Predictor::Kernel, 8, 4)[..], &[clip("all", 0, 14)]);
    let examples = &examples;
    let playback = Playback { model, skin: None, examples, clips, between: true, levels: &[] };
    let appearance = &Appearance::default();
    let exported = Export { playback, appearance, placement: Placement::AsModel }.run();
    let scene = Scene::read(&exported.unwrap().glb);
    let (_, times, values) = curves(&scene, 0);
    assert_eq!((&times, times.len()), (&scene.times(0), values.len()));
    assert!(times.len() > 14, "{times:?}");
    let frames: Vec<f32> = clips[0].times.iter().map(|&time| time as f32).collect();
    for (time, values) in times.iter().zip(&values) {
        let before = frames.partition_point(|frame| frame <= time) - 1;
        let [from, to] = [before, (before + 1).min(13)].map(|frame| pose(examples, frame).curves);
        let part = (time - frames[before]) * 30.0;
        for ((value, from), to) in values.iter().zip(from).zip(to) {
            assert!((value - from - part * (to - from)).abs() < 1e-4, "{time}: {value}");
        }
    }
}

#[test]
fn curves_are_written_into_an_artist_s_file_too() {
    let Some(examples) = some("curves/set.npz", 0..20) else { return };
    let clips = [clip("a", 0, 12), clip("b", 12, 8)];
    let file = Glb::read(&demo_glb(&examples, &clips).unwrap()).save("curves");
    let bytes = model(&examples, Predictor::Kernel, 8, 4);
    let grafted = export_into(&bytes, &examples, &clips, &[], &file).unwrap();
    std::fs::remove_file(file).unwrap();
    let scene = Scene::read(&grafted.glb);
    for (number, clip) in clips.iter().enumerate() {
        let (names, times, values) = curves(&scene, 2 + number);
        assert_eq!((&names, &times), (&examples.curve_names, &scene.times(2 + number)));
        let frames = clip.first..clip.first + clip.times.len();
        let expected = frames.map(|frame| pose(&examples, frame).curves);
        assert_eq!(values, expected.collect::<Vec<_>>());
    }
}

/// Helpers of a face without joints hang under the armature.
#[test]
fn a_face_without_joints_plays() {
    let Some(mut examples) = some("face-curves/set.npz", 0..60) else { return };
    examples.skeleton = Skeleton::still();
    examples.joint_weights = None;
    let clips = [clip("take", 0, 60)];
    let played = Played::new(&examples, model(&examples, Predictor::Kernel, 12, 8), &clips);
    assert_eq!(played.loaded().first::<Envelope>().unwrap().joint_len(), 0);
    let off = played.off_at_keys();
    println!("face-curves: off by {off:.1e}");
    assert!(off < NEAR, "{off}");
    let armature = played.scene.gltf.nodes().nth(played.scene.node("armature")).unwrap();
    let children: Vec<_> =
        armature.children().map(|node| node.name().unwrap().to_owned()).collect();
    let expected: Vec<_> = (0..13).map(|number| format!("proxy_{number}")).collect();
    assert_eq!(children, expected);
}
