//! Normals and tangents, by tangent coefficients or by cofactors (METHOD §1.8).

use super::counts::EIGHT;
use super::view::Row;
use crate::lanes::Real;
use crate::linear::{Columns, Matrix3x4, columns, cross, dot, moved, sum, transform};
use crate::numeric::{halves, sqrt};
use glam::{Mat4, Vec4, Vec4Swizzles};

/// Two directions in the surface at rest, perpendicular to each other and to the normal.
///
/// The coefficients g and h of a vertex refer to these directions.
pub(super) struct Frame<R> {
    pub(super) g: [R; 3],
    pub(super) h: [R; 3],
}

impl<R: Real> Frame<R> {
    /// Makes the frame of a normal and the rest tangent, which need not be exactly perpendicular.
    #[inline(always)]
    pub(super) fn of_tangent(normal: [R; 3], tangent: [R; 3]) -> Self {
        let h = cross(normal, tangent);
        Self { g: cross(h, normal), h }
    }

    /// Makes the frame of a normal without a tangent, without a branch (Duff et al., Building an Orthonormal Basis,
    /// Revisited, JCGT 2017).
    ///
    /// - `up`: z of the file's normal. The frame flips where the sign of `up` changes. The sign is the file's, so a
    ///   caller's normal that crosses z = 0 does not flip the frame.
    #[inline(always)]
    pub(super) fn of_normal([x, y, z]: [R; 3], up: R) -> Self {
        let one = up.splat(1.0);
        let side = one.with_sign_of(up);
        let (sided, share) = (side * x, x / (side + z));
        let g = [one - sided * share, -(side * y * share), -sided];
        Self { g, h: cross([x, y, z], g) }
    }
}

/// Influences of a vertex with tangent coefficients, and the palette.
#[derive(Clone, Copy)]
pub(super) struct Vertex<'a> {
    pub(super) palette: &'a [Matrix3x4],
    /// Index of the vertex. The other fields hold the rows of its block.
    pub(super) vertex: usize,
    pub(super) indices: &'a [[[u8; 2]; EIGHT]],
    pub(super) weights: &'a [Row],
    /// g and h of each influence but the first, as two f16.
    pub(super) coefficients: &'a [Row],
}

/// Correction of the skinned frame: g is Σ g_l (y_l - y_first), and h is Σ h_l (y_l - y_first).
///
/// y_l is the position of the vertex under transform l. An influence without coefficients is left out.
pub(super) struct FrameCorrection {
    g: [f32; 3],
    h: [f32; 3],
}

impl Vertex<'_> {
    /// Computes the correction of the skinned frame.
    ///
    /// `None` if an index is beyond the palette. Loading checks the indices, so the file's bytes must have changed
    /// since.
    ///
    /// - `position`: of the vertex at rest.
    pub(super) fn frame_correction(&self, position: [f32; 3]) -> Option<FrameCorrection> {
        let (first, others) = self.indices.split_first()?;
        let first = moved(self.transform(first)?, position);
        let mut sums = FrameCorrection { g: [0.0; 3], h: [0.0; 3] };
        for (indices, words) in others.iter().zip(self.coefficients) {
            let word = u32::from_le_bytes(words[self.vertex % EIGHT]);
            if word == 0 {
                continue;
            }
            let place = moved(self.transform(indices)?, position);
            let [g, h] = halves(word);
            let sums = sums.g.iter_mut().zip(&mut sums.h);
            for ((sum_g, sum_h), (place, first)) in sums.zip(place.iter().zip(first)) {
                let apart = place - first;
                *sum_g += g * apart;
                *sum_h += h * apart;
            }
        }
        Some(sums)
    }

    /// Turns a rest normal by the transform of the strongest influence, the first of equals.
    ///
    /// This replaces a skinned normal without a direction.
    #[cold]
    fn turn_by_strongest(&self, normal: [f32; 3]) -> Option<[f32; 3]> {
        let (mut most, mut strongest) = (-1.0, None);
        for (indices, weights) in self.indices.iter().zip(self.weights) {
            let weight = f32::from_le_bytes(weights[self.vertex % EIGHT]);
            if weight > most {
                (most, strongest) = (weight, Some(indices));
            }
        }
        let [x, y, z, _] = columns(self.transform(strongest?)?);
        unit(transform(&[x, y, z], normal), 1.0)
    }

    fn transform(&self, indices: &[[u8; 2]; EIGHT]) -> Option<&Matrix3x4> {
        self.palette.get(usize::from(u16::from_le_bytes(indices[self.vertex % EIGHT])))
    }

    /// Computes the posed normal: the cross product of the posed directions of the frame.
    ///
    /// - `blended`: the 3x3 of the blended transform.
    /// - `rest`, `side`: the rest normal, and the [`side`] of the palette.
    pub(super) fn normal(
        &self,
        blended: &Columns,
        frame: &Frame<f32>,
        correction: &FrameCorrection,
        (rest, side): ([f32; 3], f32),
    ) -> [f32; 3] {
        let g = sum(transform(blended, frame.g), correction.g);
        let h = sum(transform(blended, frame.h), correction.h);
        let turned = unit(cross(g, h), side).or_else(|| self.turn_by_strongest(rest));
        turned.unwrap_or(rest)
    }
}

impl FrameCorrection {
    /// Adds the correction to a skinned direction.
    ///
    /// - `direction`: at rest.
    /// - `image`: the direction times the blended 3x3.
    pub(super) fn apply(
        &self,
        frame: &Frame<f32>,
        direction: [f32; 3],
        image: [f32; 3],
    ) -> [f32; 3] {
        let (g, h) = (dot(direction, frame.g), dot(direction, frame.h));
        sum(sum(image, self.g.map(|x| x * g)), self.h.map(|x| x * h))
    }
}

/// Returns the cofactors of a transform's 3x3: the cross products of the columns.
#[inline(always)]
pub(super) fn cofactors(m: &Mat4) -> Mat4 {
    let Mat4 { x_axis: x, y_axis: y, z_axis: z, .. } = *m;
    Mat4::from_cols(vec_cross(y, z), vec_cross(z, x), vec_cross(x, y), Vec4::ZERO)
}

#[inline(always)]
fn vec_cross(a: Vec4, b: Vec4) -> Vec4 {
    (a * b.yzxw() - a.yzxw() * b).yzxw()
}

/// Scales a vector to length 1; `None` if the vector has no direction.
///
/// - `length`: 1, or -1 to reverse the vector.
#[inline(always)]
pub(super) fn unit(v: [f32; 3], length: f32) -> Option<[f32; 3]> {
    let square = dot(v, v);
    if !square.is_normal() {
        return None;
    }
    let scale = length / sqrt(square);
    Some(v.map(|x| x * scale))
}

/// Returns the side of a palette: -1 if the first transform mirrors, else 1.
///
/// A mirror reverses the cross product of two transformed directions. The side makes normals point outward again.
#[inline(always)]
pub(super) fn side(palette: &[Matrix3x4]) -> f32 {
    let volume = palette.first().map_or(1.0, |m| {
        let [x, y, z] = m.map(|[x, y, z, _]| [x, y, z]);
        dot(x, cross(y, z))
    });
    if volume < 0.0 { -1.0 } else { 1.0 }
}
