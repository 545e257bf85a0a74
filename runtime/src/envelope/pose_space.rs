//! Which space the matrices of a pose are in, if they do not lead from rest to posed in model space.

use super::key::joint_index;
use super::pose_fault::PoseFaultKind as Kind;
use super::pose_limits::{RIGID_TOLERANCE, allowance_of, origin};
use super::view::Envelope;
use crate::linear::{Matrix3x4, compose, dot, floats, inverse, moved, rows};

/// How far from the origin a frame is taken for the identity, as a share of the diagonal.
const IDENTITY_REACH: f32 = 1.0e-5;

/// Where a joint stands and where its parent carries it, by the joint's matrix, the parent's, and the inverse bind
/// matrices of both.
type Ends = fn([&Matrix3x4; 2], [&Matrix3x4; 2]) -> [[f32; 3]; 2];

/// What matrices may be in place of skinning matrices, the likely first. A joint's rest origin is its frame's.
const SPACES: [(Kind, Ends); 4] = [
    (Kind::Frames, |[own, above], [bind, bind_above]| {
        [shift(own), moved(above, moved(bind_above, origin(bind)))]
    }),
    (Kind::BoundTwice, |[own, above], [bind, bind_above]| {
        let origin = origin(bind);
        [
            moved(own, moved(&inverse(bind), origin)),
            moved(above, moved(&inverse(bind_above), origin)),
        ]
    }),
    (Kind::Local, |[own, _], [bind, bind_above]| [shift(own), moved(bind_above, origin(bind))]),
    // Local transforms that were gathered as frames, with the inverse bind matrices.
    (Kind::Local, |[own, _], [bind, bind_above]| {
        [moved(own, origin(bind)), moved(bind_above, origin(bind))]
    }),
];

/// Finds the space in which every joint is where its parent carries it.
pub(super) fn of(envelope: &Envelope<'_>, pose: &[Matrix3x4]) -> Option<Kind> {
    if is_unset(envelope, pose) {
        return Some(Kind::Unset);
    }
    let bind = |joint: usize| Some(rows(&floats(envelope.bind_words().get(joint)?)));
    let is_joined = |ends: Ends, (joint, parent): (usize, &[u8; 2])| -> Option<bool> {
        let Some(parent) = joint_index(parent) else { return Some(true) };
        let matrices = [pose.get(joint)?, pose.get(parent)?];
        let [own, carried] = ends(matrices, [&bind(joint)?, &bind(parent)?]);
        let apart = [own[0] - carried[0], own[1] - carried[1], own[2] - carried[2]];
        let allowed = allowance_of(envelope, joint);
        Some(dot(apart, apart) <= allowed * allowed)
    };
    let all_joined = |ends: Ends| {
        envelope.parents().iter().enumerate().all(|joint| is_joined(ends, joint) == Some(true))
    };
    SPACES.iter().find(|(_, ends)| all_joined(*ends)).map(|(kind, _)| *kind)
}

/// Whether the frames from which a pose was gathered are all the identity.
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

fn shift(m: &Matrix3x4) -> [f32; 3] {
    m.map(|[.., shift]| shift)
}
