//! The numbers of a kernel: how large it is, how good it is.

use super::rows::{InputRow, OutputRow};
use super::rule::KernelRule;
use crate::format::SectionKind;
use crate::format::part::{Asked, COUNTS, SECTIONS};
use crate::format::rule::{ALWAYS, Rule};

/// Stands for no earlier term and no input: in the row of the first term, which is 1.
pub const NO_TERM: u16 = u16::MAX;

/// What the fit was measured to reach, in the units of the outputs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct KernelFit {
    /// RMS over samples of the distance between the samples' values and the kernel's.
    pub rms_residual: f32,
    /// The same, each sample left out of its own fit; 0 if it was not computed.
    pub left_out_rms: f32,
    /// The largest error of single precision that was found: the bound E of METHOD §2.7.
    pub rounding_error: f32,
    /// Reciprocal of the condition number of what was solved.
    pub reciprocal_condition: f32,
}

impl KernelFit {
    /// Bytes of section `kernel_fit`.
    pub const BYTES: usize = 16;

    /// Lists its figures in the order of the file.
    pub const fn figures(&self) -> [f32; 4] {
        let Self { rms_residual, left_out_rms, rounding_error, reciprocal_condition } = *self;
        [rms_residual, left_out_rms, rounding_error, reciprocal_condition]
    }

    /// Makes it of its figures.
    pub const fn from_figures(figures: [f32; 4]) -> Self {
        let [rms_residual, left_out_rms, rounding_error, reciprocal_condition] = figures;
        Self { rms_residual, left_out_rms, rounding_error, reciprocal_condition }
    }
}

/// Counts of a kernel, from which every section's length follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KernelCounts {
    /// Inputs, I.
    pub input_len: u32,
    /// Outputs, O.
    pub output_len: u32,
    /// Features, d: what the inputs make together.
    pub feature_len: u32,
    /// Rows of the metric, e; 0 if distances are those of the features.
    pub metric_len: u32,
    /// Centres, n.
    pub centre_len: u32,
    /// Terms of the polynomial, T.
    pub term_len: u32,
    /// Values, m: what the outputs take together.
    pub value_len: u32,
    /// Rows of the variance's factor, r; 0 if no variance is stored.
    pub variance_len: u32,
}

impl KernelCounts {
    /// Bytes of section `kernel_counts`.
    pub const BYTES: usize = 32;

    /// Lists the counts in the order of the file.
    pub const fn words(&self) -> [u32; 8] {
        let Self { input_len, output_len, feature_len, metric_len, .. } = *self;
        let Self { centre_len, term_len, value_len, variance_len, .. } = *self;
        [
            input_len,
            output_len,
            feature_len,
            metric_len,
            centre_len,
            term_len,
            value_len,
            variance_len,
        ]
    }

    /// Makes them of their words.
    pub const fn from_words(words: [u32; 8]) -> Self {
        let [input_len, output_len, feature_len, metric_len, rest @ ..] = words;
        let [centre_len, term_len, value_len, variance_len] = rest;
        Self {
            input_len,
            output_len,
            feature_len,
            metric_len,
            centre_len,
            term_len,
            value_len,
            variance_len,
        }
    }

    /// Returns c, the number of coordinates in which distances are measured: e, or d without a metric.
    pub const fn coordinate_len(&self) -> u32 {
        if self.metric_len > 0 { self.metric_len } else { self.feature_len }
    }

    /// Whether a kernel of these counts has a section.
    pub fn has(&self, section: SectionKind) -> bool {
        Rule::of(&RULES, section).is_some_and(|rule| self.asked().has & rule.has != 0)
    }

    /// Computes a section's length in bytes, the least of the names; `None` if no kernel has it.
    pub fn section_bytes(&self, section: SectionKind) -> Option<u64> {
        Rule::of(&RULES, section)?.bytes(&self.asked().sizes)
    }

    /// Returns what they ask of the sections, as [`RULES`] have it.
    pub(crate) const fn asked(&self) -> Asked {
        let Self { input_len: i, output_len: o, feature_len: d, metric_len: e, .. } = *self;
        let Self { centre_len: n, term_len: t, value_len: m, variance_len: r, .. } = *self;
        let has_metric = if e > 0 { METRIC } else { 0 };
        let has_variance = if r > 0 { VARIANCE } else { 0 };
        let names = i.saturating_add(o);
        let basis = n.saturating_add(t);
        let variance = blocks(r, basis)
            .saturating_add(blocks(n, t))
            .saturating_add(blocks(t, t))
            .saturating_mul(8)
            .saturating_add(m);
        let sizes = [
            1,
            i,
            o,
            names,
            d,
            blocks(e, d),
            blocks(n, self.coordinate_len()),
            t,
            blocks(m, basis),
            variance,
        ];
        Asked::new(ALWAYS | has_metric | has_variance, sizes)
    }
}

/// Counts the columns of 8 of a matrix in blocks of 8 rows; more than a file holds where they are too many.
const fn blocks(rows: u32, columns: u32) -> u32 {
    rows.div_ceil(8).saturating_mul(columns)
}

/// Where the counts stand in their section.
pub(crate) mod place {
    pub(crate) const INPUTS: usize = 0;
    pub(crate) const OUTPUTS: usize = 1;
    pub(crate) const FEATURES: usize = 2;
    pub(crate) const METRIC: usize = 3;
    pub(crate) const CENTRES: usize = 4;
    pub(crate) const TERMS: usize = 5;
    pub(crate) const VALUES: usize = 6;
    pub(crate) const VARIANCE: usize = 7;
}

/// Bit of a kernel with a metric.
const METRIC: u8 = 4;
/// Bit of a kernel with a variance.
const VARIANCE: u8 = 8;

/// The sections of a kernel, in the order in which the trainer writes them.
pub const KERNEL_SECTIONS: [SectionKind; RULES.len()] = Rule::sections(&RULES);

const _: () = assert!(RULES.len() <= SECTIONS && KernelCounts::BYTES <= 4 * COUNTS);

/// What a kernel asks of its sections. Sizes: 1, I, O, I + O, d, then columns of 8 of the metric and of the
/// centres, T, columns of 8 of the coefficients, words of the variance.
pub(crate) const RULES: [Rule; 12] = [
    Rule::new(SectionKind::KernelCounts, KernelCounts::BYTES as u8, [0, 0]),
    Rule::new(SectionKind::Names, 4, [3, 0]).or_more(4),
    Rule::new(SectionKind::KernelRule, KernelRule::BYTES as u8, [0, 0]).finite_after(1),
    Rule::new(SectionKind::Inputs, InputRow::BYTES as u8, [1, 0]).finite_after(1),
    Rule::new(SectionKind::Outputs, OutputRow::BYTES as u8, [2, 0]).finite_after(1),
    Rule::new(SectionKind::Features, 16, [4, 0]).finite_after(0),
    Rule::new(SectionKind::Metric, 32, [5, 0]).with(METRIC).finite_after(0),
    Rule::new(SectionKind::KernelCentres, 32, [6, 0]).finite_after(0),
    Rule::new(SectionKind::Terms, 4, [7, 0]),
    Rule::new(SectionKind::KernelCoefficients, 32, [8, 0]).finite_after(0),
    Rule::new(SectionKind::Variance, 4, [9, 0]).with(VARIANCE).finite_after(0),
    Rule::new(SectionKind::KernelFit, KernelFit::BYTES as u8, [0, 0]).finite_after(0),
];
