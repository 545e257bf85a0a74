//! An exported file plays the skin that the runtime computes.

use super::scene::Scene;
use super::{arm, clip, export, farthest, model, only, pose, runtime_skin, set, vectors};
use nalgebra::{Matrix4, Vector3};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::{Model, Skin};
use sinew_trainer::envelope::s3::ProxyCount;
use sinew_trainer::envelope::{Options, Predict, train};
use sinew_trainer::examples::{Clip, Examples};
use sinew_trainer::export::Placement;
use sinew_trainer::progress::Silent;

/// Largest distance of the exported skin from the runtime's, as a share of the rest diagonal.
/// Rounding of nodes and matrices takes less than 1 % of it.
pub(super) const NEAR: f64 = 1e-4;

/// A model's file, and the examples to compare with.
pub(super) struct Played<'a> {
    examples: &'a Examples,
    model: Vec<u8>,
    clips: &'a [Clip],
    pub(super) scene: Scene,
}

impl<'a> Played<'a> {
    pub(super) fn new(examples: &'a Examples, model: Vec<u8>, clips: &'a [Clip]) -> Self {
        let scene = Scene::read(
            &export(&model, None, examples, clips, &[], Placement::AsModel).unwrap().glb,
        );
        let played = Self { examples, model, clips, scene };
        assert_eq!(played.scene.gltf.animations().len(), clips.len());
        let rest = played.skinned(&played.scene.worlds(None));
        let expected = examples.surface().copied(&vectors(&examples.rest));
        assert!(farthest(&rest, &expected) < 1e-6 * examples.diagonal());
        played
    }

    pub(super) fn loaded(&self) -> Model<&[u8]> {
        Model::from_bytes(self.model.as_slice()).unwrap()
    }

    fn skinned(&self, worlds: &[Matrix4<f64>]) -> Vec<Vector3<f64>> {
        self.scene
            .skinned(self.loaded().first::<Skin>().unwrap().name(), &self.scene.palette(worlds))
    }

    /// Returns the largest distance from the runtime's skin at the keys, as a share of the
    /// diagonal.
    pub(super) fn off_at_keys(&self) -> f64 {
        let mut most: f64 = 0.0;
        for (animation, clip) in self.clips.iter().enumerate() {
            let times: Vec<_> = clip.times.iter().map(|&time| time as f32).collect();
            assert_eq!(self.scene.times(animation), times);
            for key in 0..times.len() {
                let found = self.skinned(&self.scene.worlds(Some((animation, key, 0.0))));
                let pose = pose(self.examples, clip.first + key);
                most = most.max(farthest(&found, &runtime_skin(&self.loaded(), &pose)));
            }
        }
        most / self.examples.diagonal()
    }

    /// Returns the largest distance half way between keys. The runtime evaluates the pose of the
    /// file's joints there.
    pub(super) fn off_between_keys(&self) -> f64 {
        let mut most: f64 = 0.0;
        for (animation, clip) in self.clips.iter().enumerate() {
            for key in 1..clip.times.len() {
                let worlds = self.scene.worlds(Some((animation, key - 1, 0.5)));
                let pose = self.scene.pose(&self.examples.skeleton.names, &worlds);
                let expected = runtime_skin(&self.loaded(), &pose);
                most = most.max(farthest(&self.skinned(&worlds), &expected));
            }
        }
        most / self.examples.diagonal()
    }
}

#[track_caller]
fn check(name: &str, examples: &Examples, predictor: Predictor, proxies: usize, clips: &[Clip]) {
    let off = Played::new(examples, model(examples, predictor, proxies, 4), clips).off_at_keys();
    println!("{name}, {}: off by {off:.1e} of the diagonal", predictor.name());
    assert!(off < NEAR, "{name}, {}: {off}", predictor.name());
}

#[test]
fn the_demo_by_every_predictor_and_in_two_clips() {
    let examples = arm(400);
    for predictor in Predictor::ALL {
        check("demo", &examples, predictor, 8, &[clip("a", 0, 12), clip("b", 12, 28)]);
    }
}

#[test]
fn mpfb_arm_by_every_predictor() {
    let Some(examples) = set("mpfb-arm/mpfb_arm.npz") else { return };
    let examples = only(&examples, (0..examples.frame_len()).step_by(3));
    for predictor in Predictor::ALL {
        check("mpfb-arm", &examples, predictor, 20, &[clip("all", 0, examples.frame_len())]);
    }
}

/// Successive frames are unrelated. Half way between them the skin must still hang together:
/// proxies detached from their joints would tear it.
#[test]
fn mpfb_body_by_kernel() {
    let Some(examples) = set("mpfb-body/mpfb_body.npz") else { return };
    let examples = only(&examples, (0..examples.frame_len()).step_by(16));
    let clips = [clip("all", 0, examples.frame_len())];
    let played = Played::new(&examples, model(&examples, Predictor::Kernel, 30, 4), &clips);
    let [at_keys, between] = [played.off_at_keys(), played.off_between_keys()];
    println!("mpfb-body, kernel: off by {at_keys:.1e}, half way {between:.1e}");
    assert!(at_keys < NEAR && between < 0.03, "{at_keys} {between}");
}

/// A real sequence, whose successive frames are similar, as in a clip.
#[test]
fn half_way_between_frames_of_a_sequence_the_skin_stays_near() {
    let Some(examples) = set("dem-bones/bone.npz") else { return };
    let examples = only(&examples, 0..100);
    let clips = [clip("all", 0, 100)];
    for predictor in [Predictor::Kernel, Predictor::Rotational] {
        let played = Played::new(&examples, model(&examples, predictor, 12, 4), &clips);
        let [at_keys, between] = [played.off_at_keys(), played.off_between_keys()];
        println!("dem-bones, {}: off by {at_keys:.1e}, half way {between:.1e}", predictor.name());
        assert!(at_keys < NEAR && between < 2e-3, "{}: {at_keys} {between}", predictor.name());
    }
}

/// The model puts every joint under one root; an exported file keeps the original roots.
#[test]
fn a_second_root_hangs_under_no_joint() {
    let mut examples = arm(300);
    examples.skeleton.parents[4] = Some(0);
    examples.skeleton.roots = vec![4];
    let clips = [clip("all", 0, 4)];
    let played = Played::new(&examples, model(&examples, Predictor::Kernel, 6, 4), &clips);
    let nodes = || played.scene.gltf.nodes();
    let under = |joint: usize| {
        let node = played.scene.node(&examples.skeleton.names[joint]);
        let is_parent =
            |other: &gltf::Node<'_>| other.children().any(|child| child.index() == node);
        nodes().find(is_parent).unwrap().name().unwrap().to_owned()
    };
    assert_eq!([under(0), under(4)], ["armature", "armature"]);
    assert_eq!(under(5), examples.skeleton.names[4]);
    assert!(played.off_at_keys() < NEAR);
}

/// More joints than a byte can count, and more influences than one attribute holds.
#[test]
fn wide_palettes_and_many_influences() {
    let examples = arm(300);
    let options = Options {
        predictor: Predict::Only(Predictor::Rotational),
        proxies: Some(ProxyCount::Fixed(260)),
        influences: 7,
        refine: false,
        ..Options::default()
    };
    let model = train(&examples, &options, &Silent).unwrap().model;
    let clips = [clip("all", 0, 4)];
    let played = Played::new(&examples, model, &clips);
    let skin =
        played.loaded().first::<Skin>().map(|skin| (skin.palette_len(), skin.influence_len()));
    assert!(skin.is_some_and(|(palette, influences)| palette > 256 && influences > 4));
    let off = played.off_at_keys();
    assert!(off < NEAR, "{off}");
}

#[test]
fn a_character_that_stands_along_z_is_turned_upright() {
    let examples = arm(300);
    let clips = [clip("all", 0, 3)];
    let model = model(&examples, Predictor::Kernel, 4, 4);
    let skinned = |placement| {
        let scene =
            Scene::read(&export(&model, None, &examples, &clips, &[], placement).unwrap().glb);
        scene.skinned("skin", &scene.palette(&scene.worlds(Some((0, 2, 0.0)))))
    };
    let upright: Vec<_> =
        skinned(Placement::AsModel).iter().map(|x| Vector3::new(x.x, x.z, -x.y)).collect();
    assert!(farthest(&skinned(Placement::Upright), &upright) < 1e-6 * examples.diagonal());
}
