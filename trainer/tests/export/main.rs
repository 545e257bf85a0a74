//! Exported files, read back by the glTF specification and held against the runtime.
#![allow(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod scene;

use nalgebra::{Matrix4, Vector3};
use scene::Scene;
use sinew_runtime::format::Predictor;
use sinew_runtime::{Envelope, Matrix3x4, Model};
use sinew_trainer::demo::{DemoOptions, demo};
use sinew_trainer::envelope::rotational::proxies::ProxyCount;
use sinew_trainer::envelope::{Options, Predict, train};
use sinew_trainer::examples::{Clip, Examples, npz};
use sinew_trainer::export::export;
use sinew_trainer::progress::Silent;
use std::path::Path;

/// Greatest distance of the exported skin from the runtime's, as a share of the rest diagonal.
const NEAR: f64 = 1e-4;

/// Loads a set; none where there is no shared data, which continuous integration must have.
fn set(file: &str) -> Option<Examples> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data").join(file);
    if path.exists() {
        return Some(npz::load(&path).unwrap().examples);
    }
    assert!(std::env::var_os("CI").is_none(), "{file} must be in ../shared/data");
    eprintln!("{file} is not in ../shared/data: not tested");
    None
}

fn arm() -> Examples {
    demo(&DemoOptions { vertices: 400, poses: 30, held_out: 10, seed: 4 })
}

fn model(examples: &Examples, predictor: Predictor, proxies: usize) -> Vec<u8> {
    let proxies = Some(ProxyCount::Fixed(proxies));
    let options = Options { predictor: Predict::Only(predictor), proxies, ..Options::default() };
    train(examples, &options, &Silent).unwrap().model
}

fn clip(name: &str, first: usize, len: usize) -> Clip {
    let times = (0..len).map(|frame| frame as f64 / 30.0).collect();
    Clip { name: name.to_owned(), first, times }
}

/// Skins a pose by the runtime.
fn runtime_skin(envelope: &Envelope<'_>, pose: &[Matrix3x4]) -> Vec<Vector3<f64>> {
    let mut workspace = vec![0.0; envelope.workspace_len()];
    let mut palette = vec![Matrix3x4::default(); envelope.palette_len()];
    envelope.palette(pose, &mut workspace, &mut palette).unwrap();
    let mut positions = vec![[0.0; 3]; envelope.vertex_len()];
    envelope.skin_positions(&palette, &mut positions).unwrap();
    positions.into_iter().map(|x| x.map(f64::from).into()).collect()
}

fn pose(examples: &Examples, frame: usize) -> Vec<Matrix3x4> {
    examples.pose(frame).iter().map(|m| m.map(|row| row.map(|x| x as f32))).collect()
}

fn farthest(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

/// Greatest distances from the runtime, in shares of the diagonal: at the keys and half way
/// between them, where the runtime is asked for the pose that the file's own joints take.
fn distances(examples: &Examples, model: &[u8], clips: &[Clip]) -> [f64; 2] {
    let scene = Scene::read(&export(model, examples, clips, &[]).unwrap().glb);
    let envelope = Model::from_bytes(model).unwrap().envelope().unwrap();
    assert_eq!(scene.gltf.animations().len(), clips.len());
    let at_rest = scene.palette(&scene.worlds(None));
    let rest: Vec<_> = examples.rest.iter().map(|x| Vector3::from(*x)).collect();
    assert!(
        farthest(&scene.skinned(envelope.name(), &at_rest), &rest) < 1e-6 * examples.diagonal()
    );
    let names = &examples.skeleton.names;
    let joints: Vec<usize> = names.iter().map(|name| scene.node(name)).collect();
    let binds: Vec<Matrix4<f64>> = scene.worlds(None);
    let [mut at_keys, mut between] = [0.0, 0.0];
    for (animation, clip) in clips.iter().enumerate() {
        let times = scene.times(animation);
        assert_eq!(times, clip.times.iter().map(|&time| time as f32).collect::<Vec<_>>());
        for key in 0..times.len() {
            let skin = scene.palette(&scene.worlds(Some((animation, key, 0.0))));
            let found = scene.skinned(envelope.name(), &skin);
            let expected = runtime_skin(&envelope, &pose(examples, clip.first + key));
            at_keys = f64::max(at_keys, farthest(&found, &expected));
            if key + 1 < times.len() {
                let worlds = scene.worlds(Some((animation, key, 0.5)));
                let halfway: Vec<Matrix3x4> = joints
                    .iter()
                    .map(|&node| worlds[node] * binds[node].try_inverse().unwrap())
                    .map(|m| [0, 1, 2].map(|r| [0, 1, 2, 3].map(|c| m[(r, c)] as f32)))
                    .collect();
                let found = scene.skinned(envelope.name(), &scene.palette(&worlds));
                let expected = runtime_skin(&envelope, &halfway);
                between = f64::max(between, farthest(&found, &expected));
            }
        }
    }
    [at_keys, between].map(|distance| distance / examples.diagonal())
}

#[test]
fn the_demo_plays_as_the_runtime_skins_it_by_every_predictor() {
    let examples = arm();
    for predictor in Predictor::ALL {
        let model = model(&examples, predictor, 8);
        let clips = [clip("first", 0, 12), clip("second", 12, 28)];
        let [at_keys, between] = distances(&examples, &model, &clips);
        println!("demo {predictor:?}: at keys {at_keys:.1e}, half way {between:.1e}");
        assert!(at_keys < NEAR, "{predictor:?}: {at_keys}");
    }
}

#[test]
fn mpfb_arm_plays_as_the_runtime_skins_it_by_every_predictor() {
    let Some(examples) = set("mpfb-arm/mpfb_arm.npz") else { return };
    for predictor in Predictor::ALL {
        let model = model(&examples, predictor, 20);
        let [at_keys, between] =
            distances(&examples, &model, &[clip("all", 0, examples.frame_len())]);
        println!("mpfb-arm {predictor:?}: at keys {at_keys:.1e}, half way {between:.1e}");
        assert!(at_keys < NEAR, "{predictor:?}: {at_keys}");
    }
}

#[test]
fn mpfb_body_plays_as_the_runtime_skins_it() {
    let Some(examples) = set("mpfb-body/mpfb_body.npz") else { return };
    for predictor in Predictor::ALL {
        let model = model(&examples, predictor, 60);
        let [at_keys, between] =
            distances(&examples, &model, &[clip("all", 0, examples.frame_len())]);
        println!("mpfb-body {predictor:?}: at keys {at_keys:.1e}, half way {between:.1e}");
        assert!(at_keys < NEAR, "{predictor:?}: {at_keys}");
    }
}
