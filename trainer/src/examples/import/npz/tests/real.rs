//! The real sets beside the repository.

use super::*;
use crate::formats::testing;

/// Loads a set of `../shared/data`, which must be there where CI is set.
fn shared(set: &str) -> Option<Loaded> {
    testing::shared(set).map(|set| load(&set).unwrap())
}

fn counts(examples: &Examples) -> [usize; 7] {
    [
        examples.frame_len(),
        examples.vertex_len(),
        examples.triangles.len(),
        examples.joint_len(),
        examples.frames_of(Split::Train).len(),
        examples.frames_of(Split::HeldOut).len(),
        examples.frames_of(Split::Extreme).len(),
    ]
}

#[test]
fn dem_bones_loads() {
    let Some(Loaded { mut examples, warnings, .. }) = shared("dem-bones/bone.npz") else { return };
    assert_eq!(counts(&examples), [400, 754, 1504, 6, 300, 100, 0]);
    let joints = vec!["joint1".to_owned(), "joint4".to_owned()];
    assert_eq!(warnings, [Warning::SeveralRoots { joints }]);
    let parents = [None, Some(0), Some(0), Some(0), Some(3), Some(3)];
    assert_eq!(examples.skeleton.parents, parents);
    assert_eq!(examples.skeleton.roots, [3]);
    let split = examples.split.clone();
    examples.hold_out(0.25).unwrap();
    assert_eq!(examples.split, split);
}

#[test]
fn mpfb_arm_loads_and_its_origins_can_be_found_again() {
    let Some(Loaded { mut examples, warnings, .. }) = shared("mpfb-arm/mpfb_arm.npz") else {
        return;
    };
    assert_eq!(counts(&examples), [264, 899, 1666, 5, 180, 70, 14]);
    assert_eq!(warnings, []);
    // Ball joints: the elbow is a hinge with pronation, whose origin the data gives as well.
    let diagonal = examples.diagonal();
    let given = examples.skeleton.rest.clone();
    examples.skeleton.unplaced = (1..5).collect();
    examples.place_joints();
    for joint in 1..5 {
        let [given, found] =
            [&given, &examples.skeleton.rest].map(|rest| rest[joint].map(|row| row[3]));
        // A hinge's origin may slide along its axis: what counts is that both maps agree there.
        let mut worst: f64 = 0.0;
        for frame in examples.frames_of(Split::Train) {
            let pose = examples.pose(frame);
            let parent = examples.skeleton.parents[joint].unwrap();
            for row in 0..3 {
                let at = |map: &Matrix3x4| {
                    map[row][3] + (0..3).map(|axis| map[row][axis] * found[axis]).sum::<f64>()
                };
                worst = worst.max((at(&pose[joint]) - at(&pose[parent])).abs());
            }
        }
        assert!(
            worst < 1e-5 * diagonal,
            "joint {joint}: {worst}, given {given:?}, found {found:?}"
        );
    }
    assert!(examples.engine.is_none() && examples.surface().tangents().is_none());
}

#[test]
fn mpfb_body_loads() {
    let Some(Loaded { examples, warnings, .. }) = shared("mpfb-body/mpfb_body.npz") else { return };
    assert_eq!(counts(&examples), [220, 13380, 26756, 53, 160, 60, 0]);
    assert_eq!(warnings, []);
    // As many as the file has coordinates that a corner names.
    let engine = examples.engine.as_ref().unwrap();
    assert_eq!(engine.copy_of.len(), 14517);
    let normals = examples.surface().normals();
    // Nothing shades along a seam.
    for (copy, &vertex) in engine.copy_of.iter().enumerate().skip(1) {
        let beside = engine.copy_of[copy - 1] == vertex;
        assert!(!beside || normals[copy - 1] == normals[copy]);
    }
    assert!(normals.iter().all(|n| (n.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-12));
}
