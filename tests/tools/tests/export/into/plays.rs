//! An artist's file plays the skin that the runtime computes.

use super::super::scene::Scene;
use super::super::validator::valid;
use super::super::{clip, model, pose, runtime_skin, set};
use super::{Character, Clip, Examples, Glb, export_into};
use nalgebra::{Matrix4, Vector3};
use serde_json::json;
use sinew_runtime::Model;
use sinew_runtime::envelope::Predictor;
use sinew_trainer::envelope::levels::Level;
use sinew_trainer::examples::{Loaded, Source, load};
use sinew_trainer::export::Grafted;
use std::path::Path;

/// Largest distance from the runtime's skin, as a share of the rest diagonal.
const NEAR: f64 = 1e-4;

/// Expected content of a file.
struct Expected<'a> {
    mesh: &'a str,
    examples: &'a Examples,
    model: &'a [u8],
    clips: &'a [Clip],
    /// Maps a point of the runtime to the file's world.
    world: &'a dyn Fn(Vector3<f64>) -> Vector3<f64>,
    /// Scale of the file's world: metres in the file per metre of the model.
    unit: f64,
}

/// Exports a model into a file and compares every vertex with the runtime's nearest vertex at every
/// key. At rest, the two must coincide.
#[track_caller]
fn check(name: &str, file: &Path, expected: &Expected<'_>) -> Grafted {
    let Expected { mesh, examples, model, clips, world, unit } = *expected;
    let grafted = export_into(model, examples, clips, &[], file).unwrap();
    valid(name, &grafted.glb);
    let scene = Scene::read(&grafted.glb);
    let loaded = Model::from_bytes(model).unwrap();
    let node = scene.gltf.nodes().nth(scene.node(mesh)).unwrap();
    // At rest, the file's vertices are at the places of the model's vertices.
    let rest = Scene::read(&std::fs::read(file).unwrap());
    let at_rest = rest.posed(mesh, &rest.worlds(None));
    let close = 1e-4 * unit * examples.diagonal();
    let own_rest = examples.surface().copied(&examples.rest);
    let vertex_of: Vec<usize> = at_rest
        .iter()
        .enumerate()
        .map(|(own, x)| {
            let far = |v: &usize| (world(Vector3::from(own_rest[*v])) - x).norm();
            let is_own = own < own_rest.len() && far(&own) < close;
            let nearest = (0..own_rest.len()).min_by(|a, b| far(a).total_cmp(&far(b)));
            let found = if is_own { own } else { nearest.unwrap() };
            assert!(far(&found) < close, "{name}: {own} is {} away", far(&found));
            found
        })
        .collect();
    assert!(node.skin().is_some());
    let mut roots = scene.gltf.default_scene().unwrap().nodes();
    assert!(roots.any(|root| root.index() == node.index()), "{name}: the mesh is not shown");
    let mut most: f64 = 0.0;
    let first = scene.gltf.animations().len() - clips.len();
    for (number, clip) in clips.iter().enumerate() {
        for key in 0..clip.times.len() {
            let found = scene.posed(mesh, &scene.worlds(Some((first + number, key, 0.0))));
            let skin = runtime_skin(&loaded, &pose(examples, clip.first + key));
            assert_eq!(found.len(), vertex_of.len());
            for (x, &vertex) in found.iter().zip(&vertex_of) {
                most = most.max((x - world(skin[vertex])).norm());
            }
        }
    }
    most /= unit * examples.diagonal();
    println!("{name}: off by {most:.1e} of the diagonal");
    assert!(most < NEAR, "{name}: {most}");
    grafted
}

#[track_caller]
fn check_demo(
    name: &str,
    character: &Character,
    world: &dyn Fn(Vector3<f64>) -> Vector3<f64>,
) -> Grafted {
    let Character { examples, clips, glb, model } = character;
    let file = glb.save(name);
    let unit = (world(Vector3::x()) - world(Vector3::zeros())).norm();
    let grafted =
        check(name, &file, &Expected { mesh: "skin", examples, model, clips, world, unit });
    std::fs::remove_file(file).unwrap();
    grafted
}

#[test]
fn in_the_file_that_it_was_trained_on() {
    let grafted = check_demo("own", &Character::new(), &|x| x);
    assert_eq!(grafted.meshes, ["skin"]);
    assert_eq!(grafted.added_joints, [""; 0]);
    assert_eq!(grafted.animations, ["train (sinew)", "new"]);
    assert_eq!(grafted.kept_animations, ["train", "held-out"]);
}

/// A mesh that the file lacks follows the model's joints, wherever they are in the file.
#[test]
fn a_further_mesh_is_added() {
    let mut character = Character::new();
    character.glb.json["nodes"][0]["scale"] = json!([0.5, 0.5, 0.5]);
    let Character { examples, clips, glb, model } = &character;
    let file = glb.save("further");
    let mesh = sinew_trainer::formats::Mesh {
        positions: examples.rest.clone(),
        triangles: examples.triangles.clone(),
        engine: examples.engine.clone(),
    };
    let levels = [Level { name: "lod1".to_owned(), mesh, is_placed: false }];
    let grafted = export_into(model, examples, clips, &levels, &file).unwrap();
    std::fs::remove_file(file).unwrap();
    valid("further", &grafted.glb);
    assert_eq!((grafted.levels.len(), grafted.levels[0].name.as_str()), (1, "lod1"));
    let scene = Scene::read(&grafted.glb);
    let first = scene.gltf.animations().len() - clips.len();
    for (number, clip) in clips.iter().enumerate() {
        for key in 0..clip.times.len() {
            let worlds = scene.worlds(Some((first + number, key, 0.0)));
            let [own, further] = ["skin", "lod1"].map(|mesh| scene.posed(mesh, &worlds));
            let apart = own.iter().zip(&further).map(|(a, b)| (a - b).norm());
            let apart = apart.fold(0.0, f64::max);
            // The mesh is unchanged, with weights fitted to its destination.
            assert!(apart < 0.01 * examples.diagonal(), "{apart}");
        }
    }
}

/// Some exporters keep z up and centimetres, and convert both in a node above the joints.
#[test]
fn under_an_armature_that_scales_and_turns() {
    let mut character = Character::new();
    let matrices = character.glb.json["skins"][0]["inverseBindMatrices"].as_u64().unwrap() as usize;
    let positions = character.attribute("POSITION");
    let glb = &mut character.glb;
    glb.change(positions, 3, |x| x.iter_mut().for_each(|x| *x *= 100.0));
    glb.change(matrices, 16, |m| m[12..15].iter_mut().for_each(|x| *x *= 100.0));
    for bound in ["min", "max"] {
        for x in glb.json["accessors"][positions][bound].as_array_mut().unwrap() {
            *x = json!(x.as_f64().unwrap() as f32 * 100.0);
        }
    }
    for node in glb.json["nodes"].as_array_mut().unwrap() {
        if let Some(moved) = node.get_mut("translation") {
            *moved = json!([0, 1, 2].map(|axis| moved[axis].as_f64().unwrap() * 100.0));
        }
    }
    let half = std::f64::consts::FRAC_1_SQRT_2;
    glb.json["nodes"][0]["scale"] = json!([0.01, 0.01, 0.01]);
    glb.json["nodes"][0]["rotation"] = json!([-half, 0.0, 0.0, half]);
    glb.json.as_object_mut().unwrap().remove("animations");
    let grafted = check_demo("armature", &character, &|x| Vector3::new(x.x, x.z, -x.y));
    assert_eq!(grafted.kept_animations, [""; 0]);
}

/// The mesh has other axes and another unit than the joints, which are as in the model.
#[test]
fn where_the_mesh_has_other_axes_than_the_model() {
    let mut character = Character::new();
    let matrices = character.glb.json["skins"][0]["inverseBindMatrices"].as_u64().unwrap() as usize;
    let positions = character.attribute("POSITION");
    let glb = &mut character.glb;
    let there = |x: &mut [f32]| x.copy_from_slice(&[100.0 * x[0], 100.0 * x[2], -100.0 * x[1]]);
    glb.change(positions, 3, there);
    let back = Matrix4::new(
        0.01, 0.0, 0.0, 0.0, 0.0, 0.0, -0.01, 0.0, 0.0, 0.01, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0,
    );
    glb.change(matrices, 16, |m| {
        let matrix = Matrix4::from_column_slice(m) * back;
        m.copy_from_slice(matrix.as_slice());
    });
    let [low, high] = ["min", "max"].map(|bound| {
        let bound = &glb.json["accessors"][positions][bound];
        [0, 1, 2].map(|axis| bound[axis].as_f64().unwrap() as f32)
    });
    glb.json["accessors"][positions]["min"] = json!([low[0], low[2], -high[1]].map(|x| x * 100.0));
    glb.json["accessors"][positions]["max"] = json!([high[0], high[2], -low[1]].map(|x| x * 100.0));
    check_demo("axes", &character, &|x| x);
}

/// Joints given by matrices, one of them missing, and a mesh under the armature.
#[test]
fn where_joints_are_matrices_or_missing() {
    let mut character = Character::new();
    let glb = &mut character.glb;
    glb.json.as_object_mut().unwrap().remove("animations");
    let nodes = glb.json["nodes"].as_array_mut().unwrap();
    let last = nodes.iter().rposition(|node| node.get("mesh").is_none()).unwrap();
    nodes[last]["name"] = json!("stranger");
    for node in nodes.iter_mut().filter(|node| node.get("mesh").is_none()).skip(1) {
        let read = |name: &str, otherwise: &[f64]| -> Vec<f64> {
            let stated = node.get(name).and_then(|x| x.as_array());
            stated.map_or(otherwise.to_vec(), |x| x.iter().map(|x| x.as_f64().unwrap()).collect())
        };
        let (t, r) = (read("translation", &[0.0; 3]), read("rotation", &[0.0, 0.0, 0.0, 1.0]));
        let turn = nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(
            r[3], r[0], r[1], r[2],
        ));
        let matrix =
            nalgebra::Translation3::new(t[0], t[1], t[2]).to_homogeneous() * turn.to_homogeneous();
        for name in ["translation", "rotation"] {
            node.as_object_mut().unwrap().remove(name);
        }
        node["matrix"] = json!(matrix.as_slice());
    }
    let mesh = nodes.iter().position(|node| node.get("mesh").is_some()).unwrap();
    nodes[mesh]["translation"] = json!([5.0, 6.0, 7.0]);
    nodes[0]["children"].as_array_mut().unwrap().push(json!(mesh));
    let shown = glb.json["scenes"][0]["nodes"].as_array_mut().unwrap();
    shown.retain(|node| *node != json!(mesh));
    let grafted = check_demo("matrices", &character, &|x| x);
    assert_eq!(grafted.added_joints, [character.examples.skeleton.names.last().unwrap().as_str()]);
}

#[test]
fn a_mesh_without_a_skin_takes_the_joints_with_it() {
    let mut character = Character::new();
    let names = character.examples.skeleton.names.clone();
    let root = character.glb.json.as_object_mut().unwrap();
    let mesh = root["nodes"].as_array().unwrap().iter().position(|node| node.get("mesh").is_some());
    let mut mesh = root["nodes"][mesh.unwrap()].clone();
    mesh.as_object_mut().unwrap().remove("skin");
    mesh["translation"] = json!([1.0, 2.0, 3.0]);
    root.insert("nodes".to_owned(), json!([mesh]));
    root.insert("scenes".to_owned(), json!([{ "nodes": [0] }]));
    for gone in ["skins", "animations"] {
        root.remove(gone);
    }
    let attributes = root["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap();
    attributes.retain(|name, _| name == "POSITION" || name == "NORMAL");
    let Character { examples, clips, model, .. } = &character;
    let file = character.glb.save("static");
    let grafted = export_into(model, examples, clips, &[], &file).unwrap();
    assert_eq!(grafted.added_joints.len(), names.len());
    let scene = Scene::read(&grafted.glb);
    let runtime = Model::from_bytes(model.as_slice()).unwrap();
    for key in [0, 5] {
        let found = scene.posed("skin", &scene.worlds(Some((0, key, 0.0))));
        let skin = runtime_skin(&runtime, &pose(examples, key));
        let shift = Vector3::new(1.0, 2.0, 3.0);
        let far = found.iter().zip(skin).map(|(x, y)| (x - y - shift).norm()).fold(0.0, f64::max);
        // The poses start from the place where the file shows the rest mesh.
        assert!(far < NEAR * examples.diagonal(), "{far}");
    }
    std::fs::remove_file(file).unwrap();
}

#[test]
fn fox_in_its_own_file() {
    let Some(path) = models::shared("gltf-loader/Fox.glb") else { return };
    let Loaded { examples, clips, .. } = load(&Source::file(&path)).unwrap();
    let model = model(&examples, Predictor::Kernel, 4, 4);
    let expected = Expected {
        mesh: "fox",
        examples: &examples,
        model: &model,
        clips: &clips[1..2],
        world: &|x| x,
        unit: 1.0,
    };
    let grafted = check("fox", &path, &expected);
    assert_eq!(grafted.animations, ["Walk (sinew)"]);
    let [before, after] = [std::fs::read(&path).unwrap(), grafted.glb].map(|glb| Glb::read(&glb));
    for name in ["materials", "textures", "images", "samplers"] {
        assert_eq!(before.json[name], after.json[name], "{name}");
    }
    assert_eq!(before.seen(7), after.seen(7), "the image");
}

/// A model of posed meshes in metres with z up, and the glTF exporter's file of that character: y
/// up, vertices split along seams, two materials, shapes.
#[test]
fn a_leg_in_blenders_export() {
    let Some(examples) = set("leg/leg.npz") else { return };
    let Some(path) = models::shared("leg/leg.glb") else { return };
    let model = model(&examples, Predictor::Kernel, 6, 4);
    let clips = [clip("stretch", 66, 8)];
    let expected = Expected {
        mesh: "Leg",
        examples: &examples,
        model: &model,
        clips: &clips,
        world: &|x| Vector3::new(x.x, x.z, -x.y),
        unit: 1.0,
    };
    let grafted = check("leg", &path, &expected);
    assert_eq!(grafted.kept_animations, ["Walk Cycle", "Stretch"]);
}
