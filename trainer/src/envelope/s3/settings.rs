//! The choice of near-rigid vertices and anchors by validation inside the training split (METHOD §1.6, §1.7).

use super::reduce::{Anchors, Reduced, Reduction};
use super::validation::Validation;
use crate::envelope::FitError;
use crate::progress::Progress;
use serde::Serialize;

/// Candidate fractions of F; at 1 the proxies follow LBS wherever it leads.
const FRACTIONS: [f64; 11] = [0.05, 0.1, 0.15, 0.25, 0.35, 0.5, 0.65, 0.75, 0.85, 0.95, 1.0];
/// Candidate γ, tried at the best fraction.
const NEAR_RIGID: [f64; 6] = [0.1, 1.0, 10.0, 100.0, 1e3, 1e4];
/// Candidate μ, tried at the best γ.
const PATCH: [f64; 4] = [1e-6, 1e-4, 1e-3, 1e-2];
/// What the search starts from.
const START: Anchors = Anchors { near_rigid: 10.0, patch: 1e-4 };
/// One candidate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Setting {
    /// Fraction of the vertices that belong to F, those with the least LBS error.
    pub near_rigid_fraction: f64,
    /// γ and μ.
    pub anchors: Anchors,
}

/// A candidate and its score.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SettingTrial {
    /// The candidate.
    pub choice: Setting,
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
}

impl Candidates<'_> {
    /// Tries fractions of F, then γ, then μ; returns the choice and every trial in order.
    ///
    /// # Errors
    /// [`FitError::Singular`] where no candidate is regular.
    pub fn choose(
        &self,
        progress: &dyn Progress,
    ) -> Result<(Setting, Vec<SettingTrial>), FitError> {
        progress.step("near-rigid vertices", FRACTIONS.len() + NEAR_RIGID.len() + PATCH.len());
        let mut search = Sweep { candidates: self, trials: Vec::new(), best: None, progress };
        for near_rigid_fraction in FRACTIONS {
            search.attempt(Setting { near_rigid_fraction, anchors: START });
        }
        for near_rigid in NEAR_RIGID {
            let best = search.best()?;
            search.attempt(Setting { anchors: Anchors { near_rigid, ..best.anchors }, ..best });
        }
        for patch in PATCH {
            let best = search.best()?;
            search.attempt(Setting { anchors: Anchors { patch, ..best.anchors }, ..best });
        }
        Ok((search.best()?, search.trials))
    }

    /// Reduces the reconstruction with the anchors of a choice.
    pub fn reduce(&self, choice: &Setting) -> Option<Reduced> {
        let fixed = near_rigid(self.lbs_errors, choice.near_rigid_fraction);
        Reduction { fixed: &fixed, anchors: Some(choice.anchors), ..self.reduction }.run()
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
    /// The best so far, and its error.
    best: Option<(Setting, f64)>,
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
        if let Some(rms) = rms.filter(|rms| self.best.is_none_or(|best| *rms < best.1)) {
            self.best = Some((choice, rms));
        }
    }

    fn best(&self) -> Result<Setting, FitError> {
        self.best.map(|best| best.0).ok_or(FitError::Singular)
    }
}
