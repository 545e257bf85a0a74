//! What a block of outputs may be fitted with.

use super::terms::TermSet;
use crate::regression::function::{by_name, order};
use serde::Serialize;
use sinew_runtime::kernel::Kernel;

/// One over the widths that are tried, in mean distances of the views.
const EPSILONS: [f64; 10] = [0.125, 0.177, 0.25, 0.354, 0.5, 0.707, 1.0, 1.414, 2.0, 4.0];
/// Kernels without a width.
const PLAIN: [Kernel; 3] = [Kernel::Linear, Kernel::ThinPlate, Kernel::Cubic];

/// A polynomial with or without kernels, and how it does.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Candidate {
    /// The polynomial.
    pub polynomial: &'static str,
    /// The kernels beside it, and one over their width.
    pub kernel: Option<Width>,
    /// RMS error of numbers of views that are left out; none where the others do not determine a fit.
    pub left_out: Option<f64>,
}

/// A kernel of a width.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Width {
    /// G.
    #[serde(serialize_with = "by_name")]
    pub kernel: Kernel,
    /// What distances are multiplied by, of which the mean one is 1.
    pub epsilon: f64,
}

impl Width {
    /// What serves where nothing can be chosen: lines from view to view.
    pub(super) const PLAIN: Self = Self { kernel: Kernel::Linear, epsilon: 1.0 };

    /// Lists all that may stand beside a polynomial.
    pub(super) fn all(set: &TermSet) -> Vec<Self> {
        let reached = |kernel: &Kernel| set.is_whole || order(*kernel).is_some_and(|o| o <= 1);
        let plain = PLAIN.into_iter().filter(reached).map(|kernel| Self { kernel, epsilon: 1.0 });
        let of = |epsilon| Self { kernel: Kernel::Gaussian, epsilon };
        plain.chain(EPSILONS.map(of)).collect()
    }
}
