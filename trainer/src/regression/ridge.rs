//! Kernel ridge regression on few centres, of functions that vanish at the origin (METHOD §1.9, §2.2).
//!
//! Each output of a design gets the ridge that predicts blocks of samples best when they are left out.

use super::arithmetic::U;
use super::confidence::MapConfidence;
use super::design::{Design, Hyperparameters};
use super::map::KernelMap;
use super::outputs::{Block, Outputs, power_mean};
use faer::Mat;
use sinew_runtime::format::CORRECTION_MAX;
use std::cmp::Ordering;

/// Roundings of a term of the sum in f32, each random; [`KernelMap::error`] bounds the worst case.
const TERM: f64 = 5.0;
/// Candidate ridges, relative to the largest squared singular value, ascending.
const RIDGES: [f64; 5] = [1e-11, 1e-9, 1e-7, 1e-5, 1e-3];

/// Largest squared norm of a function, over the norm that the prior expects for outputs of that magnitude.
///
/// A larger norm comes from directions that the samples hardly cover. The function would explode wherever a pose covers
/// them.
const PLAUSIBLE: f64 = 1e6;
/// Largest squared error of a map over the squared error of the base, per unit of variance times growth.
const NOISE: f64 = 4.0;
/// Largest error per unit of variance times growth that a file holds.
const LARGEST_ERROR: f64 = CORRECTION_MAX as f64;

/// Parameters of a design with the ridges of its outputs, and their scores.
#[derive(Clone, Debug)]
pub struct Scored {
    /// Parameters of the design.
    pub hyperparameters: Hyperparameters,
    /// Ridge of each output, over the largest squared singular value.
    pub ridges: Vec<f64>,
    /// Score of each output, lower is better: squared errors of the samples of a block, predicted without the block, in
    /// a power mean over the blocks.
    pub scores: Vec<f64>,
}

/// Fitted map.
pub struct KernelFit {
    /// Map of scaled inputs.
    pub map: KernelMap,
    /// Factor that scales the inputs.
    pub scale: f64,
    /// Prediction of each sample's outputs without the sample's part of a block, n x r.
    pub predicted: Mat<f64>,
}

impl Scored {
    /// Returns the score of all outputs.
    pub fn score(&self) -> f64 {
        self.scores.iter().sum()
    }
}

/// Chooses the ridge of each output among the ridges with a plausible function; `None` if rounding makes every fit
/// indefinite.
pub fn best(design: &Design<'_>, outputs: &Outputs) -> Option<Scored> {
    let projected = Projected::new(design, outputs);
    let terms = rounded_terms(design, outputs.blocks.len());
    let plausible = PLAUSIBLE / design.variance();
    let scores_of = |ridge: f64| {
        let left = projected.left_out(design, outputs, ridge)?;
        let dual = design.dual(&projected.all, |_| ridge);
        let squared_norms = design.squared_norms(&dual);
        let rounded = &terms * &dual;
        let score = |output: usize| {
            if squared_norms[output] > plausible * outputs.all.col(output).squared_norm_l2() {
                return f64::INFINITY;
            }
            let rounding = rounded.col(output).squared_norm_l2();
            power_mean(left.iter().map(|left| left.col(output).squared_norm_l2() + rounding))
        };
        Some((0..outputs.all.ncols()).map(|output| (ridge, score(output))).collect::<Vec<_>>())
    };
    let better = |(old, new): ((f64, f64), (f64, f64))| match new.1.total_cmp(&old.1) {
        Ordering::Less => new,
        _ => old,
    };
    // Ridge and score of each output. Of equal scores, the larger ridge remains.
    let mut best: Option<Vec<(f64, f64)>> = None;
    for ridge in RIDGES.into_iter().rev() {
        let Some(found) = scores_of(ridge) else { continue };
        let kept: Vec<_> = match best.take() {
            Some(old) => old.into_iter().zip(found).map(better).collect(),
            None => found,
        };
        let is_past = kept.iter().all(|kept| kept.0 > ridge);
        best = Some(kept);
        if is_past {
            break;
        }
    }
    let (ridges, scores) = best?.into_iter().unzip();
    let scored = Scored { hyperparameters: design.hyperparameters, ridges, scores };
    Some(scored).filter(|scored| scored.score().is_finite())
}

/// Fits the first outputs with a ridge each; `None` if rounding makes a fit without a block indefinite.
pub fn fit(design: &Design<'_>, outputs: &Outputs, ridges: &[f64]) -> Option<KernelFit> {
    let projected = Projected::new(design, outputs);
    let mut predicted = Mat::zeros(design.sample_len(), ridges.len());
    let mut distinct = ridges.to_vec();
    distinct.sort_by(f64::total_cmp);
    distinct.dedup();
    let mut squared = vec![0.0; outputs.blocks.len()];
    let part = |block: &Block| (block.rows(&design.directions), block.rows(&outputs.all));
    let parts: Vec<(Mat<f64>, Mat<f64>)> = outputs.parts.iter().map(part).collect();
    for ridge in distinct {
        let own: Vec<usize> = (0..ridges.len()).filter(|&o| ridges[o] == ridge).collect();
        for (sum, left) in squared.iter_mut().zip(projected.left_out(design, outputs, ridge)?) {
            *sum += own.iter().map(|&o| left.col(o).squared_norm_l2()).sum::<f64>();
        }
        for (block, (rows, truth)) in outputs.parts.iter().zip(&parts) {
            let out = design.block_out(rows, ridge)?;
            let left = out.errors(block, &out.residuals(truth, &projected.all));
            for (i, &sample) in block.own.iter().enumerate() {
                own.iter().for_each(|&o| predicted[(sample, o)] = truth[(i, o)] - left[(i, o)]);
            }
        }
    }
    let solution = design.solve(&projected.all, ridges);
    let ridge = ridges.first().copied().unwrap_or_default();
    let rows = design.variance_roots(ridge, outputs.root_limit);
    let signal = outputs.signal / design.grown_variance();
    let noise = noise(design, outputs, (&projected, &squared), ridge)?.min(NOISE * signal);
    let confidence = MapConfidence {
        len: rows.ncols(),
        signal: (signal / outputs.negligible).min(LARGEST_ERROR),
        noise: (noise / outputs.negligible).min(LARGEST_ERROR),
        ..design.confidence()
    };
    let map = design.map(&faer::concat![[&solution, &rows]], confidence);
    Some(KernelFit { map, scale: design.scale(), predicted })
}

/// Returns the squared error of extrapolated samples over their variance times growth, both from the fit without their
/// block.
///
/// The result is a geometric mean over the extrapolated blocks, or over all blocks if there is no extrapolated block.
///
/// - `squared`: squared errors of each block's predicted samples.
fn noise(
    design: &Design<'_>,
    outputs: &Outputs,
    (projected, squared): (&Projected, &[f64]),
    ridge: f64,
) -> Option<f64> {
    let count = outputs.blocks.len();
    let first = if outputs.extrapolated_len > 0 { count - outputs.extrapolated_len } else { 0 };
    let of_block = |b: usize| {
        let out = design.block_out(&projected.blocks[b], ridge)?;
        let variance = out.grown_variance(design, &outputs.blocks[b]).max(f64::MIN_POSITIVE);
        Some((squared[b] / variance).max(f64::MIN_POSITIVE).ln())
    };
    let sum = (first..count).map(of_block).sum::<Option<f64>>()?;
    Some((sum / (count - first).max(1) as f64).exp())
}

/// Outputs projected onto a design's directions.
struct Projected {
    all: Mat<f64>,
    blocks: Vec<Mat<f64>>,
}

impl Projected {
    fn new(design: &Design<'_>, outputs: &Outputs) -> Self {
        let blocks = outputs.blocks.iter().map(|block| block.rows(&design.directions)).collect();
        Self { all: design.directions.transpose() * &outputs.all, blocks }
    }

    /// Returns the errors of the samples of each block, predicted by the rest.
    fn left_out(
        &self,
        design: &Design<'_>,
        outputs: &Outputs,
        ridge: f64,
    ) -> Option<Vec<Mat<f64>>> {
        let all = design.residuals(&outputs.all, &self.all, ridge);
        let errors = |(block, rows): (&Block, &Mat<f64>)| {
            Some(design.block_out(rows, ridge)?.errors(block, &block.rows(&all)))
        };
        outputs.blocks.iter().zip(&self.blocks).map(errors).collect()
    }
}

/// Returns the error that rounding to f32 adds to each centre's term, for each of a design's directions: centres + 1 x
/// k.
///
/// - `blocks`: number of blocks; the error counts for the samples of one block.
fn rounded_terms(design: &Design<'_>, blocks: usize) -> Mat<f64> {
    let samples = design.sample_len() as f64 / blocks as f64;
    let mut terms = design.directions_at_centres();
    for (mut row, term) in terms.row_iter_mut().zip(design.terms()) {
        row *= faer::Scale(samples.sqrt() * TERM * U * term);
    }
    terms
}

#[cfg(test)]
mod tests {
    use super::super::function::SMOOTHEST_FIRST;
    use super::super::inputs::{Inputs, WIDTHS};
    use super::*;
    use sinew_runtime::envelope::GroupKernel;

    fn truth(x: f64, y: f64) -> [f64; 2] {
        [x * y + x, (2.0 * x).cos() - 1.0 - y]
    }

    /// Returns two outputs of 120 samples in eight blocks.
    fn outputs(of: impl Fn(usize, usize) -> f64) -> Outputs {
        let blocks: Vec<_> = (0..8).map(|b| Block::row(15 * b..15 * b + 15)).collect();
        Outputs {
            all: Mat::from_fn(120, 2, of),
            parts: blocks.clone(),
            blocks,
            extrapolated_len: 0,
            signal: 1.0,
            negligible: 1e-6,
            root_limit: 16,
        }
    }

    #[test]
    fn directions_that_samples_hardly_cover_get_small_coefficients() {
        // The spread falls from input to input, but each input contributes as much to the second output.
        let swing = |r: usize, i: usize| ((1 + r) as f64 * 0.37 * (i * i) as f64).sin();
        let values = Mat::from_fn(6, 120, |r, i| 0.1f64.powi(r as i32) * swing(r, i));
        let outputs = outputs(|i, o| (0..[1, 6][o]).map(|r| swing(r, i)).sum());
        let inputs = Inputs::new(values).unwrap();
        let hyperparameters =
            Hyperparameters { kernel: GroupKernel::Gaussian, width: 16.0, centres: 8 };
        let design = Design::new(&inputs, hyperparameters).unwrap();
        let scored = best(&design, &outputs).unwrap();
        let KernelFit { map, scale, .. } = fit(&design, &outputs, &scored.ridges).unwrap();
        let along = |r: usize| -> Vec<f64> {
            let input: [f64; 6] = std::array::from_fn(|k| if k == r { 0.5 * scale } else { 0.0 });
            map.evaluate(&input).outputs
        };
        assert!((along(0)[0] - 0.5).abs() < 0.01);
        // The ridge that predicts left-out blocks best would give some thousands.
        assert!(along(5)[1].abs() < 50.0, "{:?}", along(5));
    }

    #[test]
    fn a_smooth_function_is_learned_by_every_kernel_and_is_zero_at_zero() {
        let values =
            Mat::from_fn(2, 120, |r, i| [(0.37 * i as f64).sin(), (0.61 * i as f64).cos()][r]);
        let outputs = outputs(|i, o| truth(values[(0, i)], values[(1, i)])[o]);
        let blocks = outputs.blocks.clone();
        let inputs = Inputs::new(values).unwrap();
        for kernel in SMOOTHEST_FIRST {
            let designs = WIDTHS.into_iter().flat_map(|w| Design::each(&inputs, kernel, w, &[120]));
            let scored = designs.filter_map(|design| Some((best(&design, &outputs)?, design)));
            let (scored, design) =
                scored.min_by(|a, b| a.0.score().total_cmp(&b.0.score())).unwrap();
            let KernelFit { map, scale, predicted } =
                fit(&design, &outputs, &scored.ridges).unwrap();
            let at = |x: f64, y: f64| map.evaluate(&[scale * x, scale * y]);
            assert_eq!(at(0.0, 0.0).outputs, [0.0, 0.0]);
            let most = if kernel == GroupKernel::Matern12 { 0.1 } else { 0.02 };
            for (x, y) in [(0.3, -0.2), (-0.5, 0.4), (0.1, 0.8)] {
                assert!(at(x, y).expected_error.map_weight() > 0.99);
                for (a, b) in at(x, y).outputs.iter().zip(truth(x, y)) {
                    assert!((a - b).abs() < most, "{kernel:?} {a} {b}");
                }
            }
            let left = predicted - &outputs.all;
            let of = |o: usize| {
                let own = |b: &Block| b.own.iter().map(|&i| left[(i, o)].powi(2)).sum::<f64>();
                power_mean(blocks.iter().map(own))
            };
            assert!(of(0) + of(1) <= scored.score() && scored.score() < 1e-2);
        }
    }
}
