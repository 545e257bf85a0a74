//! Cross-validation inside the training split, by folds (METHOD §1.1).

use super::predictor::{self, GradientPredictor};
use super::reduce::Reduced;
use super::refine::Regression;
use crate::envelope::folds::Folds;
use crate::envelope::lbs::blend::Weights;
use crate::envelope::lbs::poses::Poses;
use crate::envelope::lbs::projection::Projection;
use crate::envelope::lbs::targets::skin;
use crate::progress::Progress;
use crate::regression::outputs::Block;
use faer::Mat;
use nalgebra::Matrix3;
use rayon::prelude::*;

/// Key gradients of every training pose, predicted without each fold in turn.
pub struct Validation<'a> {
    projection: &'a Projection,
    poses: &'a Poses,
    folds: Vec<FoldPrediction>,
}

struct FoldPrediction {
    fold: Block,
    /// Predictors fitted without the fold, P.
    predictors: Vec<GradientPredictor>,
    /// What they predict of all poses, 3n x 3P.
    predicted: Mat<f64>,
}

impl FoldPrediction {
    fn new(fold: Block, predictors: Vec<GradientPredictor>, poses: &Poses) -> Self {
        Self { predicted: predictor::predict_stacked(&predictors, poses), fold, predictors }
    }
}

impl<'a> Validation<'a> {
    /// Fits the predictors of P key sequences once a fold, by a function of the poses that are left and a sequence in them.
    pub fn new(
        projection: &'a Projection,
        poses: &'a Poses,
        sequences: &[Vec<Matrix3<f64>>],
        predictor: &(impl Fn(&Poses, &[Matrix3<f64>]) -> GradientPredictor + Sync),
        progress: &dyn Progress,
    ) -> Self {
        let folds = Folds::new(poses).runs().to_vec();
        progress.step("cross-validation", folds.len() * sequences.len());
        let folds = folds
            .into_iter()
            .map(|fold| {
                let left = fold.others(poses.len());
                let train = poses.only(&left);
                let predictors: Vec<_> = sequences
                    .par_iter()
                    .map(|sequence| {
                        let kept: Vec<_> = left.iter().map(|&pose| sequence[pose]).collect();
                        progress.advance(1);
                        predictor(&train, &kept)
                    })
                    .collect();
                FoldPrediction::new(fold, predictors, poses)
            })
            .collect();
        Self { projection, poses, folds }
    }

    /// The same by predictors without scale and shear.
    #[must_use]
    pub fn without_shear(&self) -> Self {
        let of = |of: &FoldPrediction| {
            let rigid = of.predictors.iter().map(GradientPredictor::without_shear).collect();
            FoldPrediction::new(of.fold.clone(), rigid, self.poses)
        };
        Self { folds: self.folds.par_iter().map(of).collect(), ..*self }
    }

    /// RMS error of the poses, each predicted without its fold.
    pub fn score(&self, reduced: &Reduced) -> f64 {
        self.score_maps(&self.unrefined(reduced))
    }

    /// RMS error of the poses after refinement at a ridge, each pose refined and predicted without its fold.
    ///
    /// - `regressions`: of each fold.
    pub fn score_refined(&self, reduced: &Reduced, regressions: &[Regression], ridge: f64) -> f64 {
        self.score_maps(&self.refined(reduced, regressions, ridge))
    }

    /// The maps of all poses, 3n x 4P, by fits that have not seen each fold.
    pub fn unrefined(&self, reduced: &Reduced) -> Vec<Mat<f64>> {
        self.folds.par_iter().map(|fold| reduced.palette(&fold.predicted, self.poses)).collect()
    }

    /// The same, refined at a ridge.
    pub fn refined(
        &self,
        reduced: &Reduced,
        regressions: &[Regression],
        ridge: f64,
    ) -> Vec<Mat<f64>> {
        let of = |(fold, regression): (&FoldPrediction, &Regression)| {
            regression.refine(reduced, ridge).palette(&fold.predicted, self.poses)
        };
        self.folds.par_iter().zip(regressions).map(of).collect()
    }

    /// What refines a reconstruction, by the poses outside each fold.
    pub fn regressions(&self, reduced: &Reduced) -> Vec<Regression> {
        let of = |of: &FoldPrediction| {
            let FoldPrediction { fold, predicted, .. } = of;
            let residual = self.projection.residual(&reduced.palette(predicted, self.poses));
            let mut out: Vec<usize> = fold.out().collect();
            out.sort_unstable();
            Regression::new(predicted, self.poses, &residual, &out)
        };
        self.folds.par_iter().map(of).collect()
    }

    fn score_maps(&self, maps: &[Mat<f64>]) -> f64 {
        self.projection.rms(&self.join(maps))
    }

    /// Joins the folds' own rows of the maps of all folds.
    pub fn join(&self, maps: &[Mat<f64>]) -> Mat<f64> {
        let columns = maps.first().map_or(0, Mat::ncols);
        let mut joined = Mat::zeros(3 * self.poses.len(), columns);
        for (FoldPrediction { fold, .. }, maps) in self.folds.iter().zip(maps) {
            for &pose in &fold.own {
                joined.subrows_mut(3 * pose, 3).copy_from(maps.subrows(3 * pose, 3));
            }
        }
        joined
    }
}

/// Largest distance between two skinnings of the marked vertices over the poses.
pub fn largest_distance(
    rest: &[[f64; 3]],
    (a, a_maps): (&Weights, &Mat<f64>),
    (b, b_maps): (&Weights, &Mat<f64>),
    marked: &[bool],
) -> f64 {
    let distances: Vec<f64> = (0..rest.len())
        .into_par_iter()
        .filter(|&vertex| marked[vertex])
        .map(|vertex| {
            let one = skin(&rest[vertex], a, vertex, a_maps);
            let other = skin(&rest[vertex], b, vertex, b_maps);
            let squared = |i: usize| -> f64 {
                (i..i + 3).map(|k| (one[k] - other[k]) * (one[k] - other[k])).sum()
            };
            (0..one.len()).step_by(3).map(squared).fold(0.0, f64::max)
        })
        .collect();
    distances.into_iter().fold(0.0, f64::max).sqrt()
}
