//! Blending: from a palette to the transform of a vertex, and the transform of vectors.

use super::counts::EIGHT;
use super::view::{Row, Skin};
use crate::linear::Matrix3x4;
use crate::matrix::IDENTITY;
use glam::{Mat4, Vec4};

/// Rows of the influences of a block: indices and weights.
type InfluenceRows<'a> = (&'a [[[u8; 2]; EIGHT]], &'a [Row]);

/// Influences of all vertices, and the palette.
pub(super) struct Influences<'a> {
    palette: &'a [Matrix3x4],
    indices: &'a [[[u8; 2]; EIGHT]],
    weights: &'a [Row],
    /// Rows of a block of vertices.
    len: usize,
    /// Rows from a block to the next.
    step: usize,
}

#[cfg(feature = "prior")]
impl Skin<'_> {
    /// Blends the transforms of a vertex, or is the identity without an envelope.
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
    /// Without an envelope every vertex follows the identity.
    pub(super) fn new(skin: &Skin<'a>, palette: &'a [Matrix3x4]) -> Self {
        const PALETTE: &[Matrix3x4] = &[IDENTITY];
        const INDICES: &[[[u8; 2]; EIGHT]] = &[[[0; 2]; EIGHT]];
        const WEIGHTS: &[Row] = &[[1.0f32.to_le_bytes(); EIGHT]];
        match skin.influence_len() {
            0 => Self { palette: PALETTE, indices: INDICES, weights: WEIGHTS, len: 1, step: 0 },
            len => {
                let (indices, weights) = (skin.indices(), skin.weights());
                Self { palette, indices, weights, len, step: len }
            }
        }
    }

    /// Returns the rows of a vertex's block. `None` if the vertex is beyond the mesh.
    #[inline(always)]
    pub(super) fn rows(&self, vertex: usize) -> Option<InfluenceRows<'a>> {
        let first = vertex / EIGHT * self.step;
        let own = first..first + self.len;
        Some((self.indices.get(own.clone())?, self.weights.get(own)?))
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

    /// Blends the transforms of a vertex, or is the identity without an envelope.
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

/// Blends the transforms of a vertex, first to last, and returns the columns of the sum.
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
    if indices.is_empty() || weights.is_empty() {
        return None;
    }
    let (mut x, mut y, mut z) = (Vec4::ZERO, Vec4::ZERO, Vec4::ZERO);
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
