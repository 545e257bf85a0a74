//! Scratch memory of a solve, and its division.

use super::packed::packed_len;
use super::part::{Prior, PriorCounts};

/// Words of the cache key.
const KEY: usize = 7;
/// Vectors of S numbers.
const VECTORS: usize = 10;

impl PriorCounts {
    /// Returns the numbers of scratch that a [`super::PinJob`] needs.
    ///
    /// - `scalar_len`: [`super::PinList::scalar_len`] of its pins; three times the largest number
    ///   of pins is enough.
    pub const fn pin_scratch_len(&self, scalar_len: usize) -> usize {
        let n = self.shape_len as usize;
        let fixed = KEY + 2 * packed_len(n) + VECTORS * n;
        fixed.saturating_add(scalar_len.saturating_mul(n + 1))
    }
}

/// Cache key: identifies the inputs of the matrices in a scratch, except its rows.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct CacheKey(pub(super) [f64; KEY]);

impl CacheKey {
    /// The key of no inputs. A real key starts with a file's length, which is not 0.
    pub(super) const NOTHING: Self = Self([0.0; KEY]);

    pub(super) fn new(prior: &Prior<'_>, scalar_len: usize, terms: [f32; 2]) -> Self {
        let [len, checksum] = prior.file().words().map(f64::from);
        let [temporal, symmetry] = terms.map(f64::from);
        // Both numbers are below 2^53.
        let (part, shapes) = (prior.part() as f64, prior.shape_len() as f64);
        Self([len, checksum, part, shapes, scalar_len as f64, temporal, symmetry])
    }
}

/// A divided scratch.
pub(super) struct Scratch<'a> {
    pub(super) key: &'a mut [f64; KEY],
    /// Weights from which the change is measured.
    pub(super) anchor: &'a mut [f64],
    pub(super) rhs: &'a mut [f64],
    pub(super) low: &'a mut [f64],
    pub(super) high: &'a mut [f64],
    pub(super) zero: &'a mut [f64],
    pub(super) held: &'a mut [f64],
    /// Four work vectors, which a search overwrites.
    pub(super) work: [&'a mut [f64]; 4],
    pub(super) hessian: &'a mut [f64],
    pub(super) factor: &'a mut [f64],
    /// A stiffness and S numbers for each scalar of the pins.
    pub(super) rows: &'a mut [f64],
}

impl<'a> Scratch<'a> {
    /// Divides a scratch; `None` if it is too short.
    pub(super) fn new(scratch: &'a mut [f64], n: usize, scalar_len: usize) -> Option<Self> {
        let (key, mut rest) = scratch.split_first_chunk_mut()?;
        let mut cut = |len: usize| {
            let (own, others) = core::mem::take(&mut rest).split_at_mut_checked(len)?;
            rest = others;
            Some(own)
        };
        Some(Self {
            key,
            anchor: cut(n)?,
            rhs: cut(n)?,
            low: cut(n)?,
            high: cut(n)?,
            zero: cut(n)?,
            held: cut(n)?,
            work: [cut(n)?, cut(n)?, cut(n)?, cut(n)?],
            hessian: cut(packed_len(n))?,
            factor: cut(packed_len(n))?,
            rows: cut(scalar_len.checked_mul(n + 1)?)?,
        })
    }
}
