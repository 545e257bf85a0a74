//! The choice of near-rigid vertices, anchors and refinement by validation inside the training
//! split (METHOD §1.6, §1.7).

use super::super::FitError;
use super::reduce::{Anchors, Reduced, Reduction};
use super::refine::Projection;
use super::validation::Validation;
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
pub struct Choice {
    /// Fraction of the vertices that belong to F, those with the least LBS error.
    pub near_rigid_fraction: f64,
    /// γ and μ.
    pub anchors: Anchors,
    /// Ridge of the refinement; none leaves c1 and c2 as the reconstruction gives them.
    pub refinement: Option<f64>,
}

/// A candidate and its score.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Trial {
    /// The candidate.
    pub choice: Choice,
    /// Cross-validated RMS error over the diagonal; none where the system is singular.
    pub rms: Option<f64>,
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
    pub fn choose(&self, progress: &dyn Progress) -> Result<(Choice, Vec<Trial>), FitError> {
        progress.step("near-rigid vertices", FRACTIONS.len() + NEAR_RIGID.len() + PATCH.len());
        let mut search = Search { candidates: self, trials: Vec::new(), best: None, progress };
        for near_rigid_fraction in FRACTIONS {
            search.attempt(Choice { near_rigid_fraction, anchors: START, refinement: None });
        }
        for near_rigid in NEAR_RIGID {
            let best = search.best()?;
            search.attempt(Choice { anchors: Anchors { near_rigid, ..best.anchors }, ..best });
        }
        for patch in PATCH {
            let best = search.best()?;
            search.attempt(Choice { anchors: Anchors { patch, ..best.anchors }, ..best });
        }
        let choice = search.best()?;
        let mut trials = search.trials;
        let refinement = self.refinement(&choice, &mut trials, progress)?;
        Ok((Choice { refinement, ..choice }, trials))
    }

    /// Reduces the reconstruction with the anchors of a choice, without refinement.
    pub fn reduce(&self, choice: &Choice) -> Option<Reduced> {
        let fixed = near_rigid(self.lbs_errors, choice.near_rigid_fraction);
        Reduction { fixed: &fixed, anchors: Some(choice.anchors), ..self.reduction }.run()
    }

    fn refinement(
        &self,
        choice: &Choice,
        trials: &mut Vec<Trial>,
        progress: &dyn Progress,
    ) -> Result<Option<f64>, FitError> {
        let Some(projection) = self.projection else { return Ok(None) };
        progress.step("refinement", 1);
        let reduced = self.reduce(choice).ok_or(FitError::Singular)?;
        let scores = self.validation.score_refined(&reduced, projection, &REFINEMENT);
        progress.advance(1);
        let unrefined = self.validation.score(&reduced);
        let best = scores.iter().copied().fold(unrefined, f64::min);
        let mut chosen = None;
        let mut open = unrefined > STIFFER * best;
        for (&strength, &rms) in REFINEMENT.iter().zip(&scores) {
            let refined = Choice { refinement: Some(strength), ..*choice };
            trials.push(Trial { choice: refined, rms: Some(rms) });
            if open && rms <= STIFFER * best {
                chosen = Some(strength);
                open = false;
            }
        }
        Ok(chosen)
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

struct Search<'a> {
    candidates: &'a Candidates<'a>,
    trials: Vec<Trial>,
    best: Option<(f64, Choice)>,
    progress: &'a dyn Progress,
}

impl Search<'_> {
    fn attempt(&mut self, choice: Choice) {
        self.progress.advance(1);
        if self.trials.iter().any(|trial| trial.choice == choice) {
            return;
        }
        let reduced = self.candidates.reduce(&choice);
        let rms = reduced.map(|reduced| self.candidates.validation.score(&reduced));
        self.trials.push(Trial { choice, rms });
        if let Some(rms) = rms.filter(|rms| self.best.is_none_or(|(best, _)| *rms < best)) {
            self.best = Some((rms, choice));
        }
    }

    fn best(&self) -> Result<Choice, FitError> {
        self.best.map(|(_, choice)| choice).ok_or(FitError::Singular)
    }
}
