//! Derivatives of a kernel's values with respect to the numbers of a query.

use super::counts::{KernelCounts, NO_TERM};
use super::features::{features, gradients};
use super::point::{self, Point, inputs_of, quaternion};
use super::rows::InputRow;
use super::rule::QueryRule;
use super::view::KernelMap;
use crate::error::{Argument, CallError, CallErrorKind};
use crate::linear::{Sum, block_entry, block_product, block_sums, floats, padded, split};
use crate::unit::level;

impl KernelCounts {
    /// Returns the floats of scratch that [`KernelMap::jacobian`] needs.
    pub const fn jacobian_scratch_len(&self) -> usize {
        let (n, t) = (self.centre_len as usize, self.term_len as usize);
        let m = self.value_len as usize;
        Point::scratch_len(self) + 2 * padded(n) + t + padded(m) + 4 * m
    }
}

impl KernelMap<'_> {
    /// Returns the floats of scratch that [`KernelMap::jacobian`] needs.
    pub const fn jacobian_scratch_len(&self) -> usize {
        self.counts().jacobian_scratch_len()
    }

    /// Computes the derivatives of the m values with respect to the R numbers of a query. The
    /// values are taken before the fade, ranges and normalisation; the values of a rotation are its
    /// vector.
    ///
    /// A feature that is clamped at an end of its range has derivative 0. On a centre the
    /// derivative of a cone is 0 (METHOD §3). The call takes as long as d evaluations.
    ///
    /// - `query`: as for [`KernelMap::evaluate`].
    /// - `scratch`: at least [`KernelMap::jacobian_scratch_len`] floats, of any content.
    /// - `out`: m rows of R derivatives.
    ///
    /// # Errors
    /// The errors of [`KernelMap::evaluate`]. For a derivative that would not be finite, the
    /// argument of [`crate::CallErrorKind::NonFinite`] is the Jacobian.
    pub fn jacobian(
        &self,
        query: &[f32],
        scratch: &mut [f32],
        out: &mut [f32],
    ) -> Result<(), CallError> {
        let counts = self.counts();
        let row = self.query_len();
        let m = counts.value_len as usize;
        Argument::Jacobian.check_len(m.saturating_mul(row), out.len())?;
        Argument::Scratch.check_least(counts.jacobian_scratch_len(), scratch.len())?;
        point::check(self, query)?;
        let (point, scratch) = Point::new(self, query, scratch);
        let (slopes, scratch) = split(scratch, padded(counts.centre_len as usize));
        self.slopes(&point, slopes.as_chunks_mut().0);
        let columns = Columns { map: self, point, slopes: slopes.as_chunks().0 };
        // The first pass checks that all derivatives are finite, the second writes them.
        let unsound =
            |at: usize| CallError::new(CallErrorKind::NonFinite, Argument::Jacobian).at(at);
        columns.each(query, scratch, |value, column, x| {
            let place = value * row + column;
            if x.is_finite() { Ok(()) } else { Err(unsound(place)) }
        })?;
        columns.each(query, scratch, |value, column, x| {
            if let Some(out) = out.get_mut(value * row + column) {
                *out = x;
            }
            Ok(())
        })
    }

    /// Computes 2 dG/ds for each centre, n values in whole blocks.
    fn slopes(&self, point: &Point<'_>, out: &mut [[f32; 8]]) {
        let kernel = self.rule().kernel;
        block_sums(level(), Sum::Squared, self.centres(), point.z, out);
        for slope in out.as_flattened_mut() {
            *slope = 2.0 * kernel.slope(*slope);
        }
    }
}

/// Inputs of the derivatives.
struct Columns<'a, 's> {
    map: &'a KernelMap<'a>,
    point: Point<'s>,
    slopes: &'s [[f32; 8]],
}

impl Columns<'_, '_> {
    /// Computes each derivative, in the order of the inputs, and passes it on with the indices of
    /// its value and number.
    fn each(
        &self,
        query: &[f32],
        scratch: &mut [f32],
        mut each: impl FnMut(usize, usize, f32) -> Result<(), CallError>,
    ) -> Result<(), CallError> {
        let m = self.map.counts().value_len as usize;
        let (sums, scratch) = split(scratch, 4 * m);
        let (mut column, mut feature) = (0, 0);
        for (input, numbers) in inputs_of(self.map, query) {
            let numbers = quaternion(numbers);
            sums.fill(0.0);
            for gradient in self.gradients(&input, numbers, feature) {
                let derivatives = self.by_feature(feature, scratch);
                for (sums, gradient) in sums.chunks_exact_mut(m.max(1)).zip(gradient) {
                    for (sum, x) in sums.iter_mut().zip(derivatives.iter()) {
                        *sum += x * gradient;
                    }
                }
                feature += 1;
            }
            let own = sums.chunks_exact(m.max(1)).take(input.kind.number_len());
            for sums in own {
                for (value, sum) in sums.iter().enumerate() {
                    each(value, column, *sum)?;
                }
                column += 1;
            }
        }
        Ok(())
    }

    /// Lists the derivatives of an input's features with respect to its numbers; 0 for a clamped
    /// feature.
    fn gradients(
        &self,
        input: &InputRow,
        numbers: [f32; 4],
        first: usize,
    ) -> impl Iterator<Item = [f32; 4]> {
        let is_clamped = self.map.rule().query == QueryRule::Clamp;
        let ranges = self.map.features().get(first..).unwrap_or_default().iter().map(floats);
        let own = features(input, numbers).into_iter().zip(gradients(input, numbers));
        own.zip(ranges).take(input.kind.feature_len()).map(
            move |((feature, gradient), [_, _, low, high])| {
                let is_kept = is_clamped && !(low <= feature && feature <= high);
                if is_kept { [0.0; 4] } else { gradient }
            },
        )
    }

    /// Computes the m derivatives of the values with respect to a feature.
    fn by_feature<'m>(&self, feature: usize, scratch: &'m mut [f32]) -> &'m [f32] {
        let counts = self.map.counts();
        let (n, m) = (counts.centre_len as usize, counts.value_len as usize);
        let (steps, scratch) = split(scratch, padded(n));
        let (terms, scratch) = split(scratch, counts.term_len as usize);
        let (out, _) = split(scratch, padded(m));
        self.steps(feature, steps.as_chunks_mut().0);
        self.terms(feature, terms);
        out.fill(0.0);
        let steps = steps.get(..n).unwrap_or_default();
        block_product(level(), self.map.coefficients(), [steps, terms], out.as_chunks_mut().0);
        let figures = self.map.features().get(feature).map(floats).unwrap_or_default();
        let [_, scale, ..]: [f32; 4] = figures;
        out.iter_mut().for_each(|x| *x *= scale);
        out.get(..m).unwrap_or_default()
    }

    /// Computes the derivative of each centre's G with respect to u of a feature.
    fn steps(&self, feature: usize, out: &mut [[f32; 8]]) {
        let (map, z) = (self.map, self.point.z);
        let counts = map.counts();
        let (e, d) = (counts.metric_len as usize, counts.feature_len as usize);
        // A chunk length of zero would panic.
        let blocks = map.centres().chunks_exact(z.len().max(1));
        for ((out, slopes), block) in out.iter_mut().zip(self.slopes).zip(blocks) {
            *out = [0.0; 8];
            for (i, (z, centres)) in z.iter().zip(block).enumerate() {
                let along = match e {
                    0 if i == feature => 1.0,
                    0 => continue,
                    _ => block_entry(map.metric(), (e, d), i, feature).unwrap_or_default(),
                };
                for (out, t) in out.iter_mut().zip(floats(centres)) {
                    *out += along * (z - t);
                }
            }
            out.iter_mut().zip(slopes).for_each(|(out, slope)| *out *= slope);
        }
    }

    /// Computes the derivatives of the monomials with respect to u of a feature.
    fn terms(&self, feature: usize, out: &mut [f32]) {
        let (u, powers) = (self.point.u, self.point.terms);
        for (place, term) in self.map.terms().iter().enumerate() {
            let [earlier, input] = term.map(u16::from_le_bytes);
            let (earlier, input) = (usize::from(earlier), usize::from(input));
            let own = if input == feature { powers.get(earlier) } else { None };
            let before = out.get(earlier).zip(u.get(input)).map_or(0.0, |(t, u)| t * u);
            let is_first = earlier == usize::from(NO_TERM);
            let value = if is_first { 0.0 } else { before + own.copied().unwrap_or_default() };
            if let Some(out) = out.get_mut(place) {
                *out = value;
            }
        }
    }
}
