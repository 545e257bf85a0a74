//! Seeded poses of any skeleton: inside and outside the trained range, near half turns, at rest, far
//! from the origin, stretched, hidden, and with curves.

use nalgebra::{Matrix3, Matrix3x4, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew_runtime::Envelope;
use sinew_trainer::numeric::affine::{after, linear};
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
    /// Trained angles; matrices differ from a rotation by up to 1e-4, the limit for a rigid pose.
    Nearly,
    /// Trained angles; joints that stretch are scaled and sheared by factors of 1/4 to 4.
    Stretched,
    /// Trained angles; a joint is scaled to 0 or mirrored. Only if joints stretch.
    Hidden,
}

impl Kind {
    const RIGID: [Self; 7] = [
        Self::Rest,
        Self::Trained,
        Self::Single,
        Self::Beyond,
        Self::HalfTurn,
        Self::Tiny,
        Self::Nearly,
    ];

    /// Lists the kinds of an envelope's poses.
    fn of(envelope: &Envelope<'_>) -> Vec<Self> {
        let others: &[Self] =
            if envelope.stretches() { &[Self::Stretched, Self::Hidden] } else { &[] };
        [&Self::RIGID[..], others].concat()
    }
}

/// A pose of J joints and C curves.
#[derive(Clone, Debug)]
pub struct Pose {
    /// The kind.
    pub kind: Kind,
    /// Whether a rigid motion moves the whole pose.
    pub moved: bool,
    /// Skinning matrices, rest to posed, model space, as a backend takes them.
    pub transforms: Vec<sinew_runtime::Matrix3x4>,
    /// Values of the curves.
    pub curves: Vec<f32>,
}

impl Pose {
    /// Converts the matrices to f64.
    pub fn widened(&self) -> Vec<Matrix3x4<f64>> {
        self.transforms.iter().map(widened).collect()
    }

    /// Converts the curves to f64.
    pub fn widened_curves(&self) -> Vec<f64> {
        self.curves.iter().map(|value| f64::from(*value)).collect()
    }
}

/// Draws poses, every kind in turn, with and without a rigid motion; the first is the rest pose
/// without motion.
pub fn poses(envelope: &Envelope<'_>, count: usize) -> Vec<Pose> {
    let mut random = ChaCha8Rng::seed_from_u64(2007);
    let kinds = Kind::of(envelope);
    let kinds = kinds.iter().flat_map(|&kind| [(kind, false), (kind, true)]).cycle();
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
    let single = random.random_range(0..joint_len.max(1));
    let mut transforms = vec![Matrix3x4::identity(); joint_len];
    for joint in envelope.evaluation_order() {
        let trained = f64::from(envelope.pose_range(joint).unwrap_or_default());
        let angle = match kind {
            Kind::Rest => 0.0,
            Kind::Single if joint != single => 0.0,
            Kind::Beyond => random.random_range(0.0..PI),
            Kind::HalfTurn => PI + random.random_range(-1.0..1.0) * power(-6..0, random),
            Kind::Tiny => power(-9..-2, random),
            _ => random.random_range(0.0..=trained),
        };
        let displaced = if kind == Kind::Beyond { 0.3 * diagonal } else { 0.0 };
        // The local motion rotates about the joint's rest origin, in the rest pose's axes.
        let turn = so3::exp(&(axis(random) * angle));
        let origin = envelope.inverse_bind(joint).map(|m| {
            let frame = widened(&m);
            -(linear(&frame).transpose() * frame.column(3))
        });
        let origin = origin.unwrap_or_else(Vector3::zeros);
        let shift = direction(random) * (displaced * random.random_range(0.0..1.0));
        let local = map(&turn, &(origin - turn * origin + shift));
        transforms[joint] = match envelope.parent(joint) {
            Some(parent) => after(&transforms[parent], &local),
            None => local,
        };
    }
    if kind == Kind::Nearly {
        let strain = |r: usize, c: usize| if c < 3 { (3 * r + c) as f64 / 8.0 - 0.5 } else { 0.0 };
        let size = power(-7..-4, random);
        transforms
            .iter_mut()
            .for_each(|transform| *transform += Matrix3x4::from_fn(strain) * (0.3 * size));
    }
    if matches!(kind, Kind::Stretched | Kind::Hidden) {
        let stretching = |joint: usize| envelope.stretch_range(joint) > Some(0.0);
        let joints = transforms.iter_mut().enumerate();
        for (_, transform) in joints.filter(|(joint, _)| stretching(*joint)) {
            stretch(transform, kind == Kind::Stretched, random);
        }
    }
    if kind == Kind::Hidden {
        let scale = match random.random_range(0..3) {
            0 => [-1.0, 1.0, 1.0],
            1 => [0.0, 1.0, 1.0],
            _ => [0.0; 3],
        };
        let scale = Matrix3::from_diagonal(&Vector3::from(scale));
        let hidden = linear(&transforms[single]) * scale;
        transforms[single].fixed_columns_mut::<3>(0).copy_from(&hidden);
    }
    if moved {
        let motion = rigid_motion(diagonal, random);
        transforms.iter_mut().for_each(|transform| *transform = after(&motion, transform));
    }
    let curves = (0..envelope.curve_len()).map(|curve| {
        let [least, most] = envelope.curve_range(curve).unwrap_or_default();
        match kind {
            Kind::Rest => 0.0,
            Kind::Single if curve != single => 0.0,
            Kind::Beyond => most + (most - least) * random.random_range(0.0..2.0),
            Kind::Tiny => most * power(-9..-2, random) as f32,
            _ => random.random_range(least..=most),
        }
    });
    let curves = curves.collect();
    Pose { kind, moved, transforms: transforms.iter().map(rounded).collect(), curves }
}

/// Scales a transform along any three axes, by factors near 1 or, if `far`, of 1/4 to 4: a scale and a
/// shear of the joint.
fn stretch(transform: &mut Matrix3x4<f64>, far: bool, random: &mut ChaCha8Rng) {
    let most = if far { 4f64.ln() } else { 0.2 };
    let factors = Vector3::from_fn(|_, _| random.random_range(-most..=most).exp());
    let axes = so3::exp(&(axis(random) * random.random_range(0.0..PI)));
    let stretched = linear(transform) * axes * Matrix3::from_diagonal(&factors) * axes.transpose();
    transform.fixed_columns_mut::<3>(0).copy_from(&stretched);
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
    use crate::models::{self, SHAPES, shape_of};
    use sinew_runtime::Model;
    use sinew_runtime::envelope::Predictor;

    #[test]
    fn poses_are_rigid_and_the_same_every_time() {
        let bytes = models::random(shape_of(Predictor::Rotational));
        let model = Model::from_bytes(bytes).unwrap();
        let envelope = model.first::<Envelope>().unwrap();
        let all = poses(&envelope, POSES);
        assert!(all.len() >= 1000);
        assert!(all.iter().zip(poses(&envelope, POSES)).all(|(a, b)| a.transforms == b.transforms));
        for pose in &all {
            assert!(pose.curves.is_empty() && !matches!(pose.kind, Kind::Stretched | Kind::Hidden));
            for transform in pose.widened() {
                let turn = transform.fixed_columns::<3>(0).into_owned();
                assert!((turn.transpose() * turn - Matrix3::identity()).amax() < 1.5e-4);
                assert!(turn.determinant() > 0.0);
            }
        }
        let rest = vec![rounded(&Matrix3x4::identity()); envelope.joint_len()];
        assert!(all[0].transforms == rest && all[2].transforms != rest);
    }

    #[test]
    fn poses_of_a_model_that_stretches_are_stretched_hidden_and_have_curves() {
        for shape in SHAPES.into_iter().filter(|shape| shape.stretches) {
            let bytes = models::random(shape);
            let model = Model::from_bytes(bytes).unwrap();
            let envelope = model.first::<Envelope>().unwrap();
            let all = poses(&envelope, POSES);
            assert!(all.iter().all(|pose| pose.curves.len() == shape.curves));
            let volumes = |kind: Kind| {
                let own = all.iter().filter(move |pose| pose.kind == kind);
                own.flat_map(Pose::widened).map(|map| linear(&map).determinant())
            };
            assert!(volumes(Kind::Stretched).any(|volume| volume < 0.1));
            assert!(volumes(Kind::Stretched).all(|volume| volume > 0.01));
            assert!(volumes(Kind::Stretched).any(|volume| volume > 10.0));
            assert!(volumes(Kind::Hidden).any(|volume| volume.abs() < 1e-6));
            assert!(volumes(Kind::Hidden).any(|volume| volume < -0.1));
        }
    }
}
