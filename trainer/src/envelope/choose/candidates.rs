//! Numbers of proxies to try, and the choice among fitted candidates.

use super::report::CandidateReport;
use crate::envelope::fitted::Fitted;
use crate::envelope::lbs::training::Training;
use crate::envelope::options::Options;
use crate::envelope::s3::{ProxyCount, RotationalReport};
use crate::settings::{COEFFICIENTS_COST, TIED, UNSEEN};
use sinew_runtime::Limits;

/// Smallest usual number of proxies.
const PROXIES: usize = 40;
/// Candidate numbers of proxies, in quarters of the usual number. The last one is tried only under a budget.
const QUARTERS: [usize; 4] = [4, 8, 2, 1];

/// Lists the numbers of proxies to try, the usual number first.
pub(super) fn proxy_counts(training: &Training, options: &Options) -> Vec<ProxyCount> {
    if let Some(count) = options.proxies {
        return vec![count];
    }
    let most = proxies_max(training).min(options.method().proxies_max());
    let usual = usual_count(training);
    let quarters = if options.budget.is_some() { &QUARTERS[..] } else { &QUARTERS[..3] };
    let mut counts = Vec::new();
    for count in quarters.iter().map(|quarters| (quarters * usual / 4).clamp(1, most)) {
        if !counts.contains(&ProxyCount::Fixed(count)) {
            counts.push(ProxyCount::Fixed(count));
        }
    }
    counts
}

/// Returns the usual number of proxies. It is at least the number of joints and curves. So proxies without joints reach
/// the error of LBS.
pub(super) fn usual_count(training: &Training) -> usize {
    let poses = &training.poses;
    (poses.joint_len() + poses.curve_len()).max(PROXIES).min(proxies_max(training))
}

/// Returns the largest number of proxies that the mesh and a file allow.
pub(super) fn proxies_max(training: &Training) -> usize {
    training.triangles.len().min(Limits::DEFAULT.proxies as usize)
}

/// Fitted envelope within the budget.
pub(super) struct Candidate {
    pub(super) fitted: Fitted,
    pub(super) tangent_coefficients: bool,
    /// Index of the report.
    pub(super) report: usize,
    pub(super) validated_rms: f64,
    pub(super) rotational: Option<RotationalReport>,
}

/// Chooses the candidate with the smallest file among those that tie with the least error.
pub(super) fn chosen<'a>(
    candidates: &'a [Candidate],
    reports: &[CandidateReport],
) -> Option<&'a Candidate> {
    let best = best(candidates)?;
    let is_comparable = |c: &&Candidate| c.tangent_coefficients == best.tangent_coefficients;
    let comparable: Vec<&Candidate> = candidates.iter().filter(is_comparable).collect();
    let rated = comparable.iter().map(|c| (c.validated_rms, reports[c.report].bytes));
    smallest_tied(&Vec::from_iter(rated)).map(|index| comparable[index])
}

/// Finds the candidate with the least error. A candidate without tangent coefficients wins only if the best candidate
/// with them has more than [`COEFFICIENTS_COST`] times its error.
fn best(candidates: &[Candidate]) -> Option<&Candidate> {
    let least = |coefficients| {
        let comparable = candidates.iter().filter(move |c| c.tangent_coefficients == coefficients);
        comparable.min_by(|a, b| a.validated_rms.total_cmp(&b.validated_rms))
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

/// Returns the index of the smallest file among the candidates that tie with the best. A candidate is (error, bytes).
fn smallest_tied(all: &[(f64, Option<usize>)]) -> Option<usize> {
    let least = all.iter().map(|own| own.0).fold(f64::INFINITY, f64::min);
    let tied = (0..all.len()).filter(|&i| all[i].0 <= TIED * least.max(UNSEEN));
    tied.min_by_key(|&i| all[i].1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_of_tied_files_is_chosen() {
        let chosen = |all: &[(f64, usize)]| {
            smallest_tied(&Vec::from_iter(all.iter().map(|&(error, bytes)| (error, Some(bytes)))))
        };
        assert_eq!(chosen(&[(1e-3, 300), (1.01e-3, 200), (1.03e-3, 100)]), Some(1));
        // Both errors are invisible.
        assert_eq!(chosen(&[(1e-5, 300), (2.5e-5, 200)]), Some(1));
        assert_eq!(chosen(&[(1e-5, 300), (3e-5, 200)]), Some(0));
        assert_eq!(chosen(&[]), None);
    }
}
