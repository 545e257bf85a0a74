//! Check of a pose: every matrix must be rigid, and every joint must be where its parent carries it.

use super::arrays::is_finite;
use super::fault::{
    CURVE_MARGIN, PoseFault, PoseFaultKind as Kind, RIGID_TOLERANCE, STRETCH_MARGIN, allowance,
    rest_origin,
};
use super::mistake;
use crate::envelope::confidence::norm;
use crate::envelope::polar::{is_hidden, strain};
use crate::envelope::view::{Envelope, joint_index};
use crate::linear::{Matrix3x4, cross, dot, floats, moved, rows};
use crate::matrix::scale_of;
use crate::numeric::sqrt;

/// Rounding allowance of a joint's position, as a share of the distance from the origin.
const ROUNDING: f32 = 4.0e-6;
/// Scale below which a joint counts as hidden.
const HIDDEN_SCALE: f32 = 1.0e-2;

impl Envelope<'_> {
    /// Checks for a debug build that a pose fits the skeleton, and names the likely mistake if the pose does not.
    ///
    /// Each matrix must be a rotation and a translation, up to a scale of 1.001. A joint that stretched in training may
    /// have twice the strain of [`Envelope::stretch_range`]. A curve may be ten times as large as in training. Each
    /// joint must be where its parent carries it. The gap may be twice [`Envelope::pose_gap`], and 0.1 % of the
    /// certificate's diagonal more. The gaps reveal other axes or units, transposed matrices, frames, local transforms,
    /// and inverse bind matrices applied twice.
    ///
    /// A right pose of 53 joints takes 1.3 µs on a desktop. A wrong pose is tried in all axes and units, and takes up
    /// to 8 ms.
    ///
    /// Two mistakes stay unseen. The whole character may stand or lie anywhere. A pose in which no joint turns is
    /// right in any axes.
    ///
    /// - `pose`: J skinning matrices, rest to posed, in model space.
    /// - `curves`: values of the C curves.
    ///
    /// # Errors
    /// A [`PoseFault`] of any [`super::PoseFaultKind`].
    pub fn check_pose(&self, pose: &[Matrix3x4], curves: &[f32]) -> Result<(), PoseFault> {
        if pose.len() != self.joint_len() {
            return Err(PoseFault::new(Kind::Length, pose.len()));
        }
        self.check_curves(curves)?;
        let diagonal = self.certificate().diagonal;
        let gaps = self.pose_ranges().get(self.joint_len()..).unwrap_or_default();
        let all = pose.iter().zip(self.bind_words()).zip(self.parents()).zip(gaps).enumerate();
        for (joint, (((matrix, bind), parent), [gap])) in all {
            self.check_matrix(matrix, joint)?;
            let Some(above) = joint_index(parent).and_then(|parent| pose.get(parent)) else {
                continue;
            };
            let origin = rest_origin(&rows(&floats(bind)));
            let (own, carried) = (moved(matrix, origin), moved(above, origin));
            let apart = [own[0] - carried[0], own[1] - carried[1], own[2] - carried[2]];
            let far = own[0].abs() + own[1].abs() + own[2].abs();
            let allowed = allowance(diagonal, f32::from_le_bytes(*gap)) + ROUNDING * far;
            let found = dot(apart, apart);
            // A parent that is not finite gives NaN, which must be refused too.
            let is_near = found <= allowed * allowed;
            if !is_near {
                return Err(self.not_joined(pose, joint, sqrt(found), allowed));
            }
        }
        Ok(())
    }

    /// Checks that each of C curves is finite and near its trained range.
    fn check_curves(&self, curves: &[f32]) -> Result<(), PoseFault> {
        if curves.len() != self.curve_len() {
            return Err(PoseFault::new(Kind::CurveLength, curves.len()));
        }
        for (curve, (value, range)) in curves.iter().zip(self.curve_ranges()).enumerate() {
            let [least, most] = floats(range);
            let reach = least.abs().max(most.abs());
            let (found, allowed) = (value.abs(), CURVE_MARGIN * reach);
            let is_near = found <= allowed;
            // A value that is not finite fails too. A curve that training left at 0 has no scale.
            if !is_near && (reach > 0.0 || !found.is_finite()) {
                return Err(PoseFault {
                    found: *value,
                    allowed,
                    ..PoseFault::new(Kind::Curve, curve)
                });
            }
        }
        Ok(())
    }

    /// Checks that a matrix is finite and as rigid as its joint was in training.
    #[inline]
    fn check_matrix(&self, matrix: &Matrix3x4, joint: usize) -> Result<(), PoseFault> {
        if is_rigid(matrix) {
            return Ok(());
        }
        let range = self.stretch_range(joint).unwrap_or_default();
        if range > 0.0 && is_finite(matrix) && !is_hidden(matrix) {
            let (found, allowed) = (norm(&strain(matrix)), STRETCH_MARGIN * range);
            if found <= allowed + RIGID_TOLERANCE {
                return Ok(());
            }
            let fault = PoseFault::new(Kind::Stretched, joint);
            return Err(PoseFault { found, allowed, ..fault });
        }
        Err(not_rigid(matrix, joint))
    }

    /// Returns the reason why a joint is off its parent.
    #[cold]
    fn not_joined(&self, pose: &[Matrix3x4], joint: usize, found: f32, allowed: f32) -> PoseFault {
        // A later joint that is not rigid may be the reason.
        for (joint, matrix) in pose.iter().enumerate() {
            if let Err(fault) = self.check_matrix(matrix, joint) {
                return fault;
            }
        }
        let fault = PoseFault { found, allowed, ..PoseFault::new(Kind::Apart, joint) };
        mistake::explain(self, pose, fault)
    }
}

/// Whether a matrix is finite, and its linear part a rotation.
#[inline]
fn is_rigid(m: &Matrix3x4) -> bool {
    let [[x0, x1, x2, tx], [y0, y1, y2, ty], [z0, z1, z2, tz]] = *m;
    let (x, y, z) = ([x0, x1, x2], [y0, y1, y2], [z0, z1, z2]);
    let near = |found: f32, expected: f32| (found - expected).abs() <= RIGID_TOLERANCE;
    // No short circuit: branches would cost more than products.
    (near(dot(x, x), 1.0) & near(dot(y, y), 1.0) & near(dot(z, z), 1.0))
        & (near(dot(x, y), 0.0) & near(dot(y, z), 0.0) & near(dot(z, x), 0.0))
        & (dot(cross(x, y), z) > 0.0)
        & (tx.is_finite() & ty.is_finite() & tz.is_finite())
}

/// Returns the fault of a matrix that is not rigid.
#[cold]
fn not_rigid(m: &Matrix3x4, joint: usize) -> PoseFault {
    if !is_finite(m) {
        return PoseFault::new(Kind::NonFinite, joint);
    }
    let [x, y, z] = m.map(|[x, y, z, _]| [x, y, z]);
    if *m == [[0.0; 4]; 3] {
        return PoseFault::new(Kind::Unset, joint);
    }
    let factor = scale_of(m);
    if factor < HIDDEN_SCALE {
        return PoseFault { factor, ..PoseFault::new(Kind::Hidden, joint) };
    }
    let square = factor * factor;
    let off = |found: f32, expected: f32| (found - expected).abs();
    let worst = |expected: f32| {
        let lengths = [x, y, z].map(|row| off(dot(row, row), expected));
        let angles = [off(dot(x, y), 0.0), off(dot(y, z), 0.0), off(dot(z, x), 0.0)];
        lengths.into_iter().chain(angles).fold(0.0, f32::max)
    };
    let kind = if dot(cross(x, y), z) < 0.0 {
        Kind::Mirrored
    } else if worst(square) <= RIGID_TOLERANCE * square {
        Kind::Scaled
    } else {
        Kind::Stretched
    };
    let fault =
        PoseFault { found: worst(1.0), allowed: RIGID_TOLERANCE, ..PoseFault::new(kind, joint) };
    if kind == Kind::Scaled { PoseFault { factor, ..fault } } else { fault }
}
