//! How well the training poses predict each other: kernel ridge regression of what LBS leaves, each
//! joint's skin from the joints near it, in Gram matrices over the poses (METHOD §1.9, §2.2).

use super::context::Context;
use crate::envelope::correction::features::Features;
use crate::envelope::skin::folds::folds;
use crate::examples::spread;
use faer::linalg::solvers::DenseSolveCore;
use faer::{Mat, Side};
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;
use std::ops::Range;

/// Most poses that are compared: the work grows with their cube.
const POSES: usize = 300;
/// Poses on which width and ridge are chosen.
const TRIED: usize = 100;
/// Vertices that are looked at; more tell no more of the poses.
const VERTICES: usize = 4000;
/// Hops of the joints that a joint's skin listens to, as the kernel maps choose most often.
pub(super) const HOPS: usize = 2;
/// Candidate squared widths, in median squared distances of the poses.
const WIDTHS: [f64; 3] = [4.0, 16.0, 64.0];
/// Candidate ridges, as shares of the kernel's mean diagonal.
const RIDGES: [f64; 3] = [1e-5, 1e-4, 1e-3];
/// Share of the linear kernel, as in `kernel::ridge`.
const LINEAR: f64 = 0.2;

/// What LBS leaves of one joint's skin, as a function of the poses.
pub(super) struct Region {
    pub(super) joint: usize,
    /// Inner products of what LBS leaves in the compared poses, n x n, summed over the vertices.
    pub(super) gram: Mat<f64>,
    /// The kernel of the poses, zero at rest, n x n.
    pub(super) kernel: Mat<f64>,
    pub(super) ridge: f64,
}

/// Squared errors of each pose, summed over the vertices, predicted by the others.
pub(super) struct Errors {
    /// Without the pose alone.
    pub(super) alone: Vec<f64>,
    /// Without its contiguous block of poses.
    pub(super) block: Vec<f64>,
}

/// Chooses the training poses that are compared, by their number among the training frames.
pub(super) fn compared(context: &Context<'_>) -> Vec<usize> {
    spread(context.frames.len(), POSES)
}

/// Makes the regions of all joints with skin that moves.
pub(super) fn regions(context: &Context<'_>, poses: &[usize]) -> Vec<Region> {
    let stride = context.dominant.len().div_ceil(VERTICES);
    let skins = context.skins();
    let own = |joint: usize| {
        let skin: Vec<usize> = skins[joint].iter().copied().step_by(stride).collect();
        Region::new(context, joint, &skin, poses)
    };
    (0..skins.len()).into_par_iter().filter_map(own).collect()
}

impl Region {
    fn new(context: &Context<'_>, joint: usize, skin: &[usize], poses: &[usize]) -> Option<Self> {
        let (training, features) = (&context.training, Features::of(&context.training));
        let inputs = features.inputs(&training.poses, joint, HOPS);
        let all = features.evaluate(&training.poses, &inputs);
        let inputs = Mat::from_fn(all.nrows(), poses.len(), |r, i| all[(r, poses[i])]);
        let squared = Squared::new(&inputs)?;
        let gram = gram(context, joint, skin, poses);
        let kernels = WIDTHS.map(|width| squared.kernel(width));
        let some = spread(poses.len(), TRIED);
        let pick =
            |m: &Mat<f64>| Mat::from_fn(some.len(), some.len(), |i, j| m[(some[i], some[j])]);
        let (gram_there, blocks) = (pick(&gram), folds(some.len()));
        let (mut best, mut least) = (None, f64::INFINITY);
        for (width, kernel) in kernels.iter().enumerate() {
            let kernel = pick(kernel);
            let mean = kernel.diagonal().column_vector().sum() / some.len() as f64;
            for ridge in RIDGES.map(|ridge| ridge * mean) {
                let Some(left) = Errors::new(&kernel, &gram_there, ridge, &blocks) else {
                    continue;
                };
                let sum = left.block.iter().sum();
                if sum < least {
                    (best, least) = (Some((width, ridge)), sum);
                }
            }
        }
        let (width, ridge) = best?;
        let kernel = kernels.into_iter().nth(width)?;
        Some(Self { joint, gram, kernel, ridge })
    }

    /// Foretells every compared pose by the others.
    pub(super) fn errors(&self) -> Option<Errors> {
        Errors::new(&self.kernel, &self.gram, self.ridge, &folds(self.gram.nrows()))
    }

    /// Takes what one pose predicts from the others: the regression's own update, kernel and
    /// residuals conditioned on the pose.
    pub(super) fn learn(&mut self, pose: usize) {
        let n = self.gram.nrows();
        let scale = 1.0 / (self.kernel[(pose, pose)].max(0.0) + self.ridge);
        let row = |m: &Mat<f64>| (0..n).map(|i| m[(pose, i)]).collect::<Vec<f64>>();
        let (kernel, gram) = (row(&self.kernel), row(&self.gram));
        let share: Vec<f64> = kernel.iter().map(|k| k * scale).collect();
        for j in 0..n {
            let column = self.kernel.col_as_slice_mut(j);
            column.iter_mut().zip(&share).for_each(|(k, s)| *k -= s * kernel[j]);
            let column = self.gram.col_as_slice_mut(j);
            let by = share[j] * gram[pose] - gram[j];
            column.iter_mut().zip(&share).zip(&gram).for_each(|((g, s), own)| {
                *g += s * by - share[j] * own;
            });
        }
    }
}

impl Errors {
    /// With A = K + λI and S = A⁻¹ G A⁻¹, the poses of a block I are missed by
    /// `B⁻¹ S_II B⁻¹`, B = (A⁻¹)_II; a single pose is a block of one.
    fn new(
        kernel: &Mat<f64>,
        gram: &Mat<f64>,
        ridge: f64,
        blocks: &[Range<usize>],
    ) -> Option<Self> {
        let n = kernel.nrows();
        let mut ridged = kernel.clone();
        (0..n).for_each(|i| ridged[(i, i)] += ridge);
        let inverse = ridged.llt(Side::Lower).ok()?.inverse();
        let half = gram * &inverse;
        let missed =
            |i: usize, j: usize| -> f64 { (0..n).map(|k| inverse[(k, i)] * half[(k, j)]).sum() };
        let alone = (0..n).map(|i| missed(i, i) / inverse[(i, i)].powi(2)).collect();
        let mut block = Vec::with_capacity(n);
        for range in blocks {
            let own =
                inverse.submatrix(range.start, range.start, range.len(), range.len()).to_owned();
            let own = own.llt(Side::Lower).ok()?.inverse();
            let inner = Mat::from_fn(range.len(), range.len(), |i, j| {
                missed(range.start + i, range.start + j)
            });
            let left = &own * inner * &own;
            block.extend((0..range.len()).map(|i| left[(i, i)]));
        }
        Some(Self { alone, block })
    }
}

/// Squared distances of poses and of rest.
struct Squared {
    products: Mat<f64>,
    median: f64,
}

impl Squared {
    /// Takes inputs d x n, zero at rest; none where they are all alike.
    fn new(inputs: &Mat<f64>) -> Option<Self> {
        let mut squared = Self { products: inputs.transpose() * inputs, median: 0.0 };
        let n = inputs.ncols();
        let pairs = (0..n).flat_map(|i| (0..i).map(move |j| (i, j)));
        let mut distances: Vec<f64> =
            pairs.map(|(i, j)| squared.between(i, j)).filter(|&d| d > 0.0).collect();
        let middle = distances.len() / 2;
        if distances.is_empty() {
            return None;
        }
        squared.median = *distances.select_nth_unstable_by(middle, f64::total_cmp).1;
        Some(squared)
    }

    fn between(&self, i: usize, j: usize) -> f64 {
        let p = &self.products;
        (p[(i, i)] + p[(j, j)] - 2.0 * p[(i, j)]).max(0.0)
    }

    /// Gaussian and linear kernel, conditioned to be zero at rest.
    fn kernel(&self, width: f64) -> Mat<f64> {
        let scale = 1.0 / (width * self.median);
        let n = self.products.nrows();
        let rest: Vec<f64> = (0..n).map(|i| (-scale * self.products[(i, i)]).exp()).collect();
        Mat::from_fn(n, n, |i, j| {
            (-scale * self.between(i, j)).exp() - rest[i] * rest[j]
                + LINEAR / self.median * self.products[(i, j)]
        })
    }
}

/// Inner products of what LBS leaves, in the joint's own frame.
fn gram(context: &Context<'_>, joint: usize, skin: &[usize], poses: &[usize]) -> Mat<f64> {
    let mut left = Mat::zeros(3 * skin.len(), poses.len());
    for (i, &pose) in poses.iter().enumerate() {
        let turn: Matrix3<f64> =
            context.training.poses.map(pose, joint).fixed_columns::<3>(0).transpose();
        for (k, &vertex) in skin.iter().enumerate() {
            let column = context.residuals.col_as_slice(vertex);
            let own = turn * Vector3::from_column_slice(&column[3 * pose..3 * pose + 3]);
            (0..3).for_each(|axis| left[(3 * k + axis, i)] = own[axis]);
        }
    }
    left.transpose() * &left
}

#[cfg(test)]
mod tests {
    use super::*;

    const N: usize = 12;
    const RIDGE: f64 = 1e-2;

    /// A region of poses on a spiral, with outputs n x 2.
    fn region() -> (Region, Mat<f64>) {
        let inputs = Mat::from_fn(2, N, |r, i| {
            let t = 0.4 * i as f64;
            t * [t.cos(), t.sin()][r]
        });
        let outputs = Mat::from_fn(N, 2, |i, o| [inputs[(0, i)].sin(), inputs[(1, i)] * 0.3][o]);
        let kernel = Squared::new(&inputs).unwrap().kernel(4.0);
        let gram = &outputs * outputs.transpose();
        (Region { joint: 0, gram, kernel, ridge: RIDGE }, outputs)
    }

    /// Squared error of a pose predicted by some others, by solving for them.
    fn missed(kernel: &Mat<f64>, outputs: &Mat<f64>, pose: usize, by: &[usize]) -> f64 {
        let among = Mat::from_fn(by.len(), by.len(), |i, j| {
            kernel[(by[i], by[j])] + if i == j { RIDGE } else { 0.0 }
        });
        let truth = Mat::from_fn(by.len(), 2, |i, o| outputs[(by[i], o)]);
        let solution = among.partial_piv_lu().inverse() * truth;
        let predicted = |o: usize| -> f64 {
            (0..by.len()).map(|k| kernel[(pose, by[k])] * solution[(k, o)]).sum()
        };
        (0..2).map(|o| (outputs[(pose, o)] - predicted(o)).powi(2)).sum()
    }

    #[test]
    fn poses_left_out_in_closed_form_equal_fits_without_them() {
        let (region, outputs) = region();
        let blocks = [0..5, 5..7, 7..N];
        let found = Errors::new(&region.kernel, &region.gram, RIDGE, &blocks).unwrap();
        for block in blocks {
            for pose in block.clone() {
                let others: Vec<usize> = (0..N).filter(|&i| i != pose).collect();
                let outside: Vec<usize> = (0..N).filter(|i| !block.contains(i)).collect();
                let alone = missed(&region.kernel, &outputs, pose, &others);
                let blocked = missed(&region.kernel, &outputs, pose, &outside);
                assert!((found.alone[pose] - alone).abs() < 1e-9 * (1.0 + alone));
                assert!((found.block[pose] - blocked).abs() < 1e-9 * (1.0 + blocked));
            }
        }
    }

    #[test]
    fn learning_poses_one_by_one_equals_a_fit_to_all_of_them() {
        let (mut region, outputs) = region();
        let kernel = region.kernel.clone();
        let learnt = [7, 2, 10];
        learnt.into_iter().for_each(|pose| region.learn(pose));
        for pose in (0..N).filter(|pose| !learnt.contains(pose)) {
            let expected = missed(&kernel, &outputs, pose, &learnt);
            assert!((region.gram[(pose, pose)] - expected).abs() < 1e-9 * (1.0 + expected));
        }
    }

    #[test]
    fn the_kernel_is_zero_at_rest() {
        let inputs = Mat::from_fn(2, 4, |r, i| if i == 0 { 0.0 } else { (r + i) as f64 });
        let kernel = Squared::new(&inputs).unwrap().kernel(4.0);
        assert!((0..4).all(|i| kernel[(0, i)].abs() < 1e-15) && kernel[(1, 1)] > 0.1);
    }
}
