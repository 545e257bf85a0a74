//! Blending: from a palette to the transform of a vertex, and the transform of vectors.

use super::view::Skin;
use crate::linear::{Le, Matrix3x4};
use core::iter;
use core::ops::Range;
use glam::{Mat4, Vec4};

/// Influences of all vertices, and the palette.
pub(super) struct Influences<'a> {
    palette: &'a [Matrix3x4],
    indices: &'a [[u8; 2]],
    weights: &'a [Le],
    /// Number of influences of a vertex, K; 0 without an envelope.
    len: usize,
}

/// Indices and weights of vertices with four influences each.
pub(super) type Fours<'a> = (&'a [[[u8; 2]; 4]], &'a [[Le; 4]]);

#[cfg(feature = "prior")]
impl Skin<'_> {
    /// Blends the transforms of a vertex; the identity without influences.
    ///
    /// `None` if the vertex is beyond the mesh, or if the palette is too short.
    pub(crate) fn blended(&self, palette: &[Matrix3x4], vertex: usize) -> Option<Matrix3x4> {
        let [x, y, z, _] =
            Influences::new(self, palette).blend(vertex)?.transpose().to_cols_array_2d();
        Some([x, y, z])
    }
}

/// Whether four influences, the usual number, get separate code.
///
/// The separate code is a quarter faster on x86-64. Small processors have too few registers: a Cortex-M4F needs 31
/// instructions more for each vertex.
const UNROLL: bool = cfg!(any(target_pointer_width = "64", target_family = "wasm"));

impl<'a> Influences<'a> {
    pub(super) fn new(skin: &Skin<'a>, palette: &'a [Matrix3x4]) -> Self {
        let (indices, weights) = (skin.indices(), skin.weights());
        Self { palette, indices, weights, len: skin.influence_len() }
    }

    /// Returns the indices and weights of a range of vertices with four influences each; else `None`.
    ///
    /// The slices serve a plain loop around [`Self::blend_row`]. LTO does not inline an iterator of blended matrices:
    /// each matrix would go through memory, at five times the cost.
    #[inline(always)]
    pub(super) fn by_four(&self, vertices: Range<usize>) -> Option<Fours<'a>> {
        if !UNROLL || self.len != 4 {
            return None;
        }
        let indices = self.indices.as_chunks().0.get(vertices.clone())?;
        Some((indices, self.weights.as_chunks().0.get(vertices)?))
    }

    /// Blends the transforms of a range of vertices; lists nothing without influences.
    #[inline(always)]
    pub(super) fn blend_each(&self, vertices: Range<usize>) -> impl Iterator<Item = Mat4> {
        let all = vertices.start * self.len..vertices.end * self.len;
        let influences = self.indices.get(all.clone()).zip(self.weights.get(all));
        let (mut indices, mut weights) = influences.unwrap_or_default();
        // At least 1, so that the loop over the influences of a vertex needs no test for 0.
        let len = self.len.max(1);
        iter::from_fn(move || {
            let (first_indices, more_indices) = indices.split_at_checked(len)?;
            let (first_weights, more_weights) = weights.split_at_checked(len)?;
            (indices, weights) = (more_indices, more_weights);
            blend(self.palette, first_indices, first_weights)
        })
    }

    /// Blends the transforms of one vertex from its indices and weights, as [`blend`] does.
    #[inline(always)]
    pub(super) fn blend_row(&self, indices: &[[u8; 2]], weights: &[Le]) -> Option<Mat4> {
        blend(self.palette, indices, weights)
    }

    /// Returns the indices and weights of a vertex; `None` if the vertex is beyond the mesh.
    #[inline(always)]
    pub(super) fn of(&self, vertex: usize) -> Option<(&'a [[u8; 2]], &'a [Le])> {
        let start = vertex * self.len;
        let indices = self.indices.get(start..)?.get(..self.len)?;
        Some((indices, self.weights.get(start..)?.get(..self.len)?))
    }

    /// Blends the transforms of a vertex; the identity without influences.
    ///
    /// `None` if the vertex is beyond the mesh, or as for [`blend`].
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

/// Blends the transforms of a vertex, first to last, and returns the columns of the sum.
///
/// `None` if an index is beyond the palette. Loading checks the indices, so the file's bytes must have changed since.
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

/// Returns a transform times a point.
#[inline(always)]
pub(super) fn moved(m: &Mat4, rest: [f32; 3]) -> [f32; 3] {
    (along(m, rest) + m.w_axis).truncate().to_array()
}

/// Returns the linear part of a transform times a vector, column by column.
#[inline(always)]
pub(super) fn along(m: &Mat4, [x, y, z]: [f32; 3]) -> Vec4 {
    m.x_axis * x + m.y_axis * y + m.z_axis * z
}
