//! A prior in a loaded file: what loading found of it, and what it holds.

use super::counts::{PriorCounts, PriorFit, RULES};
use super::packed::packed_len;
use crate::format::part::{Part, PartLayout, first_counts};
use crate::format::rule::Rule;
use crate::format::{FileId, SectionKind};
use crate::linear::{Le, floats};
use crate::names::Names;
use core::fmt;

/// What loading found of a prior: its counts, and where its arrays lie. It borrows nothing, so that it can be kept
/// beside the model, and views be made of it each frame.
#[derive(Clone, Copy, Debug)]
pub struct PriorLayout(pub(crate) PartLayout);

const NAMES: usize = Rule::place(&RULES, SectionKind::Names);
const MEAN: usize = Rule::place(&RULES, SectionKind::PriorMean);
const FACTOR: usize = Rule::place(&RULES, SectionKind::PriorFactor);
const BOUNDS: usize = Rule::place(&RULES, SectionKind::WeightBounds);
const SYMMETRY: usize = Rule::place(&RULES, SectionKind::Symmetry);
const CANCEL: usize = Rule::place(&RULES, SectionKind::CancelPairs);
const FIT: usize = Rule::place(&RULES, SectionKind::PriorFit);

impl PriorLayout {
    /// Returns the prior; `None` if the bytes are not those of the file in which it was found, by their length and the
    /// checksum that they state.
    ///
    /// Nothing is read again. Of bytes that have changed otherwise the prior gives wrong numbers, but never panics.
    pub fn open<'a>(&self, file: &'a [u8]) -> Option<Prior<'a>> {
        self.0.open(file).map(Prior)
    }

    /// Returns the counts.
    pub const fn counts(&self) -> PriorCounts {
        PriorCounts::from_words(first_counts(&self.0.counts))
    }
}

/// Mean and precision of the weights of a skin's S shapes; borrowed from a loaded model.
///
/// Accessors by number return `None` beyond their range.
#[derive(Clone, Copy)]
pub struct Prior<'a>(pub(crate) Part<'a>);

impl<'a> Prior<'a> {
    /// Returns what loading found, to open it again.
    pub const fn layout(&self) -> PriorLayout {
        PriorLayout(self.0.layout)
    }

    /// Tells in which file it is.
    pub const fn file(&self) -> FileId {
        self.0.id()
    }

    /// Returns its place in [`crate::Model::parts`], by which [`crate::Model::sections`] are told apart.
    pub const fn part(&self) -> usize {
        self.0.index()
    }

    /// Returns the part's name.
    pub fn name(&self) -> &'a str {
        self.names().get(0).unwrap_or_default()
    }

    /// Returns its counts.
    pub const fn counts(&self) -> PriorCounts {
        self.layout().counts()
    }

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

impl fmt::Debug for Prior<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, counts) = (self.name(), self.counts());
        f.debug_struct("Prior").field("name", &name).field("counts", &counts).finish()
    }
}
