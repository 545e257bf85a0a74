//! Tests of glTF: from files to examples, and morph targets by name.

mod curves;
mod faults;
mod made;

use super::*;
use crate::ErrorKind;
use crate::examples::{Loaded, Source, Split, Warning, load};
use crate::formats::scene::Clip;
use crate::formats::testing::shared;
use crate::formats::{FormatWarning, ShapedMesh};
use made::{Made, NO_TURN, QUARTER, moved_by};
use serde_json::json;
use sinew_runtime::format::{Axis, Handedness};

fn near(found: [f64; 3], expected: [f64; 3], tolerance: f64) {
    let far = found.iter().zip(expected).any(|(a, b)| (a - b).abs() > tolerance);
    assert!(!far, "{found:?}, expected {expected:?}");
}

fn loaded(made: &Made, test: &str) -> Loaded {
    load(&Source::file(&made.write(test))).unwrap()
}

/// A script computed the expected positions from the specification of the format.
#[test]
fn the_fox_runs() {
    let Some(fox) = shared("gltf-loader/Fox.glb") else { return };
    let Loaded { examples, clips, warnings } = load(&Source::file(&fox)).unwrap();
    let counts = [examples.vertex_len(), examples.triangles.len(), examples.joint_len()];
    assert_eq!(counts, [290, 576, 24]);
    let clips: Vec<_> = clips.iter().map(|c| (c.name.as_str(), c.first, c.times.len())).collect();
    assert_eq!(clips, [("Survey", 0, 83), ("Walk", 83, 18), ("Run", 101, 25)]);
    assert_eq!(warnings, [Warning::PlainSkin]);
    assert_eq!(examples.skeleton.names[2], "b_Hip_01");
    let engine = examples.engine.as_ref().unwrap();
    assert_eq!(engine.uv.as_ref().map(Vec::len), Some(1728));
    near(examples.frame(40)[engine.copy_of[17]], [15.320872317, 55.945745005, 48.748890049], 1e-6);
    near(
        examples.frame(101 + 7)[engine.copy_of[1000]],
        [7.038239042, 38.832917685, 44.744594341],
        1e-6,
    );
    let run = Source { clips: &["Run".to_owned()], fps: Some(60.0), ..Source::file(&fox) };
    assert_eq!(load(&run).unwrap().examples.frame_len(), 70);
}

/// The file has no skin, so its shapes are targets of another scene; a script computed the expected values.
#[test]
fn morph_targets_pass_through_their_keys() {
    let Some(file) = shared("gltf-loader/MorphStressTest.gltf") else { return };
    let meshes = read_posed_meshes(&file).unwrap();
    assert_eq!(meshes.vertex_len, 24 + 1504);
    assert_eq!(meshes.vertices.len(), (225 + 153 + 48) * meshes.vertex_len);
    let vertex = (225 + 153 + 20) * meshes.vertex_len + 24 + 700;
    near(meshes.vertices[vertex], [-0.200665787, 1.346000016, 0.246193975], 1e-8);
    let error = load(&Source::file(&file)).unwrap_err();
    assert!(error.to_string().contains("no mesh has a skin"), "{error}");
}

#[test]
fn a_joint_carries_its_vertices() {
    let Loaded { examples, clips, .. } = loaded(&Made::scene(), "carries");
    let times = vec![0.0, 0.5, 1.0];
    assert_eq!(clips, [Clip { name: "bend".into(), first: 0, times, numbers: None }]);
    assert_eq!(examples.split, [Split::Train; 3]);
    assert_eq!(examples.skeleton.parents, [None, Some(0)]);
    assert_eq!(examples.skeleton.rest[1].map(|row| row[3]), [2.0, 0.0, 0.0]);
    let weights = [[1.0, 0.0], [0.0, 1.0], [0.5, 0.5]];
    assert_eq!(examples.joint_weights.as_deref(), Some(weights.as_flattened()));
    assert_eq!(examples.frame(0), examples.rest);
    let bent = examples.frame(1);
    near(bent[0], [1.0, 0.0, 0.0], 1e-7);
    near(bent[1], [2.0, 1.0, 0.0], 1e-7);
    // Half-way between (2, 1, 0) and its image (1, 0, 0).
    near(bent[2], [1.5, 0.5, 0.0], 1e-7);
    let bend = examples.pose(1)[1];
    near(bend[0][..3].try_into().unwrap(), [0.0, -1.0, 0.0], 1e-7);
    near(bend.map(|row| row[3]), [2.0, -2.0, 0.0], 1e-7);
}

#[test]
fn blender_s_extra_joint_gives_a_warning() {
    let mut made = Made::scene();
    made.json["nodes"][2]["name"] = json!("neutral_bone");
    let Loaded { warnings, .. } = loaded(&made, "neutral");
    let expected = FormatWarning::NeutralBone { joint: "neutral_bone".into(), count: 2 };
    assert_eq!(warnings, [Warning::Format(expected), Warning::PlainSkin]);
}

#[test]
fn morph_targets_are_skinned() {
    let mut made = Made::scene();
    let (times, weights) = (made.floats(&[[0.0], [1.0]]), made.floats(&[[0.0], [0.5]]));
    let target = json!({ "node": 0, "path": "weights" });
    made.clip("raise", target, times, weights, "LINEAR");
    let Loaded { examples, clips, warnings } = loaded(&made, "skinned");
    assert_eq!((clips[1].first, clips[1].times.len()), (3, 2));
    assert_eq!(warnings, []);
    near(examples.frame(4)[1], [3.0, 0.0, 0.5], 1e-12);
    assert_eq!(examples.frame(3), examples.rest);
}

/// Targets from a file are its shapes, moved by the joints, as a viewer shows them.
#[test]
fn posed_meshes_are_skinned_where_they_have_a_skin() {
    let mut made = Made::scene();
    let (times, weights) = (made.floats(&[[0.0], [1.0]]), made.floats(&[[0.0], [0.5]]));
    let target = json!({ "node": 0, "path": "weights" });
    made.clip("raise", target, times, weights, "LINEAR");
    let nodes = made.json["nodes"].as_array_mut().unwrap();
    // The mesh follows its skin instead of its node.
    nodes[0]["translation"] = json!([7.0, 0.0, 0.0]);
    nodes.push(json!({ "name": "rigid", "mesh": 0, "translation": [0.0, 5.0, 0.0] }));
    made.json["scenes"][0]["nodes"] = json!([0, 1, 3]);
    let meshes = read_posed_meshes(&made.write("posed-skinned")).unwrap();
    assert_eq!((meshes.vertex_len, meshes.vertices.len()), (6, 5 * 6));
    let vertex = |frame: usize, vertex: usize| meshes.vertices[6 * frame + vertex];
    near(vertex(1, 1), [2.0, 1.0, 0.0], 1e-7);
    near(vertex(1, 2), [1.5, 0.5, 0.0], 1e-7);
    near(vertex(4, 1), [3.0, 0.0, 0.5], 1e-12);
    near(vertex(1, 3), [1.0, 5.0, 0.0], 1e-7);
}

#[test]
fn posed_meshes_that_nothing_shapes_are_refused() {
    let mut made = Made::scene();
    made.json["nodes"][0].as_object_mut().unwrap().remove("skin");
    let error = read_posed_meshes(&made.write("posed-still")).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Missing);
    assert!(error.message().starts_with("has neither a skin nor morph targets"), "{error}");
}

#[test]
fn keys_are_interpolated_by_their_mode() {
    let mut made = Made::scene();
    let times = made.floats(&[[0.0], [1.0]]);
    let ends = made.floats(&[[2.0, 0.0, 0.0], [2.0, 4.0, 0.0]]);
    let cubic = made.floats(&[
        [0.0; 3],
        [2.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 3.0, 0.0],
        [2.0, 4.0, 0.0],
        [0.0; 3],
    ]);
    let turns = made.floats(&[NO_TURN, QUARTER]);
    let target = |path| json!({ "node": 2, "path": path });
    made.clip("line", target("translation"), times, ends, "LINEAR");
    made.clip("step", target("translation"), times, ends, "STEP");
    made.clip("cubic", target("translation"), times, cubic, "CUBICSPLINE");
    made.clip("turn", target("rotation"), times, turns, "LINEAR");
    let file = made.write("interpolated");
    let quarter = |clip: &str| {
        let source = Source { clips: &[clip.to_owned()], fps: Some(4.0), ..Source::file(&file) };
        let Loaded { examples, clips, .. } = load(&source).unwrap();
        assert_eq!(clips[0].times, [0.0, 0.25, 0.5, 0.75, 1.0]);
        examples.pose(1)[1]
    };
    let height = |clip| quarter(clip)[1][3];
    assert!((height("line") - 1.0).abs() < 1e-12);
    assert_eq!(height("step"), 0.0);
    // Hermite at t = 1/4: h01 4 + h10 1 + h11 3.
    let (t, t2, t3) = (0.25, 0.0625, 0.015625);
    let hermite = 4.0 * (3.0 * t2 - 2.0 * t3) + (t3 - 2.0 * t2 + t) + 3.0 * (t3 - t2);
    assert!((height("cubic") - hermite).abs() < 1e-12);
    let angle = std::f64::consts::FRAC_PI_8;
    assert!((quarter("turn")[0][0] - angle.cos()).abs() < 1e-7);
    assert!((quarter("turn")[1][0] - angle.sin()).abs() < 1e-7);
}

/// An armature in centimetres, under a node that scales it to metres.
#[test]
fn a_common_scale_goes_into_the_rest_mesh() {
    let mut made = Made::scene();
    let inverses = made.floats(&[moved_by(0.0), moved_by(-2.0)]);
    made.json["nodes"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "name": "metres", "children": [1], "scale": [0.01, 0.01, 0.01] }));
    made.json["scenes"][0]["nodes"] = json!([0, 3]);
    made.json["skins"][0]["inverseBindMatrices"] = json!(inverses);
    let Loaded { examples, .. } = loaded(&made, "scaled");
    near(examples.rest[1], [0.03, 0.0, 0.0], 1e-9);
    near(examples.frame(1)[1], [0.02, 0.01, 0.0], 1e-9);
    near(examples.skeleton.rest[1].map(|row| row[3]), [0.02, 0.0, 0.0], 1e-9);
    assert!((examples.pose(1)[1][1][0] - 1.0).abs() < 1e-7);
}

/// A second mesh, half as far along x in a separate space, with a separate skin.
#[test]
fn meshes_are_joined_in_one_space() {
    let mut made = Made::scene();
    let inverses = made.floats(&[moved_by(5.0), moved_by(3.0)]);
    let positions = made.floats(&[[-4.0, 0.0, 0.0], [-2.0, 0.0, 0.0], [-3.0, 1.0, 0.0]]);
    let mut mesh = made.json["meshes"][0].clone();
    mesh["primitives"][0]["attributes"]["POSITION"] = json!(positions);
    made.json["meshes"].as_array_mut().unwrap().push(mesh);
    made.json["skins"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "joints": [1, 2], "inverseBindMatrices": inverses }));
    made.json["nodes"].as_array_mut().unwrap().extend([
        json!({ "name": "sleeve", "mesh": 1, "skin": 1 }),
        json!({ "name": "prop", "mesh": 0 }),
    ]);
    made.json["scenes"][0]["nodes"] = json!([0, 1, 3, 4]);
    let Loaded { examples, warnings, .. } = loaded(&made, "joined");
    assert_eq!((examples.vertex_len(), examples.triangles.len()), (6, 2));
    assert_eq!(examples.triangles[1], [3, 4, 5]);
    assert_eq!(examples.rest[..3], examples.rest[3..]);
    assert_eq!(examples.frame(1)[..3], examples.frame(1)[3..]);
    assert!(warnings.contains(&FormatWarning::UnskinnedMeshes(vec!["prop".into()]).into()));
    let ranges = [("body".to_owned(), 0..3), ("sleeve".to_owned(), 3..6)];
    assert_eq!(examples.ranges, ranges);
    // Every glTF scene has these axes. A single mesh has no ranges.
    let plain = loaded(&Made::scene(), "plain").examples;
    let space = Space {
        up: Some(Axis::Y),
        forward: Some(Axis::Z),
        handedness: Handedness::Right,
        unit: Some(1.0),
    };
    assert!(plain.ranges.is_empty() && plain.space == space && examples.space == space);
}

#[test]
fn texture_coordinates_grow_upward() {
    let mut made = Made::scene();
    let uv = made.floats(&[[0.25, 0.0], [0.5, 0.25], [0.0, 1.0]]);
    made.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(uv);
    let uv = loaded(&made, "uv").examples.engine.unwrap().uv.unwrap();
    assert_eq!(uv, [[0.25, 1.0], [0.5, 0.75], [0.0, 0.0]]);
}

/// Returns the scene with a second triangle on the edge from 1 to 2, which has separate vertices there.
fn seamed() -> (Made, usize) {
    let mut made = Made::scene();
    let edge = [[3.0, 0.0, 0.0], [2.0, 1.0, 0.0]];
    let first = [[1.0, 0.0, 0.0], edge[0], edge[1]];
    let positions = made.floats(&[first, [edge[1], edge[0], [3.0, 1.0, 0.0]]].concat());
    let up = [0.0, 0.0, 1.0];
    let raised = made.floats(&[[0.0; 3], up, [0.0; 3], [0.0; 3], up, [0.0; 3]]);
    let joints = made.bytes(&[[0, 1, 0, 0]; 6]);
    let both = [0.5, 0.5, 0.0, 0.0];
    let (upper, lower) = ([1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]);
    let weights = made.floats(&[upper, lower, both, both, lower, lower]);
    let primitive = &mut made.json["meshes"][0]["primitives"][0];
    primitive["attributes"] =
        json!({ "POSITION": positions, "JOINTS_0": joints, "WEIGHTS_0": weights });
    primitive["targets"] = json!([{ "POSITION": raised }]);
    (made, raised)
}

#[test]
fn vertices_at_one_position_are_copies_in_the_file_s_order() {
    let (made, _) = seamed();
    let Loaded { examples, .. } = loaded(&made, "welded");
    assert_eq!((examples.vertex_len(), &examples.triangles[..]), (4, &[[0, 1, 2], [2, 1, 3]][..]));
    assert_eq!(examples.rest[3], [3.0, 1.0, 0.0]);
    let engine = examples.engine.as_ref().unwrap();
    assert_eq!(engine.copy_of, [0, 1, 2, 2, 1, 3]);
    assert_eq!(engine.triangles, [[0, 1, 2], [3, 4, 5]]);
    // The seam does not shade.
    assert_eq!(examples.surface().normals(), [[0.0, 0.0, 1.0]; 6]);
    let plain = loaded(&Made::scene(), "not-welded").examples;
    assert!(plain.engine.is_none());
}

#[test]
fn vertices_that_move_apart_are_not_one() {
    let (mut made, _) = seamed();
    let raised = made.floats(&[[0.0_f32; 3]; 6]);
    made.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": made.json["meshes"][0]["primitives"][0]["targets"][0]["POSITION"] }, { "POSITION": raised }]);
    made.json["meshes"][0]["weights"] = json!([0.0, 0.0]);
    assert_eq!(loaded(&made, "morphs-alike").examples.vertex_len(), 4);
    let mut apart = [[0.0_f32; 3]; 6];
    apart[3] = [0.0, 0.0, 1.0];
    let apart = made.floats(&apart);
    made.json["meshes"][0]["primitives"][0]["targets"][1] = json!({ "POSITION": apart });
    assert_eq!(loaded(&made, "morphs-apart").examples.vertex_len(), 5);
}

#[test]
fn authored_directions_are_read_and_repaired() {
    let (mut made, _) = seamed();
    let lean = [0.6, 0.0, 0.8];
    let up = [0.0, 0.0, 1.0];
    let normals = made.floats(&[up, up, up, [f32::NAN, 0.0, 1.0], lean, lean]);
    let tangents = made.floats(&[[1.0, 0.0, 0.0, -1.0]; 6]);
    let attributes = &mut made.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["NORMAL"] = json!(normals);
    attributes["TANGENT"] = json!(tangents);
    let Loaded { examples, warnings, .. } = loaded(&made, "authored");
    assert!(warnings.contains(&FormatWarning::NormalsRepaired(1).into()));
    let engine = examples.engine.unwrap();
    assert_eq!(engine.tangents.unwrap(), [[1.0, 0.0, 0.0, -1.0]; 6]);
    for (found, expected) in engine.normals.unwrap().into_iter().zip([up, up, up, up, lean, lean]) {
        near(found, expected.map(f64::from), 1e-7);
    }
    let few = made.floats(&[up; 5]);
    made.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(few);
    let error = load(&Source::file(&made.write("few-normals"))).unwrap_err().to_string();
    assert!(error.contains("mesh body") && error.contains("normals"), "{error}");
}

#[test]
fn a_mirrored_mesh_keeps_its_outside_and_the_sides_of_its_texture() {
    for x in [1.0, -1.0] {
        let mut made = Made::scene();
        let normals = made.floats(&[[0.0_f32, 0.0, 1.0]; 3]);
        let tangents = made.floats(&[[1.0_f32, 0.0, 0.0, 1.0]; 3]);
        let attributes = &mut made.json["meshes"][0]["primitives"][0]["attributes"];
        attributes["NORMAL"] = json!(normals);
        attributes["TANGENT"] = json!(tangents);
        made.json["nodes"][0] = json!({ "name": "body", "mesh": 0, "scale": [x, 1.0, 1.0] });
        let mesh = read_mesh(&made.write(&format!("mirrored{x}"))).unwrap().mesh;
        assert_eq!(mesh.positions, [[x, 0.0, 0.0], [3.0 * x, 0.0, 0.0], [2.0 * x, 1.0, 0.0]]);
        assert_eq!(mesh.triangles, [if x > 0.0 { [0, 1, 2] } else { [1, 0, 2] }]);
        let engine = mesh.engine.unwrap();
        assert_eq!(engine.normals.unwrap(), [[0.0, 0.0, 1.0]; 3]);
        // The texture's v still grows along y, which is the handedness times normal x tangent.
        assert_eq!(engine.tangents.unwrap(), [[x, 0.0, 0.0, x]; 3]);
    }
}

#[test]
fn clips_that_move_nothing_are_left_out() {
    let mut made = Made::scene();
    let (times, ends) = (made.floats(&[[0.0], [1.0]]), made.floats(&[[0.0_f32; 3]; 2]));
    made.json["nodes"].as_array_mut().unwrap().push(json!({ "name": "camera" }));
    made.clip("pan", json!({ "node": 3, "path": "translation" }), times, ends, "LINEAR");
    let Loaded { clips, warnings, .. } = loaded(&made, "idle");
    assert_eq!(clips.len(), 1);
    assert!(warnings.contains(&FormatWarning::IdleClips(vec!["pan".into()]).into()));
}

#[test]
fn integers_are_scaled_and_sparse_values_replace() {
    let mut made = Made::scene();
    let weights = made.bytes(&[[255, 0, 0, 0], [0, 255, 0, 0], [51, 204, 0, 0]]);
    made.json["accessors"][weights]["normalized"] = json!(true);
    made.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = json!(weights);
    let (places, values) = (made.bytes(&[[1_u8]]), made.floats(&[[3.0, 0.0, 7.0]]));
    let view = |accessor: usize| made.json["accessors"][accessor]["bufferView"].clone();
    let sparse = json!({
        "count": 1,
        "indices": { "bufferView": view(places), "componentType": 5121 },
        "values": { "bufferView": view(values) },
    });
    made.json["accessors"][0]["sparse"] = sparse;
    let Loaded { examples, .. } = loaded(&made, "sparse");
    near(examples.rest[1], [3.0, 0.0, 7.0], 0.0);
    // A fifth at (2, 1, 0), four fifths at (1, 0, 0).
    near(examples.frame(1)[2], [1.2, 0.2, 0.0], 1e-7);
}

fn shaped(made: &Made, test: &str) -> ShapedMesh {
    read_shapes(&made.write(test)).unwrap()
}

#[test]
fn targets_of_a_mirrored_mesh_and_its_faces_are_mirrored() {
    let mut made = Made::scene();
    made.json["nodes"][0] = json!({ "name": "body", "mesh": 0, "scale": [-1.0, 1.0, 2.0] });
    let found = shaped(&made, "mirrored-targets");
    assert_eq!(found.positions, [[-1.0, 0.0, 0.0], [-3.0, 0.0, 0.0], [-2.0, 1.0, 0.0]]);
    assert_eq!(found.faces, [[1, 0, 2]]);
    assert_eq!(found.shapes[0].deltas, [[0.0; 3], [0.0, 0.0, 2.0], [0.0; 3]]);
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
    // Doubled, a quarter turn about x, and moved.
    nodes.push(json!({ "name": "teeth", "mesh": 1, "translation": [0.0, 5.0, 0.0], "scale": [2.0, 2.0, 2.0],
        "rotation": [std::f32::consts::FRAC_1_SQRT_2, 0.0, 0.0, std::f32::consts::FRAC_1_SQRT_2] }));
    nodes.push(json!({ "name": "eyes", "mesh": 2 }));
    made.json["scenes"][0]["nodes"] = json!([0, 1, 3, 4]);
    let mesh = shaped(&made, "shaped-several");
    assert_eq!(mesh.warnings, [FormatWarning::UnshapedMeshes(vec!["eyes".to_owned()])]);
    assert_eq!((mesh.positions.len(), mesh.faces.len()), (6, 2));
    assert_eq!(mesh.faces[1], [3, 4, 5]);
    let names: Vec<_> = mesh.shapes.iter().map(|shape| shape.name.as_str()).collect();
    assert_eq!(names, ["raised", "other"]);
    near(mesh.positions[5], [4.0, 5.0, 2.0], 1e-6);
    near(mesh.shapes[0].deltas[1], [0.0, 0.0, 1.0], 1e-6);
    near(mesh.shapes[0].deltas[4], [0.0, -2.0, 0.0], 1e-6);
    near(mesh.shapes[1].deltas[1], [0.0; 3], 0.0);
    near(mesh.shapes[1].deltas[4], [0.0, -2.0, 0.0], 1e-6);
}

#[test]
fn a_scene_without_targets_is_refused() {
    let mut made = Made::scene();
    made.json["meshes"][0]["primitives"][0].as_object_mut().unwrap().remove("targets");
    made.json["meshes"][0].as_object_mut().unwrap().remove("weights");
    let error = read_shapes(&made.write("shaped-none")).unwrap_err().to_string();
    assert_eq!(error, "has no blendshape: export the face with its shape keys (morph targets)");
}

/// A script read the expected counts and names from the file by the specification of the format.
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
