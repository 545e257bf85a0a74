//! From a query to outputs.

use super::counts::KernelCounts;
use super::outputs;
use super::point::{self, Point};
use super::view::KernelMap;
use crate::error::{Argument, CallError};
use crate::lanes::{Eight, in_lanes};
use crate::linear::{block_distances, block_product, padded, split};
use crate::numeric::nearness;

impl KernelCounts {
    /// Returns the floats of scratch that [`KernelMap::evaluate`] needs.
    pub const fn scratch_len(&self) -> usize {
        let (n, m) = (self.centre_len as usize, self.value_len as usize);
        // A rotation gives one number more than it has values.
        Point::scratch_len(self) + padded(n) + padded(m) + m + self.output_len as usize
    }
}

impl KernelMap<'_> {
    /// Computes the outputs of a query, and returns the confidence in them, in [0, 1]: 1 where a centre is
    /// near, 0 far from all; 1 where the kernel has no fade.
    ///
    /// - `query`: [`KernelMap::query_len`] numbers: 1 of a scalar, 3 of a vector, of a rotation a quaternion x,
    ///   y, z, w of any length but 0, one input after the other.
    /// - `scratch`: at least [`KernelCounts::scratch_len`] floats, of any content.
    /// - `out`: [`KernelMap::result_len`] numbers: 1 of a scalar, 3 of a vector, of a rotation a quaternion of
    ///   length 1, one output after the other.
    ///
    /// # Errors
    /// - [`crate::CallErrorKind::Length`]: `query` or `out` has another length.
    /// - [`crate::CallErrorKind::TooShort`]: `scratch` is too short.
    /// - [`crate::CallErrorKind::NonFinite`]: a number of `query` is not finite; or one of the outputs would not
    ///   be, by its first number: the query is too far out for single precision.
    /// - [`crate::CallErrorKind::ZeroRotation`]: the quaternion of an input, whose number is the index, has no
    ///   direction.
    pub fn evaluate(
        &self,
        query: &[f32],
        scratch: &mut [f32],
        out: &mut [f32],
    ) -> Result<f32, CallError> {
        let counts = self.counts();
        let (n, m) = (counts.centre_len as usize, counts.value_len as usize);
        Argument::Outputs.check_len(self.result_len(), out.len())?;
        Argument::Scratch.check_least(counts.scratch_len(), scratch.len())?;
        point::check(self, query)?;
        let (point, scratch) = Point::new(self, query, scratch);
        let (basis, scratch) = split(scratch, padded(n));
        let (values, scratch) = split(scratch, padded(m));
        let confidence = self.basis(&point, basis.as_chunks_mut().0);
        let basis = basis.get(..n).unwrap_or_default();
        // Without centres and terms there is no column to sum.
        values.fill(0.0);
        block_product(self.coefficients(), [basis, point.terms], values.as_chunks_mut().0);
        let (found, _) = split(scratch, out.len());
        let (values, _) = split(values, m);
        outputs::evaluate(self, confidence, values, found)?;
        out.iter_mut().zip(found).for_each(|(out, found)| *out = *found);
        Ok(confidence)
    }

    /// Computes G of each centre, n values in whole blocks, and returns the confidence.
    pub(super) fn basis(&self, point: &Point<'_>, out: &mut [[f32; 8]]) -> f32 {
        let rule = self.rule();
        let mut doubt = 1.0;
        let mut left = self.counts().centre_len as usize;
        let mut blocks = out.iter_mut();
        block_distances(self.centres(), point.z, |distances| {
            let Some(out) = blocks.next() else { return };
            *out = *rule.kernel.values(distances.squared).floats();
            // A centre that vouches wholly leaves no doubt, whatever the others do.
            if rule.has_fade() && doubt > 0.0 {
                let nearness = in_lanes(distances.squared, |s| nearness(s, rule.fade));
                for near in nearness.floats().iter().take(left) {
                    doubt *= 1.0 - near;
                }
                left = left.saturating_sub(8);
            }
        });
        if rule.has_fade() { 1.0 - doubt } else { 1.0 }
    }
}
