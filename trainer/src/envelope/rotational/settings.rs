//! The choice of near-rigid vertices, anchors and refinement by validation inside the training
//! split (METHOD §1.6, §1.7).

use super::reduce::{Anchors, Reduced, Reduction};
use super::validation::Validation;
use crate::envelope::FitError;
use crate::envelope::skin::projection::Projection;
use crate::progress::Progress;
use serde::Serialize;

/// Candidate fractions of F; at 1 the proxies follow LBS wherever it leads.
const FRACTIONS: [f64; 11] = [0.05, 0.1, 0.15, 0.25, 0.35, 0.5, 0.65, 0.75, 0.85, 0.95, 1.0];
/// Candidate γ, tried at the best fraction.
const NEAR_RIGID: [f64; 6] = [0.1, 1.0, 10.0, 100.0, 1e3, 1e4];
/// Candidate μ, tried at the best γ.
const PATCH: [f64; 4] = [1e-6, 1e-4, 1e-3, 1e-2];
/// Candidate ridges of the refinement, tried last, the stiffest first.
const REFINEMENT: [f64; 8] = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8];
/// What the search starts from.
const START: Anchors = Anchors { near_rigid: 10.0, patch: 1e-4 };
/// A stiffer ridge is taken where it scores within this of the best: it strays less far from the
/// Poisson reconstruction in poses unlike the training's.
const STIFFER: f64 = 1.02;

/// One candidate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Setting {
    /// Fraction of the vertices that belong to F, those with the least LBS error.
    pub near_rigid_fraction: f64,
    /// γ and μ.
    pub anchors: Anchors,
    /// Ridge of the refinement; none leaves c1 and c2 as the reconstruction gives them.
    pub refinement: Option<f64>,
}

/// A candidate and its score.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SettingTrial {
    /// The candidate.
    pub choice: Setting,
    /// Cross-validated RMS error over the diagonal; none where the system is singular.
    pub rms: Option<f64>,
}

/// The candidate taken.
#[derive(Clone, Copy, Debug)]
pub struct Chosen {
    /// The candidate.
    pub choice: Setting,
    /// Its cross-validated RMS error over the diagonal.
    pub rms: f64,
}

/// What is chosen from.
pub struct Candidates<'a> {
    /// What is reduced; F and the anchors are replaced.
    pub reduction: Reduction<'a>,
    /// Squared LBS error of each vertex.
    pub lbs_errors: &'a [f64],
    /// What scores a candidate.
    pub validation: &'a Validation<'a>,
    /// The training meshes for the refinement; none where it is not to be tried.
    pub projection: Option<&'a Projection>,
}

impl Candidates<'_> {
    /// Tries fractions of F, then γ, then μ, then the refinement; returns the choice and every
    /// trial in order.
    ///
    /// # Errors
    /// [`FitError::Singular`] where no candidate is regular.
    pub fn choose(&self, progress: &dyn Progress) -> Result<(Chosen, Vec<SettingTrial>), FitError> {
        progress.step("near-rigid vertices", FRACTIONS.len() + NEAR_RIGID.len() + PATCH.len());
        let mut search = Sweep { candidates: self, trials: Vec::new(), best: None, progress };
        for near_rigid_fraction in FRACTIONS {
            search.attempt(Setting { near_rigid_fraction, anchors: START, refinement: None });
        }
        for near_rigid in NEAR_RIGID {
            let best = search.best()?.choice;
            search.attempt(Setting { anchors: Anchors { near_rigid, ..best.anchors }, ..best });
        }
        for patch in PATCH {
            let best = search.best()?.choice;
            search.attempt(Setting { anchors: Anchors { patch, ..best.anchors }, ..best });
        }
        let unrefined = search.best()?;
        let mut trials = search.trials;
        let chosen = self.refine(unrefined, &mut trials, progress)?;
        Ok((chosen, trials))
    }

    /// Reduces the reconstruction with the anchors of a choice, without refinement.
    pub fn reduce(&self, choice: &Setting) -> Option<Reduced> {
        let fixed = near_rigid(self.lbs_errors, choice.near_rigid_fraction);
        Reduction { fixed: &fixed, anchors: Some(choice.anchors), ..self.reduction }.run()
    }

    /// Tries the refinement of a choice, and takes the stiffest ridge that is good enough.
    fn refine(
        &self,
        unrefined: Chosen,
        trials: &mut Vec<SettingTrial>,
        progress: &dyn Progress,
    ) -> Result<Chosen, FitError> {
        let Some(projection) = self.projection else { return Ok(unrefined) };
        progress.step("refinement", 1);
        let reduced = self.reduce(&unrefined.choice).ok_or(FitError::Singular)?;
        let scores = self.validation.score_refined(&reduced, projection, &REFINEMENT);
        progress.advance(1);
        let refined: Vec<_> = REFINEMENT
            .iter()
            .zip(scores)
            .map(|(&strength, rms)| {
                let choice = Setting { refinement: Some(strength), ..unrefined.choice };
                Chosen { choice, rms }
            })
            .collect();
        trials.extend(refined.iter().map(|c| SettingTrial { choice: c.choice, rms: Some(c.rms) }));
        let best = refined.iter().map(|c| c.rms).fold(unrefined.rms, f64::min);
        let mut stiffest_first = std::iter::once(unrefined).chain(refined);
        Ok(stiffest_first.find(|c| c.rms <= STIFFER * best).unwrap_or(unrefined))
    }
}

/// Marks F: the given fraction of V vertices, those with the least LBS error.
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

struct Sweep<'a> {
    candidates: &'a Candidates<'a>,
    trials: Vec<SettingTrial>,
    best: Option<Chosen>,
    progress: &'a dyn Progress,
}

impl Sweep<'_> {
    fn attempt(&mut self, choice: Setting) {
        self.progress.advance(1);
        if self.trials.iter().any(|trial| trial.choice == choice) {
            return;
        }
        let reduced = self.candidates.reduce(&choice);
        let rms = reduced.map(|reduced| self.candidates.validation.score(&reduced));
        self.trials.push(SettingTrial { choice, rms });
        if let Some(rms) = rms.filter(|rms| self.best.is_none_or(|best| *rms < best.rms)) {
            self.best = Some(Chosen { choice, rms });
        }
    }

    fn best(&self) -> Result<Chosen, FitError> {
        self.best.ok_or(FitError::Singular)
    }
}
