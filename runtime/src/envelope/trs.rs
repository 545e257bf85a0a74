//! Helpers as bones of translation, rotation and scale, for engines whose bones hold these (METHOD §1.13).

use super::counts::HelperKind;
use super::polar::{nearest_rotation, normed};
use super::view::{Envelope, place};
use crate::error::{Argument, CallError};
use crate::linear::{
    Columns, IDENTITY, Le, Matrix3x4, columns, cross, dot, moved, product, quaternion, split,
    squared_length, turn,
};
use crate::numeric::sqrt;

/// Least and greatest sum of the squares of a linear part that is projected.
const SQUARES: [f32; 2] = [1.0e-6, 1.0e6];
/// Least determinant, in magnitude, of a projected linear part of the norm of a rotation. Above it, Newton's steps
/// reach single precision.
const FLAT: f32 = 0.1;

/// Spread of a helper without a preferred direction.
const EVEN: [f32; 6] = [1.0, 0.0, 0.0, 1.0, 0.0, 1.0];

/// Transform of a bone in model space: `y = translation + rotation (scale * x)`, with x relative to the bone's rest
/// frame, the translation to [`Envelope::helper_centre`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trs {
    /// Translation, in units of the model.
    pub translation: [f32; 3],
    /// Rotation, a unit quaternion x, y, z, w with w not negative.
    pub rotation: [f32; 4],
    /// Scale along the model's axes at rest. All three are negative if the transform mirrors.
    pub scale: [f32; 3],
}

impl Trs {
    /// The bone of a helper at rest, at the model's origin.
    pub const IDENTITY: Self =
        Self { translation: [0.0; 3], rotation: [0.0, 0.0, 0.0, 1.0], scale: [1.0; 3] };

    /// Returns the bone's entry of a palette: the transform from rest to posed, in model space.
    ///
    /// - `centre`: [`Envelope::helper_centre`] of the helper.
    pub fn palette_entry(&self, centre: [f32; 3]) -> Matrix3x4 {
        let [a, b, c] = self.scale;
        let mut out = [[0.0; 4]; 3];
        let rows = turn(self.rotation).into_iter().zip(self.translation);
        for (out, ([x, y, z], shift)) in out.iter_mut().zip(rows) {
            let row = [x * a, y * b, z * c];
            let [x, y, z] = row;
            *out = [x, y, z, shift - dot(row, centre)];
        }
        out
    }

    /// Returns the bone of a helper, which moves vertices of a spread about a centre.
    fn of(map: &Matrix3x4, centre: [f32; 3], spread: &[f32; 6]) -> Self {
        let [xx, xy, xz, yy, yz, zz] = *spread;
        let [x, y, z, _] = columns(map);
        let linear = [x, y, z];
        let weighed = product(&linear, &[[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]);
        let found = if is_upright(linear) {
            // Twice the steps: a spread is flatter than a transform.
            nearest_rotation(nearest_rotation(normed(weighed)))
        } else {
            IDENTITY
        };
        // A file may state a spread that is no covariance.
        let [a, b, c] = found;
        let square = dot(a, a) + dot(b, b) + dot(c, c);
        let rotation = if square > 2.0 && square < 4.0 { found } else { IDENTITY };
        let [a, b, c] = rotation;
        let mirror = if dot(a, cross(b, c)) < 0.0 { -1.0 } else { 1.0 };
        let turn = rotation.map(|column| column.map(|value| mirror * value));
        let ([x, y, z], w) = quaternion(&turn);
        let length = sqrt(squared_length([x, y, z, w]));
        let [a, b, c] = turn;
        let [along_x, along_y, along_z] = weighed;
        Self {
            translation: moved(map, centre),
            rotation: [x, y, z, w].map(|value| value / length),
            scale: [dot(a, along_x) / xx, dot(b, along_y) / yy, dot(c, along_z) / zz],
        }
    }
}

impl Envelope<'_> {
    /// Computes the palette of a pose, and the bones of its P helpers, or of the P proxies of a rotational envelope.
    ///
    /// A bone holds the nearest rotation of its palette entry, the scale along the axes of the rest pose, and the image
    /// of the centre. It loses the shear of the entry; [`super::Certificate::trs_error`] is the largest distance that a
    /// vertex moved by that in training. Helpers of kind [`HelperKind::Trs`] or [`HelperKind::Rigid`] have no shear, and
    /// lose nothing but rounding. The J joints are bones of the engine's own skeleton, so they are not among the results.
    ///
    /// In the engine a helper's bone has no parent but the model, its bind matrix is the translation by minus
    /// [`Envelope::helper_centre`], and its vertices have the weights of [`crate::Skin::influences`].
    ///
    /// An engine whose bones inherit the scale of their parents holds any palette entry exactly in two nodes.
    /// The singular values of its linear part give `L = U diag(s) Vᵀ`. The parent has the rotation U, the scale s and
    /// the translation of the bone; the child has the rotation Vᵀ, and skins the vertices. A helper that flattens or
    /// stretches by more than about 7 relative to its size, or scales by less than 0.001 or more than 1000, has the
    /// identity rotation.
    ///
    /// - `pose`, `curves`, `scratch`, `out_palette`: as for [`Envelope::palette`].
    /// - `out_bones`: [`Envelope::proxy_len`] transforms, in model space.
    ///
    /// # Errors
    /// - The errors of [`Envelope::palette`].
    /// - [`crate::CallErrorKind::Length`]: `out_bones` has another length.
    pub fn palette_trs(
        &self,
        pose: &[Matrix3x4],
        curves: &[f32],
        scratch: &mut [f32],
        out_palette: &mut [Matrix3x4],
        out_bones: &mut [Trs],
    ) -> Result<f32, CallError> {
        Argument::Bones.check_len(self.proxy_len(), out_bones.len())?;
        let confidence = self.palette(pose, curves, scratch, out_palette)?;
        let first = out_palette.len().saturating_sub(out_bones.len());
        let (_, helpers) = split(out_palette, first);
        for ((out, map), words) in out_bones.iter_mut().zip(helpers).zip(self.helper_places()) {
            *out = self.bone_at(map, words);
        }
        Ok(confidence)
    }

    /// Returns the bone of a helper for its entry of a palette; `None` beyond the helpers. [`Self::palette_trs`] describes
    /// it.
    pub fn bone(&self, helper: usize, entry: &Matrix3x4) -> Option<Trs> {
        self.helper_places().get(helper).map(|words| self.bone_at(entry, words))
    }

    fn bone_at(&self, entry: &Matrix3x4, words: &[Le; 9]) -> Trs {
        let (centre, spread) = place(words);
        let is_affine = self.helper_kind() == HelperKind::Affine;
        Trs::of(entry, centre, if is_affine { &spread } else { &EVEN })
    }
}

/// Projects the transforms of the P helpers onto the envelope's kind.
///
/// The image of a helper's centre stays. A linear part outside the range of the projection stays too.
pub(crate) fn project(envelope: &Envelope<'_>, helpers: &mut [Matrix3x4]) {
    let kind = envelope.helper_kind();
    if kind == HelperKind::Affine {
        return;
    }
    for (map, words) in helpers.iter_mut().zip(envelope.helper_places()) {
        let (centre, _) = place(words);
        let [x, y, z, _] = columns(map);
        if !is_upright([x, y, z]) {
            continue;
        }
        let [a, b, c] = nearest_rotation(normed([x, y, z]));
        let scale = match kind {
            HelperKind::Rigid => [1.0; 3],
            _ => [dot(a, x), dot(b, y), dot(c, z)],
        };
        let rows = a.into_iter().zip(b).zip(c);
        for (row, ((a, b), c)) in map.iter_mut().zip(rows) {
            let [x, y, z, shift] = *row;
            let [a, b, c] = [a * scale[0], b * scale[1], c * scale[2]];
            *row = [a, b, c, shift + dot([x - a, y - b, z - c], centre)];
        }
    }
}

/// Whether a linear part is neither nearly 0, nor huge, nor flat.
fn is_upright([x, y, z]: Columns) -> bool {
    let square = dot(x, x) + dot(y, y) + dot(z, z);
    let [least, most] = SQUARES;
    if !(square > least && square < most) {
        return false;
    }
    let [x, y, z] = normed([x, y, z]);
    dot(x, cross(y, z)).abs() > FLAT
}
