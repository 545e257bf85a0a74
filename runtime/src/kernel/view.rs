//! A kernel in a loaded file, with access to its sections.

use super::counts::{KernelCounts, KernelFit, RULES};
use super::function::Kernel;
use super::rows::{InputKind, InputRow, OutputKind, OutputRow};
use super::rule::{KernelRule, Normalise, QueryRule};
use crate::format::SectionKind;
use crate::format::part::{self, Part, first_counts};
use crate::format::rule::Rule;
use crate::linear::{Le, block_entry, floats};
use crate::names::Names;

const NAMES: usize = Rule::place(&RULES, SectionKind::Names);
const RULE: usize = Rule::place(&RULES, SectionKind::KernelRule);
const INPUTS: usize = Rule::place(&RULES, SectionKind::Inputs);
const OUTPUTS: usize = Rule::place(&RULES, SectionKind::Outputs);
const FEATURES: usize = Rule::place(&RULES, SectionKind::Features);
const METRIC: usize = Rule::place(&RULES, SectionKind::Metric);
const CENTRES: usize = Rule::place(&RULES, SectionKind::KernelCentres);
const TERMS: usize = Rule::place(&RULES, SectionKind::Terms);
const COEFFICIENTS: usize = Rule::place(&RULES, SectionKind::KernelCoefficients);
const VARIANCE: usize = Rule::place(&RULES, SectionKind::Variance);
const FIT: usize = Rule::place(&RULES, SectionKind::KernelFit);

/// A function `f = C G(|z - t|²) + B p(u)` from named inputs to named outputs; borrowed from a
/// loaded model.
///
/// Accessors by number return `None` if the number is out of range.
#[derive(Clone, Copy)]
pub struct KernelMap<'a>(pub(crate) Part<'a>);

part::view! { KernelMap, Kernel, |words| -> KernelCounts { KernelCounts::from_words(first_counts(words)) } }

impl<'a> KernelMap<'a> {
    /// Returns the choice of kernel, and the rules for queries and outputs.
    pub fn rule(&self) -> KernelRule {
        let bytes = self.0.bytes(RULE).first_chunk();
        bytes.and_then(|bytes| KernelRule::from_bytes(bytes).ok()).unwrap_or(KernelRule {
            kernel: Kernel::Linear,
            query: QueryRule::Free,
            normalise: Normalise::Never,
            fade: (0.0, 0.0),
        })
    }

    /// Returns the measured accuracy of the fit.
    pub fn fit(&self) -> KernelFit {
        let figures = self.0.array(FIT).first().map(floats);
        KernelFit::from_figures(figures.unwrap_or_default())
    }

    /// Returns R, the numbers of a query.
    pub fn query_len(&self) -> usize {
        let kinds = self.input_rows().iter().filter_map(|[kind, ..]| InputKind::from_number(*kind));
        kinds.map(InputKind::number_len).sum()
    }

    /// Returns the numbers of a result.
    pub fn result_len(&self) -> usize {
        let kinds =
            self.output_rows().iter().filter_map(|[kind, ..]| OutputKind::from_number(*kind));
        kinds.map(OutputKind::number_len).sum()
    }

    /// Returns an input's name.
    pub fn input_name(&self, input: usize) -> Option<&'a str> {
        let is_there = input < self.counts().input_len as usize;
        self.names().get(input.checked_add(1)?).filter(|_| is_there)
    }

    /// Returns an output's name.
    pub fn output_name(&self, output: usize) -> Option<&'a str> {
        self.names().get(output.checked_add(1)?.checked_add(self.counts().input_len as usize)?)
    }

    /// Lists the I inputs, in the order of a query.
    pub fn inputs(&self) -> impl Iterator<Item = InputRow> + use<'a> {
        let rows = self.0.bytes(INPUTS).as_chunks().0;
        rows.iter().filter_map(|row| InputRow::from_bytes(row).ok())
    }

    /// Lists the O outputs, in the order of a result.
    pub fn outputs(&self) -> impl Iterator<Item = OutputRow> + use<'a> {
        let rows = self.0.bytes(OUTPUTS).as_chunks().0;
        rows.iter().filter_map(|row| OutputRow::from_bytes(row).ok())
    }

    /// Returns the shift and scale of a feature, and its least and greatest value in the data.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) fn feature(&self, feature: usize) -> Option<[f32; 4]> {
        self.0.entry(FEATURES, self.counts().feature_len as usize, feature).map(floats)
    }

    /// Returns a coefficient of the metric W (e x d).
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) fn metric_entry(&self, row: usize, column: usize) -> Option<f32> {
        let counts = self.counts();
        let shape = (counts.metric_len as usize, counts.feature_len as usize);
        block_entry(self.metric(), shape, row, column)
    }

    /// Returns coordinate i of centre k.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) fn centre(&self, k: usize, i: usize) -> Option<f32> {
        let counts = self.counts();
        let shape = (counts.centre_len as usize, counts.coordinate_len() as usize);
        block_entry(self.centres(), shape, k, i)
    }

    /// Returns the factors of a monomial: an earlier monomial and an input. The first monomial,
    /// which is 1, has [`super::NO_TERM`] twice.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) fn term(&self, term: usize) -> Option<[u16; 2]> {
        let is_there = term < self.counts().term_len as usize;
        let term = self.terms().get(term).filter(|_| is_there)?;
        Some(term.map(u16::from_le_bytes))
    }

    /// Returns a coefficient of [C B] (m x (n + T)).
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) fn coefficient(&self, row: usize, column: usize) -> Option<f32> {
        let counts = self.counts();
        let columns = counts.centre_len.saturating_add(counts.term_len) as usize;
        block_entry(self.coefficients(), (counts.value_len as usize, columns), row, column)
    }

    pub(crate) fn names(&self) -> Names<'a> {
        let counts = self.counts();
        let others = counts.input_len.saturating_add(counts.output_len) as usize;
        Names::new(self.0.bytes(NAMES), others.saturating_add(1))
    }

    pub(super) fn rule_bytes(&self) -> &'a [u8] {
        self.0.bytes(RULE)
    }

    pub(super) fn input_rows(&self) -> &'a [[u8; InputRow::BYTES]] {
        self.0.bytes(INPUTS).as_chunks().0
    }

    pub(super) fn output_rows(&self) -> &'a [[u8; OutputRow::BYTES]] {
        self.0.bytes(OUTPUTS).as_chunks().0
    }

    pub(super) fn features(&self) -> &'a [[Le; 4]] {
        self.0.array(FEATURES)
    }

    pub(super) fn metric(&self) -> &'a [[Le; 8]] {
        self.0.array(METRIC)
    }

    pub(super) fn centres(&self) -> &'a [[Le; 8]] {
        self.0.array(CENTRES)
    }

    pub(super) fn terms(&self) -> &'a [[[u8; 2]; 2]] {
        self.0.bytes(TERMS).as_chunks().0.as_chunks().0
    }

    pub(super) fn coefficients(&self) -> &'a [[Le; 8]] {
        self.0.array(COEFFICIENTS)
    }

    pub(super) fn variance_words(&self) -> &'a [Le] {
        self.0.bytes(VARIANCE).as_chunks().0
    }
}
