//! The box that a posed skin stays within.

use super::Envelope;
use crate::Matrix3x4;
use crate::error::{Argument, EvalError};
use crate::format::WEIGHT_SUM_TOLERANCE;
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
}

impl Envelope<'_> {
    /// Computes a box that holds every vertex of the posed skin; `None` if there are no vertices.
    ///
    /// It is the union of each proxy's rest box moved by its map, rounded outward. Conservative,
    /// because a skinned vertex is a weighted mean of where its proxies take it.
    ///
    /// - `palette`: [`Envelope::palette_len`] maps.
    ///
    /// # Errors
    /// - [`EvalError::Length`]: `palette` has another length.
    pub fn bounds(&self, palette: &[Matrix3x4]) -> Result<Option<Bounds>, EvalError> {
        Argument::Palette.check_len(self.palette_len(), palette.len())?;
        // A weighted mean of K terms and a product of 4 err by less than K + 8 roundings.
        let slack = WEIGHT_SUM_TOLERANCE + (self.influence_len() as f32 + 8.0) * f32::EPSILON;
        let mut union: Option<Bounds> = None;
        for (proxy, map) in palette.iter().enumerate() {
            let Some(rest) = self.rest_box(proxy) else { continue };
            let moved = moved(&rest, map, slack);
            union = Some(union.map_or(moved, |union| joined(union, &moved)));
        }
        Ok(union)
    }
}

/// Returns the least box that holds two.
fn joined(mut a: Bounds, b: &Bounds) -> Bounds {
    a.min.iter_mut().zip(&b.min).for_each(|(a, b)| *a = lesser(*a, *b));
    a.max.iter_mut().zip(&b.max).for_each(|(a, b)| *a = greater(*a, *b));
    a
}

/// Moves a box by a map and widens it by `slack` of the largest magnitude that its sums can reach.
fn moved(rest: &Bounds, map: &Matrix3x4, slack: f32) -> Bounds {
    let mut out = Bounds { min: [0.0; 3], max: [0.0; 3] };
    for (row, (out_min, out_max)) in map.iter().zip(out.min.iter_mut().zip(&mut out.max)) {
        let (mut min, mut max, mut magnitude) = (row[3], row[3], row[3].abs());
        for (m, (lo, hi)) in row.iter().zip(rest.min.iter().zip(&rest.max)) {
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
