//! S1's appendix 2: a network from parameters to pixels, which it says cannot work. It shows what points and
//! warping are for.

use super::set::{Parameter, View};
use crate::scattered::solver::error::KernelError;
use crate::scattered::solver::fit::Fit;
use crate::scattered::solver::options::Options;
use crate::scattered::solver::samples::Samples;
use crate::scattered::solver::scaling::Block;
use faer::Mat;
use sinew_runtime::kernel::Kernel;

/// One over the widths of gaussians, in mean distances of the views.
const EPSILONS: [f64; 5] = [0.75, 1.0, 1.5, 2.0, 4.0];

/// A network of pixels by what it is made of: a kernel and one over its width.
pub const NETWORKS: [(Kernel, f64); 7] = [
    (Kernel::Linear, 1.0),
    (Kernel::Multiquadric, 1.0),
    (Kernel::Gaussian, EPSILONS[0]),
    (Kernel::Gaussian, EPSILONS[1]),
    (Kernel::Gaussian, EPSILONS[2]),
    (Kernel::Gaussian, EPSILONS[3]),
    (Kernel::Gaussian, EPSILONS[4]),
];

/// Returns how much of each view's picture a network over the parameters shows at others: a network is
/// linear in the pictures, so that its weights are all of it.
///
/// # Errors
/// [`KernelError`] of the fit.
pub fn weights(
    (kernel, epsilon): (Kernel, f64),
    parameters: &[Parameter],
    views: &[&View],
    at: &View,
) -> Result<Vec<f64>, KernelError> {
    let names: Vec<&str> = parameters.iter().flat_map(Parameter::names).collect();
    let value = |view: &View, c: usize| view.values.get(names[c]).copied().unwrap_or_default();
    let sites = Mat::from_fn(views.len(), names.len(), |i, c| value(views[i], c));
    let blocks = vec![Block { len: 1, weight: 1.0 }; names.len()];
    let samples = Samples::of_weights(&sites, &blocks)?;
    let fit = Fit::new(&samples, &Options { epsilon, ..Options::new(kernel) })?;
    Ok(fit.sum.evaluate(&(0..names.len()).map(|c| value(at, c)).collect::<Vec<_>>()))
}

/// Mixes pictures by their weights: numbers of equal length.
pub fn mixed(weights: &[f64], pictures: &[&[f64]]) -> Vec<f64> {
    let mut out = vec![0.0; pictures.first().map_or(0, |first| first.len())];
    for (weight, picture) in weights.iter().zip(pictures) {
        out.iter_mut().zip(*picture).for_each(|(out, x)| *out += weight * x);
    }
    out
}
