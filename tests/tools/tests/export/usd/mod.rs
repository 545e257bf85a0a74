//! USD, skinned by Pixar's UsdSkel and compared with the runtime.

use super::{arm, farthest, model, only, pose, runtime_skin, set};
use models::shared;
use nalgebra::Vector3;
use serde_json::{Value, json};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::format::{Axis, Space};
use sinew_runtime::{Model, Skin};
use sinew_trainer::examples::{Clip, Examples, Loaded, Skeleton, Source, load};
use sinew_trainer::export::{Export, Exported, Placement, Playback};
use sinew_trainer::formats::appearance::{self, Appearance};
use sinew_trainer::space::SpaceRequest;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Largest distance from the runtime's skin, as a share of the diagonal.
const NEAR: f64 = 1e-4;
const RATE: f64 = 24.0;

/// Returns the Python that has `pxr`; `None` if `cargo xtask test` could not install it.
fn python() -> Option<PathBuf> {
    let python = std::env::var_os("SINEW_USD").expect(
        "SINEW_USD must name a Python with pxr (`pip install usd-core`), as `cargo xtask test --full` \
         arranges",
    );
    if python.is_empty() {
        assert!(std::env::var_os("CI").is_none(), "CI is set, but usd-core does not install here");
        eprintln!("not run: usd-core does not install here");
        return None;
    }
    Some(python.into())
}

/// A file as UsdSkel plays it: its description, and the positions of all meshes, clip by clip and
/// code by code.
struct Skinned {
    said: Value,
    frames: Vec<Vec<Vector3<f64>>>,
}

fn skinned(python: &Path, test: &str, usda: &str, codes: &[f64]) -> Skinned {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("usd-{test}"));
    std::fs::create_dir_all(&folder).unwrap();
    let [file, points] = ["out.usda", "points.f32"].map(|name| folder.join(name));
    std::fs::write(&file, usda).unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/export/usd/skin.py");
    let mut command = Command::new(python);
    command.arg(script).args([&file, &points]).args(codes.iter().map(f64::to_string));
    let output = command.output().unwrap();
    let noted = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && noted.is_empty(), "{noted}");
    let said: Value = serde_json::from_slice(&output.stdout).unwrap();
    let bytes = std::fs::read(points).unwrap();
    std::fs::remove_dir_all(folder).unwrap();
    let floats: Vec<f64> =
        bytes.as_chunks::<4>().0.iter().map(|x| f64::from(f32::from_le_bytes(*x))).collect();
    let all: Vec<_> = floats.as_chunks::<3>().0.iter().map(|x| Vector3::from(*x)).collect();
    let frames = codes.len() * said["clips"].as_array().unwrap().len();
    let frames = all.chunks_exact(all.len() / frames).map(<[_]>::to_vec).collect();
    Skinned { said, frames }
}

/// Asserts that UsdSkel's validators find nothing.
#[track_caller]
fn valid(said: &Value) {
    assert!(said["validators"].as_u64().unwrap() > 20);
    assert_eq!(said["issues"], json!([]));
}

fn clip(name: &str, first: usize, len: usize) -> Clip {
    let times = (0..len).map(|frame| frame as f64 / RATE).collect();
    Clip { name: name.to_owned(), first, times, numbers: None }
}

fn export(
    model: &[u8],
    examples: &Examples,
    clips: &[Clip],
    appearance: &Appearance,
    placement: Placement,
) -> Exported {
    let playback = Playback { model, skin: None, examples, clips, between: false, levels: &[] };
    Export { playback, appearance, placement }.run().unwrap()
}

/// Exports two clips, and compares every frame with the runtime.
#[track_caller]
fn check(test: &str, examples: &Examples, helpers: usize, influences: usize) -> Option<Value> {
    let python = python()?;
    let half = examples.frame_len() / 2;
    let clips = [clip("first clip", 0, half), clip("2nd", half, half)];
    let bytes = model(examples, Predictor::Kernel, helpers, influences);
    let exported = export(&bytes, examples, &clips, &Appearance::default(), Placement::AsModel);
    let codes: Vec<f64> = (0..half).map(|key| key as f64).collect();
    let Skinned { said, frames } = skinned(&python, test, &exported.usda().unwrap(), &codes);
    valid(&said);
    let loaded = Model::from_bytes(&bytes[..]).unwrap();
    let off = frames
        .iter()
        .enumerate()
        .map(|(frame, found)| farthest(found, &runtime_skin(&loaded, &pose(examples, frame))));
    let off = off.fold(0.0, f64::max) / examples.diagonal();
    println!("{test}: off by {off:.1e} of the diagonal");
    assert!(off < NEAR, "{off}");
    assert_eq!(
        (&said["clips"], &said["bound"]),
        (&json!(["first clip", "2nd"]), &json!(["first_clip"]))
    );
    assert_eq!((&said["rate"], &said["range"]), (&json!(RATE), &json!([0.0, half as f64 - 1.0])));
    assert_eq!(said["samples"], json!([codes, codes]));
    let most = loaded.first::<Skin>().unwrap().influence_len();
    assert_eq!(said["meshes"][0]["influences"], json!(most));
    Some(said)
}

#[test]
fn the_demo_is_skinned_by_usd_as_by_the_runtime() {
    let examples = arm(400);
    let Some(said) = check("demo", &examples, 8, 5) else { return };
    let joints = said["joints"].as_array().unwrap();
    assert_eq!(joints.len(), examples.joint_len() + 2 * 8);
    assert!(joints.contains(&json!("proxy_7_axes")));
}

#[test]
fn a_rig_whose_joints_stretch_is_skinned_by_usd_as_by_the_runtime() {
    let Some(examples) = set("stretchy/set.npz") else { return };
    let examples = only(&examples, (0..examples.frame_len()).step_by(5));
    let Some(said) = check("stretchy", &examples, 12, 4) else { return };
    // The root alone is rigid.
    assert_eq!(said["joints"].as_array().unwrap().len(), 19 + 2 * 18 + 2 * 12);
}

#[test]
fn a_face_without_joints_is_skinned_by_usd_and_keeps_its_curves() {
    let Some(mut examples) = set("face-curves/set.npz") else { return };
    examples = only(&examples, 0..60);
    examples.skeleton = Skeleton::still();
    examples.joint_weights = None;
    let Some(said) = check("face-curves", &examples, 12, 8) else { return };
    assert_eq!(said["curves"][1]["names"], json!(examples.curve_names));
    for (key, values) in said["curves"][1]["values"].as_array().unwrap().iter().enumerate() {
        let expected = pose(&examples, 30 + key).curves;
        assert_eq!(*values, json!(expected));
    }
}

/// The space of the file, materials, normals and texture coordinates.
#[test]
fn a_leg_keeps_its_materials_in_the_axes_that_were_asked_for() {
    let (Some(path), Some(python)) = (shared("leg/leg.glb"), python()) else { return };
    let Loaded { examples, clips, .. } = load(&Source::file(&path)).unwrap();
    let bytes = model(&examples, Predictor::Kernel, 4, 4);
    let appearance = appearance::load(&path).unwrap();
    let asked =
        Space { up: Some(Axis::Z), forward: Some(Axis::MinusY), unit: Some(0.01), ..Space::GLTF };
    let placement = Placement::In(SpaceRequest::all_of(&asked));
    let exported = export(&bytes, &examples, &clips[..1], &appearance, placement);
    let code = clips[0].times[3] * 30.0;
    let Skinned { said, frames } = skinned(&python, "leg", &exported.usda().unwrap(), &[code]);
    valid(&said);
    assert_eq!((&said["up"], &said["rate"]), (&json!("Z"), &json!(30.0)));
    assert!((said["metres"].as_f64().unwrap() - 0.01).abs() < 1e-8);
    let loaded = Model::from_bytes(&bytes[..]).unwrap();
    // From y up in metres to z up in centimetres.
    let expected: Vec<_> = runtime_skin(&loaded, &pose(&examples, clips[0].first + 3))
        .iter()
        .map(|x| Vector3::new(x.x, -x.z, x.y) * 100.0)
        .collect();
    assert!(farthest(&frames[0], &expected) < NEAR * 100.0 * examples.diagonal());
    let leg = &said["meshes"][0];
    let count = |material: &str| {
        let number = appearance.materials.iter().position(|m| m["name"] == material);
        appearance.of_triangles.iter().filter(|own| **own == number).count()
    };
    let expected = json!({ "Claw": count("Claw"), "Fur Brown": count("Fur Brown") });
    assert_eq!((&leg["name"], &leg["subsets"]), (&json!("Leg"), &expected));
    let (skin, surface) = (loaded.first::<Skin>().unwrap(), examples.surface());
    let near = |name: &str, vertex: usize, expected: &[f64]| {
        let found = leg[name][vertex].as_array().unwrap().iter().map(|x| x.as_f64().unwrap());
        assert!(found.zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{name} {vertex}");
    };
    for vertex in 0..skin.vertex_len() {
        let normal = skin.rest_normal(vertex).unwrap().map(f64::from);
        near("normals", vertex, &normal);
        near("st", vertex, &surface.uv().unwrap()[vertex]);
    }
}

#[test]
fn a_file_that_is_wrong_is_found_out() {
    let Some(python) = python() else { return };
    let examples = arm(300);
    let bytes = model(&examples, Predictor::Kernel, 4, 4);
    let nothing = Appearance::default();
    let clips = [clip("all", 0, 3)];
    let text = export(&bytes, &examples, &clips, &nothing, Placement::AsModel).usda().unwrap();
    let issues = |text: &str| {
        let Skinned { said, .. } = skinned(&python, "wrong", text, &[0.0]);
        said["issues"].as_array().unwrap().len()
    };
    assert_eq!(issues(&text), 0);
    assert_eq!(issues(&text.replace("    metersPerUnit = 1\n", "")), 1);
}

#[test]
fn a_character_that_stands_along_x_is_refused() {
    let examples = Examples { space: Space::GLTF, ..arm(300) };
    let bytes = model(&examples, Predictor::Kernel, 4, 4);
    let asked =
        SpaceRequest { up: Some(Axis::X), forward: Some(Axis::Z), ..SpaceRequest::default() };
    let clips = [clip("all", 0, 3)];
    let exported = export(&bytes, &examples, &clips, &Appearance::default(), Placement::In(asked));
    let error = exported.usda().unwrap_err().to_string();
    assert!(error.contains("stands along x, and USD has y or z up: give --to-up y or"), "{error}");
}
