//! The numbers of proxies that a training tries.

use crate::envelope::lbs::training::Training;
use crate::envelope::options::Options;
use crate::envelope::s3::ProxyCount;
use sinew_runtime::Limits;

/// Fewest proxies to begin with, where nothing else is said.
const PROXIES: usize = 40;
/// Candidate numbers of proxies against that, in quarters; the last only where bytes are few.
const QUARTERS: [usize; 4] = [4, 8, 2, 1];

/// The numbers of proxies to try, the usual one first.
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

/// The number of proxies to begin with: no fewer than the skeleton has joints, so that proxies alone are never poorer
/// than LBS.
pub(super) fn usual_count(training: &Training) -> usize {
    training.poses.joint_len().max(PROXIES).min(proxies_max(training))
}

/// The most proxies that the mesh and a file can have.
pub(super) fn proxies_max(training: &Training) -> usize {
    training.triangles.len().min(Limits::DEFAULT.proxies as usize)
}
