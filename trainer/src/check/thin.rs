//! Which poses the others make superfluous, and which stand alone.

use super::context::{Context, worst_first};
use super::finding::FrameName;
use super::thresholds::{ISOLATED, NEGLIGIBLE, REDUNDANT, VISIBLE};
use crate::envelope::clean::{Region, compared, regions};
use crate::regression::gram::SampleErrors;
use rayon::prelude::*;
use serde::Serialize;

/// How the training poses predict each other.
#[derive(Clone, Debug, Serialize)]
pub struct Predicted {
    /// Training poses there are.
    pub poses: usize,
    /// Those that were compared: all, or some, evenly apart.
    pub compared: usize,
    /// RMS error of LBS in them, in % of the diagonal.
    pub lbs_percent: f64,
    /// RMS error to be expected in poses never seen, in % of the diagonal: each contiguous block of
    /// poses predicted by the others.
    pub expected_percent: f64,
    /// The error of LBS in millimetres; `None` where the unit is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lbs_mm: Option<f64>,
    /// The expected error in millimetres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expected_mm: Option<f64>,
    /// Poses that predict all others, in order.
    pub enough: Vec<FrameName>,
    /// The others, that which is predicted best first.
    pub redundant: Vec<FrameName>,
    /// Poses that no other is like, the loneliest first.
    pub isolated: Vec<Isolated>,
}

impl Predicted {
    /// Counts the poses that were compared, and says of how many.
    pub fn of_compared(&self) -> String {
        let Self { poses, compared, .. } = self;
        if compared < poses {
            format!("the {compared} training poses that were compared (of {poses})")
        } else {
            format!("{poses} training poses")
        }
    }
}

/// A pose that no other is like.
#[derive(Clone, Debug, Serialize)]
pub struct Isolated {
    /// The frame.
    pub frame: FrameName,
    /// The joint whose skin is predicted worst.
    pub joint: String,
    /// RMS error when it is predicted by all others, in % of the diagonal.
    pub percent: f64,
    /// That in millimetres; `None` where the unit is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mm: Option<f64>,
}

/// Compares the training poses; none where LBS leaves nothing to predict, or no joint moves.
pub(super) fn predict(context: &Context<'_>) -> Option<Predicted> {
    if context.lbs_rms() < VISIBLE {
        return None;
    }
    let poses = compared(context.frames.len());
    let mut regions = regions(context.left(), &poses);
    if regions.is_empty() {
        return None;
    }
    let errors: Vec<SampleErrors> = regions
        .par_iter()
        .map(|region| region.errors(context.training, &poses))
        .collect::<Option<Vec<_>>>()?;
    let sum = |of: &dyn Fn(&SampleErrors) -> f64| errors.iter().map(of).sum::<f64>();
    let left = |r: &Region| (0..poses.len()).map(|i| r.regression.left(i)).sum::<f64>();
    let lbs: f64 = regions.iter().map(left).sum();
    let block: f64 = sum(&|e| e.block.iter().sum());
    let alone: Vec<f64> = (0..poses.len()).map(|i| sum(&|e| e.alone[i])).collect();

    // Sums over the vertices of the regions, to RMS over all.
    let all: Vec<usize> = (0..context.dominant.len()).collect();
    let whole: f64 = poses.iter().map(|&i| context.rms(i, &all).powi(2)).sum();
    let percent = |squared: f64| 100.0 * (squared / lbs * whole).sqrt();
    let mean = |squared: f64| percent(squared / poses.len() as f64);

    let usual = alone.iter().sum::<f64>() / poses.len() as f64;
    let mean_lbs = lbs / poses.len() as f64;
    let tolerance = (REDUNDANT.powi(2) * usual).max(NEGLIGIBLE.powi(2) * mean_lbs);
    let Enough { mut kept, redundant } = enough(&mut regions, tolerance);
    kept.sort_unstable();
    let stands_alone =
        |&i: &usize| alone[i] > ISOLATED.powi(2) * usual && percent(alone[i]) > 100.0 * VISIBLE;
    let name = |i: usize| context.frame(poses[i]);
    let worst_joint = |i: usize| {
        let of = |r: &usize| errors[*r].alone[i];
        let worst = (0..regions.len()).max_by(|a, b| of(a).total_cmp(&of(b)));
        worst.map_or(String::new(), |r| context.joint(regions[r].joint).to_owned())
    };
    let isolated = (0..poses.len()).filter(stands_alone);
    let isolated = worst_first(isolated, |i| alone[i]).into_iter().map(|i| {
        let percent = percent(alone[i]);
        Isolated { frame: name(i), joint: worst_joint(i), percent, mm: context.mm(percent) }
    });
    Some(Predicted {
        poses: context.frames.len(),
        compared: poses.len(),
        lbs_percent: mean(lbs),
        expected_percent: mean(block),
        lbs_mm: context.mm(mean(lbs)),
        expected_mm: context.mm(mean(block)),
        enough: kept.iter().map(|&i| name(i)).collect(),
        redundant: redundant.iter().map(|&i| name(i)).collect(),
        isolated: isolated.collect(),
    })
}

/// Poses by their number among those compared.
struct Enough {
    kept: Vec<usize>,
    /// Best predicted first.
    redundant: Vec<usize>,
}

/// Takes the pose that those taken predict worst, until all others are predicted to within a squared
/// error.
fn enough(regions: &mut [Region], tolerance: f64) -> Enough {
    let n = regions.first().map_or(0, |region| region.regression.sample_len());
    let mut kept = Vec::new();
    loop {
        let error = |i: usize| regions.iter().map(|region| region.regression.left(i)).sum::<f64>();
        let errors: Vec<f64> = (0..n).map(error).collect();
        let mut redundant: Vec<usize> = (0..n).filter(|i| !kept.contains(i)).collect();
        let by_error = |&a: &usize, &b: &usize| errors[a].total_cmp(&errors[b]);
        match redundant.iter().copied().max_by(by_error) {
            Some(worst) if errors[worst] > tolerance => {
                regions.par_iter_mut().for_each(|region| region.regression.learn(worst));
                kept.push(worst);
            }
            _ => {
                redundant.sort_by(by_error);
                return Enough { kept, redundant };
            }
        }
    }
}
