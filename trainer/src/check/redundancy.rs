//! Poses that the other poses make redundant, and isolated poses.

use super::context::{Context, worst_first};
use super::finding::{Finding, FrameName, Kind};
use super::thresholds::{ISOLATED, NEGLIGIBLE, REDUNDANT, UNEXPLAINED, VISIBLE};
use crate::envelope::clean::{Region, compared, regions};
use crate::regression::gram::SampleErrors;
use rayon::prelude::*;
use serde::Serialize;

/// How well the training poses predict each other.
#[derive(Clone, Debug, Serialize)]
pub struct Predicted {
    /// Number of training poses.
    pub poses: usize,
    /// Number of compared poses: all, or some at even distances.
    pub compared: usize,
    /// RMS error of LBS in the compared poses, in % of the diagonal.
    pub lbs_percent: f64,
    /// Expected RMS error in new poses, in % of the diagonal. Each contiguous block of poses is predicted by the
    /// others.
    pub expected_percent: f64,
    /// The error of LBS in millimetres; `None` if the unit is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lbs_mm: Option<f64>,
    /// The expected error in millimetres; `None` if the unit is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expected_mm: Option<f64>,
    /// Poses that predict all others, in the order of the frames.
    pub enough: Vec<FrameName>,
    /// The other poses, the best predicted first.
    pub redundant: Vec<FrameName>,
    /// Poses unlike all others, the most isolated first.
    pub isolated: Vec<Isolated>,
}

impl Predicted {
    /// Describes the number of compared poses, and of all poses if more.
    pub fn describe_poses(&self) -> String {
        let Self { poses, compared, .. } = self;
        if compared < poses {
            format!("the {compared} training poses that were compared (of {poses})")
        } else {
            format!("{poses} training poses")
        }
    }
}

/// A pose unlike all others.
#[derive(Clone, Debug, Serialize)]
pub struct Isolated {
    /// The frame.
    pub frame: FrameName,
    /// The joint with the worst predicted skin.
    pub joint: String,
    /// RMS error of the prediction by all other poses, in % of the diagonal.
    pub percent: f64,
    /// The error in millimetres; `None` if the unit is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mm: Option<f64>,
}

/// Warns of a skin that the poses do not explain.
pub(super) fn unexplained(predicted: &Predicted) -> Option<Finding> {
    let Predicted { lbs_percent, expected_percent, .. } = predicted;
    let text = format!(
        "the pose does not explain the skin: frames predicted by the others have {:.0} % of the error of LBS; \
         something else moves the skin (curves that training does not read, a simulation, another take), or too few \
         frames have similar poses: give the curves that drive it, or add frames",
        100.0 * expected_percent / lbs_percent
    );
    (*expected_percent > UNEXPLAINED * lbs_percent)
        .then(|| Finding::warning(Kind::Unexplained, text, Vec::new()))
}

/// Compares the training poses; `None` if LBS is exact or no joint moves.
pub(super) fn predict(context: &Context<'_>) -> Option<Predicted> {
    if context.training.lbs_rms() < VISIBLE {
        return None;
    }
    let poses = compared(context.frames.len());
    let mut regions = regions(context.lbs_residuals(), &poses);
    if regions.is_empty() {
        return None;
    }
    let errors: Vec<SampleErrors> = regions
        .par_iter()
        .map(|region| region.errors(context.training, &poses))
        .collect::<Option<_>>()?;
    let sum = |of: &dyn Fn(&SampleErrors) -> f64| errors.iter().map(of).sum::<f64>();
    let left = |r: &Region| (0..poses.len()).map(|i| r.regression.left(i)).sum::<f64>();
    let lbs: f64 = regions.iter().map(left).sum();
    let block: f64 = sum(&|e| e.block.iter().sum());
    let alone: Vec<f64> = (0..poses.len()).map(|i| sum(&|e| e.alone[i])).collect();

    // Scales sums over the vertices of the regions to an RMS over all vertices.
    let all: Vec<usize> = (0..context.dominant.len()).collect();
    let whole: f64 = poses.iter().map(|&i| context.rms(i, &all).powi(2)).sum();
    let percent = |squared: f64| 100.0 * (squared / lbs * whole).sqrt();
    let mean = |squared: f64| percent(squared / poses.len() as f64);

    let usual = alone.iter().sum::<f64>() / poses.len() as f64;
    let mean_lbs = lbs / poses.len() as f64;
    let tolerance = (REDUNDANT.powi(2) * usual).max(NEGLIGIBLE.powi(2) * mean_lbs);
    let (mut kept, redundant) = enough(&mut regions, tolerance);
    kept.sort_unstable();
    let is_isolated =
        |&i: &usize| alone[i] > ISOLATED.powi(2) * usual && percent(alone[i]) > 100.0 * VISIBLE;
    let name = |i: usize| context.frame(poses[i]);
    let worst_joint = |i: usize| {
        let of = |r: &usize| errors[*r].alone[i];
        let worst = (0..regions.len()).max_by(|a, b| of(a).total_cmp(&of(b)));
        worst.map_or(String::new(), |r| context.joint(regions[r].joint).to_owned())
    };
    let isolated = (0..poses.len()).filter(is_isolated);
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

/// Selects the pose with the worst prediction by the selected poses, until the squared error of every other pose is
/// within the tolerance. Returns the selected and the other poses, the best predicted first, as indices among the
/// compared poses.
fn enough(regions: &mut [Region], tolerance: f64) -> (Vec<usize>, Vec<usize>) {
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
                return (kept, redundant);
            }
        }
    }
}
