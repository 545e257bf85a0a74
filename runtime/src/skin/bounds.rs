//! Bounding boxes: boxes under transforms, and the box around a posed skin.

use super::counts::{RULES, WEIGHT_SUM_TOLERANCE};
use super::view::{Skin, of_vertex};
use crate::error::{Argument, CallError, CallErrorKind};
use crate::format::SectionKind;
use crate::format::rule::Rule;
use crate::linear::{Le, Matrix3x4, floats};
use crate::numeric::{greater, lesser};

const BOXES: usize = Rule::place(&RULES, SectionKind::RestBoxes);

/// Axis-aligned box.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bounds {
    /// Least coordinates.
    pub min: [f32; 3],
    /// Greatest coordinates.
    pub max: [f32; 3],
}

impl Bounds {
    /// Whether a point is in the box or on a face of the box.
    pub fn contains(&self, point: [f32; 3]) -> bool {
        self.min.iter().zip(&self.max).zip(&point).all(|((min, max), x)| min <= x && x <= max)
    }

    /// Reads a box of the file; `None` if the box is empty.
    pub(crate) fn from_corners(le: &[Le; 6]) -> Option<Self> {
        let [x0, y0, z0, x1, y1, z1] = floats(le);
        (x0 <= x1).then_some(Self { min: [x0, y0, z0], max: [x1, y1, z1] })
    }

    /// Returns the box of one point.
    pub(crate) const fn of(point: [f32; 3]) -> Self {
        Self { min: point, max: point }
    }

    /// Grows the box to contain another box.
    pub(crate) fn join(&mut self, other: &Self) {
        self.min.iter_mut().zip(&other.min).for_each(|(a, b)| *a = lesser(*a, *b));
        self.max.iter_mut().zip(&other.max).for_each(|(a, b)| *a = greater(*a, *b));
    }

    /// Widens the box on every side, rounded outward. A width of 0 leaves the box unchanged.
    pub(crate) fn widen(&mut self, by: f32) {
        // Room for two roundings here, and for one in the caller's `by`.
        let rounding = |x: f32| if by > 0.0 { 2.0 * f32::EPSILON * (x.abs() + by) } else { 0.0 };
        self.min.iter_mut().for_each(|x| *x = (*x - by) - rounding(*x));
        self.max.iter_mut().for_each(|x| *x = (*x + by) + rounding(*x));
    }

    /// Adds another box to get the box of all sums of two points, rounded outward. Adding 0 leaves a side unchanged.
    #[cfg(feature = "shapes")]
    pub(crate) fn add(&mut self, other: &Self) {
        let rounding = |x: f32, by: f32| {
            if by == 0.0 { 0.0 } else { 2.0 * f32::EPSILON * (x.abs() + by.abs()) }
        };
        self.min.iter_mut().zip(other.min).for_each(|(x, by)| *x = (*x + by) - rounding(*x, by));
        self.max.iter_mut().zip(other.max).for_each(|(x, by)| *x = (*x + by) + rounding(*x, by));
    }

    /// Returns the box around the transformed box, widened for rounding.
    ///
    /// - `slack`: width, as a share of the largest magnitude of a coordinate's terms.
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

impl<'a> Skin<'a> {
    /// Returns the box of the rest positions that a transform of the palette moves; `None` if there are none.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) fn rest_box(&self, index: usize) -> Option<Bounds> {
        self.0.entry(BOXES, self.palette_len(), index).and_then(Bounds::from_corners)
    }

    pub(super) fn boxes(&self) -> &'a [[Le; 6]] {
        self.0.array(BOXES)
    }

    /// Computes a box around every vertex of the posed skin; `None` if there are no vertices.
    ///
    /// The box is the union of the transformed rest boxes, rounded outward. The union is conservative, because a
    /// skinned vertex is a weighted mean of its transformed positions. Without an envelope the box surrounds the rest
    /// positions.
    ///
    /// - `palette`: [`Skin::palette_len`] transforms. If a number in them is not finite, the box has no meaning.
    /// - `rest_offset`: largest offset, along any axis, of the caller's rest mesh ([`super::SkinJob::rest_positions`]) from the
    ///   file's rest mesh; 0 for the file's rest mesh.
    ///
    /// # Errors
    /// - [`CallErrorKind::Length`]: `palette` has another length.
    /// - [`CallErrorKind::OutOfRange`]: `rest_offset` is negative or not finite.
    pub fn bounds(
        &self,
        palette: &[Matrix3x4],
        rest_offset: f32,
    ) -> Result<Option<Bounds>, CallError> {
        Argument::Palette.check_len(self.palette_len(), palette.len())?;
        if !(0.0..=f32::MAX).contains(&rest_offset) {
            return Err(CallError::new(CallErrorKind::OutOfRange, Argument::RestPositions));
        }
        Ok(self.posed_bounds(palette, |rest| rest.widen(rest_offset)))
    }

    /// Computes a box around every vertex of the posed skin.
    ///
    /// - `palette`: [`Skin::palette_len`] transforms.
    /// - `widen`: widens a box at rest.
    pub(super) fn posed_bounds(
        &self,
        palette: &[Matrix3x4],
        widen: impl Fn(&mut Bounds),
    ) -> Option<Bounds> {
        // A weighted mean of K terms and a product of 4 terms have an error of less than K + 8 roundings.
        let slack = WEIGHT_SUM_TOLERANCE + (self.influence_len() as f32 + 8.0) * f32::EPSILON;
        let mut union: Option<Bounds> = None;
        let (boxes, positions) = (self.boxes(), self.positions());
        // Without influences each vertex is a box that nothing moves.
        let fixed = if self.influence_len() == 0 { self.vertex_len() } else { 0 };
        for at in 0..boxes.len().max(fixed) {
            let rest = match fixed {
                0 => Bounds::from_corners(boxes.get(at)?),
                _ => of_vertex(positions, at).map(Bounds::of),
            };
            let Some(mut rest) = rest else { continue };
            widen(&mut rest);
            let own = palette.get(at).map_or(rest, |transform| rest.moved(transform, slack));
            match &mut union {
                Some(union) => union.join(&own),
                None => union = Some(own),
            }
        }
        union
    }
}

/// Whether a point is in a box of the file or on a face of the box. An empty box contains no point.
pub(super) fn is_inside(corners: &[Le; 6], point: [f32; 3]) -> bool {
    let (min, max) = corners.split_at(3);
    let mut sides = point.iter().zip(min.iter().zip(max));
    sides.all(|(x, (min, max))| f32::from_le_bytes(*min) <= *x && *x <= f32::from_le_bytes(*max))
}
