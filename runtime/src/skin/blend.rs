//! Blending: from a palette to the transform of a vertex, and what it does to vectors.

use super::view::Skin;
use crate::linear::{self, Le, Matrix3x4, dot};
use crate::numeric::sqrt;
use core::iter;
use core::ops::Range;
use glam::{Mat4, Vec4, Vec4Swizzles};

/// The influences of all vertices, and the palette that they refer to.
pub(super) struct Influences<'a> {
    palette: &'a [Matrix3x4],
    indices: &'a [[u8; 2]],
    weights: &'a [Le],
    /// How many a vertex has; 0 without an envelope.
    len: usize,
}

/// Indices and weights of vertices with four influences each.
pub(super) type Fours<'a> = (&'a [[[u8; 2]; 4]], &'a [[Le; 4]]);

#[cfg(feature = "prior")]
impl Skin<'_> {
    /// Blends the transforms of a vertex; the identity without influences. `None` of a vertex beyond the mesh, or of a
    /// palette that is too short.
    pub(crate) fn blended(&self, palette: &[Matrix3x4], vertex: usize) -> Option<Matrix3x4> {
        let [x, y, z, _] =
            Influences::new(self, palette).blend(vertex)?.transpose().to_cols_array_2d();
        Some([x, y, z])
    }
}

/// Whether the usual number of influences gets code of its own: a quarter faster on x86-64, but small
/// processors have too few registers for it (31 instructions a vertex more on a Cortex-M4F).
const UNROLL: bool = cfg!(any(target_pointer_width = "64", target_family = "wasm"));

impl<'a> Influences<'a> {
    pub(super) fn new(skin: &Skin<'a>, palette: &'a [Matrix3x4]) -> Self {
        let (indices, weights) = (skin.indices(), skin.weights());
        Self { palette, indices, weights, len: skin.influence_len() }
    }

    /// Returns the indices and weights of a range's vertices if each vertex has four influences; else `None`.
    ///
    /// They are slices for a plain loop around [`Self::blend_row`]. An adapter that yields the blended matrices is not
    /// inlined under LTO: each matrix then goes through memory, at five times the cost.
    #[inline(always)]
    pub(super) fn by_four(&self, vertices: Range<usize>) -> Option<Fours<'a>> {
        if !UNROLL || self.len != 4 {
            return None;
        }
        let indices = self.indices.as_chunks().0.get(vertices.clone())?;
        Some((indices, self.weights.as_chunks().0.get(vertices)?))
    }

    /// Blends the transforms of vertices; of none where they have no influences.
    #[inline(always)]
    pub(super) fn blend_each(&self, vertices: Range<usize>) -> impl Iterator<Item = Mat4> {
        let all = vertices.start * self.len..vertices.end * self.len;
        let influences = self.indices.get(all.clone()).zip(self.weights.get(all));
        let (mut indices, mut weights) = influences.unwrap_or_default();
        // At least one, so that the loop over a vertex's influences needs no way around it.
        let len = self.len.max(1);
        iter::from_fn(move || {
            let (first_indices, more_indices) = indices.split_at_checked(len)?;
            let (first_weights, more_weights) = weights.split_at_checked(len)?;
            (indices, weights) = (more_indices, more_weights);
            blend(self.palette, first_indices, first_weights)
        })
    }

    /// Blends the transforms of one vertex, as [`blend`] does.
    #[inline(always)]
    pub(super) fn blend_row(&self, indices: &[[u8; 2]], weights: &[Le]) -> Option<Mat4> {
        blend(self.palette, indices, weights)
    }

    /// Returns a vertex's indices and weights.
    #[inline(always)]
    pub(super) fn of(&self, vertex: usize) -> Option<(&'a [[u8; 2]], &'a [Le])> {
        let start = vertex * self.len;
        let indices = self.indices.get(start..)?.get(..self.len)?;
        Some((indices, self.weights.get(start..)?.get(..self.len)?))
    }

    /// Blends the transforms of a vertex; the identity without influences. `None` as by [`blend`], or
    /// for a vertex beyond the mesh.
    #[inline(always)]
    pub(super) fn blend(&self, vertex: usize) -> Option<Mat4> {
        if UNROLL && self.len == 4 {
            let indices = self.indices.as_chunks::<4>().0.get(vertex)?;
            return blend(self.palette, indices, self.weights.as_chunks::<4>().0.get(vertex)?);
        }
        if self.len == 0 {
            return Some(Mat4::IDENTITY);
        }
        let start = vertex * self.len;
        let indices = self.indices.get(start..).and_then(|rest| rest.get(..self.len))?;
        blend(self.palette, indices, self.weights.get(start..)?)
    }
}

/// Blends the transforms of a vertex, first to last, and returns the columns of the sum. `None` stands
/// for an index beyond the palette, which a loaded skin does not have.
#[inline(always)]
fn blend(palette: &[Matrix3x4], indices: &[[u8; 2]], weights: &[Le]) -> Option<Mat4> {
    let [mut x, mut y, mut z] = [Vec4::ZERO; 3];
    for (index, weight) in indices.iter().zip(weights) {
        let [a, b, c] = palette.get(usize::from(u16::from_le_bytes(*index)))?;
        let weight = f32::from_le_bytes(*weight);
        x += Vec4::from_array(*a) * weight;
        y += Vec4::from_array(*b) * weight;
        z += Vec4::from_array(*c) * weight;
    }
    Some(Mat4::from_cols(x, y, z, Vec4::ZERO).transpose())
}

#[inline(always)]
pub(super) fn moved(m: &Mat4, rest: [f32; 3]) -> [f32; 3] {
    (along(m, rest) + m.w_axis).truncate().to_array()
}

/// Returns the linear part of a transform times a vector, column by column.
#[inline(always)]
pub(super) fn along(m: &Mat4, [x, y, z]: [f32; 3]) -> Vec4 {
    m.x_axis * x + m.y_axis * y + m.z_axis * z
}

/// Returns the cofactors of a transform's 3x3: cross products of its columns.
#[inline(always)]
pub(super) fn cofactors(m: &Mat4) -> Mat4 {
    let Mat4 { x_axis: x, y_axis: y, z_axis: z, .. } = *m;
    Mat4::from_cols(cross(y, z), cross(z, x), cross(x, y), Vec4::ZERO)
}

#[inline(always)]
fn cross(a: Vec4, b: Vec4) -> Vec4 {
    (a * b.yzxw() - a.yzxw() * b).yzxw()
}

/// Returns a vector at the length of `length`, which is 1 or -1; `None` where it has no direction.
#[inline(always)]
pub(super) fn unit(v: [f32; 3], length: f32) -> Option<[f32; 3]> {
    let square = dot(v, v);
    if !square.is_normal() {
        return None;
    }
    let scale = length / sqrt(square);
    Some(v.map(|x| x * scale))
}

/// Returns -1 where a palette mirrors, by its first transform, else 1: what cross products of its columns take
/// outward, a mirror takes inward.
#[inline(always)]
pub(super) fn side(palette: &[Matrix3x4]) -> f32 {
    let volume = palette.first().map_or(1.0, |m| {
        let [x, y, z] = m.map(|[x, y, z, _]| [x, y, z]);
        dot(x, linear::cross(y, z))
    });
    if volume < 0.0 { -1.0 } else { 1.0 }
}
