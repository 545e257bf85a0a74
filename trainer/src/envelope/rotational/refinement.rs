//! The choice of the refinement: its ridge, whether the keys that it refines scale and shear, and how much lessons count.
//!
//! Of a candidate the folds tell how it does between training poses, and lessons how it does beside them: what counts is
//! by how many times either is better.

use super::lessons::Lessons;
use super::predictor::{GradientPredictor, predict_stacked};
use super::reduce::Reduced;
use super::refine::Regression;
use super::validation::Validation;
use crate::envelope::skin::poses::Poses;
use crate::envelope::skin::projection::Projection;
use faer::Mat;
use serde::Serialize;

/// Candidate ridges, the stiffest first.
const RIDGES: [f64; 8] = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8];
/// Candidate weights of all lessons against that of all training poses. Ridges are tried with the first, the others with
/// the best ridge.
const WEIGHTS: [f64; 4] = [2e-2, 2e-3, 2e-4, 2e-5];
/// A stiffer ridge is taken where it scores within this of the best: it strays less far from the
/// Poisson reconstruction in poses unlike the training's.
const STIFFER: f64 = 1.02;

/// Power of the folds' error against that of lessons, which are but another predictor's word.
const FOLDS_POWER: f64 = 1.5;

/// A refinement.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Refinement {
    /// Ridge of its regression.
    pub ridge: f64,
    /// Whether keys scale and shear.
    pub shear: bool,
    /// Weight of all lessons against that of all training poses.
    pub lessons: f64,
}

/// A candidate and its errors, RMS as shares of the diagonal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RefinementTrial {
    /// The candidate; none leaves c1 and c2 as the reconstruction gives them.
    pub choice: Option<Refinement>,
    /// Of training poses, each by a fit that has not seen its fold.
    pub rms: f64,
    /// Of lessons, as far as the proxies can help it; none without lessons.
    pub lessons: Option<f64>,
}

impl RefinementTrial {
    fn score(&self) -> f64 {
        self.rms.powf(FOLDS_POWER) * self.lessons.unwrap_or(1.0)
    }
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
    lessons: Option<Seen<'a>>,
}

/// Lessons as keys of one kind see them.
struct Seen<'a> {
    poses: &'a Poses,
    gradients: Mat<f64>,
    projection: &'a Projection,
    regression: Regression,
    /// How much one counts where all count as much as all training poses.
    count: f64,
}

impl<'a> Refining<'a> {
    /// Gathers what refines a reconstruction.
    ///
    /// - `lessons`: with their meshes as the palette sees them.
    pub fn new(
        unrefined: &'a Reduced,
        keyed: &'a Keyed<'a>,
        (poses, projection): (&Poses, &Projection),
        lessons: Option<(&'a Lessons, &'a Projection)>,
    ) -> Self {
        let regression = |poses: &Poses, gradients: &Mat<f64>, projection: &Projection| {
            let left_over = projection.residual(&unrefined.palette(gradients, poses));
            Regression::new(gradients, poses, &left_over, &[])
        };
        let count = |lessons: &Lessons| poses.len() as f64 / lessons.poses.len().max(1) as f64;
        let seen = |(lessons, projection): (&'a Lessons, &'a Projection)| {
            let gradients = predict_stacked(&keyed.predictors, &lessons.poses);
            Seen {
                poses: &lessons.poses,
                regression: regression(&lessons.poses, &gradients, projection),
                gradients,
                projection,
                count: count(lessons),
            }
        };
        let gradients = predict_stacked(&keyed.predictors, poses);
        Self {
            trained: regression(poses, &gradients, projection),
            folds: keyed.validation.regressions(unrefined),
            unrefined,
            keyed,
            lessons: lessons.map(seen),
        }
    }

    /// Gives c1 and c2 of a refinement.
    pub fn refined(&self, choice: &Refinement) -> Reduced {
        self.taught(&self.trained, choice.lessons).refine(self.unrefined, choice.ridge)
    }

    /// Gives the maps of all poses, 3n x 4P, by refinements that have not seen each fold.
    pub fn maps_of_folds(&self, choice: &Refinement) -> Vec<Mat<f64>> {
        let folds = self.taught_folds(choice.lessons);
        self.keyed.validation.refined(self.unrefined, &folds, choice.ridge)
    }

    fn taught(&self, regression: &Regression, weight: f64) -> Regression {
        match &self.lessons {
            None => regression.clone(),
            Some(seen) => regression.and(&seen.regression, weight * seen.count),
        }
    }

    fn taught_folds(&self, weight: f64) -> Vec<Regression> {
        self.folds.iter().map(|fold| self.taught(fold, weight)).collect()
    }

    fn unrefined(&self) -> RefinementTrial {
        let rms = self.keyed.validation.score(self.unrefined);
        RefinementTrial { choice: None, rms, lessons: self.error_on_lessons(self.unrefined) }
    }

    /// Tries ridges at one weight of lessons.
    ///
    /// - `shear`: whether the keys scale and shear.
    fn attempt(&self, ridges: &[f64], shear: bool, lessons: f64) -> Vec<RefinementTrial> {
        let (trained, folds) = (self.taught(&self.trained, lessons), self.taught_folds(lessons));
        let of_ridge = |&ridge: &f64| RefinementTrial {
            choice: Some(Refinement { ridge, shear, lessons }),
            rms: self.keyed.validation.score_refined(self.unrefined, &folds, ridge),
            lessons: self.error_on_lessons(&trained.refine(self.unrefined, ridge)),
        };
        ridges.iter().map(of_ridge).collect()
    }

    fn error_on_lessons(&self, reduced: &Reduced) -> Option<f64> {
        let Seen { poses, gradients, projection, .. } = self.lessons.as_ref()?;
        Some(projection.rms(&reduced.palette(gradients, poses)))
    }
}

/// Tries no refinement, every ridge on keys that scale and shear and on such that do not, and at the best one other
/// weights of lessons; gives the stiffest of those that score alike, and the trials in order.
pub fn choose(
    shearing: &Refining<'_>,
    rigid: &Refining<'_>,
) -> (Option<Refinement>, Vec<RefinementTrial>) {
    let by_ridge = [(shearing, true), (rigid, false)]
        .map(|(refining, shear)| refining.attempt(&RIDGES, shear, WEIGHTS[0]));
    let mut trials = vec![shearing.unrefined()];
    for (one, other) in by_ridge[0].iter().zip(&by_ridge[1]) {
        trials.extend([*one, *other]);
    }
    let mut chosen = stiffest(&trials);
    if let (Some(best), true) = (chosen, shearing.lessons.is_some()) {
        let refining = if best.shear { shearing } else { rigid };
        for &lessons in &WEIGHTS[1..] {
            trials.extend(refining.attempt(&[best.ridge], best.shear, lessons));
        }
        chosen = stiffest(&trials);
    }
    (chosen, trials)
}

fn stiffest(trials: &[RefinementTrial]) -> Option<Refinement> {
    let best = trials.iter().map(RefinementTrial::score).fold(f64::INFINITY, f64::min);
    trials.iter().find(|trial| trial.score() <= STIFFER * best)?.choice
}

#[cfg(test)]
mod tests {
    use super::super::{ProxyCount, RotationalOptions, fit};
    use super::*;
    use crate::envelope::correction::lists;
    use crate::envelope::correction::search::Search;
    use crate::envelope::demo::{DemoOptions, demo};
    use crate::envelope::helpers::fit::HelperFit;
    use crate::envelope::skin::targets::Targets;
    use crate::envelope::skin::training::Training;
    use crate::examples::Split;
    use crate::progress::Silent;

    #[test]
    fn of_few_poses_a_refinement_that_learns_from_lessons_errs_less_on_others() {
        let examples = demo(&DemoOptions { vertices: 300, poses: 12, held_out: 30, seed: 1 });
        let training = Training::new(&examples, &Silent).unwrap();
        let helpers = HelperFit::new(&training).unwrap().run(20, 4);
        let target = helpers.target(&training);
        let known = lists::choose(&target, 1, &Silent);
        let maps = Search::new(target, &known, &Silent).fit(usize::MAX).unwrap();
        let lessons = Lessons::new(&training, &helpers.fitted(&training, maps.groups));
        let options =
            RotationalOptions { proxies: ProxyCount::Fixed(20), ..RotationalOptions::default() };
        let (poses, moved) = training.view(&examples, &examples.frames_of(Split::HeldOut));
        let error = |lessons| {
            let rotational = fit(&training, &options, lessons, &Silent).unwrap();
            let fitted = rotational.fitted(rotational.best(), &training);
            let own = training.targets(&fitted.weights);
            let targets = Targets { trajectories: &moved, ..own };
            (targets.rms(&fitted.envelope.palettes(&poses)), rotational.report.refinement.unwrap())
        };
        let ((plain, _), (taught, choice)) = (error(None), error(Some(&lessons)));
        assert!(taught < 0.8 * plain, "{taught} for {plain}: {choice:?}");
    }
}
