//! Blendshapes by name.

use super::scene::Scene;
use super::{ARM, FACES, near};
use crate::formats::FormatWarning;
use crate::formats::fbx::shaped::parse_shapes;

const TEXTURE: &str = "LayerElementUV: 0 {\nVersion: 101\nMappingInformationType: \"ByPolygonVertex\"\n\
    ReferenceInformationType: \"IndexToDirect\"\nUV: *6 {\na: 0,0,1,0,1,1\n}\nUVIndex: *7 {\na: 0,1,2,0,1,2,2\n}\n}\n\
    Layer: 0 {\nVersion: 100\nLayerElement: {\nType: \"LayerElementUV\"\nTypedIndex: 0\n}\n}\n";

#[test]
fn channels_are_shapes_and_of_several_in_one_the_last() {
    let mut scene = Scene::default();
    let node = scene.node("head", "Mesh", 0, &[("Lcl Scaling", [2.0, 2.0, 2.0])]);
    let mesh = scene.mesh(node, &ARM, &FACES, TEXTURE);
    let smile = [(50.0, 3, [0.0, 0.0, 2.0]), (100.0, 3, [0.0, 1.0, 1.0])];
    scene.channel(mesh, "smile", &smile);
    scene.channel(mesh, "blink", &[(100.0, 1, [1.0, 0.0, 0.0])]);
    let plain = scene.node("hat", "Mesh", 0, &[]);
    scene.mesh(plain, &ARM, &FACES, "");
    let found = parse_shapes(scene.text().as_bytes()).unwrap();
    near(&found.positions, &ARM.map(|p| p.map(|x| 2.0 * x)));
    let names: Vec<_> = found.shapes.iter().map(|shape| shape.name.as_str()).collect();
    assert_eq!(names, ["smile", "blink"]);
    near(&found.shapes[0].deltas[3..4], &[[0.0, 2.0, 2.0]]);
    near(&found.shapes[1].deltas[..2], &[[0.0; 3], [2.0, 0.0, 0.0]]);
    assert_eq!(found.faces, [vec![0, 1, 3, 4], vec![1, 2, 3]]);
    assert_eq!(found.uv, [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]);
    assert_eq!(found.uv_faces, [vec![0, 1, 2, 0], vec![1, 2, 2]]);
    let (meshes, channels) = (vec!["hat".to_owned()], vec!["smile".to_owned()]);
    let expected =
        [FormatWarning::UnshapedMeshes { meshes }, FormatWarning::ShapesBetween { channels }];
    assert_eq!(found.warnings, expected);
}

#[test]
fn a_mesh_without_channels_is_refused() {
    let mut scene = Scene::default();
    let node = scene.node("head", "Mesh", 0, &[]);
    scene.mesh(node, &ARM, &FACES, "");
    let error = parse_shapes(scene.text().as_bytes()).unwrap_err().to_string();
    assert_eq!(error, "has no blendshape: export the face with its shape keys (morph targets)");
}
