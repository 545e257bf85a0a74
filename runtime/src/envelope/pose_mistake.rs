//! What is wrong with a rigid pose whose joints are off their parents: the mistake about all of it that, undone,
//! puts them back.

use super::key::joint_index;
use super::pose_fault::{PoseFault, PoseFaultKind as Kind};
use super::pose_limits::{allowance_of, origin};
use super::pose_space;
use super::view::Envelope;
use crate::linear::{Matrix3x4, compose, dot, floats, inverse, moved, rows};

/// Orders of the axes, the model's own first.
const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [2, 1, 0], [1, 0, 2], [1, 2, 0], [2, 0, 1]];
/// How near to 1 a factor is taken for a right unit.
const SAME_UNIT: f32 = 0.02;
/// The least and the greatest factor between units: a mile is 1.6e6 millimetres.
const FACTORS: [f32; 2] = [1.0e-7, 1.0e7];

/// A mistake about a whole pose.
#[derive(Clone, Copy)]
struct Mistake {
    /// Which axis of the pose each axis of the model is.
    order: [usize; 3],
    signs: [f32; 3],
    transposed: bool,
    /// Whether it was made of the joints' frames, which the file's inverse bind matrices then turned into a pose,
    /// or of the pose.
    of_frames: bool,
}

/// Tries every mistake on a pose of rigid matrices, and names the one that explains it; else the fault remains.
pub(super) fn explained(
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
    fault: PoseFault,
) -> PoseFault {
    if let Some(kind) = pose_space::of(envelope, pose) {
        return PoseFault { kind, ..fault };
    }
    if has_lost_translations(envelope, pose) {
        return PoseFault { kind: Kind::Transposed, ..fault };
    }
    // A mistake about one thing is likelier than about two.
    for is_other_unit in [false, true] {
        for mistake in Mistake::all() {
            let Some(factor) = mistake.factor(envelope, pose) else { continue };
            let factor = if (factor - 1.0).abs() <= SAME_UNIT { 1.0 } else { factor };
            if (factor != 1.0) == is_other_unit && mistake.explains(envelope, pose, factor) {
                let (kind, axes) = (mistake.kind(), mistake.axes());
                return PoseFault { kind, factor, axes, ..fault };
            }
        }
    }
    fault
}

/// Whether no matrix of a pose, or of the frames that it was made of, moves the origin: they lie in the last row
/// of four by four, which was dropped.
fn has_lost_translations(envelope: &Envelope<'_>, pose: &[Matrix3x4]) -> bool {
    let unmoved = |m: &Matrix3x4| m.iter().all(|[.., shift]| *shift == 0.0);
    let near = |m: &Matrix3x4| {
        let [x, y, z] = m.map(|[.., shift]| shift);
        let reach = 1.0e-5 * envelope.certificate().diagonal;
        dot([x, y, z], [x, y, z]) <= reach * reach
    };
    let frame = |(m, bind): (&Matrix3x4, Matrix3x4)| near(&compose(m, &inverse(&bind)));
    pose.iter().all(unmoved) || pose.iter().zip(envelope.inverse_binds()).all(frame)
}

impl Mistake {
    /// Lists the mistakes, likely ones first.
    fn all() -> impl Iterator<Item = Self> {
        let axes = ORDERS.into_iter().flat_map(|order| (0..8u8).map(move |signs| (order, signs)));
        let both = [false, true];
        let kinds = both.into_iter().flat_map(move |transposed| both.map(|of| (transposed, of)));
        axes.flat_map(move |(order, signs)| {
            let sign = |axis: u8| if signs >> axis & 1 == 0 { 1.0 } else { -1.0 };
            let signs = [sign(0), sign(1), sign(2)];
            let mistake =
                move |(transposed, of_frames)| Self { order, signs, transposed, of_frames };
            kinds.clone().map(mistake)
        })
    }

    /// Returns a matrix without it, but for the unit.
    fn undone(&self, m: &Matrix3x4) -> Matrix3x4 {
        let mut out = [[0.0; 4]; 3];
        for (row, out) in out.iter_mut().enumerate() {
            for (column, out) in out.iter_mut().enumerate() {
                let source = [self.order.get(row), self.order.get(column)];
                let at = |r: usize, c: usize| m.get(r).and_then(|m| m.get(c)).copied();
                let value = match (source, self.transposed) {
                    ([Some(&r), Some(&c)], false) => at(r, c),
                    ([Some(&r), Some(&c)], true) => at(c, r),
                    ([Some(&r), None], _) => at(r, 3),
                    _ => None,
                };
                let sign = |axis: usize| self.signs.get(axis).copied().unwrap_or(1.0);
                *out = sign(row) * sign(column) * value.unwrap_or_default();
            }
        }
        out
    }

    /// Lists how far each joint is off its parent: what the rotations leave, and what the lengths of the pose add
    /// to it, times a factor; and how far it may be.
    fn gaps<'a>(
        &'a self,
        envelope: &'a Envelope<'_>,
        pose: &'a [Matrix3x4],
    ) -> impl Iterator<Item = ([f32; 3], [f32; 3], f32)> + 'a {
        let bind =
            |joint: usize| envelope.bind_words().get(joint).map(|words| rows(&floats(words)));
        let undone = move |joint: usize| {
            let (m, bind) = (pose.get(joint)?, bind(joint)?);
            let m = if self.of_frames { compose(m, &inverse(&bind)) } else { *m };
            Some((self.undone(&m), bind))
        };
        envelope.parents().iter().enumerate().filter_map(move |(joint, parent)| {
            let ((own, bind), (above, bind_above)) =
                (undone(joint)?, undone(joint_index(parent)?)?);
            // Where the joint is at rest: seen from the model, or from itself and from its parent.
            let rest = origin(&bind);
            let (place, place_above) =
                if self.of_frames { ([0.0; 3], moved(&bind_above, rest)) } else { (rest, rest) };
            let turned = |m: &Matrix3x4, v: [f32; 3]| m.map(|[x, y, z, _]| dot([x, y, z], v));
            let minus = |a: [f32; 3], b: [f32; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
            let shift = |m: &Matrix3x4| m.map(|[.., shift]| shift);
            let left = minus(turned(&own, place), turned(&above, place_above));
            Some((left, minus(shift(&own), shift(&above)), allowance_of(envelope, joint)))
        })
    }

    /// Finds by how much lengths of the pose are to be multiplied, so that joints come nearest to their parents.
    fn factor(&self, envelope: &Envelope<'_>, pose: &[Matrix3x4]) -> Option<f32> {
        let (mut both, mut square) = (0.0, 0.0);
        for (left, moved, _) in self.gaps(envelope, pose) {
            both += dot(left, moved);
            square += dot(moved, moved);
        }
        let factor = -both / square;
        let [least, greatest] = FACTORS;
        (least <= factor && factor <= greatest).then_some(factor)
    }

    /// Whether every joint is where its parent carries it, once the mistake is undone.
    fn explains(&self, envelope: &Envelope<'_>, pose: &[Matrix3x4], factor: f32) -> bool {
        self.gaps(envelope, pose).all(|(left, moved, allowed)| {
            let gap = |axis: usize| {
                let of = |v: [f32; 3]| v.get(axis).copied().unwrap_or_default();
                of(left) + factor * of(moved)
            };
            let gap = [gap(0), gap(1), gap(2)];
            dot(gap, gap) <= allowed * allowed
        })
    }

    /// Returns which axis of the pose each axis of the model is, from 1.
    fn axes(&self) -> [i8; 3] {
        let [x, y, z] = self.order.map(|axis| axis as i8 + 1);
        let [sx, sy, sz] = self.signs.map(|sign| sign as i8);
        [sx * x, sy * y, sz * z]
    }

    /// Names it; what it does to lengths is named beside.
    fn kind(&self) -> Kind {
        // An order that leaves one axis alone swaps the other two, which mirrors.
        let in_place = self.order.iter().zip(0..).filter(|(axis, place)| *axis == place).count();
        let [sx, sy, sz] = self.signs;
        let is_mirror = (sx * sy * sz < 0.0) != (in_place == 1);
        if self.transposed {
            Kind::Transposed
        } else if self.axes() == [1, 2, 3] {
            Kind::Units
        } else if is_mirror {
            Kind::Handedness
        } else {
            Kind::Axes
        }
    }
}
