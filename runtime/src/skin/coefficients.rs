//! Normals and tangents by tangent coefficients (METHOD §1.8).

use super::blend::unit;
use crate::lanes::Real;
use crate::linear::{Columns, Le, Matrix3x4, columns, cross, dot, moved, sum, transform};
use crate::numeric::halves;

/// What adds nothing to any number, not even to -0.
const NOTHING: [f32; 3] = [-0.0; 3];

/// Two directions along the surface at rest, across each other and across the normal, which the coefficients g and h
/// are of.
pub(super) struct Frame<R> {
    pub(super) g: [R; 3],
    pub(super) h: [R; 3],
}

impl<R: Real> Frame<R> {
    /// Makes that of a normal and the rest tangent, which need not be quite across each other.
    #[inline(always)]
    pub(super) fn of_tangent(normal: [R; 3], tangent: [R; 3]) -> Self {
        let h = cross(normal, tangent);
        Self { g: cross(h, normal), h }
    }

    /// Makes that of a normal alone, without a branch (Duff et al., Building an Orthonormal Basis, Revisited, JCGT
    /// 2017).
    ///
    /// - `up`: the z of the file's own normal. Its sign is on which of two seams the frame turns over; so it does not
    ///   turn where a normal of the caller's crosses the seam and the file's does not.
    #[inline(always)]
    pub(super) fn of_normal([x, y, z]: [R; 3], up: R) -> Self {
        let one = R::from(1.0);
        let side = one.with_sign_of(up);
        let (sided, share) = (side * x, x / (side + z));
        let g = [one - sided * share, -(side * y * share), -sided];
        Self { g, h: cross([x, y, z], g) }
    }
}

/// What a vertex follows.
#[derive(Clone, Copy)]
pub(super) struct Vertex<'a> {
    pub(super) palette: &'a [Matrix3x4],
    pub(super) indices: &'a [[u8; 2]],
    pub(super) weights: &'a [Le],
    /// g and h of each but the last, as two f16.
    pub(super) coefficients: &'a [Le],
}

/// What the coefficients add to the images of the directions of a frame as the transforms part: sums of g_l (y_l - y_last), y the
/// place to which a transform moves the vertex, and likewise of h.
pub(super) struct Parted {
    g: [f32; 3],
    h: [f32; 3],
}

impl Vertex<'_> {
    /// Sums what the coefficients add; `None` stands for an index beyond the palette, which a loaded skin does not
    /// have.
    pub(super) fn parted(&self, position: [f32; 3]) -> Option<Parted> {
        let (last, others) = self.indices.split_last()?;
        let last = moved(self.transform(last)?, position);
        let mut sums = Parted { g: NOTHING, h: NOTHING };
        for (index, word) in others.iter().zip(self.coefficients) {
            let place = moved(self.transform(index)?, position);
            let [g, h] = halves(u32::from_le_bytes(*word));
            let sums = sums.g.iter_mut().zip(&mut sums.h);
            for ((sum_g, sum_h), (place, last)) in sums.zip(place.iter().zip(last)) {
                let apart = place - last;
                *sum_g += g * apart;
                *sum_h += h * apart;
            }
        }
        Some(sums)
    }

    /// Turns a normal that has no direction else by the transform of the strongest influence, the first of equals.
    #[cold]
    fn turn_by_strongest(&self, normal: [f32; 3]) -> Option<[f32; 3]> {
        let (mut most, mut strongest) = (-1.0, None);
        for (index, weight) in self.indices.iter().zip(self.weights) {
            let weight = f32::from_le_bytes(*weight);
            if weight > most {
                (most, strongest) = (weight, Some(index));
            }
        }
        let [x, y, z, _] = columns(self.transform(strongest?)?);
        unit(transform(&[x, y, z], normal), 1.0)
    }

    fn transform(&self, index: &[u8; 2]) -> Option<&Matrix3x4> {
        self.palette.get(usize::from(u16::from_le_bytes(*index)))
    }

    /// Returns the posed normal, by the images of the frame's directions.
    ///
    /// - `blended`: the 3x3 of the blended transform.
    /// - `side`: of the palette, 1 or -1.
    pub(super) fn normal(
        &self,
        blended: &Columns,
        frame: &Frame<f32>,
        parted: &Parted,
        (rest, side): ([f32; 3], f32),
    ) -> [f32; 3] {
        let g = sum(transform(blended, frame.g), parted.g);
        let h = sum(transform(blended, frame.h), parted.h);
        let turned = unit(cross(g, h), side).or_else(|| self.turn_by_strongest(rest));
        turned.unwrap_or(rest)
    }
}

impl Parted {
    /// Adds to the image of a direction.
    pub(super) fn add(&self, frame: &Frame<f32>, direction: [f32; 3], image: [f32; 3]) -> [f32; 3] {
        let (g, h) = (dot(direction, frame.g), dot(direction, frame.h));
        sum(sum(image, self.g.map(|x| x * g)), self.h.map(|x| x * h))
    }
}
