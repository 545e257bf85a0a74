//! The real scenes beside the repository, against what another importer made of them.

use super::*;
use crate::examples::{Examples, npz};

const DATA: &str = "../../shared/data/dem-bones";

/// Finds the scenes, which must be there where CI is set.
fn data() -> Option<std::path::PathBuf> {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join(DATA);
    if !data.is_dir() {
        assert!(std::env::var_os("CI").is_none(), "CI is set, but there is no {}", data.display());
        eprintln!("not run: there is no {}", data.display());
        return None;
    }
    Some(data)
}

/// Reads a scene, and the arrays that Blender's importers of Alembic and of FBX made of it.
fn shared(scene: &str) -> Option<(Examples, SampledScene)> {
    let data = data()?;
    let examples = npz::load(&data.join("bone.npz")).unwrap().examples;
    Some((examples, read(&data.join(scene), &KEYS).unwrap_or_else(|error| panic!("{error}"))))
}

/// The turn from y up to z up, which Blender makes.
fn turn() -> Matrix4<f64> {
    Matrix4::new(1., 0., 0., 0., 0., 0., -1., 0., 0., 1., 0., 0., 0., 0., 0., 1.)
}

fn turned([x, y, z]: [f64; 3]) -> [f64; 3] {
    [x, -z, y]
}

/// The joint of the arrays that has the name of a joint of the rig.
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
    // Its normals are smooth, its texture has seams: as many coordinates as are named, but for tangents.
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
        // The arrays' second root hangs under the first.
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
    // Weights of the file; rest positions and maps of the arrays.
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
            // FBX divides weights by their sum, which these only nearly have at 1.
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
