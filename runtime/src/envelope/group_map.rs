//! The kernel map of a group, read in place: `y = w outputs (C (G(s) - rest) + A x)`.

use super::group_kernel::GroupKernel;
use crate::lanes::{Eight, Lanes, in_lanes};
use crate::linear::{Le, block_distances, block_entry, block_product, padded};
use crate::numeric::nearness;

/// Sizes of a kernel map.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shape {
    /// Inputs, d.
    pub(crate) input_len: usize,
    /// Centres, n.
    pub(crate) centre_len: usize,
    /// Latent values, r.
    pub(crate) rank: usize,
    /// Outputs, o.
    pub(crate) output_len: usize,
}

impl Shape {
    /// Counts the floats of a map in the file; sizes below 2^20 cannot overflow it.
    pub(crate) fn words(&self) -> u64 {
        let Self { input_len: d, centre_len: n, rank: r, output_len: o } = *self;
        let rows = |len: usize| padded(len) as u64;
        let columns = |len: usize| len as u64;
        rows(n) * columns(d) + rows(n) + rows(r) * columns(n + d) + rows(o) * columns(r)
    }

    /// Counts the floats that evaluating a map takes: x, g, z and y, each in whole blocks.
    pub(crate) fn scratch_len(&self) -> usize {
        let Self { input_len, centre_len, rank, output_len } = *self;
        padded(input_len) + padded(centre_len) + padded(rank) + padded(output_len)
    }
}

/// A kernel map from d inputs to o outputs.
#[derive(Clone, Copy)]
pub(crate) struct Map<'a> {
    pub(crate) shape: Shape,
    pub(crate) kernel: GroupKernel,
    /// Squared distances at which a centre stops to vouch for x wholly, and at all.
    pub(crate) fade: (f32, f32),
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
        fade: (f32, f32),
        words: &'a [Le],
    ) -> Option<Self> {
        let Shape { input_len: d, centre_len: n, rank: r, output_len: o } = shape;
        let blocks = words.as_chunks().0;
        let matrix = |rows: usize, columns: usize| rows.div_ceil(8).checked_mul(columns);
        let (centres, blocks) = blocks.split_at_checked(matrix(n, d)?)?;
        let (rest, blocks) = blocks.split_at_checked(matrix(n, 1)?)?;
        let (coefficients, blocks) = blocks.split_at_checked(matrix(r, n + d)?)?;
        let (outputs, _) = blocks.split_at_checked(matrix(o, r)?)?;
        Some(Self { shape, kernel, fade, centres, rest, coefficients, outputs })
    }

    /// Evaluates the map where it is confident, and returns the confidence w, in [0, 1] (METHOD
    /// §2.6).
    ///
    /// - `input`: x, d values.
    /// - `scratch`: padded n + padded r values, of any content.
    /// - `out`: y, padded o values; left as they are where w is 0.
    pub(crate) fn evaluate(&self, input: &[f32], scratch: &mut [f32], out: &mut [f32]) -> f32 {
        let Shape { centre_len: n, rank: r, .. } = self.shape;
        let (basis, latent) = scratch.split_at_mut(padded(n).min(scratch.len()));
        let confidence = self.basis(input, basis.as_chunks_mut().0);
        if confidence == 0.0 {
            return 0.0;
        }
        let basis = basis.get(..n).unwrap_or_default();
        block_product(self.coefficients, [basis, input], latent.as_chunks_mut().0);
        let latent = latent.get(..r).unwrap_or_default();
        let out = out.as_chunks_mut().0;
        block_product(self.outputs, [latent, &[]], out);
        for value in out.as_flattened_mut() {
            *value *= confidence;
        }
        confidence
    }

    /// Computes g, n values in whole blocks, and returns w.
    fn basis(&self, input: &[f32], out: &mut [[f32; 8]]) -> f32 {
        let mut doubt = 1.0;
        let mut left = self.shape.centre_len;
        let mut blocks = out.iter_mut().zip(self.rest);
        block_distances(self.centres, input, |distances| {
            let Some((out, rest)) = blocks.next() else { return };
            *out = *self.kernel.changes(&distances, Lanes::read(rest)).floats();
            let nearness = in_lanes(distances.squared, |s| nearness(s, self.fade));
            for near in nearness.floats().iter().take(left) {
                doubt *= 1.0 - near;
            }
            left = left.saturating_sub(8);
        });
        1.0 - doubt
    }

    /// Returns coordinate i of centre k.
    pub(crate) fn centre(&self, k: usize, i: usize) -> Option<f32> {
        block_entry(self.centres, (self.shape.centre_len, self.shape.input_len), k, i)
    }

    /// Returns the kernel of centre k at x = 0.
    pub(crate) fn rest(&self, k: usize) -> Option<f32> {
        block_entry(self.rest, (self.shape.centre_len, 1), k, 0)
    }

    /// Returns a coefficient of [C A] (r x (n + d)).
    pub(crate) fn coefficient(&self, row: usize, column: usize) -> Option<f32> {
        let Shape { input_len, centre_len, rank, .. } = self.shape;
        block_entry(self.coefficients, (rank, centre_len + input_len), row, column)
    }

    /// Returns a coefficient of the outputs (o x r).
    pub(crate) fn output(&self, row: usize, column: usize) -> Option<f32> {
        block_entry(self.outputs, (self.shape.output_len, self.shape.rank), row, column)
    }
}
