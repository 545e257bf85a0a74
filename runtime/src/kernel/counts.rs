//! Counts and measured accuracy of a kernel.

use super::rows::{InputRow, OutputRow};
use super::rule::KernelRule;
use crate::format::SectionKind;
use crate::format::flat::flat;
use crate::format::part::{Asked, COUNTS, SECTIONS};
use crate::format::rule::{ALWAYS, Rule};

/// Sentinel for "none" in the row of the first term, which is 1 and has no earlier term and no
/// input.
pub const NO_TERM: u16 = u16::MAX;

/// Measured accuracy of the fit, in units of the outputs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(not(feature = "internals"), non_exhaustive)]
pub struct KernelFit {
    /// RMS distance between the samples' values and the kernel's.
    pub rms_residual: f32,
    /// RMS distance with each sample left out of its own fit; 0 if not computed.
    pub left_out_rms: f32,
    /// Largest observed error of single precision: the bound E of METHOD §2.7.
    pub rounding_error: f32,
    /// Reciprocal condition number of the solved system.
    pub reciprocal_condition: f32,
}

flat! { KernelFit of "kernel_fit", figures, from_figures: [f32; 4] {
    rms_residual, left_out_rms, rounding_error, reciprocal_condition
} }

/// Counts of a kernel. The length of every section follows from the counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KernelCounts {
    /// Inputs, I.
    pub input_len: u32,
    /// Outputs, O.
    pub output_len: u32,
    /// Features of all inputs, d.
    pub feature_len: u32,
    /// Rows of the metric, e; 0 if distances are measured between features.
    pub metric_len: u32,
    /// Centres, n.
    pub centre_len: u32,
    /// Terms of the polynomial, T.
    pub term_len: u32,
    /// Values of all outputs, m.
    pub value_len: u32,
    /// Rows of the variance's factor, r; 0 if the file has no variance.
    pub variance_len: u32,
}

flat! { KernelCounts of "kernel_counts", words, from_words: [u32; 8] {
    input_len, output_len, feature_len, metric_len, centre_len, term_len, value_len, variance_len
} }

impl KernelCounts {
    /// Returns c, the number of coordinates for distances: e, or d without a metric.
    pub const fn coordinate_len(&self) -> u32 {
        if self.metric_len > 0 { self.metric_len } else { self.feature_len }
    }

    /// Whether a kernel of these counts has a section.
    pub fn has(&self, section: SectionKind) -> bool {
        Rule::of(&RULES, section).is_some_and(|rule| self.asked().has & rule.has != 0)
    }

    /// Computes a section's length in bytes, or the least length of the names; `None` if kernels
    /// lack the section.
    pub fn section_bytes(&self, section: SectionKind) -> Option<u64> {
        Rule::of(&RULES, section)?.bytes(&self.asked().sizes)
    }

    /// Returns the requirements for the sections, in the terms of [`RULES`].
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

/// Returns the number of columns of 8 in a matrix stored in blocks of 8 rows. Saturates above the
/// size of any file.
const fn blocks(rows: u32, columns: u32) -> u32 {
    rows.div_ceil(8).saturating_mul(columns)
}

/// Indices of the counts in their section.
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

/// Bit for a kernel with a metric.
const METRIC: u8 = 4;
/// Bit for a kernel with a variance.
const VARIANCE: u8 = 8;

/// The sections of a kernel, in the trainer's order.
pub const KERNEL_SECTIONS: [SectionKind; RULES.len()] = Rule::sections(&RULES);

const _: () = assert!(RULES.len() <= SECTIONS && KernelCounts::BYTES <= 4 * COUNTS);

/// Rules for the sections of a kernel. Sizes: 1, I, O, I + O, d, columns of 8 of the metric and of
/// the centres, T, columns of 8 of the coefficients, words of the variance.
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
