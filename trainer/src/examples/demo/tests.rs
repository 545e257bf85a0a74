use sha2::{Digest, Sha256};

use nalgebra::Vector3;

use super::shape::above;
use super::*;
use crate::examples::Matrix3x4;

fn small() -> DemoOptions {
    DemoOptions { vertices: 500, poses: 24, held_out: 8, seed: 1 }
}

#[test]
fn counts_are_those_asked_for() {
    let examples = demo(&DemoOptions::default());
    assert!(examples.vertex_len().abs_diff(2000) < 100, "{}", examples.vertex_len());
    assert_eq!(examples.frames_of(Split::Train).len(), 120);
    assert_eq!(examples.frames_of(Split::HeldOut).len(), 40);
    assert_eq!(examples.joint_len(), 7);
}

#[test]
fn the_examples_are_valid_at_every_size() {
    for vertices in [0, 200, 500, 3000, 20_000] {
        let examples = demo(&DemoOptions { vertices, poses: 3, held_out: 1, seed: 9 });
        assert_eq!(examples.validate().unwrap(), []);
        assert!((examples.diagonal() - 0.94).abs() < 0.02, "{}", examples.diagonal());
    }
}

#[test]
fn held_out_clips_lie_between_training_clips() {
    let split = demo(&DemoOptions { vertices: 0, ..DemoOptions::default() }).split;
    let changes = split.windows(2).filter(|pair| pair[0] != pair[1]).count();
    assert!((6..=8).contains(&changes), "{changes}");
}

#[test]
fn bits_depend_on_the_options_alone() {
    let bits = |options: &DemoOptions| {
        let examples = demo(options);
        let mut hasher = Sha256::new();
        for number in examples
            .vertices
            .as_flattened()
            .iter()
            .chain(examples.transforms.as_flattened().as_flattened())
        {
            hasher.update(number.to_le_bytes());
        }
        hasher.finalize().iter().take(8).map(|byte| format!("{byte:02x}")).collect::<String>()
    };
    assert_eq!(bits(&small()), "5642dac45534e6ff", "the same on every machine");
    assert_ne!(bits(&small()), bits(&DemoOptions { seed: 2, ..small() }));
}

#[test]
fn held_out_frames_do_not_depend_on_the_training_frames() {
    let held_out = |examples: &Examples| {
        let frames = examples.frames_of(Split::HeldOut);
        frames.iter().map(|&frame| examples.frame(frame).to_vec()).collect::<Vec<_>>()
    };
    let fewer = demo(&DemoOptions { poses: 5, ..small() });
    assert_eq!(held_out(&demo(&small())), held_out(&fewer));
}

#[test]
fn the_pose_without_angles_is_the_rest_pose() {
    let pose = Pose::new(&[0.0; 13]);
    for point in &Skin::new(500).points {
        let moved = Flesh::new(point).posed(&pose);
        assert!((moved - point.position).norm() < 1e-15);
    }
}

#[test]
fn both_ends_follow_their_joints_rigidly() {
    let examples = demo(&small());
    let vertex_len = examples.vertex_len();
    for frame in 0..examples.frame_len() {
        for (joint, vertex) in [(0, 0), (0, 5), (6, vertex_len - 1), (6, vertex_len - 9)] {
            let expected = apply(&examples.pose(frame)[joint], &examples.rest[vertex]);
            let found = examples.frame(frame)[vertex];
            let gap = (0..3).map(|axis| (expected[axis] - found[axis]).abs()).fold(0.0, f64::max);
            assert!(gap < 1e-6, "frame {frame}, vertex {vertex}: {gap}");
        }
    }
}

#[test]
fn joints_stay_together() {
    let examples = demo(&small());
    let skeleton = &examples.skeleton;
    for frame in 0..examples.frame_len() {
        let pose = examples.pose(frame);
        for joint in 1..examples.joint_len() {
            let origin = skeleton.rest[joint].map(|row| row[3]);
            let parent = skeleton.parents[joint].unwrap();
            let (own, parents) = (apply(&pose[joint], &origin), apply(&pose[parent], &origin));
            assert!((0..3).all(|axis| (own[axis] - parents[axis]).abs() < 1e-12));
        }
    }
}

#[test]
fn faces_look_outward() {
    let skin = Skin::new(1500);
    for triangle in &skin.triangles {
        let [a, b, c] = triangle.map(|vertex| &skin.points[vertex]);
        let normal = (b.position - a.position).cross(&(c.position - a.position));
        // The normal points away from the middle of the section: forward at the front, up at the top.
        let (up, front) = (a.around.0 + b.around.0, a.around.1 + b.around.1);
        let thumb = (0.46..0.62).contains(&a.along) && up > 0.0;
        let outward = above() * up + Vector3::z() * front;
        assert!(thumb || normal.dot(&outward) > 0.0, "{triangle:?} at {}", a.along);
    }
}

#[test]
fn the_skin_has_normals_and_tangents_everywhere() {
    let examples = demo(&small());
    let length = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let surface = examples.surface();
    for (normal, tangent) in surface.normals().iter().zip(surface.tangents().unwrap()) {
        assert!((length(normal) - 1.0).abs() < 1e-12);
        assert!((length(&tangent[..3]) - 1.0).abs() < 1e-12);
        assert!((0..3).map(|axis| normal[axis] * tangent[axis]).sum::<f64>().abs() < 1e-12);
    }
}

fn apply(map: &Matrix3x4, point: &[f64; 3]) -> [f64; 3] {
    map.map(|row| row[3] + (0..3).map(|axis| row[axis] * point[axis]).sum::<f64>())
}
