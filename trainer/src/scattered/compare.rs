//! All kernels through the same samples.

use super::solver::fit::Fit;
use super::solver::options::Options;
use super::solver::samples::{Conflicts, Samples};
use super::solver::scaling::Block;
use crate::regression::function::order;
use faer::Mat;
use sinew_runtime::kernel::Kernel;

/// Fits every kernel to samples of one value, each with a width of their mean distance, and evaluates it
/// at points; a kernel that they are too few for is left out.
pub fn all_kernels(
    sites: &[Vec<f64>],
    values: &[f64],
    points: &[Vec<f64>],
) -> Vec<(String, Vec<f64>)> {
    let d = sites.first().map_or(0, Vec::len);
    let places = Mat::from_fn(sites.len(), d, |i, c| sites[i][c]);
    let values = Mat::from_fn(values.len(), 1, |i, _| values[i]);
    let blocks = vec![Block { len: 1, weight: 1.0 }; d];
    let Ok(samples) = Samples::new(&places, &values, &blocks, Conflicts::Average) else {
        return Vec::new();
    };
    let solvable = Kernel::ALL.into_iter().filter(|kernel| order(*kernel).is_some());
    let fitted = solvable.filter_map(|kernel| {
        let fit = Fit::new(&samples, &Options::new(kernel)).ok()?;
        let at = |point: &Vec<f64>| fit.sum.evaluate(point)[0];
        Some((kernel.name().to_owned(), points.iter().map(at).collect()))
    });
    fitted.collect()
}
