//! Tests of curves from blendshape channels.

use super::{Arm, KEYS};
use crate::formats::scene::{CurveTrack, SampledScene, Sampling};

const CURVES: Sampling<'_> = Sampling { curves: true, ..KEYS };

fn track(name: &str, weights: &[f64]) -> CurveTrack {
    CurveTrack { name: name.to_owned(), mesh: "body".to_owned(), weights: weights.to_vec() }
}

#[track_caller]
fn near(rig: &SampledScene, expected: &[CurveTrack]) {
    let names = |all: &[CurveTrack]| -> Vec<[String; 2]> {
        all.iter().map(|track| [track.name.clone(), track.mesh.clone()]).collect()
    };
    assert_eq!(names(&rig.curves), names(expected));
    for (found, expected) in rig.curves.iter().zip(expected) {
        let apart = found.weights.iter().zip(&expected.weights).map(|(a, b)| (a - b).abs());
        assert!(apart.fold(0.0, f64::max) < 1e-6, "{found:?}, expected {expected:?}");
        assert_eq!(found.weights.len(), expected.weights.len());
    }
}

/// An arm with the channels `smile`, from 0 to 50 percent, and `frown`, at 30 percent.
fn arm() -> Arm {
    let mut arm = Arm::skinned("Linear");
    let smile = arm.scene.channel(arm.mesh, "smile", &[(100.0, 0, [0.0, 0.0, 1.0])]);
    arm.scene.keys(arm.layer, smile, "DeformPercent", "DeformPercent", &[(1, 0.0), (2, 50.0)]);
    let frown = arm.scene.channel(arm.mesh, "frown", &[(100.0, 1, [0.0, 0.0, 1.0])]);
    arm.scene.weigh(frown, 30.0);
    arm
}

#[test]
fn weights_of_channels_are_curves() {
    let rig = arm().sampled(&CURVES).unwrap();
    near(&rig, &[track("smile", &[0.0, 0.5]), track("frown", &[0.3, 0.3])]);
    assert_eq!(arm().rig().curves, []);
}

#[test]
fn a_clip_of_curves_alone_counts_if_curves_are_read() {
    let mut arm = arm();
    let layer = arm.scene.animation("talk");
    let jaw = arm.scene.channel(arm.mesh, "jaw", &[(100.0, 2, [0.0, 0.0, 1.0])]);
    arm.scene.keys(layer, jaw, "DeformPercent", "DeformPercent", &[(5, 0.0), (6, 100.0)]);
    let names = |rig: &SampledScene| -> Vec<String> {
        rig.clips.iter().map(|clip| clip.name.clone()).collect()
    };
    assert_eq!(names(&arm.rig()), ["bend"]);
    let rig = arm.sampled(&CURVES).unwrap();
    assert_eq!(names(&rig), ["bend", "talk"]);
    assert_eq!(rig.curves[2].weights[2..], [0.0, 1.0]);
}
