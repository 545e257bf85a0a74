//! Seeded poses of any skeleton: inside and outside the trained range, near half turns, at rest,
//! and far from the origin.

use nalgebra::{Matrix3, Matrix3x4, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew_runtime::Envelope;
use sinew_trainer::envelope::lbs::poses::rigid_inverse;
use sinew_trainer::numeric::affine::after;
use sinew_trainer::numeric::so3;
use std::f64::consts::PI;

/// Number of poses of a conformance test.
pub const POSES: usize = 1024;
/// Largest offset of a pose from the character's rest place, in diagonals.
const FAR: f64 = 100.0;

/// The kind of a pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Every joint at rest.
    Rest,
    /// Angles within the trained ranges.
    Trained,
    /// One joint within its trained range, the others at rest.
    Single,
    /// Any angle; joints displaced by some tenths of the diagonal.
    Beyond,
    /// Angles that differ from π by a millionth to a tenth.
    HalfTurn,
    /// Angles from 1e-9 to 1e-3.
    Tiny,
    /// Trained angles; matrices differ from a rotation by up to 1e-4, the limit for a pose.
    Stretched,
}

impl Kind {
    const ALL: [Self; 7] = [
        Self::Rest,
        Self::Trained,
        Self::Single,
        Self::Beyond,
        Self::HalfTurn,
        Self::Tiny,
        Self::Stretched,
    ];
}

/// A pose of J joints.
#[derive(Clone, Debug)]
pub struct Pose {
    /// The kind.
    pub kind: Kind,
    /// Whether a rigid motion moves the whole pose.
    pub moved: bool,
    /// Skinning matrices, rest to posed, model space, as a backend takes them.
    pub transforms: Vec<sinew_runtime::Matrix3x4>,
}

impl Pose {
    /// Converts the matrices to f64.
    pub fn widened(&self) -> Vec<Matrix3x4<f64>> {
        self.transforms.iter().map(widened).collect()
    }
}

/// Draws poses, every kind in turn, with and without a rigid motion; the first is the rest pose
/// without motion.
pub fn poses(envelope: &Envelope<'_>, count: usize) -> Vec<Pose> {
    let mut random = ChaCha8Rng::seed_from_u64(2007);
    let kinds = Kind::ALL.iter().flat_map(|&kind| [(kind, false), (kind, true)]).cycle();
    kinds.take(count).map(|(kind, moved)| pose(envelope, kind, moved, &mut random)).collect()
}

/// Draws a rigid motion of any angle and of up to a hundred diagonals.
pub fn rigid_motion(diagonal: f64, random: &mut ChaCha8Rng) -> Matrix3x4<f64> {
    let turn = so3::exp(&(direction(random) * random.random_range(0.0..PI)));
    let shift = direction(random) * (diagonal * random.random_range(0.0..FAR));
    map(&turn, &shift)
}

/// Rounds a transform to f32, as a backend takes it.
pub fn rounded(transform: &Matrix3x4<f64>) -> sinew_runtime::Matrix3x4 {
    [0, 1, 2].map(|r| [0, 1, 2, 3].map(|c| transform[(r, c)] as f32))
}

/// Converts a transform to f64.
pub fn widened(transform: &sinew_runtime::Matrix3x4) -> Matrix3x4<f64> {
    Matrix3x4::from_fn(|r, c| f64::from(transform[r][c]))
}

fn pose(envelope: &Envelope<'_>, kind: Kind, moved: bool, random: &mut ChaCha8Rng) -> Pose {
    let joint_len = envelope.joint_len();
    let diagonal = f64::from(envelope.certificate().diagonal);
    let single = random.random_range(0..joint_len);
    let mut transforms = vec![Matrix3x4::identity(); joint_len];
    for joint in envelope.evaluation_order() {
        let trained = f64::from(envelope.pose_range(joint).unwrap_or_default());
        let angle = match kind {
            Kind::Rest => 0.0,
            Kind::Single if joint != single => 0.0,
            Kind::Trained | Kind::Single | Kind::Stretched => random.random_range(0.0..=trained),
            Kind::Beyond => random.random_range(0.0..PI),
            Kind::HalfTurn => PI + random.random_range(-1.0..1.0) * power(-6..0, random),
            Kind::Tiny => power(-9..-2, random),
        };
        let displaced = if kind == Kind::Beyond { 0.3 * diagonal } else { 0.0 };
        // The local motion rotates about the joint's rest origin, in the rest pose's axes.
        let turn = so3::exp(&(axis(random) * angle));
        let origin = envelope.inverse_bind(joint).map(|m| rigid_inverse(&widened(&m)));
        let origin = origin.map_or(Vector3::zeros(), |frame| frame.column(3).into_owned());
        let shift = direction(random) * (displaced * random.random_range(0.0..1.0));
        let local = map(&turn, &(origin - turn * origin + shift));
        transforms[joint] = match envelope.parent(joint) {
            Some(parent) => after(&transforms[parent], &local),
            None => local,
        };
    }
    if kind == Kind::Stretched {
        let strain = |r: usize, c: usize| if c < 3 { (3 * r + c) as f64 / 8.0 - 0.5 } else { 0.0 };
        let size = power(-7..-4, random);
        transforms
            .iter_mut()
            .for_each(|transform| *transform += Matrix3x4::from_fn(strain) * (0.3 * size));
    }
    if moved {
        let motion = rigid_motion(diagonal, random);
        transforms.iter_mut().for_each(|transform| *transform = after(&motion, transform));
    }
    Pose { kind, moved, transforms: transforms.iter().map(rounded).collect() }
}

/// Draws one of the three axes in half of the cases, which gives exact zeros; else any direction.
fn axis(random: &mut ChaCha8Rng) -> Vector3<f64> {
    if random.random() {
        return direction(random);
    }
    Vector3::ith(random.random_range(0..3), if random.random() { 1.0 } else { -1.0 })
}

fn direction(random: &mut ChaCha8Rng) -> Vector3<f64> {
    loop {
        let v = Vector3::from_fn(|_, _| random.random_range(-1.0..1.0_f64));
        if (0.1..1.0).contains(&v.norm()) {
            return v.normalize();
        }
    }
}

/// Draws a power of ten with any real exponent in a range.
fn power(exponents: std::ops::Range<i32>, random: &mut ChaCha8Rng) -> f64 {
    10f64.powf(random.random_range(f64::from(exponents.start)..f64::from(exponents.end)))
}

fn map(turn: &Matrix3<f64>, shift: &Vector3<f64>) -> Matrix3x4<f64> {
    let mut out = Matrix3x4::zeros();
    out.fixed_columns_mut::<3>(0).copy_from(turn);
    out.set_column(3, shift);
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::{self, shape_of};
    use sinew_runtime::Model;
    use sinew_runtime::envelope::Predictor;

    #[test]
    fn poses_are_rigid_and_the_same_every_time() {
        let bytes = models::random(shape_of(Predictor::Rotational));
        let model = Model::from_bytes(bytes).unwrap();
        let envelope = model.envelope().unwrap();
        let all = poses(&envelope, POSES);
        assert!(all.len() >= 1000);
        assert!(all.iter().zip(poses(&envelope, POSES)).all(|(a, b)| a.transforms == b.transforms));
        for pose in &all {
            for transform in pose.widened() {
                let turn = transform.fixed_columns::<3>(0).into_owned();
                assert!((turn.transpose() * turn - Matrix3::identity()).amax() < 1.5e-4);
                assert!(turn.determinant() > 0.0);
            }
        }
        let rest = vec![rounded(&Matrix3x4::identity()); envelope.joint_len()];
        assert!(all[0].transforms == rest && all[2].transforms != rest);
    }
}
