//! Tests of FBX: refused files and their messages; blendshapes; and real scenes against
//! another importer.

use super::*;
use crate::ErrorKind;
use crate::examples::{Examples, Source, load, npz};
use crate::formats::fbx::meshes::parse_shapes;

#[track_caller]
fn says(fault: &Error, expected: &str) {
    let text = fault.to_string();
    assert!(text.starts_with(expected), "{text}");
    assert!(!text.ends_with('.') && text.len() > expected.len(), "{text}");
}

#[test]
fn files_that_are_not_fbx_are_refused() {
    let folder = Folder::new("fbx");
    for bytes in [&b""[..], b"garbage", b"v 0 0 0\n", b"Kaydara FBX Binary  \0\x1a\0\xe8\x1c\0\0"] {
        let path = folder.write("a.fbx", bytes);
        let error = read(&path, &KEYS).err().unwrap();
        assert_eq!(error.kind(), ErrorKind::Damaged);
        says(&error, "is no FBX file that can be read: ");
    }
    let error = read(&folder.0.join("none.fbx"), &KEYS).err().unwrap();
    assert_eq!(error.kind(), ErrorKind::Read);
}

#[test]
fn a_scene_without_a_mesh_a_joint_or_an_animation_is_refused() {
    let mut scene = Scene::default();
    let parse = |scene: &Scene| parse(scene.text().as_bytes(), &KEYS).err().unwrap();
    says(&parse(&scene), "is empty: its scene shows no node");
    let mut bare = Scene::default();
    bare.node("bone", "LimbNode", 0, &[]);
    says(&parse(&bare), "holds no mesh");
    let node = scene.node("body", "Mesh", 0, &[]);
    scene.mesh(node, &ARM, &FACES, "");
    says(&parse(&scene), "has no joint");
    scene.node("bone", "LimbNode", 0, &[]);
    says(&parse(&scene), "holds no animation");
    let layer = scene.animation("still");
    let text = "no animation targets a joint or a shape of the mesh (clips: still)";
    says(&parse(&scene), text);
    scene.keys(layer, node, "Lcl Translation", "d|X", &[(0, 0.0), (1, 1.0)]);
    says(&parse(&scene), text);
}

#[test]
fn missing_and_idle_clips_are_refused() {
    let mut arm = Arm::skinned("Linear");
    arm.scene.animation("empty");
    let fault = |clip: &str| {
        let sampling = Sampling {
            fps: None,
            clips: &[clip.to_owned()],
            shapes: true,
            still: false,
            played: false,
            curves: false,
        };
        arm.sampled(&sampling).err().unwrap().to_string()
    };
    assert_eq!(fault("walk"), "has no clip walk, there are: bend, empty");
    assert!(fault("empty").contains("(clips: empty)"));
}

#[test]
fn skins_that_cannot_be_read_name_the_mesh() {
    let mut arm = Arm::skinned("Linear");
    arm.bind(arm.mesh, "Linear");
    says(&arm.fault(), "mesh body has 2 skins, expected one");
    let mut arm = Arm::bare();
    arm.scene.skin(arm.mesh, "Linear");
    says(&arm.fault(), "the skin of mesh body has no joint");
    let mut arm = Arm::bare();
    let skin = arm.scene.skin(arm.mesh, "Linear");
    let flat = [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 0., 0., 0., 0., 0., 1.];
    arm.scene.cluster(skin, arm.tip, &[(0, 1.0)], flat, translation(0.0, 0.0, 0.0));
    says(&arm.fault(), "the bind matrix of joint tip cannot be inverted");
}

#[test]
fn meshes_bound_in_different_poses_are_refused() {
    let bound = |apart: f64| {
        let mut arm = Arm::skinned("Linear");
        let node = arm.scene.node("sleeve", "Mesh", 0, &[]);
        let mesh = arm.scene.mesh(node, &ARM, &FACES, "");
        let skin = arm.scene.skin(mesh, "Linear");
        let link = translation(1.0 + apart, 0.0, 0.0);
        arm.scene.cluster(skin, arm.tip, &[(0, 1.0)], translation(-1.0, 0.0, 0.0), link);
        arm
    };
    says(&bound(0.5).fault(), "mesh sleeve binds joint tip elsewhere than the other meshes do");
    assert_eq!(bound(1e-6).rig().rest.len(), 10, "rounding is no difference");
}

#[test]
fn joints_that_hide_or_mirror_are_named_with_their_frame() {
    for (x, words) in
        [(0.0, "frame 1: joint tip is scaled to 0: "), (-1.0, "frame 1: joint tip is mirrored: ")]
    {
        let mut arm = Arm::skinned("Linear");
        arm.scene.keys(arm.layer, arm.tip, "Lcl Scaling", "d|X", &[(1, 1.0), (2, x)]);
        let folder = Folder::new(&format!("fbx-hidden{x}"));
        let path = folder.write("arm.fbx", arm.scene.text());
        let error = load(&Source::file(&path)).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
}

/// Rigs often mirror the joints of one side.
#[test]
fn a_joint_that_is_mirrored_in_the_bind_pose_too_moves_like_another() {
    let mut arm = Arm::bare();
    arm.scene.keys(arm.layer, arm.tip, "Lcl Scaling", "d|X", &[(1, -1.0), (2, -1.0)]);
    let skin = arm.scene.skin(arm.mesh, "Linear");
    let weights = [(0, 1.0), (1, 1.0), (2, 0.5), (4, 1.0)];
    let here = translation(0.0, 0.0, 0.0);
    arm.scene.cluster(skin, arm.root, &weights, here, here);
    // x becomes 1 - x, both there and back.
    let mirror = [-1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 1., 0., 0., 1.];
    arm.scene.cluster(skin, arm.tip, &[(2, 0.5), (3, 1.0)], mirror, mirror);
    let folder = Folder::new("fbx-mirrored-bind");
    let [found, expected] = [arm, Arm::skinned("Linear")].map(|arm| {
        load(&Source::file(&folder.write("arm.fbx", arm.scene.text()))).unwrap().examples
    });
    near(&found.rest, &expected.rest);
    near(&found.vertices, &expected.vertices);
    let same = |a: &[[[f64; 4]; 3]], b: &[[[f64; 4]; 3]]| {
        let pairs = a.as_flattened().as_flattened().iter().zip(b.as_flattened().as_flattened());
        a.len() == b.len() && pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 1e-9
    };
    assert!(same(&found.transforms, &expected.transforms), "{:?}", found.transforms);
    // The rest frame is a rotation: all three axes change sides.
    let rest = [[1.0, 0.0, 0.0, 1.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, -1.0, 0.0]];
    assert!(same(&found.skeleton.rest[1..], &[rest]), "{:?}", found.skeleton.rest);
}

#[test]
fn joints_under_a_constraint_without_keys_are_refused() {
    let constrained = |keyed: bool| {
        let mut arm = Arm::skinned("Linear");
        let group = arm.scene.node("group", "Null", 0, &[]);
        let target = arm.scene.node("target", "Null", 0, &[]);
        arm.scene.connect(arm.root, group);
        let joint = if keyed { arm.tip } else { group };
        let inside = "Type: \"Position From Positions\"\n";
        let constraint =
            arm.scene.object("Constraint", "follow", "Position From Positions", inside);
        arm.scene.connect_to(joint, constraint, "Constrained Object");
        arm.scene.connect_to(target, constraint, "Source");
        arm
    };
    let mut arm = constrained(true);
    assert_eq!(arm.rig().names, ["root", "tip"], "what is baked needs no constraint");
    arm = constrained(false);
    says(&arm.fault(), "joint group has no keys but a constraint, follow, which is not evaluated");
}

#[test]
fn spoiled_scenes_do_not_panic() {
    let mut arm = Arm::skinned("Linear");
    arm.scene.channel(arm.mesh, "", &[(50.0, 3, [0.0, 0.0, 2.0]), (100.0, 3, [0.0, 1.0, 1.0])]);
    let text = arm.scene.text();
    assert!(arm.rig().shapes.is_some());
    spoil(text.as_bytes(), |bytes| drop(parse(bytes, &KEYS)));
}

#[test]
fn numbers_that_are_not_finite_do_not_panic() {
    let text = Arm::skinned("Linear").scene.text();
    for number in ["nan", "inf", "-inf", "1e308", "-1e308", "99999999999"] {
        for place in text.match_indices("a: ").map(|(place, _)| place + 3) {
            let end = place + text[place..].find([',', '\n']).unwrap();
            let spoiled = format!("{}{number}{}", &text[..place], &text[end..]);
            drop(parse(spoiled.as_bytes(), &KEYS));
        }
    }
}

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
    let expected = [FormatWarning::UnshapedMeshes(meshes), FormatWarning::ShapesBetween(channels)];
    assert_eq!(found.warnings, expected);
}

#[test]
fn shapes_of_a_mirrored_mesh_and_its_faces_are_mirrored() {
    let mut scene = Scene::default();
    let node = scene.node("head", "Mesh", 0, &[("Lcl Scaling", [-1.0, 1.0, 1.0])]);
    let mesh = scene.mesh(node, &ARM, &FACES, TEXTURE);
    scene.channel(mesh, "blink", &[(100.0, 1, [1.0, 0.0, 0.5])]);
    let found = parse_shapes(scene.text().as_bytes()).unwrap();
    near(&found.positions, &ARM.map(|[x, y, z]| [-x, y, z]));
    near(&found.shapes[0].deltas[..2], &[[0.0; 3], [-1.0, 0.0, 0.5]]);
    assert_eq!(found.faces, [vec![4, 3, 1, 0], vec![3, 2, 1]]);
    assert_eq!(found.uv_faces, [vec![0, 2, 1, 0], vec![2, 2, 1]]);
}

#[test]
fn a_mesh_without_channels_is_refused() {
    let mut scene = Scene::default();
    let node = scene.node("head", "Mesh", 0, &[]);
    scene.mesh(node, &ARM, &FACES, "");
    let error = parse_shapes(scene.text().as_bytes()).unwrap_err().to_string();
    assert_eq!(error, "has no blendshape: export the face with its shape keys (morph targets)");
}

/// Returns the folder of the real scenes; `None` if there is none, which is a failure in CI.
fn data() -> Option<std::path::PathBuf> {
    crate::formats::testing::shared("dem-bones")
}

/// Reads a scene, and the arrays that Blender's importers of Alembic and FBX made of it.
fn shared(scene: &str) -> Option<(Examples, SampledScene)> {
    let data = data()?;
    let examples = npz::load(&data.join("bone.npz")).unwrap().examples;
    Some((examples, read(&data.join(scene), &KEYS).unwrap_or_else(|error| panic!("{error}"))))
}

/// The rotation from y up to z up, as in Blender.
fn turn() -> Matrix4<f64> {
    Matrix4::new(1., 0., 0., 0., 0., 0., -1., 0., 0., 1., 0., 0., 0., 0., 0., 1.)
}

fn turned([x, y, z]: [f64; 3]) -> [f64; 3] {
    [x, -z, y]
}

/// Returns the joint of the arrays with a given name.
fn of_name(examples: &Examples, name: &str) -> usize {
    examples.skeleton.names.iter().position(|other| other == name).unwrap()
}

fn check(examples: &Examples, rig: &SampledScene) {
    let mut names = rig.names.clone();
    names.sort();
    assert_eq!(names, ["joint1", "joint2", "joint3", "joint4", "joint5", "joint6"]);
    assert_eq!((rig.rest.len(), rig.triangles.len(), rig.frames.len()), (754, 1504, 400 * 6));
    assert_eq!(rig.triangles, examples.triangles);
    assert_eq!(rig.warnings, []);
    // Normals are smooth and the texture has seams, so vertices split only by texture coordinates and tangents.
    let engine = rig.engine.as_ref().unwrap();
    let uv = engine.uv.iter().flatten().map(|uv| uv.map(f64::to_bits));
    let apart: std::collections::BTreeSet<_> = engine.copy_of.iter().zip(uv).collect();
    assert_eq!((apart.len(), engine.normals.is_some()), (808, true));
    for (found, expected) in rig.rest.iter().zip(&examples.rest) {
        let found = turned(*found);
        assert!((0..3).all(|axis| (found[axis] - expected[axis]).abs() < 2e-7));
    }
    let mut worst: f64 = 0.0;
    for (joint, name) in rig.names.iter().enumerate() {
        let other = of_name(examples, name);
        let parent = rig.parents[joint].map(|parent| of_name(examples, &rig.names[parent]));
        // In the arrays, the second root hangs under the first root.
        assert!(parent == examples.skeleton.parents[other] || name == "joint4");
        let back = rig.binds[joint].try_inverse().unwrap();
        for frame in 0..400 {
            let map = turn() * rig.frames[6 * frame + joint] * back * turn().transpose();
            let expected = examples.pose(frame)[other];
            for (row, expected) in expected.iter().enumerate() {
                for (column, expected) in expected.iter().enumerate() {
                    worst = worst.max((map[(row, column)] - expected).abs());
                }
            }
        }
    }
    // Blender computes in single precision.
    assert!(worst < 1e-6, "{worst:e}");
}

#[test]
fn a_skeleton_beside_a_mesh_moves_as_another_importer_says() {
    let Some((examples, rig)) = shared("Bone_Trans.fbx") else { return };
    check(&examples, &rig);
    assert!(rig.shapes.is_none());
    let [clip] = &rig.clips[..] else { panic!("{:?}", rig.clips) };
    assert_eq!((clip.name.as_str(), clip.times.len()), ("Take 001", 400));
    // The take begins at frame 1.
    assert!((clip.times[0] - 1.0 / 24.0).abs() < 1e-9);
    assert!((clip.times[399] - 400.0 / 24.0).abs() < 1e-9);
}

#[test]
fn a_skin_poses_its_mesh_as_the_other_importer_s_maps_do() {
    let Some((examples, rig)) = shared("Bone_All.fbx") else { return };
    check(&examples, &rig);
    assert!(!rig.morphs);
    // Weights from the file; rest positions and maps from the arrays.
    let scene = open(&std::fs::read(data().unwrap().join("Bone_All.fbx")).unwrap()).unwrap();
    let mut weights = vec![[0.0; 6]; 754];
    for cluster in &scene.skin_deformers[0].clusters {
        let joint = of_name(&examples, &cluster.bone_node.as_ref().unwrap().element.name);
        for (&vertex, &weight) in cluster.vertices.iter().zip(&cluster.weights) {
            weights[vertex as usize][joint] = weight;
        }
    }
    let mut worst: f64 = 0.0;
    for (frame, shape) in shapes(&rig).into_iter().enumerate() {
        for (vertex, found) in shape.iter().enumerate() {
            // FBX divides weights by their sum, which is only nearly 1 here.
            let sum: f64 = weights[vertex].iter().sum();
            let mut expected = [0.0; 3];
            for (map, weight) in examples.pose(frame).iter().zip(weights[vertex]) {
                for (row, expected) in map.iter().zip(&mut expected) {
                    let moved: f64 =
                        (0..3).map(|axis| row[axis] * examples.rest[vertex][axis]).sum();
                    *expected += weight / sum * (moved + row[3]);
                }
            }
            let found = turned(*found);
            worst = (0..3).map(|axis| (found[axis] - expected[axis]).abs()).fold(worst, f64::max);
        }
    }
    assert!(worst < 2e-6, "{worst:e}");
}

#[test]
fn real_scenes_without_an_animation_say_so() {
    let Some(data) = data() else { return };
    let fault = |scene: &str| read(&data.join(scene), &KEYS).err().unwrap().to_string();
    assert!(fault("Bone_Geom.fbx").starts_with("has no joint: "));
    assert!(fault("Bone_Skin.fbx").contains("(clips: Take 001)"));
}

#[test]
fn spoiled_binary_scenes_do_not_panic() {
    let Some(data) = data() else { return };
    let bytes = std::fs::read(data.join("Bone_All.fbx")).unwrap();
    for len in (0..bytes.len()).step_by(1999) {
        drop(parse(&bytes[..len], &KEYS));
    }
    let mut spoiled = bytes.clone();
    for place in (0..bytes.len()).step_by(1499) {
        spoiled[place] ^= 0xff;
        drop(parse(&spoiled, &KEYS));
        spoiled[place] = bytes[place];
    }
}
