//! The choice of the refinement, by folds: its ridge, and whether the keys that it refines scale and shear.

use super::predictor::{GradientPredictor, predict_stacked};
use super::reduce::Reduced;
use super::refine::Regression;
use super::validation::Validation;
use crate::envelope::lbs::poses::Poses;
use crate::envelope::lbs::projection::Projection;
use faer::Mat;
use serde::Serialize;

/// Candidate ridges, the stiffest first.
const RIDGES: [f64; 8] = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8];

/// A refinement.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Refinement {
    /// Ridge of its regression.
    pub ridge: f64,
    /// Whether keys scale and shear.
    pub shear: bool,
}

/// A candidate and its error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RefinementTrial {
    /// The candidate; none leaves c1 and c2 as the reconstruction gives them.
    pub choice: Option<Refinement>,
    /// RMS error of the training poses as a share of the diagonal, each by a fit that has not seen its fold.
    pub rms: f64,
}

/// Keys of one kind.
pub struct Keyed<'a> {
    /// Their predictors, P.
    pub predictors: Vec<GradientPredictor>,
    /// What such predictors do that have not seen a fold.
    pub validation: Validation<'a>,
}

impl Keyed<'_> {
    /// The same without scale and shear.
    #[must_use]
    pub fn without_shear(&self) -> Self {
        Self {
            predictors: self.predictors.iter().map(GradientPredictor::without_shear).collect(),
            validation: self.validation.without_shear(),
        }
    }
}

/// A reconstruction by keys of one kind, and what refines it.
pub struct Refining<'a> {
    unrefined: &'a Reduced,
    /// The keys.
    pub keyed: &'a Keyed<'a>,
    /// By all training poses, and by those outside each fold.
    trained: Regression,
    folds: Vec<Regression>,
}

impl<'a> Refining<'a> {
    /// Gathers what refines a reconstruction.
    pub fn new(
        unrefined: &'a Reduced,
        keyed: &'a Keyed<'a>,
        poses: &Poses,
        projection: &Projection,
    ) -> Self {
        let gradients = predict_stacked(&keyed.predictors, poses);
        let left_over = projection.residual(&unrefined.palette(&gradients, poses));
        Self {
            trained: Regression::new(&gradients, poses, &left_over, &[]),
            folds: keyed.validation.regressions(unrefined),
            unrefined,
            keyed,
        }
    }

    /// Gives c1 and c2 of a refinement.
    pub fn refined(&self, choice: &Refinement) -> Reduced {
        self.trained.refine(self.unrefined, choice.ridge)
    }

    /// Gives the maps of all poses, 3n x 4P, by refinements that have not seen each fold.
    pub fn maps_of_folds(&self, choice: &Refinement) -> Vec<Mat<f64>> {
        self.keyed.validation.refined(self.unrefined, &self.folds, choice.ridge)
    }

    fn attempt(&self, ridge: f64, shear: bool) -> RefinementTrial {
        let rms = self.keyed.validation.score_refined(self.unrefined, &self.folds, ridge);
        RefinementTrial { choice: Some(Refinement { ridge, shear }), rms }
    }
}

/// Tries no refinement, and every ridge on keys that scale and shear and on such that do not; gives the best, and the
/// trials in order.
pub fn choose(
    shearing: &Refining<'_>,
    rigid: &Refining<'_>,
) -> (Option<Refinement>, Vec<RefinementTrial>) {
    let rms = shearing.keyed.validation.score(shearing.unrefined);
    let mut trials = vec![RefinementTrial { choice: None, rms }];
    for ridge in RIDGES {
        trials.extend([shearing.attempt(ridge, true), rigid.attempt(ridge, false)]);
    }
    let best = trials.iter().min_by(|a, b| a.rms.total_cmp(&b.rms));
    (best.and_then(|trial| trial.choice), trials)
}
