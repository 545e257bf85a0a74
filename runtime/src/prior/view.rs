//! A prior in a loaded file: what loading found of it, and what it holds.

use super::counts::{PriorCounts, PriorFit, RULES};
use super::packed::packed_len;
use crate::format::SectionKind;
use crate::format::part::{self, Part, first_counts};
use crate::format::rule::Rule;
use crate::linear::{Le, floats};
use crate::names::Names;

const NAMES: usize = Rule::place(&RULES, SectionKind::Names);
const MEAN: usize = Rule::place(&RULES, SectionKind::PriorMean);
const FACTOR: usize = Rule::place(&RULES, SectionKind::PriorFactor);
const BOUNDS: usize = Rule::place(&RULES, SectionKind::WeightBounds);
const SYMMETRY: usize = Rule::place(&RULES, SectionKind::Symmetry);
const CANCEL: usize = Rule::place(&RULES, SectionKind::CancelPairs);
const FIT: usize = Rule::place(&RULES, SectionKind::PriorFit);

/// Mean and precision of the weights of a skin's S shapes; borrowed from a loaded model.
///
/// Accessors by number return `None` beyond their range.
#[derive(Clone, Copy)]
pub struct Prior<'a>(pub(crate) Part<'a>);

part::view! { Prior, PriorLayout, |words| -> PriorCounts { PriorCounts::from_words(first_counts(words)) } }

impl<'a> Prior<'a> {
    /// Returns S, the number of shapes.
    pub const fn shape_len(&self) -> usize {
        self.counts().shape_len as usize
    }

    /// Returns the mean weight of a shape.
    pub fn mean(&self, shape: usize) -> Option<f32> {
        self.means().get(shape).map(|le| f32::from_le_bytes(*le))
    }

    /// Returns an entry of U, whose square Uᵀ U is the precision; 0 below the diagonal.
    pub fn factor_entry(&self, row: usize, column: usize) -> Option<f32> {
        let n = self.shape_len();
        if row >= n || column >= n {
            return None;
        }
        let Some(after) = column.checked_sub(row) else { return Some(0.0) };
        let start = packed_len(n) - packed_len(n - row);
        self.factor().get(start + after).map(|le| f32::from_le_bytes(*le))
    }

    /// Returns the least and the greatest weight of a shape.
    pub fn weight_bounds(&self, shape: usize) -> Option<[f32; 2]> {
        self.0.entry(BOUNDS, self.shape_len(), shape).map(floats)
    }

    /// Lists the pairs of shapes that mirror each other, each with its stiffness: the reciprocal of the mean square by
    /// which they differ.
    pub fn symmetry(&self) -> impl Iterator<Item = ([usize; 2], f32)> + use<'a> {
        self.symmetry_rows()
            .iter()
            .map(|[pair, stiffness]| (shapes(pair), f32::from_le_bytes(*stiffness)))
    }

    /// Lists the pairs of shapes of which one alone is at work.
    pub fn cancel_pairs(&self) -> impl Iterator<Item = [usize; 2]> + use<'a> {
        self.cancel_rows().iter().map(shapes)
    }

    /// Returns how stiff pins are by default, and what the prior was measured to reach.
    pub fn fit(&self) -> PriorFit {
        let figures = self.0.array(FIT).first().map(floats);
        PriorFit::from_figures(figures.unwrap_or_default())
    }

    pub(super) fn names(&self) -> Names<'a> {
        Names::new(self.0.bytes(NAMES), 1)
    }

    pub(super) fn means(&self) -> &'a [Le] {
        self.0.bytes(MEAN).as_chunks().0
    }

    /// Rows of U, packed.
    pub(super) fn factor(&self) -> &'a [Le] {
        self.0.bytes(FACTOR).as_chunks().0
    }

    pub(super) fn bounds(&self) -> &'a [[Le; 2]] {
        self.0.array(BOUNDS)
    }

    pub(super) fn symmetry_rows(&self) -> &'a [[Le; 2]] {
        self.0.array(SYMMETRY)
    }

    pub(super) fn cancel_rows(&self) -> &'a [Le] {
        self.0.bytes(CANCEL).as_chunks().0
    }
}

/// Reads a pair of shapes.
pub(super) fn shapes([a, b, c, d]: &Le) -> [usize; 2] {
    [[*a, *b], [*c, *d]].map(|le| u16::from_le_bytes(le).into())
}
