//! What was fitted, to choose from.

use super::alike::{COEFFICIENTS_COST, Rated, smallest_alike};
use super::fitted::Fitted;
use super::rotational::{Method, RotationalReport};
use super::training_report::CandidateReport;
use sinew_runtime::envelope::Predictor;

/// Of a predictor whose error is at most so many times the least more is tried: more proxies, a hybrid that is not refined.
const NEARLY: f64 = 1.15;

/// What predicts, and how its c1 and c2 come about.
pub(super) type Kind = (Predictor, Option<Method>);

/// An envelope that was fitted and fits the budget.
pub(super) struct Candidate {
    pub(super) fitted: Fitted,
    pub(super) tangent_coefficients: bool,
    pub(super) report: usize,
    pub(super) validated_rms: f64,
    pub(super) rotational: Option<RotationalReport>,
}

impl Candidate {
    pub(super) fn kind(&self, reports: &[CandidateReport]) -> Kind {
        (self.fitted.envelope.predictor(), reports[self.report].method)
    }
}

/// Lists the kinds whose error is nearly the least.
pub(super) fn near(candidates: &[Candidate], reports: &[CandidateReport]) -> Vec<Kind> {
    let Some(best) = chosen(candidates, reports) else { return Vec::new() };
    let is_near = |c: &&Candidate| c.validated_rms <= NEARLY * best.validated_rms;
    candidates.iter().filter(is_near).map(|c| c.kind(reports)).collect()
}

/// Chooses the candidate with the least error, or a smaller one of which that cannot be told apart. Of those alike
/// one whose maps know how far a pose is from those of training goes before a rotational one, which does not, and what
/// lessons taught before what is not refined.
pub(super) fn chosen<'a>(
    candidates: &'a [Candidate],
    reports: &[CandidateReport],
) -> Option<&'a Candidate> {
    let best = best(candidates)?;
    let of_kind = |c: &&Candidate| c.tangent_coefficients == best.tangent_coefficients;
    let of_kind: Vec<&Candidate> = candidates.iter().filter(of_kind).collect();
    let rate = |c: &&Candidate| Rated {
        error: c.validated_rms,
        knows_poses: c.fitted.envelope.predictor().corrects(),
        untaught: reports[c.report].method == Some(Method::Unrefined),
        bytes: reports[c.report].bytes,
    };
    let rated: Vec<Rated> = of_kind.iter().map(rate).collect();
    smallest_alike(&rated).map(|place| of_kind[place])
}

/// Finds the candidate with the least error: one without tangent coefficients only where those with them leave
/// [`COEFFICIENTS_COST`] times as much.
fn best(candidates: &[Candidate]) -> Option<&Candidate> {
    let least = |coefficients| {
        let alike = candidates.iter().filter(move |c| c.tangent_coefficients == coefficients);
        alike.min_by(|a, b| a.validated_rms.total_cmp(&b.validated_rms))
    };
    match (least(true), least(false)) {
        (Some(with), Some(without))
            if with.validated_rms > COEFFICIENTS_COST * without.validated_rms =>
        {
            Some(without)
        }
        (with, without) => with.or(without),
    }
}
