//! Exported files, read back by the glTF specification and compared with the runtime.

mod dressed;
mod into;
mod levels;
mod moving;
mod plays;
mod rig;
mod scene;
mod spaces;
mod usd;
mod validator;
mod views;

use models::shared;
use nalgebra::Vector3;
use sinew_runtime::envelope::Predictor;
use sinew_runtime::{Envelope, Matrix3x4, Model, Skin};
use sinew_trainer::Error;
use sinew_trainer::envelope::levels::Level;
use sinew_trainer::envelope::s3::ProxyCount;
use sinew_trainer::envelope::{Options, Predict, train};
use sinew_trainer::examples::demo::{DemoOptions, demo};
use sinew_trainer::examples::{Clip, Examples, npz};
use sinew_trainer::export::{Export, Exported, Placement, Playback};
use sinew_trainer::formats::appearance::Appearance;
use sinew_trainer::progress::Silent;

fn set(file: &str) -> Option<Examples> {
    shared(file).map(|path| npz::load(&path).unwrap().examples)
}

fn arm(vertices: usize) -> Examples {
    demo(&DemoOptions { vertices, poses: 30, held_out: 10, seed: 4 })
}

fn model(examples: &Examples, predictor: Predictor, proxies: usize, influences: usize) -> Vec<u8> {
    let predictor = Predict::Only(predictor);
    let proxies = Some(ProxyCount::Fixed(proxies));
    let options = Options { predictor, proxies, influences, ..Options::default() };
    train(examples, &options, &Silent).unwrap().model
}

/// Exports a model without materials.
fn export(
    model: &[u8],
    skin: Option<&str>,
    examples: &Examples,
    clips: &[Clip],
    levels: &[Level],
    placement: Placement,
) -> Result<Exported, Error> {
    let appearance = &Appearance::default();
    let playback = Playback { model, skin, examples, clips, between: false, levels };
    Export { playback, appearance, placement }.run()
}

fn clip(name: &str, first: usize, len: usize) -> Clip {
    let times = (0..len).map(|frame| frame as f64 / 30.0).collect();
    Clip { name: name.to_owned(), first, times, numbers: None }
}

/// Keeps some of the frames.
fn only(examples: &Examples, frames: impl Iterator<Item = usize>) -> Examples {
    let frames: Vec<usize> = frames.collect();
    Examples {
        vertices: frames.iter().flat_map(|&f| examples.frame(f)).copied().collect(),
        transforms: frames.iter().flat_map(|&f| examples.pose(f)).copied().collect(),
        curves: frames.iter().flat_map(|&f| examples.curves_of(f)).copied().collect(),
        split: frames.iter().map(|&f| examples.split[f]).collect(),
        ..examples.clone()
    }
}

/// Transforms of the joints, and values of the curves; both may be none.
struct Pose {
    joints: Vec<Matrix3x4>,
    curves: Vec<f32>,
}

fn pose(examples: &Examples, frame: usize) -> Pose {
    let joints = examples.pose(frame).iter().map(|m| m.map(|row| row.map(|x| x as f32)));
    Pose {
        joints: joints.filter(|_| !examples.skeleton.is_still).collect(),
        curves: examples.curves_of(frame).iter().map(|&x| x as f32).collect(),
    }
}

/// Returns the runtime's palette of a pose.
fn runtime_palette(envelope: &Envelope<'_>, pose: &Pose) -> Vec<Matrix3x4> {
    let mut scratch = vec![0.0; envelope.scratch_len()];
    let mut palette = vec![Matrix3x4::default(); envelope.palette_len()];
    envelope.palette(&pose.joints, &pose.curves, &mut scratch, &mut palette).unwrap();
    palette
}

/// Skins a pose with the runtime.
fn runtime_skin(model: &Model<&[u8]>, pose: &Pose) -> Vec<Vector3<f64>> {
    let (envelope, skin) = (model.first::<Envelope>().unwrap(), model.first::<Skin>().unwrap());
    let mut positions = vec![[0.0; 3]; skin.vertex_len()];
    skin.skin_positions(&runtime_palette(&envelope, pose), &mut positions).unwrap();
    positions.into_iter().map(|x| x.map(f64::from).into()).collect()
}

fn distances<'a>(
    a: &'a [Vector3<f64>],
    b: &'a [Vector3<f64>],
) -> impl Iterator<Item = f64> + use<'a> {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).norm())
}

fn farthest(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    distances(a, b).fold(0.0, f64::max)
}

fn vectors(positions: &[[f64; 3]]) -> Vec<Vector3<f64>> {
    positions.iter().map(|x| Vector3::from(*x)).collect()
}
