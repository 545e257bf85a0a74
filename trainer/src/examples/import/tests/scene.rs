//! Tests of converting a scene and its targets to examples.

use super::super::curves::SampledCurves;
use super::super::scene;
use super::super::targets::TargetMeshes;
use crate::examples::{Clip, Examples, Loaded, Split, Warning};
use crate::formats::posed_meshes::PosedMeshes;
use crate::formats::scene::{SampledScene, Sampling};
use crate::{Error, ErrorKind};
use nalgebra::{Matrix4, Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew_runtime::format::Space;
use std::path::Path;

pub(super) const FRAMES: usize = 6;
pub(super) const VERTICES: usize = 60;

/// Creates an asymmetric limb along x that bends and bulges at a joint.
pub(super) fn limb() -> (SampledScene, Vec<[f64; 3]>) {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let mut within = |low: f64, high: f64| random.random_range(low..high);
    let rest: Vec<[f64; 3]> =
        (0..VERTICES).map(|_| [within(0.0, 2.0), within(-0.2, 0.3), within(-0.1, 0.2)]).collect();
    let bind = |x| Matrix4::new_translation(&Vector3::new(x, 0.0, 0.0));
    let turn = |frame: usize| {
        let axis = Vector3::new(0.1, 0.4, 1.0) * (0.2 * frame as f64);
        bind(1.0) * Rotation3::new(axis).to_homogeneous()
    };
    let frames: Vec<_> = (0..FRAMES).flat_map(|frame| [bind(0.0), turn(frame)]).collect();
    let posed = (0..FRAMES).flat_map(|frame| {
        let map = turn(frame) * bind(-1.0);
        rest.iter().map(move |&[x, y, z]| {
            let bulge = 1.0 + 0.1 * frame as f64 * (-8.0 * (x - 0.8).powi(2)).exp();
            let point = nalgebra::Point3::new(x, y * bulge, z * bulge);
            if x > 1.0 { map.transform_point(&point).into() } else { point.into() }
        })
    });
    let posed: Vec<[f64; 3]> = posed.collect();
    let times = (0..FRAMES).map(|frame| frame as f64 / 24.0).collect();
    let scene = SampledScene {
        rest,
        triangles: vec![[0, 1, 2]],
        engine: None,
        ranges: Vec::new(),
        joint_weights: None,
        space: Space::default(),
        names: vec!["upper".into(), "lower".into()],
        parents: vec![None, Some(0)],
        binds: vec![bind(0.0), bind(1.0)],
        at_rest: vec![bind(0.0), bind(1.0)],
        frames,
        curves: Vec::new(),
        shapes: None,
        morphs: false,
        clips: vec![Clip { name: "bend".into(), first: 0, times, numbers: None }],
        warnings: Vec::new(),
    };
    (scene, posed)
}

/// Joins a scene without curves.
fn join(
    scene: SampledScene,
    targets: Option<TargetMeshes>,
    sampling: &Sampling<'_>,
) -> Result<Loaded, Error> {
    scene::join(scene, SampledCurves::default(), targets, sampling)
}

const FILE: &str = "limb.pc2";

pub(super) fn targets(vertices: Vec<[f64; 3]>) -> TargetMeshes {
    TargetMeshes::new(Path::new(FILE), PosedMeshes::bare(VERTICES, vertices))
}

/// Checks that an error is about the targets and begins with `words`.
#[track_caller]
fn about_targets(error: &Error, words: &str) {
    assert_eq!(error.file(), Some(Path::new(FILE)), "{error}");
    assert!(error.message().starts_with(words), "{error}");
}

pub(super) const KEYS: Sampling<'_> =
    Sampling { fps: None, clips: &[], shapes: true, still: false, played: false, curves: false };

/// Converts y up to z up, and metres to centimetres.
fn converted([x, y, z]: [f64; 3]) -> [f64; 3] {
    [100.0 * x, -100.0 * z, 100.0 * y]
}

fn farthest(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let differences = a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| (a - b).abs());
    differences.fold(0.0, f64::max)
}

#[test]
fn targets_in_place_stay_as_they_are() {
    let (scene, posed) = limb();
    let Loaded { examples, clips, warnings } =
        join(scene, Some(targets(posed.clone())), &KEYS).unwrap();
    assert_eq!(examples.vertices, posed);
    assert_eq!(warnings, []);
    assert_eq!(clips[0].times.len(), FRAMES);
    assert_eq!(examples.split, [Split::Train; FRAMES]);
}

#[test]
fn targets_in_other_axes_and_units_are_brought_to_the_joints() {
    let (scene, posed) = limb();
    let moved = posed.iter().copied().map(converted).collect();
    let Loaded { examples, warnings, .. } = join(scene, Some(targets(moved)), &KEYS).unwrap();
    assert!(farthest(&examples.vertices, &posed) < 1e-12);
    let how = "(x, z, -y) x 0.01".to_owned();
    assert_eq!(warnings, [Warning::Moved { what: "targets", how }]);
}

/// The rest mesh defines the space: the joints move there and carry the mesh as before.
#[test]
fn joints_are_brought_to_a_rest_mesh() {
    let (scene, posed) = limb();
    let shifted = |x| {
        let [x, y, z] = converted(x);
        [x + 7.0, y, z - 300.0]
    };
    let here = join(limb().0, Some(targets(posed.clone())), &KEYS).unwrap().examples;
    let mut there = targets(posed.iter().copied().map(shifted).collect());
    there.meshes.rest = Some(scene.rest.iter().copied().map(shifted).collect());
    there.meshes.triangles = Some(vec![[2, 1, 0]]);
    there.split = Some(vec![Split::HeldOut; FRAMES]);
    let rest = there.meshes.rest.clone().unwrap();
    let Loaded { examples, warnings, .. } = join(scene, Some(there), &KEYS).unwrap();
    assert_eq!((&examples.rest, &examples.triangles), (&rest, &vec![[2, 1, 0]]));
    assert_eq!(examples.split, [Split::HeldOut; FRAMES]);
    assert!(matches!(&warnings[..], [Warning::Moved { what: "joints", .. }]), "{warnings:?}");
    let carry = |examples: &Examples, x: [f64; 3]| {
        let map = &examples.pose(4)[1];
        let x = [x[0], x[1], x[2], 1.0];
        [0, 1, 2].map(|row| map[row].iter().zip(x).map(|(m, x)| m * x).sum::<f64>())
    };
    for (x, moved) in here.rest.iter().zip(&rest) {
        assert!(farthest(&[carry(&examples, *moved)], &[shifted(carry(&here, *x))]) < 1e-10);
    }
    let origin = examples.skeleton.rest[1].map(|row| row[3]);
    assert!(farthest(&[origin], &[shifted([1.0, 0.0, 0.0])]) < 1e-10);
}

#[test]
fn targets_of_another_character_are_refused() {
    let (scene, posed) = limb();
    let mut random = ChaCha8Rng::seed_from_u64(4);
    let noise = posed.iter().map(|_| [0; 3].map(|_| random.random_range(-1.0..1.0))).collect();
    let error = join(scene, Some(targets(noise)), &KEYS).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Mismatch);
    about_targets(
        &error,
        "its meshes do not lie on the scene's joints in any axes and unit: off by ",
    );

    let (scene, posed) = limb();
    let mut other = targets(posed);
    other.meshes.rest = Some(scene.rest.iter().map(|&[x, y, z]| [x, y, 1.2 * z]).collect());
    let error = join(scene, Some(other), &KEYS).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Mismatch);
    about_targets(
        &error,
        "its meshes do not lie on the scene's joints in any axes and unit: off by ",
    );
}

#[test]
fn wrong_counts_give_advice() {
    let (scene, posed) = limb();
    let error = join(scene, Some(targets(posed[VERTICES..].to_vec())), &KEYS).unwrap_err();
    let words = "holds 5 meshes, the scene's clips have 6 frames (bend: 6): export both";
    about_targets(&error, words);

    let (scene, posed) = limb();
    let mut other = targets(posed);
    other.meshes.vertex_len = VERTICES / 2;
    let error = join(scene, Some(other), &KEYS).unwrap_err();
    about_targets(&error, "holds meshes of 30 vertices, the scene's mesh has 60: export both");
}

/// Cuts the limb's frames into clips of some lengths.
fn cut(scene: &mut SampledScene, lens: &[usize]) {
    let mut first = 0;
    scene.clips = ["bend", "wave", "kick", "rest", "jump", "fall"]
        .into_iter()
        .zip(lens)
        .map(|(name, &len)| {
            let times = (0..len).map(|frame| frame as f64 / 24.0).collect();
            first += len;
            Clip { name: name.into(), first: first - len, times, numbers: None }
        })
        .collect();
}

#[test]
fn targets_that_follow_the_clips_in_another_order_are_sorted() {
    let sorts = |posed: &[[f64; 3]], with_rest: bool| {
        let (mut scene, _) = limb();
        cut(&mut scene, &[2, 1, 3]);
        let frame = |frame: usize| posed[frame * VERTICES..][..VERTICES].to_vec();
        // The last clip's meshes come first, then those of the first clip.
        let mut targets = targets([3, 4, 5, 0, 1, 2].map(frame).concat());
        targets.meshes.rest = with_rest.then(|| scene.rest.clone());
        targets.split = Some([2, 2, 2, 0, 0, 1].map(use_of).to_vec());
        join(scene, Some(targets), &KEYS).unwrap()
    };
    let (_, posed) = limb();
    for with_rest in [false, true] {
        let Loaded { examples, clips, warnings } = sorts(&posed, with_rest);
        assert_eq!(examples.vertices, posed);
        assert_eq!(examples.split, [0, 0, 1, 2, 2, 2].map(use_of));
        assert_eq!(clips.iter().map(|clip| clip.times.len()).collect::<Vec<_>>(), [2, 1, 3]);
        let text = warnings[0].to_string();
        let words =
            "the targets follow the clips in another order, kick, bend, wave, and were sorted";
        assert!(warnings.len() == 1 && text.starts_with(words), "{warnings:?}");
    }
    // The meshes may have other axes and units.
    let Loaded { examples, warnings, .. } =
        sorts(&posed.iter().copied().map(converted).collect::<Vec<_>>(), false);
    assert!(farthest(&examples.vertices, &posed) < 1e-12);
    let how = "(x, z, -y) x 0.01".to_owned();
    assert_eq!(warnings[1..], [Warning::Moved { what: "targets", how }]);
}

#[test]
fn targets_of_all_clips_are_cut_to_the_requested_clips() {
    let (mut scene, posed) = limb();
    cut(&mut scene, &[2, 1, 3]);
    let poses = scene.frames.clone();
    let frame = |frame: usize| posed[frame * VERTICES..][..VERTICES].to_vec();
    // The last clip's meshes come first.
    let mut targets = targets([3, 4, 5, 0, 1, 2].map(frame).concat());
    targets.split = Some([2, 2, 2, 0, 0, 1].map(use_of).to_vec());
    let asked = ["wave".to_owned(), "kick".to_owned()];
    let sampling = Sampling { clips: &asked, ..KEYS };
    let Loaded { examples, clips, warnings } = join(scene, Some(targets), &sampling).unwrap();
    assert_eq!(examples.vertices, posed[2 * VERTICES..]);
    assert_eq!(examples.split, [1, 2, 2, 2].map(use_of));
    let lower = |pose: &[Matrix4<f64>]| pose[1] * Matrix4::new_translation(&-Vector3::x());
    for (frame, pose) in poses.chunks(2).skip(2).enumerate() {
        let found = examples.pose(frame)[1];
        assert!(farthest(&found.map(|[a, b, c, _]| [a, b, c]), &rows3(&lower(pose))) < 1e-12);
    }
    let found: Vec<_> = clips.iter().map(|clip| (clip.name.as_str(), clip.first)).collect();
    assert_eq!(found, [("wave", 0), ("kick", 1)]);
    let told = Warning::TargetsCut { clips: asked.to_vec(), frames: 4, held: 6 };
    assert_eq!(warnings.last(), Some(&told));
}

fn rows3(map: &Matrix4<f64>) -> [[f64; 3]; 3] {
    std::array::from_fn(|row| std::array::from_fn(|column| map[(row, column)]))
}

fn use_of(number: usize) -> Split {
    [Split::Train, Split::HeldOut, Split::Extreme][number]
}

#[test]
fn targets_in_order_stay_and_ambiguous_orders_are_refused() {
    let (mut scene, posed) = limb();
    cut(&mut scene, &[1; 6]);
    let Loaded { examples, warnings, .. } =
        join(scene, Some(targets(posed.clone())), &KEYS).unwrap();
    assert_eq!((examples.vertices, warnings), (posed.clone(), Vec::new()));

    // Two clips with equal motion can be exchanged.
    let frames = [0, 5, 5].map(|frame| posed[frame * VERTICES..][..VERTICES].to_vec());
    let (mut scene, _) = limb();
    let poses = |frame: usize| scene.frames[2 * frame..][..2].to_vec();
    scene.frames = [5, 5, 0].map(poses).concat();
    cut(&mut scene, &[1; 3]);
    let error = join(scene, Some(targets(frames.concat())), &KEYS).unwrap_err();
    let words = "its meshes do not follow the scene's clips in their order, bend, wave, kick, but may in several \
                 others, as kick, ";
    about_targets(&error, words);
}

const ORDER: &str = "its vertices are those of the scene's mesh, but in another order: ";

#[test]
fn vertices_in_another_order_are_refused() {
    let (scene, posed) = limb();
    let reversed =
        |frame: &[[f64; 3]]| frame.iter().rev().copied().map(converted).collect::<Vec<_>>();
    let reversed = posed.chunks(VERTICES).flat_map(reversed).collect();
    let error = join(scene, Some(targets(reversed)), &KEYS).unwrap_err();
    about_targets(&error, ORDER);
}

#[test]
fn positions_that_are_not_finite_are_refused_before_positions_are_compared() {
    let refused = |targets: TargetMeshes| {
        let (mut scene, _) = limb();
        cut(&mut scene, &[3, 3]);
        join(scene, Some(targets), &KEYS).unwrap_err()
    };
    // Spoils most vertices of a frame, so that every sample contains one.
    let spoiled = |frame: usize, number: f64| {
        let (_, mut posed) = limb();
        posed[frame * VERTICES + 7..][..VERTICES - 7].fill([number; 3]);
        posed
    };
    for number in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let expected =
            "its vertices are not finite in frame 4 (wave 1), at vertex 7: export the meshes again";
        let error = refused(targets(spoiled(4, number)));
        assert_eq!(error.message(), expected);
        about_targets(&error, expected);
    }
    let large =
        "its vertices exceed 1e9, the most a model can hold, in frame 0 (bend 0), at vertex 7: ";
    about_targets(&refused(targets(spoiled(0, 1e30))), large);
    let files = (1..=6).map(|number| format!("p{number}.obj")).collect();
    let sequence = TargetMeshes { files, ..targets(spoiled(4, f64::NAN)) };
    let words = "its vertices are not finite in frame 4 (p5.obj), at vertex 7";
    about_targets(&refused(sequence), words);
    let (scene, posed) = limb();
    let mut rest = scene.rest;
    rest[9][1] = f64::NAN;
    let mut with_rest = targets(posed);
    with_rest.meshes.rest = Some(rest);
    about_targets(&refused(with_rest), "its vertices are not finite at rest, at vertex 9");

    // Only training frames are bounded.
    let (scene, _) = limb();
    let mut split = vec![Split::Train; FRAMES];
    split[4] = Split::Extreme;
    let held_out = TargetMeshes { split: Some(split), ..targets(spoiled(4, 1e30)) };
    let error = held_out.check_numbers(&scene.clips);
    assert!(error.is_ok(), "{error:?}");
}

#[test]
fn poses_that_are_not_finite_are_reported_for_the_scene() {
    let (mut scene, posed) = limb();
    // Spoils both joints, so that no joint carries a vertex anywhere.
    scene.frames[2 * 3..][..2].fill(Matrix4::from_element(f64::NAN));
    let error = join(scene, Some(targets(posed)), &KEYS).unwrap_err();
    assert_eq!((error.kind(), error.file()), (ErrorKind::Value, None));
    assert_eq!(error.to_string(), "frame 3: the animated pose is not finite at joint upper");
}

#[test]
fn missing_files_of_a_sequence_are_named_if_they_explain_the_count() {
    for (missing, expected) in [
        (vec!["p3.obj"], "(bend: 6): p3.obj is missing"),
        (vec!["p3.obj", "p7.obj"], "(bend: 6): export both over"),
        (vec![], "(bend: 6): export both over"),
    ] {
        let (scene, posed) = limb();
        let mut targets = targets(posed[VERTICES..].to_vec());
        targets.missing = missing.into_iter().map(str::to_owned).collect();
        let error = join(scene, Some(targets), &KEYS).unwrap_err();
        about_targets(&error, "holds 5 meshes, the scene's clips have 6 frames ");
        assert!(error.message().contains(expected), "{error}");
    }
}

#[test]
fn meshes_at_one_rate_need_keys_at_one_rate() {
    let uneven = || {
        let (mut scene, posed) = limb();
        scene.clips[0].times[5] += 1.0;
        (scene, targets(posed))
    };
    let (scene, posed) = uneven();
    let error = join(scene, Some(posed), &KEYS).unwrap_err();
    assert_eq!(error.file(), None, "the scene has the keys");
    assert!(error.message().contains("clip bend has non-uniform key times"), "{error}");
    assert!(error.message().contains("--fps"), "{error}");
    let (scene, posed) = uneven();
    assert!(
        join(
            scene,
            Some(posed),
            &Sampling {
                fps: Some(24.0),
                clips: &[],
                shapes: true,
                still: false,
                played: false,
                curves: false
            }
        )
        .is_ok()
    );
}

#[test]
fn poses_without_meshes_are_refused() {
    let error = join(limb().0, None, &KEYS).unwrap_err();
    assert_eq!((error.kind(), error.file()), (ErrorKind::Missing, None));
    assert!(error.message().starts_with("holds poses but neither a skin nor shapes: "), "{error}");
}

#[test]
fn an_exploded_frame_does_not_hide_the_order_of_vertices() {
    let (_, posed) = limb();
    let exploded = |mut posed: Vec<[f64; 3]>| {
        let own = posed[VERTICES..2 * VERTICES].iter_mut().flatten().enumerate();
        own.for_each(|(i, x)| *x += 50.0 * (12.9898 * (i * i) as f64).sin());
        posed
    };
    let reversed = |frame: &[[f64; 3]]| frame.iter().rev().copied().collect::<Vec<_>>();
    let reversed = posed.chunks(VERTICES).flat_map(reversed).collect();
    let is_shuffled = |posed| {
        let error = join(limb().0, Some(targets(exploded(posed))), &KEYS).err();
        error.is_some_and(|error| error.message().starts_with(ORDER))
    };
    assert!(is_shuffled(reversed) && !is_shuffled(posed));
}
