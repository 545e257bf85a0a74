//! Morph targets by name.

use super::made::Made;
use crate::formats::gltf::shaped::{parse_shapes, read_shapes};
use crate::formats::testing::shared;
use crate::formats::{FormatWarning, ShapedMesh};
use serde_json::json;

fn shaped(made: &Made, test: &str) -> ShapedMesh {
    read_shapes(&made.write(test)).unwrap()
}

#[test]
fn targets_have_the_names_beside_them() {
    let mut made = Made::scene();
    let bare = shaped(&made, "shaped-bare");
    assert_eq!(bare.shapes[0].name, "target 0");
    made.json["meshes"][0]["extras"] = json!({ "targetNames": ["raised"] });
    let mesh = shaped(&made, "shaped-named");
    assert_eq!(mesh.positions, [[1.0, 0.0, 0.0], [3.0, 0.0, 0.0], [2.0, 1.0, 0.0]]);
    assert_eq!((mesh.faces, mesh.uv.len(), mesh.normals), (vec![vec![0, 1, 2]], 0, None));
    assert_eq!(mesh.shapes.len(), 1);
    assert_eq!(mesh.shapes[0].name, "raised");
    assert_eq!(mesh.shapes[0].deltas, [[0.0; 3], [0.0, 0.0, 1.0], [0.0; 3]]);
}

#[test]
fn shapes_of_one_name_on_several_meshes_are_one_and_placed_by_their_nodes() {
    let mut made = Made::scene();
    made.json["meshes"][0]["extras"] = json!({ "targetNames": ["raised"] });
    let mut second = made.json["meshes"][0].clone();
    second["extras"] = json!({ "targetNames": ["raised", "other"] });
    let targets = &mut second["primitives"][0]["targets"];
    let again = targets[0].clone();
    targets.as_array_mut().unwrap().push(again);
    made.json["meshes"].as_array_mut().unwrap().push(second);
    let mut plain = made.json["meshes"][0].clone();
    plain["primitives"][0].as_object_mut().unwrap().remove("targets");
    plain["weights"].take();
    made.json["meshes"].as_array_mut().unwrap().push(plain);
    let nodes = made.json["nodes"].as_array_mut().unwrap();
    // Twice as large, a quarter turn about x, and moved.
    nodes.push(json!({ "name": "teeth", "mesh": 1, "translation": [0.0, 5.0, 0.0], "scale": [2.0, 2.0, 2.0],
        "rotation": [std::f32::consts::FRAC_1_SQRT_2, 0.0, 0.0, std::f32::consts::FRAC_1_SQRT_2] }));
    nodes.push(json!({ "name": "eyes", "mesh": 2 }));
    made.json["scenes"][0]["nodes"] = json!([0, 1, 3, 4]);
    let mesh = shaped(&made, "shaped-several");
    assert_eq!(mesh.warnings, [FormatWarning::UnshapedMeshes { meshes: vec!["eyes".to_owned()] }]);
    assert_eq!((mesh.positions.len(), mesh.faces.len()), (6, 2));
    assert_eq!(mesh.faces[1], [3, 4, 5]);
    let names: Vec<_> = mesh.shapes.iter().map(|shape| shape.name.as_str()).collect();
    assert_eq!(names, ["raised", "other"]);
    super::near(mesh.positions[5], [4.0, 5.0, 2.0], 1e-6);
    super::near(mesh.shapes[0].deltas[1], [0.0, 0.0, 1.0], 1e-6);
    super::near(mesh.shapes[0].deltas[4], [0.0, -2.0, 0.0], 1e-6);
    super::near(mesh.shapes[1].deltas[1], [0.0; 3], 0.0);
    super::near(mesh.shapes[1].deltas[4], [0.0, -2.0, 0.0], 1e-6);
}

#[test]
fn a_scene_without_targets_is_refused() {
    let mut made = Made::scene();
    made.json["meshes"][0]["primitives"][0].as_object_mut().unwrap().remove("targets");
    made.json["meshes"][0].as_object_mut().unwrap().remove("weights");
    let error = read_shapes(&made.write("shaped-none")).unwrap_err().to_string();
    assert_eq!(error, "has no blendshape: export the face with its shape keys (morph targets)");
}

/// Counts and names by a script from the format's specification.
#[test]
fn a_real_file_has_eight_keys() {
    let Some(file) = shared("gltf-loader/MorphStressTest.gltf") else { return };
    let mesh = read_shapes(&file).unwrap();
    assert_eq!(mesh.positions.len(), 24 + 1504);
    let names: Vec<_> = mesh.shapes.iter().map(|shape| shape.name.as_str()).collect();
    assert_eq!(names, ["Key 1", "Key 2", "Key 3", "Key 4", "Key 5", "Key 6", "Key 7", "Key 8"]);
    assert!(mesh.normals.is_some_and(|normals| normals.len() == 24 + 1504));
}

#[test]
fn spoiled_names_do_not_panic() {
    let mut made = Made::scene();
    for names in [json!(1), json!([]), json!([1]), json!({ "a": 1 }), json!(null)] {
        made.json["meshes"][0]["extras"] = json!({ "targetNames": names });
        assert_eq!(shaped(&made, "shaped-spoiled").shapes[0].name, "target 0");
    }
    let file = made.write("shaped-bytes");
    let bytes = std::fs::read(&file).unwrap();
    for len in (0..bytes.len()).step_by(7) {
        let _ = parse_shapes(&bytes[..len], &file);
    }
}
