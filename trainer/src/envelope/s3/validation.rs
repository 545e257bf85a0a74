//! Cross-validation inside the training split, by folds (METHOD §1.1). Chooses near-rigid vertices and anchors by their
//! errors (METHOD §1.6, §1.7), then the refinement: its ridge, and predictors with or without scale and shear.

use super::keys::{GradientPredictor, predict_stacked};
use super::reduce::{Anchors, Reduced, Reduction, Regression};
use crate::Error;
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
use serde::Serialize;

/// Candidate fractions of vertices in F; at 1 all proxies follow LBS.
const FRACTIONS: [f64; 11] = [0.05, 0.1, 0.15, 0.25, 0.35, 0.5, 0.65, 0.75, 0.85, 0.95, 1.0];
/// Candidate γ, tried at the best fraction.
const NEAR_RIGID: [f64; 6] = [0.1, 1.0, 10.0, 100.0, 1e3, 1e4];
/// Candidate μ, tried at the best γ.
const PATCH: [f64; 4] = [1e-6, 1e-4, 1e-3, 1e-2];
/// Anchors of the first trials.
const START: Anchors = Anchors { near_rigid: 10.0, patch: 1e-4 };
/// Candidate ridges of the refinement, the largest first.
const RIDGES: [f64; 8] = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8];

/// Key predictors of one kind, with or without scale and shear, and their cross-validation: each fold is predicted by
/// fits without the fold.
pub struct Validation<'a> {
    projection: &'a Projection,
    poses: &'a Poses,
    /// Predictors fitted to all training poses, P.
    pub predictors: Vec<GradientPredictor>,
    folds: Vec<FoldPrediction>,
}

/// Key gradients of all poses by fits without one fold.
struct FoldPrediction {
    fold: Block,
    /// Predictors fitted without the fold, P.
    predictors: Vec<GradientPredictor>,
    /// Predicted gradients of all poses, 3n x 3P.
    predicted: Mat<f64>,
}

impl FoldPrediction {
    fn new(fold: Block, predictors: Vec<GradientPredictor>, poses: &Poses) -> Self {
        Self { predicted: predict_stacked(&predictors, poses), fold, predictors }
    }
}

impl<'a> Validation<'a> {
    /// Fits the predictors of P key sequences to all poses, and once per fold.
    ///
    /// - `sequences`: gradients of each key in the n poses.
    /// - `predictor`: fits a predictor to some poses and the sequence in these poses.
    pub fn new(
        projection: &'a Projection,
        poses: &'a Poses,
        sequences: &[Vec<Matrix3<f64>>],
        predictor: &(impl Fn(&Poses, &[Matrix3<f64>]) -> GradientPredictor + Sync),
        progress: &dyn Progress,
    ) -> Self {
        progress.step("key predictors", 1);
        let predictors = sequences.par_iter().map(|d| predictor(poses, d)).collect();
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
        Self { projection, poses, predictors, folds }
    }

    /// Returns these predictors without scale and shear.
    #[must_use]
    pub fn without_shear(&self) -> Self {
        let rigid = |predictors: &[GradientPredictor]| -> Vec<_> {
            predictors.iter().map(GradientPredictor::without_shear).collect()
        };
        let of = |of: &FoldPrediction| {
            FoldPrediction::new(of.fold.clone(), rigid(&of.predictors), self.poses)
        };
        Self {
            predictors: rigid(&self.predictors),
            folds: self.folds.par_iter().map(of).collect(),
            ..*self
        }
    }

    /// Computes the maps of all poses, 3n x 4P; each pose is predicted by a fit without its fold.
    pub fn unrefined(&self, reduced: &Reduced) -> Mat<f64> {
        let of = |of: &FoldPrediction| reduced.palette(&of.predicted, self.poses);
        self.join(self.folds.par_iter().map(of).collect())
    }

    /// Returns the RMS error of [`Validation::unrefined`].
    pub fn score(&self, reduced: &Reduced) -> f64 {
        self.projection.rms(&self.unrefined(reduced))
    }

    /// Joins the maps of the folds, each 3n x 4P: a pose's rows come from the fit without its fold.
    fn join(&self, maps: Vec<Mat<f64>>) -> Mat<f64> {
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

/// A candidate for F, γ and μ.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Setting {
    /// Fraction of the vertices in F: the vertices with the smallest LBS errors.
    pub near_rigid_fraction: f64,
    /// γ and μ.
    pub anchors: Anchors,
}

/// A candidate for F, γ and μ, and its error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SettingTrial {
    /// The candidate.
    pub choice: Setting,
    /// Cross-validated RMS error as a share of the diagonal; `None` if the system is singular.
    pub rms: Option<f64>,
}

/// Tries fractions of F, then γ, then μ; returns the best candidate and all trials in order.
///
/// - `reduction`: each candidate replaces its F and anchors.
/// - `lbs_errors`: squared LBS error of each vertex, V.
///
/// # Errors
/// The system of every candidate is singular.
pub fn choose_setting(
    reduction: Reduction<'_>,
    lbs_errors: &[f64],
    validation: &Validation<'_>,
    progress: &dyn Progress,
) -> Result<(Setting, Vec<SettingTrial>), Error> {
    progress.step("near-rigid vertices", FRACTIONS.len() + NEAR_RIGID.len() + PATCH.len());
    let mut trials = Vec::<SettingTrial>::new();
    let mut least = None::<(Setting, f64)>;
    // Returns the best candidate so far; `None` if all systems are singular.
    let mut attempt = |choice: Setting| {
        progress.advance(1);
        if trials.iter().all(|trial| trial.choice != choice) {
            let fixed = near_rigid(lbs_errors, choice.near_rigid_fraction);
            let anchors = Some(choice.anchors);
            let reduced = Reduction { fixed: &fixed, anchors, ..reduction }.run();
            let rms = reduced.map(|reduced| validation.score(&reduced));
            trials.push(SettingTrial { choice, rms });
            if let Some(rms) = rms.filter(|rms| least.is_none_or(|least| *rms < least.1)) {
                least = Some((choice, rms));
            }
        }
        least.map(|least| least.0)
    };
    let mut best = None;
    for near_rigid_fraction in FRACTIONS {
        best = attempt(Setting { near_rigid_fraction, anchors: START });
    }
    let mut best = best.ok_or_else(singular)?;
    for near_rigid in NEAR_RIGID {
        let anchors = Anchors { near_rigid, ..best.anchors };
        best = attempt(Setting { anchors, ..best }).unwrap_or(best);
    }
    for patch in PATCH {
        let anchors = Anchors { patch, ..best.anchors };
        best = attempt(Setting { anchors, ..best }).unwrap_or(best);
    }
    Ok((best, trials))
}

/// Returns the error of a fit whose every candidate gives a singular system.
pub(super) fn singular() -> Error {
    Error::fit("the reduced reconstruction is singular for every choice of near-rigid vertices")
}

/// Marks F among V vertices: the given fraction with the smallest LBS errors.
pub fn near_rigid(lbs_errors: &[f64], fraction: f64) -> Vec<bool> {
    let mut order: Vec<usize> = (0..lbs_errors.len()).collect();
    order.sort_by(|&a, &b| lbs_errors[a].total_cmp(&lbs_errors[b]).then(a.cmp(&b)));
    let mut fixed = vec![false; lbs_errors.len()];
    let count = (fraction * lbs_errors.len() as f64).round() as usize;
    for &vertex in order.iter().take(count) {
        fixed[vertex] = true;
    }
    fixed
}

/// A candidate refinement.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Refinement {
    /// Ridge of its regression, per equation.
    pub ridge: f64,
    /// Whether keys scale and shear.
    pub shear: bool,
}

/// A candidate refinement, and its error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RefinementTrial {
    /// The candidate; `None` keeps c1 and c2 of the Poisson reconstruction.
    pub choice: Option<Refinement>,
    /// Cross-validated RMS error as a share of the diagonal.
    pub rms: f64,
}

/// A reconstruction by predictors of one kind, and the regressions that refine it.
pub struct Refining<'a> {
    unrefined: &'a Reduced,
    /// The predictors.
    pub keyed: &'a Validation<'a>,
    /// Regression over all training poses.
    trained: Regression,
    /// Regressions over the poses outside each fold.
    folds: Vec<Regression>,
}

impl<'a> Refining<'a> {
    /// Sums the regressions that refine a reconstruction.
    pub fn new(unrefined: &'a Reduced, keyed: &'a Validation<'a>) -> Self {
        let Validation { projection, poses, predictors, folds } = keyed;
        let regression = |gradients: &Mat<f64>, out: &[usize]| {
            let residual = projection.residual(&unrefined.palette(gradients, poses));
            Regression::new(gradients, poses, &residual, out)
        };
        let of_fold = |of: &FoldPrediction| {
            let mut out: Vec<usize> = of.fold.out().collect();
            out.sort_unstable();
            regression(&of.predicted, &out)
        };
        let trained = regression(&predict_stacked(predictors, poses), &[]);
        Self { unrefined, keyed, trained, folds: folds.par_iter().map(of_fold).collect() }
    }

    /// Returns c1 and c2 after a refinement.
    pub fn refined(&self, choice: &Refinement) -> Reduced {
        self.trained.refine(self.unrefined, choice.ridge)
    }

    /// Computes the refined maps of all poses, 3n x 4P; each pose is refined and predicted by fits without its fold.
    pub fn validated(&self, choice: &Refinement) -> Mat<f64> {
        let Validation { poses, folds, .. } = self.keyed;
        let of = |(fold, regression): (&FoldPrediction, &Regression)| {
            regression.refine(self.unrefined, choice.ridge).palette(&fold.predicted, poses)
        };
        self.keyed.join(folds.par_iter().zip(&self.folds).map(of).collect())
    }

    fn attempt(&self, ridge: f64, shear: bool) -> RefinementTrial {
        let choice = Refinement { ridge, shear };
        let rms = self.keyed.projection.rms(&self.validated(&choice));
        RefinementTrial { choice: Some(choice), rms }
    }
}

/// Tries no refinement, then every ridge with and without scale and shear. Returns the best refinement, and all trials
/// in order.
pub fn choose_refinement(
    shearing: &Refining<'_>,
    rigid: &Refining<'_>,
) -> (Option<Refinement>, Vec<RefinementTrial>) {
    let rms = shearing.keyed.score(shearing.unrefined);
    let mut trials = vec![RefinementTrial { choice: None, rms }];
    for ridge in RIDGES {
        trials.extend([shearing.attempt(ridge, true), rigid.attempt(ridge, false)]);
    }
    let best = trials.iter().min_by(|a, b| a.rms.total_cmp(&b.rms));
    (best.and_then(|trial| trial.choice), trials)
}

/// Returns the largest distance between two skinnings of the marked vertices over all poses.
///
/// - `a`, `b`: weights of each skinning, and its stacked maps, 3n x 4 per transform.
/// - `marked`: V flags.
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
