//! Checks examples before a training: finds faults, and names poses to add or to leave out.
//!
//! Of held-out and extreme frames only the poses are read, to compare them with the training poses.

mod advice;
mod context;
mod convention;
pub mod coverage;
pub mod faces;
pub mod finding;
mod frames;
mod joints;
pub mod redundancy;
pub mod rest;
mod step;
pub mod thresholds;

use crate::Error;
use crate::envelope::clean::Inliers;
use crate::envelope::lbs::prior::own_weights;
use crate::envelope::lbs::targets::Targets;
use crate::envelope::lbs::training::Training;
use crate::envelope::one_pose;
use crate::evaluate::NEGLIGIBLE_PERCENT;
use crate::examples::{Clip, Examples, Importance};
use crate::progress::Progress;
use context::{Context, worst_first};
use finding::{Finding, FrameName, Kind, Severity};
use serde::Serialize;

/// The result of a check.
#[derive(Clone, Debug, Serialize)]
pub struct Check {
    /// Size and position of the rest mesh.
    pub size: rest::MeshSize,
    /// How far the rest mesh was tested.
    pub rest: rest::Rest,
    /// Counts of the surface.
    pub faces: faces::Faces,
    /// Error of LBS.
    pub lbs: Floor,
    /// Range of every joint except the reference root.
    pub joints: Vec<coverage::Coverage>,
    /// Range of every curve.
    pub curves: Vec<coverage::CurveCoverage>,
    /// Joints that never bend together with their parents.
    pub never_together: Vec<coverage::JointPair>,
    /// How well the training poses predict each other; `None` if LBS is exact or no joint moves.
    pub predicted: Option<redundancy::Predicted>,
    /// Findings, warnings first.
    pub findings: Vec<Finding>,
    /// Poses to add and to leave out.
    pub advice: Vec<String>,
}

/// Error of LBS with 4 influences a vertex in the training frames, in % of the diagonal: a training starts from this
/// error.
#[derive(Clone, Debug, Serialize)]
pub struct Floor {
    /// RMS.
    pub rms_percent: f64,
    /// RMS in millimetres; `None` if the unit is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms_mm: Option<f64>,
    /// RMS of LBS with the mesh's own joint weights; `None` without own weights. A vertex without own weights uses its
    /// fitted weights.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub own_weights_percent: Option<f64>,
    /// The RMS of own weights in millimetres; `None` if the unit is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub own_weights_mm: Option<f64>,
    /// The worst frames and the RMS of each.
    pub frames: Vec<(FrameName, f64)>,
    /// The worst vertices and the RMS of each.
    pub vertices: Vec<(usize, f64)>,
}

/// Number of worst frames, and of worst vertices, in a result.
const WORST: usize = 5;

/// Checks examples whose frames come from these clips.
///
/// # Errors
/// The examples are invalid, or LBS cannot be fitted to the training frames.
pub fn check(examples: &Examples, clips: &[Clip], progress: &dyn Progress) -> Result<Check, Error> {
    judge(examples, clips, progress).map(|(check, _)| check)
}

/// Checks examples as [`check`] does, and also returns the training frames with the judgement of each, for a training
/// on these frames.
///
/// # Errors
/// The errors of [`check`].
pub fn judge<'a>(
    examples: &'a Examples,
    clips: &[Clip],
    progress: &dyn Progress,
) -> Result<(Check, Inliers<'a>), Error> {
    let warnings = examples.validate()?;
    let mut findings = Vec::new();
    let size = rest::size(examples, &mut findings);
    let given = Inliers::new(examples, progress)?;
    progress.step("steps", 1);
    let mut left_out: Vec<usize> = given.left_out().iter().map(|of| of.frame).collect();
    left_out.sort_unstable();
    // Late meshes would cause other findings too, so the rest of the check uses the meshes in step.
    // Joints that are still do not show the motion of a mesh that curves drive.
    let is_face = given.training.poses.joints_are_still() && !examples.curve_names.is_empty();
    let in_step = match is_face {
        true => None,
        false => step::steps(examples, clips, &left_out, &mut findings),
    };
    let stepped;
    let inliers = match &in_step {
        Some(in_step) => {
            stepped = Inliers::new(in_step, progress)?;
            &stepped
        }
        None => &given,
    };
    let examples = inliers.training.examples;
    let wrong: Vec<usize> = inliers.outliers.iter().map(|of| of.frame).collect();
    let mut broken =
        (!wrong.is_empty()).then(|| frames::broken(inliers, clips, examples.diagonal_mm()));
    // The rest mesh, units, axes and orders are tested on the frames that a training uses. Faults of single frames are
    // searched in all training frames.
    let (others, whole, all);
    let (used, all) = if inliers.left_out().is_empty() {
        (examples, None)
    } else {
        others = examples.without(&wrong);
        whole = Training::new(examples, progress)?;
        all = Context::new(clips, &whole);
        (&others, Some(&all))
    };
    progress.step("units and axes", 1);
    let before = findings.len();
    let misplaced = convention::convention(used, &mut findings);
    findings.extend(frames::clip_order(used, clips));
    let by_clip = match findings.len() == before {
        true => frames::clips(examples, clips, &wrong),
        false => Vec::new(),
    };
    let context = Context::new(clips, &inliers.training);
    if misplaced && findings.len() == before && by_clip.is_empty() {
        let order = convention::vertex_order(used);
        findings.extend(order.or_else(|| convention::offset(&context)));
    }
    if inliers.keeps_outliers && findings.len() > before {
        // The fault of all frames explains the many wrong frames.
        broken = None;
    }
    findings.extend(by_clip);
    let faces = faces::faces(used, &warnings, &mut findings);
    let all = all.unwrap_or(&context);
    let rest = rest::rest(&context, &mut findings);
    joints::misleading_weights(&context, &mut findings);
    joints::joints(&context, &warnings, &mut findings);
    progress.step("faces in poses", 1);
    faces::in_poses(all, &mut findings);
    progress.step("frames", 1);
    if context.training.poses.are_equal() {
        let text = one_pose(context.frames.len()).to_string();
        findings.push(Finding::warning(Kind::OnePose, text, Vec::new()));
    }
    frames::repeats(all, &mut findings);
    findings.extend(broken);
    let joints = coverage::coverage(&context);
    let curves = coverage::curves(&context);
    let never_together = coverage::never_together(&context);
    progress.step("poses", 1);
    let mut predicted = redundancy::predict(&context);
    if !inliers.keeps_outliers {
        findings.extend(predicted.as_ref().and_then(redundancy::unexplained));
    }
    if let Some(predicted) = &mut predicted {
        predicted.isolated.retain(|pose| !wrong.contains(&pose.frame.frame));
    }
    findings.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    let lbs = floor(&context);
    let advice = match lbs.rms_percent > NEGLIGIBLE_PERCENT {
        true => advice::advice(&joints, &never_together, predicted.as_ref()),
        // Where LBS is exact, more poses teach nothing.
        false => Vec::new(),
    };
    let check = Check {
        size,
        rest,
        faces,
        lbs,
        joints,
        curves,
        never_together,
        predicted,
        findings,
        advice,
    };
    Ok((check, given))
}

impl Check {
    /// Counts the findings of a severity.
    pub fn count(&self, severity: Severity) -> usize {
        self.findings.iter().filter(|finding| finding.severity == severity).count()
    }

    /// Returns the first finding of a kind.
    pub fn find(&self, kind: Kind) -> Option<&Finding> {
        self.findings.iter().find(|finding| finding.kind == kind)
    }
}

fn floor(context: &Context<'_>) -> Floor {
    let all: Vec<usize> = (0..context.dominant.len()).collect();
    let of_frame = |i: usize| 100.0 * context.rms(i, &all);
    let of_vertex = |v: usize| 100.0 * context.rms_of(&[v]);
    let frames = worst_first(0..context.frames.len(), of_frame).into_iter().take(WORST);
    let vertices = worst_first(all.iter().copied(), of_vertex).into_iter().take(WORST);
    let rms_percent = 100.0 * context.training.lbs_rms();
    let own_weights_percent = own_weights_rms(context).map(|rms| 100.0 * rms);
    Floor {
        rms_percent,
        rms_mm: context.mm(rms_percent),
        own_weights_percent,
        own_weights_mm: own_weights_percent.and_then(|percent| context.mm(percent)),
        frames: frames.map(|i| (context.frame(i), of_frame(i))).collect(),
        vertices: vertices.map(|v| (v, of_vertex(v))).collect(),
    }
}

/// Returns the RMS error of LBS with the mesh's own joint weights, in diagonals; `None` without own weights.
fn own_weights_rms(context: &Context<'_>) -> Option<f64> {
    let training = context.training;
    let own = own_weights(context.examples, &training.lbs.weights)?;
    // Every vertex has weight 1, as for the fitted weights.
    let targets = Targets { importance: Importance::UNIFORM, ..training.targets(&own) };
    Some(targets.rms(&training.poses.stacked()))
}
