//! Boxes, and how a transform moves them.

use crate::linear::{Le, Matrix3x4, floats};
use crate::numeric::{greater, lesser};

/// A box along the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Least coordinates.
    pub min: [f32; 3],
    /// Greatest coordinates.
    pub max: [f32; 3],
}

impl Bounds {
    /// Whether a point lies in the box or on its faces.
    pub fn contains(&self, point: [f32; 3]) -> bool {
        self.min.iter().zip(&self.max).zip(&point).all(|((min, max), x)| min <= x && x <= max)
    }

    /// Reads a box of the file; `None` of one that holds nothing.
    pub(crate) fn from_corners(le: &[Le; 6]) -> Option<Self> {
        let [x0, y0, z0, x1, y1, z1] = floats(le);
        (x0 <= x1).then_some(Self { min: [x0, y0, z0], max: [x1, y1, z1] })
    }

    /// Returns the box of a point.
    pub(crate) const fn of(point: [f32; 3]) -> Self {
        Self { min: point, max: point }
    }

    /// Grows to the least box that holds both.
    pub(crate) fn join(&mut self, other: &Self) {
        self.min.iter_mut().zip(&other.min).for_each(|(a, b)| *a = lesser(*a, *b));
        self.max.iter_mut().zip(&other.max).for_each(|(a, b)| *a = greater(*a, *b));
    }

    /// Widens the box to every side, rounded outward; by 0 it stays as it is.
    pub(crate) fn widen(&mut self, by: f32) {
        // Two roundings, and one of whoever measured `by`.
        let rounding = |x: f32| if by > 0.0 { 2.0 * f32::EPSILON * (x.abs() + by) } else { 0.0 };
        self.min.iter_mut().for_each(|x| *x = (*x - by) - rounding(*x));
        self.max.iter_mut().for_each(|x| *x = (*x + by) + rounding(*x));
    }

    /// Adds another: the box of the sums of their points, rounded outward; by 0 a side stays where it is.
    #[cfg(feature = "shapes")]
    pub(crate) fn add(&mut self, other: &Self) {
        let rounding = |x: f32, by: f32| {
            if by == 0.0 { 0.0 } else { 2.0 * f32::EPSILON * (x.abs() + by.abs()) }
        };
        self.min.iter_mut().zip(other.min).for_each(|(x, by)| *x = (*x + by) - rounding(*x, by));
        self.max.iter_mut().zip(other.max).for_each(|(x, by)| *x = (*x + by) + rounding(*x, by));
    }

    /// Moves the box by a transform and widens it by `slack` of the largest magnitude that its sums can
    /// reach.
    pub(crate) fn moved(&self, transform: &Matrix3x4, slack: f32) -> Self {
        let mut out = Self { min: [0.0; 3], max: [0.0; 3] };
        let rows = transform.iter().zip(out.min.iter_mut().zip(&mut out.max));
        for (row, (out_min, out_max)) in rows {
            let (mut min, mut max, mut magnitude) = (row[3], row[3], row[3].abs());
            for (m, (lo, hi)) in row.iter().zip(self.min.iter().zip(&self.max)) {
                let (a, b) = (m * lo, m * hi);
                min += lesser(a, b);
                max += greater(a, b);
                magnitude += greater(a.abs(), b.abs());
            }
            *out_min = min - slack * magnitude;
            *out_max = max + slack * magnitude;
        }
        out
    }
}

/// Whether a point lies in a box or on its faces; in one that holds nothing no point does.
pub(super) fn is_inside(corners: &[Le; 6], point: [f32; 3]) -> bool {
    let (min, max) = corners.split_at(3);
    let mut sides = point.iter().zip(min.iter().zip(max));
    sides.all(|(x, (min, max))| f32::from_le_bytes(*min) <= *x && *x <= f32::from_le_bytes(*max))
}
