//! What a solve keeps in the caller's memory, and how it is cut.

use super::packed::packed_len;
use super::part::{Prior, PriorCounts};

/// Words that say of what the rest is.
const HEAD: usize = 7;
/// Vectors of S numbers.
const VECTORS: usize = 10;

impl PriorCounts {
    /// Returns the numbers of scratch that a [`super::PinJob`] needs.
    ///
    /// - `scalar_len`: of its pins, [`super::PinList::scalar_len`]; three times the most pins is enough.
    pub const fn pin_scratch_len(&self, scalar_len: usize) -> usize {
        let n = self.shape_len as usize;
        let fixed = HEAD + 2 * packed_len(n) + VECTORS * n;
        fixed.saturating_add(scalar_len.saturating_mul(n + 1))
    }
}

/// What the matrices of a scratch were made of, beside its rows.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Head(pub(super) [f64; HEAD]);

impl Head {
    /// That of nothing: a file has a length.
    pub(super) const NOTHING: Self = Self([0.0; HEAD]);

    pub(super) fn new(prior: &Prior<'_>, scalar_len: usize, terms: [f32; 2]) -> Self {
        let [len, checksum] = prior.file().words().map(f64::from);
        let [temporal, symmetry] = terms.map(f64::from);
        // Each is below 2^53.
        let (part, shapes) = (prior.part() as f64, prior.shape_len() as f64);
        Self([len, checksum, part, shapes, scalar_len as f64, temporal, symmetry])
    }
}

/// A scratch, cut.
pub(super) struct Scratch<'a> {
    pub(super) head: &'a mut [f64; HEAD],
    /// What the weights are changed from.
    pub(super) anchor: &'a mut [f64],
    pub(super) pull: &'a mut [f64],
    pub(super) low: &'a mut [f64],
    pub(super) high: &'a mut [f64],
    pub(super) zero: &'a mut [f64],
    pub(super) held: &'a mut [f64],
    /// Four vectors that a search writes anew.
    pub(super) loose: [&'a mut [f64]; 4],
    pub(super) hessian: &'a mut [f64],
    pub(super) factor: &'a mut [f64],
    /// A stiffness and S numbers a scalar of the pins.
    pub(super) rows: &'a mut [f64],
}

impl<'a> Scratch<'a> {
    /// Cuts a scratch; `None` of one that is too short.
    pub(super) fn new(scratch: &'a mut [f64], n: usize, scalar_len: usize) -> Option<Self> {
        let (head, mut rest) = scratch.split_first_chunk_mut()?;
        let mut cut = |len: usize| {
            let (own, others) = core::mem::take(&mut rest).split_at_mut_checked(len)?;
            rest = others;
            Some(own)
        };
        Some(Self {
            head,
            anchor: cut(n)?,
            pull: cut(n)?,
            low: cut(n)?,
            high: cut(n)?,
            zero: cut(n)?,
            held: cut(n)?,
            loose: [cut(n)?, cut(n)?, cut(n)?, cut(n)?],
            hessian: cut(packed_len(n))?,
            factor: cut(packed_len(n))?,
            rows: cut(scalar_len.checked_mul(n + 1)?)?,
        })
    }
}
