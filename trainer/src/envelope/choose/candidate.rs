//! What was fitted, to choose from.

use super::report::CandidateReport;
use super::ties::smallest_tied;
use crate::envelope::fitted::Fitted;
use crate::envelope::s3::RotationalReport;
use crate::settings::COEFFICIENTS_COST;

/// An envelope that was fitted and fits the budget.
pub(super) struct Candidate {
    pub(super) fitted: Fitted,
    pub(super) tangent_coefficients: bool,
    pub(super) report: usize,
    pub(super) validated_rms: f64,
    pub(super) rotational: Option<RotationalReport>,
}

/// Chooses the candidate with the least error, or a smaller one whose error cannot be told from it.
pub(super) fn chosen<'a>(
    candidates: &'a [Candidate],
    reports: &[CandidateReport],
) -> Option<&'a Candidate> {
    let best = best(candidates)?;
    let of_kind = |c: &&Candidate| c.tangent_coefficients == best.tangent_coefficients;
    let of_kind: Vec<&Candidate> = candidates.iter().filter(of_kind).collect();
    let rated = of_kind.iter().map(|c| (c.validated_rms, reports[c.report].bytes));
    smallest_tied(&Vec::from_iter(rated)).map(|place| of_kind[place])
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
