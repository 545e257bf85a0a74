//! Kernel ridge regression on few centres, of functions that vanish at the origin; everything is
//! chosen by blocks of samples left out in closed form (METHOD §1.9, §2.2).
//!
//! `f(x) = Σ_k c_k (G(|x - t_k|²/w) - G(|t_k|²/w)) + A x`: the ridge acts on the coefficients of
//! orthonormal functions, so with every sample a centre this is kernel ridge regression with the
//! kernel G + 0.2 x·x'/m, m the median squared distance of the samples, conditioned on f(0) = 0.
//! The linear part is penalised too: an unpenalised tail of many inputs overfits.

use super::arithmetic::U;
use super::centres::Greedy;
use super::function::{Exact, by_name};
use super::map::{Fade, KernelMap};
use faer::linalg::solvers::{Solve, Svd};
use faer::{ColRef, Mat, MatRef, Side};
use serde::Serialize;
use sinew_runtime::kernel::Kernel;
use std::ops::Range;

/// Share of the linear kernel beside G; m is the median squared distance of the samples.
const LINEAR: f64 = 0.2;
/// Where a fade ends, in squared distances of its start.
const FADE: f64 = 6.25;
/// Power of the mean over blocks. Near 0 it is the geometric mean, in which every block counts by
/// how much its error grows or shrinks: in a sum of squares the block that is hardest to foresee
/// would decide alone.
const GENTLE: f64 = 0.1;
/// Candidate squared widths, in median squared distances.
pub const WIDTHS: [f64; 5] = [1.0, 4.0, 16.0, 64.0, 256.0];
/// Roundings of a term of the sum in f32, each at random; `kernel::map` has the bound for the worst.
const TERM: f64 = 5.0;
/// Candidate ridges, relative to the largest squared singular value.
const RIDGES: [f64; 13] =
    [1e-11, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0, 10.0];

/// What a map is fitted with.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Choice {
    /// G.
    #[serde(serialize_with = "by_name")]
    pub kernel: Kernel,
    /// Squared width over the median squared distance.
    pub width: f64,
    /// Centres beside the origin.
    pub centres: usize,
}

/// A choice and its score.
#[derive(Clone, Debug)]
pub struct Trial {
    /// The choice.
    pub choice: Choice,
    /// Ridge of each output, over the largest squared singular value.
    pub ridges: Vec<f64>,
    /// Score of each output, the lower the better: squared error of the samples of a block,
    /// predicted without it, in a mean over the blocks.
    pub scores: Vec<f64>,
}

impl Trial {
    /// The same with ridges ten times as large.
    pub fn smoother(mut self) -> Self {
        self.ridges.iter_mut().for_each(|ridge| *ridge *= 10.0);
        self
    }

    /// Score of all outputs.
    pub fn score(&self) -> f64 {
        self.scores.iter().sum()
    }
}

/// n samples of a function of d inputs that is zero at zero.
pub struct Samples<'a> {
    inputs: Mat<f64>,
    outputs: &'a Outputs,
    /// Squared distances of the origin and the samples, n + 1 x n + 1.
    squared: Mat<f64>,
    median: f64,
}

/// What the samples are to give.
pub struct Outputs {
    /// n x r.
    pub all: Mat<f64>,
    /// Contiguous blocks of samples that cover all, the last ones perhaps again.
    pub blocks: Vec<Range<usize>>,
    /// The outputs as a fit without each block is to see them, where they depend on that.
    pub without: Vec<Mat<f64>>,
}

impl Outputs {
    fn without(&self, block: usize) -> &Mat<f64> {
        self.without.get(block).unwrap_or(&self.all)
    }

    /// Scores of predicting nothing: each output's size, over the samples as their own blocks see
    /// them.
    pub fn sizes(&self) -> Vec<f64> {
        let size = |o: usize| {
            let own = self.blocks.iter().enumerate().map(|(b, block)| {
                self.without(b).col(o).subrows(block.start, block.len()).squared_norm_l2()
            });
            gentle_mean(own)
        };
        (0..self.all.ncols()).map(size).collect()
    }
}

/// A fitted map.
pub struct Fitted {
    /// The map, of scaled inputs.
    pub map: KernelMap,
    /// What the inputs are to be multiplied by.
    pub scale: f64,
    /// What each sample's outputs are predicted to be without its block, n x r.
    pub predicted: Mat<f64>,
}

impl<'a> Samples<'a> {
    /// Takes inputs d x n; none where they are all alike.
    pub fn new(inputs: Mat<f64>, outputs: &'a Outputs) -> Option<Self> {
        let n = inputs.ncols();
        let with_origin = faer::concat![[Mat::<f64>::zeros(inputs.nrows(), 1), &inputs]];
        let products = with_origin.transpose() * &with_origin;
        let squared = Mat::from_fn(n + 1, n + 1, |i, j| {
            (products[(i, i)] + products[(j, j)] - 2.0 * products[(i, j)]).max(0.0)
        });
        let between = (1..=n).flat_map(|i| (1..i).map(move |j| (i, j)));
        let mut distances: Vec<f64> =
            between.map(|(i, j)| squared[(i, j)]).filter(|&d| d > 0.0).collect();
        if distances.is_empty() {
            return None;
        }
        let middle = distances.len() / 2;
        let median = *distances.select_nth_unstable_by(middle, f64::total_cmp).1;
        Some(Self { inputs, outputs, squared, median })
    }

    /// Returns n.
    pub fn len(&self) -> usize {
        self.inputs.ncols()
    }

    /// Returns whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns d.
    pub fn input_len(&self) -> usize {
        self.inputs.nrows()
    }

    /// Returns the inputs multiplied by a factor, d x n.
    pub fn scaled(&self, factor: f64) -> Mat<f64> {
        &self.inputs * faer::Scale(factor)
    }

    /// Tries some numbers of centres, each with its best ridge; none for a number whose system
    /// rounding makes indefinite.
    pub fn attempt(&self, kernel: Kernel, width: f64, counts: &[usize]) -> Vec<Trial> {
        let most = counts.iter().copied().max().unwrap_or(0);
        let greedy = self.greedy(kernel, width, most);
        let mut counts: Vec<_> =
            counts.iter().map(|&count| count.min(greedy.order.len())).collect();
        counts.dedup();
        let best = |centres: usize| {
            let system = self.system(&greedy, centres)?;
            let choice = Choice { kernel, width, centres };
            let terms = self.terms(&choice, &greedy);
            let folded: Vec<Folded> = RIDGES
                .into_iter()
                .filter_map(|ridge| {
                    let left = self.left_out(&system, ridge)?;
                    let size =
                        |left: &Mat<f64>| left.col_iter().map(|c| c.squared_norm_l2()).collect();
                    let rounding = self.rounding(&system, &greedy, &terms, ridge);
                    Some(Folded { ridge, errors: left.iter().map(size).collect(), rounding })
                })
                .collect();
            let outputs = 0..self.outputs.all.ncols();
            let best: Vec<(f64, f64)> = outputs.filter_map(|o| least(&folded, o)).collect();
            let (ridges, scores) = best.into_iter().unzip();
            let trial = Trial { choice, ridges, scores };
            Some(trial).filter(|trial| trial.score().is_finite())
        };
        counts.into_iter().filter_map(best).collect()
    }

    /// Fits the first `rank` outputs.
    pub fn fit(&self, trial: &Trial, rank: usize) -> Option<Fitted> {
        let choice = &trial.choice;
        let greedy = self.greedy(choice.kernel, choice.width, choice.centres);
        let system = self.system(&greedy, choice.centres)?;
        let mut predicted = Mat::zeros(self.inputs.ncols(), rank);
        let mut ridges = trial.ridges[..rank].to_vec();
        ridges.sort_by(f64::total_cmp);
        ridges.dedup();
        for ridge in ridges {
            let left = self.left_out(&system, ridge)?;
            for (b, block) in self.outputs.blocks.iter().enumerate().rev() {
                let truth = self.outputs.without(b);
                for o in (0..rank).filter(|&o| trial.ridges[o] == ridge) {
                    for i in block.clone() {
                        predicted[(i, o)] = truth[(i, o)] - left[b][(i - block.start, o)];
                    }
                }
            }
        }

        let solution = self.solution(&system, &trial.ridges[..rank]);
        let (functions, linear) = solution.split_at_row(choice.centres);
        let width = choice.width * self.median;
        let centres = greedy.at_centres(&functions.to_owned());
        let linear = linear * faer::Scale((LINEAR / self.median * width).sqrt());
        let map = KernelMap {
            kernel: choice.kernel,
            centres: Mat::from_fn(self.input_len(), choice.centres + 1, |r, k| {
                if k == 0 { 0.0 } else { self.inputs[(r, greedy.order[k - 1])] / width.sqrt() }
            }),
            coefficients: faer::concat![[centres.transpose(), linear.transpose()]],
            fade: self.fade(&greedy, choice),
        };
        Some(Fitted { map, scale: 1.0 / width.sqrt(), predicted })
    }

    /// Fades beyond what the choice was validated on: the farthest that a sample is from the
    /// centres outside its block.
    fn fade(&self, greedy: &Greedy, choice: &Choice) -> Fade {
        let centres = &greedy.order[..choice.centres];
        let mut farthest = f64::MIN_POSITIVE;
        for block in &self.outputs.blocks {
            let others = || centres.iter().filter(|k| !block.contains(k)).map(|k| k + 1);
            for i in block.clone() {
                let near = others().chain([0]).map(|k| self.squared[(i + 1, k)]);
                farthest = near.fold(f64::INFINITY, f64::min).max(farthest);
            }
        }
        let start = farthest / (choice.width * self.median);
        Fade { start, end: FADE * start }
    }

    fn greedy(&self, kernel: Kernel, width: f64, most: usize) -> Greedy {
        let scale = 1.0 / (width * self.median);
        Greedy::new(kernel, self.inputs.ncols(), most, |i, j| scale * self.squared[(i, j)])
    }

    fn system(&self, greedy: &Greedy, centres: usize) -> Option<System> {
        let scaled = self.inputs.transpose() * faer::Scale((LINEAR / self.median).sqrt());
        let design = faer::concat![[greedy.functions(centres), scaled]].thin_svd().ok()?;
        let onto = |outputs: &Mat<f64>| design.U().transpose() * outputs;
        let (all, without) = (onto(&self.outputs.all), self.outputs.without.iter().map(onto));
        let without = without.collect();
        let largest = design.S().column_vector().iter().next().map_or(0.0, |s| s * s);
        Some(System { largest, onto: all, without, design })
    }

    /// What rounding to f32 adds to each output's score, given the size of each centre's term.
    fn rounding(&self, system: &System, greedy: &Greedy, terms: &[f64], ridge: f64) -> Vec<f64> {
        let functions = self.solution(system, &vec![ridge; self.outputs.all.ncols()]);
        let coefficients = greedy.at_centres(&functions.subrows(0, terms.len() - 1).to_owned());
        let samples = self.len() as f64 / self.outputs.blocks.len() as f64;
        let square = |c: ColRef<'_, f64>| {
            let own = c.iter().zip(terms).map(|(c, term)| (c * term).powi(2));
            (TERM * U).powi(2) * own.sum::<f64>()
        };
        coefficients.col_iter().map(|c| samples * square(c)).collect()
    }

    /// RMS size of what is rounded in the kernel of each centre, the origin first: the value itself,
    /// or, for a gaussian, its change from rest.
    fn terms(&self, choice: &Choice, greedy: &Greedy) -> Vec<f64> {
        let scale = 1.0 / (choice.width * self.median);
        let of = |centre: usize| {
            let size = |i: usize| {
                let [here, rest, own] =
                    [(centre, i), (centre, 0), (0, i)].map(|at| scale * self.squared[at]);
                let twice = (2.0 * here + 2.0 * rest - own).max(0.0);
                let steepest = choice.kernel.exact(here.min(rest));
                (steepest * (own * twice).sqrt()).powi(2)
            };
            match choice.kernel {
                Kernel::Gaussian => {
                    ((1..=self.len()).map(size).sum::<f64>() / self.len() as f64).sqrt()
                }
                _ => 1.0,
            }
        };
        let centres = greedy.order[..choice.centres].iter().map(|k| k + 1);
        std::iter::once(0).chain(centres).map(of).collect()
    }

    /// Coefficients of the orthonormal functions, then of the scaled inputs, for the first outputs
    /// with a ridge each.
    fn solution(&self, system: &System, ridges: &[f64]) -> Mat<f64> {
        let s = system.design.S().column_vector();
        let shrunk = Mat::from_fn(system.onto.nrows(), ridges.len(), |k, o| {
            system.onto[(k, o)] * s[k] / (s[k] * s[k] + ridges[o] * system.largest)
        });
        system.design.V() * shrunk
    }

    /// Errors of the samples of each block, predicted by the rest: `e_I = (I - H_II)⁻¹ r_I`.
    fn left_out(&self, system: &System, ridge: f64) -> Option<Vec<Mat<f64>>> {
        let s = system.design.S().column_vector();
        let u = system.design.U();
        let shrink: Vec<f64> = s.iter().map(|s| s * s / (s * s + ridge * system.largest)).collect();
        let left = |(b, block): (usize, &Range<usize>)| {
            let rows = |m: MatRef<'_, f64>| m.subrows(block.start, block.len()).to_owned();
            let onto = system.without.get(b).unwrap_or(&system.onto);
            let u = rows(u);
            let own = Mat::from_fn(u.nrows(), u.ncols(), |i, k| u[(i, k)] * shrink[k]);
            let residual = rows(self.outputs.without(b).as_ref()) - &own * onto;
            let hat = own * u.transpose();
            let remainder = Mat::from_fn(block.len(), block.len(), |i, j| {
                f64::from(u8::from(i == j)) - hat[(i, j)]
            });
            Some(remainder.llt(Side::Lower).ok()?.solve(residual))
        };
        self.outputs.blocks.iter().enumerate().map(left).collect()
    }
}

/// The samples' functions and scaled inputs, decomposed, and the outputs on their directions.
struct System {
    design: Svd<f64>,
    /// The largest squared singular value.
    largest: f64,
    onto: Mat<f64>,
    /// The same of the outputs as each block sees them.
    without: Vec<Mat<f64>>,
}

/// Squared errors of each block and output at one ridge.
struct Folded {
    ridge: f64,
    errors: Vec<Vec<f64>>,
    rounding: Vec<f64>,
}

/// The ridge that scores best for an output, and its score.
fn least(folded: &[Folded], output: usize) -> Option<(f64, f64)> {
    let score = |f: &Folded| {
        let of = f.errors.iter().map(|errors| errors[output] + f.rounding[output]);
        (f.ridge, gentle_mean(of))
    };
    folded.iter().map(score).min_by(|a, b| a.1.total_cmp(&b.1))
}

/// The power mean of squared errors.
fn gentle_mean(errors: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = errors.fold((0, 0.0), |(n, sum), e| (n + 1, sum + e.powf(GENTLE)));
    (sum / f64::from(count.max(1))).powf(1.0 / GENTLE)
}

#[cfg(test)]
mod tests {
    use super::super::function::SMOOTHEST_FIRST;
    use super::*;

    fn truth(x: f64, y: f64) -> [f64; 2] {
        [x * y + x, (2.0 * x).cos() - 1.0 - y]
    }

    fn samples(n: usize) -> (Mat<f64>, Mat<f64>) {
        let inputs =
            Mat::from_fn(2, n, |r, i| [(0.37 * i as f64).sin(), (0.61 * i as f64).cos()][r]);
        let outputs = Mat::from_fn(n, 2, |i, o| truth(inputs[(0, i)], inputs[(1, i)])[o]);
        (inputs, outputs)
    }

    fn outputs(all: Mat<f64>, blocks: &[Range<usize>]) -> Outputs {
        Outputs { all, blocks: blocks.to_vec(), without: Vec::new() }
    }

    #[test]
    fn blocks_left_out_in_closed_form_equal_fits_without_them() {
        let (inputs, all) = samples(20);
        let blocks = [0..7, 7..12, 12..20];
        let outputs = outputs(all, &blocks);
        let samples = Samples::new(inputs, &outputs).unwrap();
        let greedy = samples.greedy(Kernel::Gaussian, 4.0, 6);
        let system = samples.system(&greedy, 6).unwrap();
        let found = faer::Mat::from_fn(20, 2, {
            let left = samples.left_out(&system, 1e-3).unwrap();
            let blocks = blocks.clone();
            move |i, o| {
                let b = blocks.iter().position(|block| block.contains(&i)).unwrap();
                left[b][(i - blocks[b].start, o)]
            }
        });
        let scaled = samples.inputs.transpose() * faer::Scale((LINEAR / samples.median).sqrt());
        let design = faer::concat![[greedy.functions(6), scaled]];
        let ridge = 1e-3 * system.largest;
        for block in &blocks {
            let kept: Vec<usize> = (0..20).filter(|i| !block.contains(i)).collect();
            let a = Mat::from_fn(kept.len(), design.ncols(), |r, c| design[(kept[r], c)]);
            let y = Mat::from_fn(kept.len(), 2, |r, c| outputs.all[(kept[r], c)]);
            let mut normal = a.transpose() * &a;
            (0..normal.nrows()).for_each(|i| normal[(i, i)] += ridge);
            let solution = normal.llt(Side::Lower).unwrap().solve(a.transpose() * y);
            let predicted = &design * solution;
            for i in block.clone() {
                for o in 0..2 {
                    let expected = outputs.all[(i, o)] - predicted[(i, o)];
                    assert!((found[(i, o)] - expected).abs() < 1e-9 * (1.0 + expected.abs()));
                }
            }
        }
    }

    #[test]
    fn a_smooth_function_is_learned_by_every_kernel_and_is_zero_at_zero() {
        let (inputs, all) = samples(120);
        let blocks: Vec<_> = (0..8).map(|b| 15 * b..15 * b + 15).collect();
        let outputs = outputs(all, &blocks);
        let samples = Samples::new(inputs, &outputs).unwrap();
        for kernel in SMOOTHEST_FIRST {
            let trials = WIDTHS.into_iter().flat_map(|w| samples.attempt(kernel, w, &[120]));
            let best = trials.min_by(|a, b| a.score().total_cmp(&b.score())).unwrap();
            let Fitted { map, scale, predicted } = samples.fit(&best, 2).unwrap();
            let at = |x: f64, y: f64| map.evaluate(&[scale * x, scale * y]);
            assert_eq!(at(0.0, 0.0).outputs, [0.0, 0.0]);
            let most = if kernel == Kernel::Matern12 { 0.1 } else { 0.02 };
            for (x, y) in [(0.3, -0.2), (-0.5, 0.4), (0.1, 0.8)] {
                assert!(at(x, y).confidence == 1.0);
                for (a, b) in at(x, y).outputs.iter().zip(truth(x, y)) {
                    assert!((a - b).abs() < most, "{kernel:?} {a} {b}");
                }
            }
            let left = predicted - &outputs.all;
            let of = |o: usize| {
                let own =
                    |b: &Range<usize>| left.col(o).subrows(b.start, b.len()).squared_norm_l2();
                gentle_mean(blocks.iter().map(own))
            };
            assert!(of(0) + of(1) <= best.score() && best.score() < 1e-2);
        }
    }

    #[test]
    fn samples_that_are_all_alike_have_no_map() {
        let blocks = [0..5, 5..10];
        let outputs = outputs(Mat::zeros(10, 1), &blocks);
        assert!(Samples::new(Mat::from_fn(2, 10, |r, _| r as f64), &outputs).is_none());
    }
}
