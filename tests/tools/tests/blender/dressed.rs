//! Looks, actions and curves of a scene, by the script and by Blender's FBX.

use super::{clip, done, made, of, python};
use serde_json::Value;
use sinew_runtime::envelope::Predictor;
use sinew_trainer::envelope::s3::ProxyCount;
use sinew_trainer::envelope::{Options, Predict, train};
use sinew_trainer::examples::{Curves, Examples, Loaded, Source, load, npz};
use sinew_trainer::export::{Export, Placement, Playback};
use sinew_trainer::formats::appearance;
use sinew_trainer::progress::Silent;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Makes the scene, exports it with more options, and returns the folder and the script's notes.
fn exported(test: &str, more: &[&str]) -> Option<(PathBuf, String)> {
    let python = python()?;
    let folder = made(&python, "dressed", test);
    let output = of(&python, &folder.join("dressed.blend"), &folder.join("dressed.npz"), more);
    let [_, noted] = done(&output);
    Some((folder, noted))
}

/// Trains examples and exports them with the looks of their file; returns the members of the GLB.
fn glb(file: &Path, examples: &Examples, clips: &[sinew_trainer::examples::Clip]) -> Value {
    let options = Options {
        predictor: Predict::Only(Predictor::Kernel),
        proxies: Some(ProxyCount::Fixed(2)),
        ..Options::default()
    };
    let model = train(examples, &options, &Silent).unwrap().model;
    let appearance = &appearance::load(file).unwrap();
    assert_eq!(appearance.missing, [""; 0]);
    let playback =
        Playback { model: &model, skin: None, examples, clips, between: false, levels: &[] };
    let glb = Export { playback, appearance, placement: Placement::AsModel }.run().unwrap().glb;
    let json_len = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&glb[20..20 + json_len]).unwrap()
}

/// Colour or image of each material, and material and triangles of each primitive by mesh.
type Looks = (BTreeMap<String, String>, BTreeMap<String, Vec<(String, u64)>>);

/// Returns the colour or image of each material by name, and the material and triangles of each
/// primitive by mesh.
fn looks(glb: &Value) -> Looks {
    let name = |value: &Value| value["name"].as_str().unwrap().to_owned();
    let surface = |material: &Value| {
        let surface = &material["pbrMetallicRoughness"];
        match surface["baseColorTexture"]["index"].as_u64() {
            Some(texture) => {
                let image = &glb["textures"][texture as usize]["source"];
                name(&glb["images"][image.as_u64().unwrap() as usize])
            }
            None => {
                let colour = surface["baseColorFactor"].as_array().unwrap().iter();
                colour.map(|x| format!("{:.3} ", x.as_f64().unwrap())).collect()
            }
        }
    };
    let materials = glb["materials"].as_array().unwrap();
    let meshes = glb["meshes"].as_array().unwrap().iter().map(|mesh| {
        let primitives = mesh["primitives"].as_array().unwrap().iter().map(|primitive| {
            let material = &materials[primitive["material"].as_u64().unwrap() as usize];
            let accessor = primitive["indices"].as_u64().unwrap() as usize;
            let count = glb["accessors"][accessor]["count"].as_u64().unwrap();
            (name(material), count / 3)
        });
        let mut primitives: Vec<_> = primitives.collect();
        primitives.sort();
        (name(mesh), primitives)
    });
    (materials.iter().map(|own| (name(own), surface(own))).collect(), meshes.collect())
}

#[test]
fn looks_live_through_the_script_as_through_fbx() {
    let Some((folder, _)) = exported("looks", &["--curves", "none"]) else { return };
    let [arrays, scene] = ["dressed.npz", "dressed.fbx"].map(|file| folder.join(file));
    let own = npz::load(&arrays).unwrap();
    let other = load(&Source::file(&scene)).unwrap();
    let found = looks(&glb(&arrays, &own.examples, &own.clips));
    let materials =
        [("Cloth", "0.250 0.500 0.750 1.000 "), ("Eye", "eye.png"), ("Skin", "skin.png")];
    let materials = materials.map(|(name, look)| (name.to_owned(), look.to_owned()));
    assert_eq!(found.0, BTreeMap::from(materials));
    assert_eq!(found, looks(&glb(&scene, &other.examples, &other.clips)));

    // Every corner has the normal that FBX gives it, in other axes and units.
    let same = |x: [f64; 3], _: f64| x;
    let moved = |[x, y, z]: [f64; 3], unit: f64| [x, -z, y].map(|x| unit * x);
    let (own, other) = (corners(&own.examples, same), corners(&other.examples, moved));
    for (all, others) in [(&own, &other), (&other, &own)] {
        for corner in all {
            let is_same =
                |other: &[f64; 6]| corner.iter().zip(other).all(|(a, b)| (a - b).abs() < 1e-4);
            assert!(others.iter().any(is_same), "{corner:?}");
        }
    }
    let normals_at = |at: [f64; 3]| -> Vec<[f64; 3]> {
        let there = own.iter().filter(|x| (0..3).all(|axis| (x[axis] - at[axis]).abs() < 1e-6));
        there.map(|&[.., x, y, z]| [x, y, z]).collect()
    };
    // The waist is hard: its vertices have one normal above and another below.
    let mut up: Vec<f64> = normals_at([0.2, 0.0, 1.0]).iter().map(|normal| normal[2]).collect();
    up.sort_by(f64::total_cmp);
    let slope = 0.1 / 1.0_f64.hypot(0.1);
    assert!((up[0] + slope).abs() < 0.01 && (up[up.len() - 1] - slope).abs() < 0.01, "{up:?}");
    // The custom normal of the flag's second vertex.
    let [flag] = normals_at([0.8, 0.0, 1.6])[..] else { panic!() };
    let expected = [0.6, -0.8, 0.0];
    assert!((0..3).all(|axis| (flag[axis] - expected[axis]).abs() < 1e-3), "{flag:?}");
}

/// Lists position and normal of every engine vertex, moved to the script's axes and unit.
fn corners(examples: &Examples, moved: fn([f64; 3], f64) -> [f64; 3]) -> Vec<[f64; 6]> {
    let engine = examples.engine.as_ref().unwrap();
    let pairs = engine.copy_of.iter().zip(engine.normals.as_ref().unwrap());
    let corner = |(vertex, normal): (&usize, &[f64; 3])| {
        let ([a, b, c], [x, y, z]) = (moved(examples.rest[*vertex], 0.01), moved(*normal, 1.0));
        [a, b, c, x, y, z]
    };
    pairs.map(corner).collect()
}

#[test]
fn every_action_is_a_clip() {
    let Some((folder, noted)) = exported("actions", &["--actions"]) else { return };
    let Loaded { examples, clips, .. } = npz::load(&folder.join("dressed.npz")).unwrap();
    let numbers: Vec<i64> = (1..9).collect();
    assert_eq!(clips, [clip("Bend", 0, 24.0, &numbers), clip("Twist", 8, 24.0, &numbers[2..6])]);
    // Bend turns the upper bone about x, Twist the lower bone about its y axis, which is z. No
    // clip holds the other's pose.
    let angle = |frame: usize, joint: usize| {
        let map = examples.pose(frame)[joint];
        ((map[0][0] + map[1][1] + map[2][2] - 1.0) / 2.0).acos().to_degrees()
    };
    let near = |found: f64, expected: f64| (found - expected).abs() < 1e-3;
    assert!(near(angle(7, 0), 0.0) && near(angle(7, 1), 80.0));
    assert!(near(angle(8, 0), 30.0) && near(angle(11, 0), 60.0) && near(angle(11, 1), 60.0));
    // Two bones have a property of one name, and two meshes one shape.
    assert_eq!(examples.curve_names, ["breath", "lower.stretch", "upper.stretch", "Puff"]);
    assert_eq!(examples.curves_of(7), [1.0, 0.0, 80.0, 1.0]);
    assert_eq!(examples.curves_of(8)[..3], [0.0; 3], "keyed by Bend alone, and so at its default");
    assert!(noted.contains("named THING.NAME as they differ: stretch"), "{noted}");
    // The FBX has the shape as a curve too. The other two are no blendshapes.
    let scene = folder.join("dressed.fbx");
    let fbx = load(&Source { curves: Curves::All, ..Source::file(&scene) }).unwrap().examples;
    assert_eq!(fbx.curve_names, ["Puff"]);
    for frame in 0..8 {
        let [found, expected] = [fbx.curves_of(frame)[0], examples.curves_of(frame)[3]];
        assert!((found - expected).abs() < 1e-6, "{frame}: {found}, expected {expected}");
    }
}

#[test]
fn actions_that_no_clip_plays_are_named() {
    let Some((folder, noted)) = exported("unplayed", &[]) else { return };
    assert!(noted.contains("actions that nothing plays are left out: Twist (--actions"), "{noted}");
    assert_eq!(npz::load(&folder.join("dressed.npz")).unwrap().clips.len(), 1);
}
