//! A group and its kernel map, read in place (METHOD §1.9).

use super::confidence::{ExpectedError, GroupConfidence};
use super::kernel::GroupKernel;
use super::row::{GroupRow, Shape};
use crate::envelope::view::Envelope;
use crate::linear::{Le, block_entry, block_product, block_sums, padded, split};
use crate::unit::Level;
use core::fmt;
use core::ops::Range;

/// Helpers that share a dominant joint and one kernel map, `y = w outputs z` with `[z h] = C g + A x`.
///
/// The inputs are `x_i = weight_i phi[feature_i]`. Accessors by index return `None` beyond their range.
#[derive(Clone)]
pub struct Group<'a> {
    /// Dominant joint.
    pub joint: usize,
    /// G.
    pub kernel: GroupKernel,
    /// Helpers of the group, a part of `0..proxy_len`.
    pub proxies: Range<usize>,
    /// Parameters of the group's confidence.
    pub confidence: GroupConfidence,
    shape: Shape,
    features: &'a [Le],
    weights: &'a [Le],
    centres: &'a [[Le; 8]],
    rest: &'a [[Le; 8]],
    coefficients: &'a [[Le; 8]],
    outputs: &'a [[Le; 8]],
}

impl<'a> Envelope<'a> {
    /// Lists the G groups. The helpers of a group follow the helpers of the previous group.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) fn groups(&self) -> impl Iterator<Item = Group<'a>> + use<'a> {
        let words = self.corrections();
        let mut end = 0;
        self.group_rows().map_while(move |row| {
            let start = end;
            end += usize::from(row.proxy_len);
            Group::new(&row, start..end, words.get(row.offset as usize..)?)
        })
    }

    /// Returns a group.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) fn group(&self, index: usize) -> Option<Group<'a>> {
        self.groups().nth(index)
    }
}

impl<'a> Group<'a> {
    /// Splits the words of a group into its arrays; `None` if the words are too few.
    fn new(row: &GroupRow, proxies: Range<usize>, words: &'a [Le]) -> Option<Self> {
        let shape = row.shape();
        let Shape { input_len: d, centre_len: n, rank: r, output_len: o, .. } = shape;
        let kernel = GroupKernel::from_number(row.kernel)?;
        let (features, words) = words.split_at_checked(padded(d))?;
        let (weights, words) = words.split_at_checked(padded(d))?;
        let blocks = words.as_chunks().0;
        let matrix = |rows: usize, columns: usize| rows.div_ceil(8).checked_mul(columns);
        let (centres, blocks) = blocks.split_at_checked(matrix(n, d)?)?;
        let (rest, blocks) = blocks.split_at_checked(matrix(n, 1)?)?;
        let (coefficients, blocks) = blocks.split_at_checked(matrix(shape.values(), n + d)?)?;
        let (outputs, _) = blocks.split_at_checked(matrix(o, r)?)?;
        Some(Self {
            joint: row.joint.into(),
            kernel,
            proxies,
            confidence: row.confidence,
            shape,
            features,
            weights,
            centres,
            rest,
            coefficients,
            outputs,
        })
    }

    /// Returns d, the number of inputs.
    pub fn input_len(&self) -> usize {
        self.shape.input_len
    }

    /// Returns n, the number of centres. A group without centres adds nothing.
    pub fn centre_len(&self) -> usize {
        self.shape.centre_len
    }

    /// Returns r, the number of latent values.
    pub fn rank(&self) -> usize {
        self.shape.rank
    }

    /// Returns m, the number of values whose squares sum to the explained variance.
    pub fn certainty_len(&self) -> usize {
        self.shape.certainty_len
    }

    /// Returns an input: the index of its feature, 12 j + 4 r + c, and its weight.
    pub fn input(&self, i: usize) -> Option<(usize, f32)> {
        self.inputs().nth(i)
    }

    /// Lists the d inputs, as [`Self::input`] returns them.
    pub(crate) fn inputs(&self) -> impl Iterator<Item = (usize, f32)> + use<'a> {
        let inputs = self.features.iter().zip(self.weights).take(self.input_len());
        inputs.map(|(feature, weight)| {
            (u32::from_le_bytes(*feature) as usize, f32::from_le_bytes(*weight))
        })
    }

    /// Returns coordinate i of centre k.
    pub fn centre(&self, k: usize, i: usize) -> Option<f32> {
        let stored =
            block_entry(self.centres, (self.shape.centre_len, self.shape.input_len), k, i)?;
        Some(stored / self.kernel.centre_factor())
    }

    /// Returns the number `rest` of centre k: [`GroupKernel::at_rest`].
    pub fn rest(&self, k: usize) -> Option<f32> {
        block_entry(self.rest, (self.shape.centre_len, 1), k, 0)
    }

    /// Returns a coefficient of [C A] ((r + m) x (n + d)): the rows of z, then the rows of h.
    pub fn coefficient(&self, row: usize, column: usize) -> Option<f32> {
        let Shape { input_len, centre_len, .. } = self.shape;
        block_entry(self.coefficients, (self.shape.values(), centre_len + input_len), row, column)
    }

    /// Returns a coefficient of the outputs (12 p x r): row 12 l + 4 r + c is entry r, c of the group's
    /// l-th helper.
    pub fn output(&self, row: usize, column: usize) -> Option<f32> {
        block_entry(self.outputs, (self.shape.output_len, self.shape.rank), row, column)
    }

    /// Evaluates the kernel map, and the expected error that gives the confidence (METHOD §2.6).
    ///
    /// Returns y too; y is empty if w is 0.
    ///
    /// - `input`: x, d values.
    /// - `scratch`: padded n + padded r + m values, of any content.
    /// - `out`: room for y, padded 12 p values.
    #[inline]
    pub(crate) fn evaluate<'b>(
        &self,
        level: Level,
        input: &[f32],
        scratch: &mut [f32],
        out: &'b mut [f32],
    ) -> (ExpectedError, &'b [f32]) {
        let Shape { centre_len: n, rank: r, certainty_len: m, .. } = self.shape;
        let (basis, values) = scratch.split_at_mut(padded(n).min(scratch.len()));
        self.basis(level, input, basis.as_chunks_mut().0);
        let basis = basis.get(..n).unwrap_or_default();
        block_product(level, self.coefficients, [basis, input], values.as_chunks_mut().0);
        let (latent, roots) = split(values, r);
        let rest_change = basis.first().copied().unwrap_or_default();
        let error = self.confidence.expected_error(input, rest_change, roots.iter().take(m));
        let w = error.map_weight();
        if w > 0.0 {
            let out = out.as_chunks_mut().0;
            block_product(level, self.outputs, [latent, &[]], out);
            let out = out.as_flattened_mut();
            for value in &mut *out {
                *value *= w;
            }
            (error, out)
        } else {
            (error, &[])
        }
    }

    /// Computes g, the change of each centre's kernel from rest, n values in whole blocks.
    #[inline]
    fn basis(&self, level: Level, input: &[f32], out: &mut [[f32; 8]]) {
        block_sums(level, self.kernel.sum(), self.centres, input, out);
        self.kernel.changes(level, out, self.rest);
    }
}

impl fmt::Debug for Group<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { joint, kernel, proxies, confidence, .. } = self;
        f.debug_struct("Group")
            .field("joint", joint)
            .field("kernel", kernel)
            .field("proxies", proxies)
            .field("confidence", confidence)
            .finish_non_exhaustive()
    }
}
