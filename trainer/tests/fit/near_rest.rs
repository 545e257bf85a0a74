//! Confidence in poses close to rest, where no error is visible (METHOD §2.6).

use super::real_sets::{arm, only};
use nalgebra::{Matrix3x4, Vector3};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::{Envelope, Model};
use sinew_trainer::envelope::posed::{Pose, palette};
use sinew_trainer::envelope::train;
use sinew_trainer::examples::demo::{DemoOptions, demo};
use sinew_trainer::examples::{Examples, Skeleton};
use sinew_trainer::numeric::so3;
use sinew_trainer::progress::Silent;

/// Returns the skinning matrices of a pose in which one joint turns and its descendants follow, J.
///
/// - `turn`: axis times angle, in radians, in the axes of the rest pose.
fn turned(skeleton: &Skeleton, joint: usize, turn: &Vector3<f64>) -> Vec<[[f64; 4]; 3]> {
    let origin = Vector3::from(skeleton.rest[joint].map(|row| row[3]));
    let linear = so3::exp(turn);
    let shift = origin - linear * origin;
    let map = Matrix3x4::from_fn(|r, c| if c < 3 { linear[(r, c)] } else { shift[r] });
    let mut follows = vec![false; skeleton.parents.len()];
    let of = |(own, parent): (usize, &Option<usize>)| {
        follows[own] = own == joint || parent.is_some_and(|parent| follows[parent]);
        let map = if follows[own] { map } else { Matrix3x4::identity() };
        [0, 1, 2].map(|r| [0, 1, 2, 3].map(|c| map[(r, c)]))
    };
    skeleton.parents.iter().enumerate().map(of).collect()
}

/// Returns the axes from the centre of a cube to its faces, edges and corners, 26 unit vectors.
fn axes() -> Vec<Vector3<f64>> {
    let digits = |i: i32| [i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1].map(f64::from);
    let all = (0..27).map(digits).filter(|axis| *axis != [0.0; 3]);
    all.map(|axis| Vector3::from(axis).normalize()).collect()
}

/// Returns the least confidence in poses in which one joint turns by an angle about any axis.
fn least_confidence(examples: &Examples, file: &[u8], degrees: f64) -> f32 {
    let model = Model::from_bytes(file).unwrap();
    let envelope = model.first::<Envelope>().unwrap();
    let curves = vec![0.0; envelope.curve_len()];
    let mut least = f32::INFINITY;
    for joint in 0..examples.joint_len() {
        for axis in axes() {
            let turn = axis * degrees.to_radians();
            let joints = turned(&examples.skeleton, joint, &turn);
            let pose = Pose::new(&envelope, &joints, &curves);
            least = least.min(palette(&envelope, &pose, 0).unwrap().1);
        }
    }
    least
}

/// Checks that the model is sure of rest and of small turns, and that a turn of 40° about an untrained axis lowers the
/// confidence.
fn check(name: &str, examples: &Examples, file: &[u8]) {
    assert_eq!(least_confidence(examples, file, 0.0), 1.0, "{name} at rest");
    for degrees in [1.0, 2.5, 5.0] {
        let least = least_confidence(examples, file, degrees);
        println!("{name}: a turn of {degrees} degrees has a confidence of at least {least:.3}");
        assert!(least >= 0.9, "{name} at {degrees} degrees: {least}");
    }
    let least = least_confidence(examples, file, 40.0);
    assert!(least < 0.5, "{name} at 40 degrees: {least}");
}

#[test]
fn a_small_turn_about_any_axis_keeps_the_confidence() {
    let examples = demo(&DemoOptions::default());
    let file = train(&examples, &only(Predictor::Kernel), &Silent).unwrap().model;
    check("demo", &examples, &file);
    let Some((examples, file)) = arm() else { return };
    check("mpfb-arm", examples, file);
}
