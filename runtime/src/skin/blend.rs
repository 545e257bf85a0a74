//! Blending: from a palette to the transform of a vertex, and the transform of vectors.

use super::view::{EIGHT, Row, Skin, rows_of};
use crate::linear::Matrix3x4;
use glam::{Mat4, Vec4};

/// Rows of the influences of a block: indices and weights.
type InfluenceRows<'a> = (&'a [[[u8; 2]; EIGHT]], &'a [Row]);

/// Influences of all vertices, and the palette.
pub(super) struct Influences<'a> {
    palette: &'a [Matrix3x4],
    /// K rows for each block of vertices.
    indices: &'a [[[u8; 2]; EIGHT]],
    /// K rows for each block of vertices.
    weights: &'a [Row],
    /// Number of influences of a vertex, K; 0 without an envelope.
    len: usize,
}

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

    /// Returns the rows of a vertex's block. `None` if the vertex is beyond the mesh.
    #[inline(always)]
    pub(super) fn rows(&self, vertex: usize) -> Option<InfluenceRows<'a>> {
        Some((rows_of(self.indices, self.len, vertex)?, rows_of(self.weights, self.len, vertex)?))
    }

    /// Blends the transforms of a vertex from the rows of its block, as [`blend`] does.
    #[inline(always)]
    pub(super) fn blend_rows(
        &self,
        (indices, weights): InfluenceRows<'_>,
        vertex: usize,
    ) -> Option<Mat4> {
        blend(self.palette, indices, weights, vertex)
    }

    /// Blends the transforms of a vertex; the identity without influences.
    ///
    /// `None` if the vertex is beyond the mesh, or as for [`blend`].
    #[inline(always)]
    pub(super) fn blend(&self, vertex: usize) -> Option<Mat4> {
        if UNROLL && self.len == 4 {
            let indices = self.indices.as_chunks::<4>().0.get(vertex / EIGHT)?;
            let weights = self.weights.as_chunks::<4>().0.get(vertex / EIGHT)?;
            return blend(self.palette, indices, weights, vertex);
        }
        self.blend_rows(self.rows(vertex)?, vertex)
    }
}

/// Blends the transforms of a vertex, first to last, and returns the columns of the sum; the identity without
/// influences.
///
/// `None` if an index is beyond the palette. Loading checks the indices, so the file's bytes must have changed since.
///
/// - `indices`, `weights`: rows of the vertex's block.
#[inline(always)]
fn blend(
    palette: &[Matrix3x4],
    indices: &[[[u8; 2]; EIGHT]],
    weights: &[Row],
    vertex: usize,
) -> Option<Mat4> {
    let one = if weights.is_empty() { 1.0 } else { 0.0 };
    let (mut x, mut y, mut z) = (Vec4::X * one, Vec4::Y * one, Vec4::Z * one);
    for (indices, weights) in indices.iter().zip(weights) {
        let index = u16::from_le_bytes(indices[vertex % EIGHT]);
        let [a, b, c] = palette.get(usize::from(index))?;
        let weight = f32::from_le_bytes(weights[vertex % EIGHT]);
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
