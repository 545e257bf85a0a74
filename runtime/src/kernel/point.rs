//! A query as the kernels use it: its scaled features, its coordinates for distances, and its
//! monomials.

use super::counts::{KernelCounts, NO_TERM};
use super::features::features;
use super::rows::InputRow;
use super::rule::QueryRule;
use super::view::KernelMap;
use crate::error::{Argument, CallError, CallErrorKind};
use crate::linear::{block_product, floats, padded, split, squared_length};
use crate::numeric::{greater, lesser};
use crate::unit::level;

/// A query as the kernels use it.
pub(super) struct Point<'s> {
    /// Features shifted and scaled, d.
    pub(super) u: &'s [f32],
    /// Coordinates for distances, c: W u, or u without a metric.
    pub(super) z: &'s [f32],
    /// Monomials of u for the polynomial, T.
    pub(super) terms: &'s [f32],
}

impl<'s> Point<'s> {
    /// Returns the floats of scratch of a point.
    pub(super) const fn scratch_len(counts: &KernelCounts) -> usize {
        let (d, e) = (counts.feature_len as usize, counts.metric_len as usize);
        padded(d) + padded(e) + counts.term_len as usize
    }

    /// Computes the point of a query that was checked before. Also returns the rest of the scratch.
    pub(super) fn new(
        map: &KernelMap<'_>,
        query: &[f32],
        scratch: &'s mut [f32],
    ) -> (Self, &'s mut [f32]) {
        let counts = map.counts();
        let (d, e) = (counts.feature_len as usize, counts.metric_len as usize);
        let (u, scratch) = split(scratch, padded(d));
        let (z, scratch) = split(scratch, padded(e));
        let (terms, scratch) = split(scratch, counts.term_len as usize);
        scale(map, query, u);
        let u = u.get(..d).unwrap_or_default();
        monomials(map.terms(), u, terms);
        if e == 0 {
            return (Self { u, z: u, terms }, scratch);
        }
        block_product(level(), map.metric(), [u, &[]], z.as_chunks_mut().0);
        (Self { u, z: z.get(..e).unwrap_or_default(), terms }, scratch)
    }
}

/// Checks the query's length, that its numbers are finite, and that rotations have a direction.
pub(super) fn check(map: &KernelMap<'_>, query: &[f32]) -> Result<(), CallError> {
    Argument::Query.check_len(map.query_len(), query.len())?;
    Argument::Query.check_finite(query.iter().position(|x| !x.is_finite()))?;
    let is_nothing = |(input, numbers): (InputRow, &[f32])| {
        input.kind.is_rotation() && !squared_length(quaternion(numbers)).is_normal()
    };
    let nothing = inputs_of(map, query).position(is_nothing);
    nothing.map_or(Ok(()), |input| {
        Err(CallError::new(CallErrorKind::ZeroRotation, Argument::Query).at(input))
    })
}

/// Lists the inputs, each with its numbers from a query.
pub(super) fn inputs_of<'q>(
    map: &KernelMap<'q>,
    query: &'q [f32],
) -> impl Iterator<Item = (InputRow, &'q [f32])> {
    let mut left = query;
    map.inputs().map(move |input| {
        let (own, rest) = left.split_at(input.kind.number_len().min(left.len()));
        left = rest;
        (input, own)
    })
}

/// Returns up to four numbers, padded with zeros.
pub(super) fn quaternion(numbers: &[f32]) -> [f32; 4] {
    let mut out = [0.0; 4];
    out.iter_mut().zip(numbers).for_each(|(out, number)| *out = *number);
    out
}

/// Computes the features, clamps them to their ranges if the rule is to clamp, and shifts and
/// scales them.
fn scale(map: &KernelMap<'_>, query: &[f32], out: &mut [f32]) {
    let is_clamped = map.rule().query == QueryRule::Clamp;
    let mut left = out.iter_mut().zip(map.features());
    for (input, numbers) in inputs_of(map, query) {
        let features = features(&input, quaternion(numbers));
        let own = features.iter().take(input.kind.feature_len());
        for (feature, (out, figures)) in own.zip(left.by_ref()) {
            let [shift, scale, low, high] = floats(figures);
            let kept = if is_clamped { lesser(greater(*feature, low), high) } else { *feature };
            *out = (kept - shift) * scale;
        }
    }
}

/// Computes the monomials, each from an earlier one.
fn monomials(terms: &[[[u8; 2]; 2]], u: &[f32], out: &mut [f32]) {
    for (place, term) in terms.iter().enumerate() {
        let [earlier, input] = term.map(u16::from_le_bytes);
        let value = match earlier {
            NO_TERM => Some(1.0),
            _ => out.get(usize::from(earlier)).zip(u.get(usize::from(input))).map(|(t, u)| t * u),
        };
        if let (Some(out), Some(value)) = (out.get_mut(place), value) {
            *out = value;
        }
    }
}
