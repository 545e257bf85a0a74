//! Variance of a kernel's values at a query: an estimate of their squared error.

use super::counts::KernelCounts;
use super::point::{self, Point};
use super::view::KernelMap;
use crate::error::{Argument, CallError, CallErrorKind};
use crate::linear::{Le, block_product, floats, padded, split};
use crate::numeric::greater;
use crate::unit::level;

impl KernelCounts {
    /// Returns the floats of scratch that [`KernelMap::variance`] needs.
    pub const fn variance_scratch_len(&self) -> usize {
        let (n, t) = (padded(self.centre_len as usize), padded(self.term_len as usize));
        let r = padded(self.variance_len as usize);
        let most = if n > t { n } else { t };
        Point::scratch_len(self) + n + if r > most { r } else { most }
    }
}

impl KernelMap<'_> {
    /// Whether the file has the matrices for a variance.
    pub const fn has_variance(&self) -> bool {
        self.counts().variance_len > 0
    }

    /// Returns the floats of scratch that [`KernelMap::variance`] needs.
    pub const fn variance_scratch_len(&self) -> usize {
        self.counts().variance_scratch_len()
    }

    /// Computes the variance of each of the m values, before the fade, ranges and normalisation.
    ///
    /// - `query`: as for [`KernelMap::evaluate`].
    /// - `scratch`: at least [`KernelMap::variance_scratch_len`] floats, of any content.
    /// - `out`: m variances, not negative, in squares of the values' units.
    ///
    /// # Errors
    /// - [`crate::CallErrorKind::NoAttribute`]: the kernel has no variance.
    /// - The errors of [`KernelMap::evaluate`]. For a variance that would not be finite, the
    ///   argument of [`crate::CallErrorKind::NonFinite`] is the variances.
    pub fn variance(
        &self,
        query: &[f32],
        scratch: &mut [f32],
        out: &mut [f32],
    ) -> Result<(), CallError> {
        if !self.has_variance() {
            return Err(CallError::new(CallErrorKind::NoAttribute, Argument::Variances));
        }
        let counts = self.counts();
        let n = counts.centre_len as usize;
        Argument::Variances.check_len(counts.value_len as usize, out.len())?;
        Argument::Scratch.check_least(counts.variance_scratch_len(), scratch.len())?;
        point::check(self, query)?;
        let (point, scratch) = Point::new(self, query, scratch);
        let (basis, scratch) = split(scratch, padded(n));
        self.basis(&point, basis.as_chunks_mut().0);
        let basis = basis.get(..n).unwrap_or_default();
        let matrices = Matrices::new(&counts, self.variance_words());
        let share = matrices.share(self.rule().kernel.value(0.0), basis, point.terms, scratch);
        let of_value = |deviation: &Le| {
            let [deviation] = floats(&[*deviation]);
            deviation * deviation * share
        };
        let unsound = matrices.deviations.iter().position(|le| !of_value(le).is_finite());
        Argument::Variances.check_finite(unsound)?;
        out.iter_mut().zip(matrices.deviations).for_each(|(out, le)| *out = of_value(le));
        Ok(())
    }
}

/// Section `variance`.
struct Matrices<'a> {
    /// r.
    row_len: usize,
    /// A, r x (n + T).
    factor: &'a [[Le; 8]],
    /// P, n x T.
    mixed: &'a [[Le; 8]],
    /// H, T x T.
    polynomial: &'a [[Le; 8]],
    /// Standard deviation of each value.
    deviations: &'a [Le],
}

impl<'a> Matrices<'a> {
    /// Splits the words of the section.
    fn new(counts: &KernelCounts, words: &'a [Le]) -> Self {
        let (n, t) = (counts.centre_len as usize, counts.term_len as usize);
        let (r, m) = (counts.variance_len as usize, counts.value_len as usize);
        let matrix = |words: &'a [Le], rows: usize, columns: usize| {
            let len = padded(rows).saturating_mul(columns).min(words.len());
            let (own, rest) = words.split_at(len);
            (own.as_chunks().0, rest)
        };
        let (factor, words) = matrix(words, r, n.saturating_add(t));
        let (mixed, words) = matrix(words, n, t);
        let (polynomial, words) = matrix(words, t, t);
        let deviations = words.get(..m).unwrap_or(words);
        Self { row_len: r, factor, mixed, polynomial, deviations }
    }

    /// Computes `G(0) - 2 g (P p) + p (H p) - |A [g; p]|²`, at least 0, for kernels g and monomials
    /// p.
    fn share(&self, at_centre: f32, g: &[f32], p: &[f32], scratch: &mut [f32]) -> f32 {
        let mut share = at_centre;
        let mixed = product(self.mixed, [p, &[]], g.len(), scratch);
        share -= 2.0 * inner(g, mixed);
        let polynomial = product(self.polynomial, [p, &[]], p.len(), scratch);
        share += inner(p, polynomial);
        let explained = product(self.factor, [g, p], self.row_len, scratch);
        share -= inner(explained, explained);
        greater(share, 0.0)
    }
}

/// Computes the product of a matrix of `row_len` rows with a vector in two parts. Rows missing in
/// the matrix give 0.
fn product<'s>(
    matrix: &[[Le; 8]],
    parts: [&[f32]; 2],
    row_len: usize,
    scratch: &'s mut [f32],
) -> &'s [f32] {
    let (out, _) = split(scratch, padded(row_len));
    out.fill(0.0);
    block_product(level(), matrix, parts, out.as_chunks_mut().0);
    out.get(..row_len).unwrap_or(out)
}

/// Returns the inner product, summed in order.
fn inner(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).fold(0.0, |sum, (a, b)| sum + a * b)
}
