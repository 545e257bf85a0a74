//! Controls of stage polar: rotations by too few steps, and other rotations and strains, are caught.

use crate::stages::altered::{Step, altered};
use conformance::compare::Mismatch;
use conformance::finding::sound;
use conformance::models::{self, stretching_shape_of};
use conformance::poses::widened;
use conformance::stages::polar::body;
use conformance::subject::{FEWER_POSES, Subject};
use conformance::tolerance::Arithmetic;
use nalgebra::Matrix3;
use sinew_runtime::Matrix3x4;
use sinew_runtime::envelope::Predictor;
use sinew_trainer::numeric::affine::{cofactors, linear};

type Turn = [[f32; 3]; 3];
type Strain = [f32; 6];

/// Compares a backend with altered rotations and strains of the joints that stretched in training.
fn with(alter: impl Fn(&Matrix3x4, &mut Turn, &mut Strain)) -> Result<(), Mismatch> {
    of(true, alter)
}

/// Compares a backend with altered rotations and strains of the joints that stretched in training,
/// or of the others. Hidden joints keep their zeros.
fn of(stretched: bool, alter: impl Fn(&Matrix3x4, &mut Turn, &mut Strain)) -> Result<(), Mismatch> {
    let bytes = models::random(stretching_shape_of(Predictor::Kernel));
    let subject = Subject::new("random", &bytes, FEWER_POSES);
    let ranges = subject.oracle.stretch_ranges.as_ref().expect("joints stretch");
    let other = altered(
        |step: Step<'_>| {
            let Step::Polar { poses, out } = step else { return };
            let all = out.turns.iter_mut().zip(&mut out.strains);
            let all = poses.joints.iter().zip(all).zip(ranges.iter().cycle());
            for ((map, (turn, strain)), range) in all {
                if *turn != [[0.0; 3]; 3] && (*range > 0.0) == stretched {
                    alter(map, turn, strain);
                }
            }
        },
        Arithmetic::IEEE,
    );
    sound(&body(&other, &subject).expect("it runs"))
}

/// Computes the columns of a rotation by Newton's steps in f64.
fn by_steps(map: &Matrix3x4, steps: usize) -> Turn {
    let map = linear(&widened(map));
    let start = map * (3f64.sqrt() / map.norm());
    let step = |x: Matrix3<f64>, _| (x + cofactors(&x) / x.determinant()) / 2.0;
    let turn = (0..steps).fold(start, step);
    [0, 1, 2].map(|c| [0, 1, 2].map(|r| turn[(r, c)] as f32))
}

#[test]
fn too_few_steps_are_caught() {
    assert_eq!(with(|map, turn, _| *turn = by_steps(map, 7)), Ok(()));
    for steps in 0..6 {
        let caught = with(|map, turn, _| *turn = by_steps(map, steps));
        assert!(matches!(caught, Err(Mismatch::Beyond { .. })), "{steps}: {caught:?}");
    }
}

#[test]
fn other_rotations_and_strains_are_caught() {
    assert_eq!(with(|_, _, _| {}), Ok(()));
    let transposed = |_: &Matrix3x4, turn: &mut Turn, _: &mut Strain| {
        *turn = [0, 1, 2].map(|r| [0, 1, 2].map(|c| turn[c][r]));
    };
    assert!(with(transposed).is_err());
    assert!(with(|_, _, strain| strain.swap(2, 3)).is_err(), "another order");
    assert!(with(|_, _, strain| *strain = strain.map(|x| 2.0 * x)).is_err(), "not the half");
    // Strains of another measure: of the left stretch, L Lᵀ.
    let left = |map: &Matrix3x4, _: &mut Turn, strain: &mut Strain| {
        let map = linear(&widened(map));
        let square = map * map.transpose() - Matrix3::identity();
        let at = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
        *strain = at.map(|at| (square[at] / 2.0) as f32);
    };
    assert!(with(left).is_err());
}

#[test]
fn a_joint_that_does_not_stretch_keeps_its_linear_part() {
    assert_eq!(of(false, |_, _, _| {}), Ok(()));
    assert!(of(false, |map, turn, _| *turn = by_steps(map, 7)).is_err());
}
