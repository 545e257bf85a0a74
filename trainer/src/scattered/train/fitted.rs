//! What every way of fitting gives.

use super::report::Report;
use crate::scattered::model::Figures;
use crate::scattered::solver::variance::Variance;
use crate::scattered::sum::KernelSum;

/// A function without its names.
pub(super) struct Fitted {
    pub(super) sum: KernelSum,
    pub(super) variance: Option<Variance>,
    pub(super) figures: Figures,
    pub(super) report: Report,
    /// Whether kernels do not reach the next sample.
    pub(super) is_narrow: bool,
    pub(super) warnings: Vec<String>,
}
