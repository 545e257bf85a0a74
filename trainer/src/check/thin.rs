//! Which poses the others make superfluous, and which stand alone.

use super::finding::FrameName;
use super::foretold::{Errors, Region, compared, regions};
use super::seen::{Seen, worst_first};
use super::thresholds::{LONELY, NEGLIGIBLE, REDUNDANT, VISIBLE};
use rayon::prelude::*;
use serde::Serialize;

/// How the training poses foretell each other.
#[derive(Clone, Debug, Serialize)]
pub struct Foretold {
    /// Poses that were compared: all, or some, evenly apart.
    pub compared: usize,
    /// RMS error of LBS in them, in % of the diagonal.
    pub lbs_percent: f64,
    /// RMS error to be expected in poses never seen, in % of the diagonal: each contiguous block of
    /// poses foretold by the others.
    pub expected_percent: f64,
    /// Poses that foretell all others, in order.
    pub enough: Vec<FrameName>,
    /// The others, that which is foretold best first.
    pub spare: Vec<FrameName>,
    /// Poses that no other is like, the loneliest first.
    pub lonely: Vec<Lonely>,
}

/// A pose that no other is like.
#[derive(Clone, Debug, Serialize)]
pub struct Lonely {
    /// The frame.
    pub frame: FrameName,
    /// The joint whose skin is foretold worst.
    pub joint: String,
    /// RMS error when it is foretold by all others, in % of the diagonal.
    pub percent: f64,
}

/// Compares the training poses; none where LBS leaves nothing to foretell, or no joint moves.
pub(super) fn foretell(seen: &Seen<'_>) -> Option<Foretold> {
    if seen.lbs_rms() < VISIBLE {
        return None;
    }
    let poses = compared(seen);
    let mut regions = regions(seen, &poses);
    if regions.is_empty() {
        return None;
    }
    let errors: Vec<Errors> = regions.par_iter().map(Region::errors).collect::<Option<Vec<_>>>()?;
    let sum = |of: &dyn Fn(&Errors) -> f64| errors.iter().map(of).sum::<f64>();
    let lbs: f64 = regions.iter().map(|r| r.gram.diagonal().column_vector().sum()).sum();
    let block: f64 = sum(&|e| e.block.iter().sum());
    let alone: Vec<f64> = (0..poses.len()).map(|i| sum(&|e| e.alone[i])).collect();

    // Sums over the vertices of the regions, to RMS over all.
    let all: Vec<usize> = (0..seen.dominant.len()).collect();
    let whole: f64 = poses.iter().map(|&i| seen.rms(i, &all).powi(2)).sum();
    let percent = |squared: f64| 100.0 * (squared / lbs * whole).sqrt();
    let mean = |squared: f64| percent(squared / poses.len() as f64);

    let usual = alone.iter().sum::<f64>() / poses.len() as f64;
    let mean_lbs = lbs / poses.len() as f64;
    let tolerance = (REDUNDANT.powi(2) * usual).max(NEGLIGIBLE.powi(2) * mean_lbs);
    let Enough { mut kept, spare } = enough(&mut regions, tolerance);
    kept.sort_unstable();
    let stands_alone =
        |&i: &usize| alone[i] > LONELY.powi(2) * usual && percent(alone[i]) > 100.0 * VISIBLE;
    let lonely = (0..poses.len()).filter(stands_alone);
    let lonely = worst_first(lonely, |i| alone[i]);
    let name = |i: usize| seen.frame(poses[i]);
    let worst_joint = |i: usize| {
        let of = |r: &usize| errors[*r].alone[i];
        let worst = (0..regions.len()).max_by(|a, b| of(a).total_cmp(&of(b)));
        worst.map_or(String::new(), |r| seen.joint(regions[r].joint).to_owned())
    };
    Some(Foretold {
        compared: poses.len(),
        lbs_percent: mean(lbs),
        expected_percent: mean(block),
        enough: kept.iter().map(|&i| name(i)).collect(),
        spare: spare.iter().map(|&i| name(i)).collect(),
        lonely: lonely
            .into_iter()
            .map(|i| Lonely { frame: name(i), joint: worst_joint(i), percent: percent(alone[i]) })
            .collect(),
    })
}

/// Poses by their number among those compared.
struct Enough {
    kept: Vec<usize>,
    /// Best foretold first.
    spare: Vec<usize>,
}

/// Takes the pose that those taken foretell worst, until all others are foretold to within a squared
/// error.
fn enough(regions: &mut [Region], tolerance: f64) -> Enough {
    let n = regions.first().map_or(0, |region| region.gram.nrows());
    let mut kept = Vec::new();
    loop {
        let error = |i: usize| regions.iter().map(|region| region.gram[(i, i)]).sum::<f64>();
        let errors: Vec<f64> = (0..n).map(error).collect();
        let mut spare: Vec<usize> = (0..n).filter(|i| !kept.contains(i)).collect();
        let by_error = |&a: &usize, &b: &usize| errors[a].total_cmp(&errors[b]);
        match spare.iter().copied().max_by(by_error) {
            Some(worst) if errors[worst] > tolerance => {
                regions.par_iter_mut().for_each(|region| region.learn(worst));
                kept.push(worst);
            }
            _ => {
                spare.sort_by(by_error);
                return Enough { kept, spare };
            }
        }
    }
}
