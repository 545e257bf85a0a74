//! Mistakes about a whole pose of rigid matrices, such as other axes or another space.
//!
//! A mistake explains a fault if, with the mistake undone, every joint is where its parent carries it.

use super::fault::{PoseFault, PoseFaultKind as Kind, RIGID_TOLERANCE, allowance_of, rest_origin};
use crate::envelope::view::{Envelope, joint_index};
use crate::linear::{Matrix3x4, compose, dot, floats, inverse, moved, rows};

/// Orders of the axes, the model's own first.
const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [2, 1, 0], [1, 0, 2], [1, 2, 0], [2, 0, 1]];
/// Largest distance from 1 of a factor that counts as the right unit.
const SAME_UNIT: f32 = 0.02;
/// Least and greatest factor between units: a mile is 1.6e6 millimetres.
const FACTORS: [f32; 2] = [1.0e-7, 1.0e7];
/// Largest distance from the origin of a frame that counts as the identity, as a share of the diagonal.
const IDENTITY_REACH: f32 = 1.0e-5;

/// Returns two positions of a joint: by its own matrix, and as its parent carries the joint.
///
/// Arguments: the matrices of the joint and of its parent, then the inverse bind matrices of both.
type Ends = fn([&Matrix3x4; 2], [&Matrix3x4; 2]) -> [[f32; 3]; 2];

/// Meanings that the matrices may have instead of skinning matrices, the likely first.
const SPACES: [(Kind, Ends); 4] = [
    // The rest origin of a joint is the origin of the joint's frame.
    (Kind::Frames, |[own, above], [bind, bind_above]| {
        [shift(own), moved(above, moved(bind_above, rest_origin(bind)))]
    }),
    (Kind::BoundTwice, |[own, above], [bind, bind_above]| {
        let origin = rest_origin(bind);
        [
            moved(own, moved(&inverse(bind), origin)),
            moved(above, moved(&inverse(bind_above), origin)),
        ]
    }),
    (Kind::Local, |[own, _], [bind, bind_above]| {
        [shift(own), moved(bind_above, rest_origin(bind))]
    }),
    // Local transforms that were gathered as frames, with the inverse bind matrices.
    (Kind::Local, |[own, _], [bind, bind_above]| {
        [moved(own, rest_origin(bind)), moved(bind_above, rest_origin(bind))]
    }),
];

/// Names the mistake that explains a fault of a pose of rigid matrices; returns the fault unchanged if none does.
pub(super) fn explain(envelope: &Envelope<'_>, pose: &[Matrix3x4], fault: PoseFault) -> PoseFault {
    if let Some(kind) = other_space(envelope, pose) {
        return PoseFault { kind, ..fault };
    }
    if has_lost_translations(envelope, pose) {
        return PoseFault { kind: Kind::Transposed, ..fault };
    }
    // One mistake is likelier than two.
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

/// Finds a space of the matrices in which every joint is where its parent carries it.
fn other_space(envelope: &Envelope<'_>, pose: &[Matrix3x4]) -> Option<Kind> {
    if is_unset(envelope, pose) {
        return Some(Kind::Unset);
    }
    let bind = |joint: usize| Some(rows(&floats(envelope.bind_words().get(joint)?)));
    let is_joined = |ends: Ends, (joint, parent): (usize, &[u8; 2])| -> Option<bool> {
        let Some(parent) = joint_index(parent) else { return Some(true) };
        let matrices = [pose.get(joint)?, pose.get(parent)?];
        let [own, carried] = ends(matrices, [&bind(joint)?, &bind(parent)?]);
        let apart = minus(own, carried);
        let allowed = allowance_of(envelope, joint);
        Some(dot(apart, apart) <= allowed * allowed)
    };
    let all_joined = |ends: Ends| {
        envelope.parents().iter().enumerate().all(|joint| is_joined(ends, joint) == Some(true))
    };
    SPACES.iter().find(|(_, ends)| all_joined(*ends)).map(|(kind, _)| *kind)
}

/// Whether all gathered frames of a pose are the identity.
fn is_unset(envelope: &Envelope<'_>, pose: &[Matrix3x4]) -> bool {
    let reach = IDENTITY_REACH * envelope.certificate().diagonal;
    let is_identity = |m: Matrix3x4| {
        let [[xx, xy, xz, tx], [yx, yy, yz, ty], [zx, zy, zz, tz]] = m;
        let off = [xx - 1.0, xy, xz, yx, yy - 1.0, yz, zx, zy, zz - 1.0];
        off.iter().all(|off| off.abs() <= RIGID_TOLERANCE)
            && dot([tx, ty, tz], [tx, ty, tz]) <= reach * reach
    };
    let mut frames =
        pose.iter().zip(envelope.inverse_binds()).map(|(m, bind)| compose(m, &inverse(&bind)));
    frames.all(is_identity)
}

/// Whether all translations are missing, in the pose or in its gathered frames.
///
/// The translations of a transposed 4 x 4 matrix are in its last row, which a 3 x 4 matrix drops.
fn has_lost_translations(envelope: &Envelope<'_>, pose: &[Matrix3x4]) -> bool {
    let is_zero = |m: &Matrix3x4| m.iter().all(|[.., shift]| *shift == 0.0);
    let is_near_zero = |m: &Matrix3x4| {
        let shift = shift(m);
        let reach = IDENTITY_REACH * envelope.certificate().diagonal;
        dot(shift, shift) <= reach * reach
    };
    let frame = |(m, bind): (&Matrix3x4, Matrix3x4)| is_near_zero(&compose(m, &inverse(&bind)));
    pose.iter().all(is_zero) || pose.iter().zip(envelope.inverse_binds()).all(frame)
}

/// Mistake about the axes, the signs or the layout of all matrices.
#[derive(Clone, Copy)]
struct Mistake {
    /// Axis of the pose for each axis of the model, from 0.
    order: [usize; 3],
    /// Sign of each axis, 1 or -1.
    signs: [f32; 3],
    transposed: bool,
    /// Whether the mistake was made with the joints' frames, before the inverse bind matrices were applied.
    of_frames: bool,
}

/// Gap between a joint and its parent under a mistake: `rotated + factor shifted`.
struct Gap {
    /// Part of the gap from the rotations, in the model's unit.
    rotated: [f32; 3],
    /// Part of the gap from the translations, in the unit of the pose.
    shifted: [f32; 3],
    /// Largest gap that is allowed.
    allowed: f32,
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

    /// Returns a matrix with the mistake undone. The unit stays.
    fn undo(&self, m: &Matrix3x4) -> Matrix3x4 {
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

    /// Lists the gaps of all joints but the root, with the mistake undone.
    fn gaps<'a>(
        &'a self,
        envelope: &'a Envelope<'_>,
        pose: &'a [Matrix3x4],
    ) -> impl Iterator<Item = Gap> + 'a {
        let bind =
            |joint: usize| envelope.bind_words().get(joint).map(|words| rows(&floats(words)));
        let undone = move |joint: usize| {
            let (m, bind) = (pose.get(joint)?, bind(joint)?);
            let m = if self.of_frames { compose(m, &inverse(&bind)) } else { *m };
            Some((self.undo(&m), bind))
        };
        envelope.parents().iter().enumerate().filter_map(move |(joint, parent)| {
            let ((own, bind), (above, bind_above)) =
                (undone(joint)?, undone(joint_index(parent)?)?);
            // Rest origin of the joint: in model space, or in the frames of the joint and of its parent.
            let rest = rest_origin(&bind);
            let (place, place_above) =
                if self.of_frames { ([0.0; 3], moved(&bind_above, rest)) } else { (rest, rest) };
            let turned = |m: &Matrix3x4, v: [f32; 3]| m.map(|[x, y, z, _]| dot([x, y, z], v));
            Some(Gap {
                rotated: minus(turned(&own, place), turned(&above, place_above)),
                shifted: minus(shift(&own), shift(&above)),
                allowed: allowance_of(envelope, joint),
            })
        })
    }

    /// Fits the factor for lengths of the pose that brings the joints nearest to their parents.
    fn factor(&self, envelope: &Envelope<'_>, pose: &[Matrix3x4]) -> Option<f32> {
        let (mut both, mut square) = (0.0, 0.0);
        for Gap { rotated, shifted, .. } in self.gaps(envelope, pose) {
            both += dot(rotated, shifted);
            square += dot(shifted, shifted);
        }
        let factor = -both / square;
        let [least, greatest] = FACTORS;
        (least <= factor && factor <= greatest).then_some(factor)
    }

    /// Whether every joint is where its parent carries it, with the mistake undone.
    fn explains(&self, envelope: &Envelope<'_>, pose: &[Matrix3x4], factor: f32) -> bool {
        self.gaps(envelope, pose).all(|Gap { rotated: [x, y, z], shifted, allowed }| {
            let [u, v, w] = shifted;
            let gap = [x + factor * u, y + factor * v, z + factor * w];
            dot(gap, gap) <= allowed * allowed
        })
    }

    /// Returns the axis of the pose for each axis of the model, from 1, negative if the axis is reversed.
    fn axes(&self) -> [i8; 3] {
        let [x, y, z] = self.order.map(|axis| axis as i8 + 1);
        let [sx, sy, sz] = self.signs.map(|sign| sign as i8);
        [sx * x, sy * y, sz * z]
    }

    /// Returns the kind of the mistake. The fault's factor and axes tell the rest.
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

fn minus(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn shift(m: &Matrix3x4) -> [f32; 3] {
    m.map(|[.., shift]| shift)
}
