//! The kernel map of a group, read in place: `y = w outputs z`, `[z h] = C (G(s) - rest) + A x`.

use super::group_kernel::GroupKernel;
use super::trust::{Evidence, Trust};
use crate::lanes::{Eight, Lanes};
use crate::linear::{Le, block_distances, block_entry, block_product, padded, split};

/// Sizes of a kernel map.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shape {
    /// Inputs, d.
    pub(crate) input_len: usize,
    /// Centres, n.
    pub(crate) centre_len: usize,
    /// Latent values, r.
    pub(crate) rank: usize,
    /// Values h that tell how well x is known, behind the latent ones.
    pub(crate) certainty_len: usize,
    /// Outputs, o.
    pub(crate) output_len: usize,
}

impl Shape {
    /// Counts the floats of a map in the file; sizes below 2^20 cannot overflow it.
    pub(crate) fn words(&self) -> u64 {
        let Self { input_len: d, centre_len: n, rank: r, output_len: o, .. } = *self;
        let rows = |len: usize| padded(len) as u64;
        let columns = |len: usize| len as u64;
        rows(n) * columns(d) + rows(n) + rows(self.values()) * columns(n + d) + rows(o) * columns(r)
    }

    /// Counts the floats that evaluating a map takes: x, g, z with h and y, each in whole blocks.
    pub(crate) fn scratch_len(&self) -> usize {
        let Self { input_len, centre_len, output_len, .. } = *self;
        padded(input_len) + padded(centre_len) + padded(self.values()) + padded(output_len)
    }

    /// Counts the values of z and h.
    fn values(&self) -> usize {
        self.rank + self.certainty_len
    }
}

/// A kernel map from d inputs to o outputs.
#[derive(Clone, Copy)]
pub(crate) struct Map<'a> {
    pub(crate) shape: Shape,
    pub(crate) kernel: GroupKernel,
    pub(crate) trust: Trust,
    centres: &'a [[Le; 8]],
    rest: &'a [[Le; 8]],
    coefficients: &'a [[Le; 8]],
    outputs: &'a [[Le; 8]],
}

impl<'a> Map<'a> {
    /// Cuts the words of a map; `None` if they are too few.
    pub(crate) fn new(
        shape: Shape,
        kernel: GroupKernel,
        trust: Trust,
        words: &'a [Le],
    ) -> Option<Self> {
        let Shape { input_len: d, centre_len: n, rank: r, output_len: o, .. } = shape;
        let blocks = words.as_chunks().0;
        let matrix = |rows: usize, columns: usize| rows.div_ceil(8).checked_mul(columns);
        let (centres, blocks) = blocks.split_at_checked(matrix(n, d)?)?;
        let (rest, blocks) = blocks.split_at_checked(matrix(n, 1)?)?;
        let (coefficients, blocks) = blocks.split_at_checked(matrix(shape.values(), n + d)?)?;
        let (outputs, _) = blocks.split_at_checked(matrix(o, r)?)?;
        Some(Self { shape, kernel, trust, centres, rest, coefficients, outputs })
    }

    /// Evaluates the map where x is known, and returns what is known of it (METHOD §2.6).
    ///
    /// - `input`: x, d values.
    /// - `scratch`: padded n + padded r + m values, of any content.
    /// - `out`: room for y, padded o values.
    ///
    /// Returns y too, or nothing where w is 0.
    #[inline]
    pub(crate) fn evaluate<'b>(
        &self,
        input: &[f32],
        scratch: &mut [f32],
        out: &'b mut [f32],
    ) -> (Evidence, &'b [f32]) {
        let Shape { centre_len: n, rank: r, certainty_len: m, .. } = self.shape;
        let (basis, values) = scratch.split_at_mut(padded(n).min(scratch.len()));
        self.basis(input, basis.as_chunks_mut().0);
        let basis = basis.get(..n).unwrap_or_default();
        block_product(self.coefficients, [basis, input], values.as_chunks_mut().0);
        let (latent, certainty) = split(values, r);
        let change = basis.first().copied().unwrap_or_default();
        let evidence = self.trust.evidence(input, change, certainty.iter().take(m));
        let w = evidence.share();
        if w > 0.0 {
            let out = out.as_chunks_mut().0;
            block_product(self.outputs, [latent, &[]], out);
            let out = out.as_flattened_mut();
            for value in &mut *out {
                *value *= w;
            }
            (evidence, out)
        } else {
            (evidence, &[])
        }
    }

    /// Computes g, n values in whole blocks.
    #[inline]
    fn basis(&self, input: &[f32], out: &mut [[f32; 8]]) {
        let mut blocks = out.iter_mut().zip(self.rest);
        block_distances(self.centres, input, |distances| {
            let Some((out, rest)) = blocks.next() else { return };
            *out = *self.kernel.changes(&distances, Lanes::read(rest)).floats();
        });
    }

    /// Returns coordinate i of centre k.
    pub(crate) fn centre(&self, k: usize, i: usize) -> Option<f32> {
        block_entry(self.centres, (self.shape.centre_len, self.shape.input_len), k, i)
    }

    /// Returns the kernel of centre k at x = 0.
    pub(crate) fn rest(&self, k: usize) -> Option<f32> {
        block_entry(self.rest, (self.shape.centre_len, 1), k, 0)
    }

    /// Returns a coefficient of [C A] ((r + m) x (n + d)).
    pub(crate) fn coefficient(&self, row: usize, column: usize) -> Option<f32> {
        let Shape { input_len, centre_len, .. } = self.shape;
        block_entry(self.coefficients, (self.shape.values(), centre_len + input_len), row, column)
    }

    /// Returns a coefficient of the outputs (o x r).
    pub(crate) fn output(&self, row: usize, column: usize) -> Option<f32> {
        block_entry(self.outputs, (self.shape.output_len, self.shape.rank), row, column)
    }
}
