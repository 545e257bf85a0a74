//! Tells, before a training, whether examples are good: what is wrong with them, and which poses to
//! add or to leave out.
//!
//! Held-out and extreme frames are read for their poses alone, to compare them with training.

mod advice;
mod broken;
mod clips;
mod context;
pub mod convention;
pub mod coverage;
mod elsewhere;
pub mod faces;
pub mod finding;
mod folded;
mod joints;
mod order;
mod painted;
mod repeats;
pub mod rest;
pub mod size;
mod step;
pub mod thin;
pub mod thresholds;
mod turns;

use crate::envelope::FitError;
use crate::envelope::clean::Inliers;
use crate::envelope::lbs::prior::own_weights;
use crate::envelope::lbs::targets::Targets;
use crate::envelope::lbs::training::Training;
use crate::evaluate::NOTHING;
use crate::examples::{Clip, Examples, ExamplesError, Importance};
use crate::progress::Progress;
use context::{Context, worst_first};
use finding::{Finding, FrameName, Kind, Severity};
use serde::Serialize;

/// What a check tells of examples.
#[derive(Clone, Debug, Serialize)]
pub struct Check {
    /// Scale and place.
    pub size: size::MeshSize,
    /// How the rest mesh was tested.
    pub rest: rest::Rest,
    /// What the faces are.
    pub faces: faces::Faces,
    /// What LBS leaves.
    pub lbs: Floor,
    /// Every joint but the reference root.
    pub joints: Vec<coverage::Coverage>,
    /// Joints that never bend together with their parent.
    pub never_together: Vec<coverage::Apart>,
    /// How the training poses predict each other; none where LBS leaves nothing.
    pub predicted: Option<thin::Predicted>,
    /// What was found, warnings first.
    pub findings: Vec<Finding>,
    /// What to add and to leave out.
    pub advice: Vec<String>,
}

/// What LBS with 4 influences leaves of the training frames, in % of the diagonal: the floor that a
/// training starts from.
#[derive(Clone, Debug, Serialize)]
pub struct Floor {
    /// RMS.
    pub rms_percent: f64,
    /// RMS in millimetres; `None` where the unit is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms_mm: Option<f64>,
    /// RMS of LBS by the joint weights that come with the mesh; `None` where there are none. A vertex without weights
    /// takes its fitted ones.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub own_weights_percent: Option<f64>,
    /// That RMS in millimetres; `None` where the unit is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub own_weights_mm: Option<f64>,
    /// The worst frames with their RMS.
    pub frames: Vec<(FrameName, f64)>,
    /// The worst vertices with their RMS.
    pub vertices: Vec<(usize, f64)>,
}

/// A check that could not be made.
#[derive(Debug, thiserror::Error)]
pub enum CheckError {
    /// The examples are at fault.
    #[error(transparent)]
    Examples(#[from] ExamplesError),
    /// LBS could not be fitted.
    #[error(transparent)]
    Fit(#[from] FitError),
}

/// Worst frames and vertices that are kept.
const WORST: usize = 5;

/// Checks examples whose frames come from some clips.
///
/// # Errors
/// [`CheckError::Examples`] where they are not valid, [`CheckError::Fit`] where LBS cannot be
/// fitted to the training frames.
pub fn check(
    examples: &Examples,
    clips: &[Clip],
    progress: &dyn Progress,
) -> Result<Check, CheckError> {
    judge(examples, clips, progress).map(|(check, _)| check)
}

/// Checks examples as [`check`] does, and returns the judged training frames too, for a training on these.
///
/// # Errors
/// As [`check`].
pub fn judge<'a>(
    examples: &'a Examples,
    clips: &[Clip],
    progress: &dyn Progress,
) -> Result<(Check, Inliers<'a>), CheckError> {
    let warnings = examples.validate()?;
    let mut findings = Vec::new();
    let size = size::size(examples, &mut findings);
    let given = Inliers::new(examples, progress)?;
    progress.step("steps", 1);
    let mut left_out: Vec<usize> = given.left_out().iter().map(|of| of.frame).collect();
    left_out.sort_unstable();
    // One cause, one finding: what late meshes look like otherwise is not told too.
    let in_step = step::steps(examples, clips, &left_out, &mut findings);
    let stepped;
    let sound = match &in_step {
        Some(in_step) => {
            stepped = Inliers::new(in_step, progress)?;
            &stepped
        }
        None => &given,
    };
    let examples = sound.training.examples;
    let doubted: Vec<usize> = sound.outliers.iter().map(|of| of.frame).collect();
    let mut named =
        (!doubted.is_empty()).then(|| broken::broken(sound, clips, examples.diagonal_mm()));
    // Rest mesh, units, axes and order are those of the frames that a training learns from; what is wrong with a frame is
    // told of every one.
    let (others, whole, all);
    let (learnt, all) = if sound.left_out().is_empty() {
        (examples, None)
    } else {
        others = examples.without(&doubted);
        whole = Training::new(examples, progress)?;
        all = Context::new(clips, &whole);
        (&others, Some(&all))
    };
    progress.step("units and axes", 1);
    let before = findings.len();
    let apart = convention::convention(learnt, &mut findings);
    findings.extend(order::of_clips(learnt, clips));
    let by_clip = match findings.len() == before {
        true => clips::clips(examples, clips, &doubted),
        false => Vec::new(),
    };
    let context = Context::new(clips, &sound.training);
    if apart && findings.len() == before && by_clip.is_empty() {
        let order = order::of_vertices(learnt);
        findings.extend(order.or_else(|| elsewhere::elsewhere(&context)));
    }
    if sound.keeps_outliers && findings.len() > before {
        // So many do not belong because the whole does not.
        named = None;
    }
    findings.extend(by_clip);
    let faces = faces::faces(learnt, &warnings, &mut findings);
    let all = all.unwrap_or(&context);
    let rest = rest::rest(&context, &mut findings);
    painted::misleading(&context, &mut findings);
    joints::joints(&context, &warnings, &mut findings);
    progress.step("faces in poses", 1);
    folded::folded(all, &mut findings);
    progress.step("frames", 1);
    if context.training.poses.are_equal() {
        findings.push(Finding {
            kind: Kind::OnePose,
            severity: Severity::Warning,
            text: FitError::OnePose { found: context.frames.len() }.to_string(),
            places: Vec::new(),
        });
    }
    repeats::repeats(all, &mut findings);
    findings.extend(named);
    let joints = coverage::coverage(&context);
    let never_together = coverage::apart(&context);
    progress.step("poses", 1);
    let mut predicted = thin::predict(&context);
    if let Some(predicted) = &mut predicted {
        predicted.isolated.retain(|pose| !doubted.contains(&pose.frame.frame));
    }
    findings.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    let lbs = floor(&context);
    let advice = match lbs.rms_percent > NOTHING {
        true => advice::advice(&joints, &never_together, predicted.as_ref()),
        // Poses teach nothing where LBS leaves nothing.
        false => Vec::new(),
    };
    let check =
        Check { size, rest, faces, lbs, advice, joints, never_together, predicted, findings };
    Ok((check, given))
}

impl Check {
    /// Counts the findings of a severity.
    pub fn count(&self, severity: Severity) -> usize {
        self.findings.iter().filter(|finding| finding.severity == severity).count()
    }

    /// Returns the finding of a kind, where there is one.
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
    let rms_percent = 100.0 * context.lbs_rms();
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

/// RMS error of LBS by the joint weights that come with the mesh, in diagonals, where there are any.
fn own_weights_rms(context: &Context<'_>) -> Option<f64> {
    let training = context.training;
    let own = own_weights(context.examples, &training.lbs.weights)?;
    // Every vertex counts the same, as for the fitted weights.
    let targets = Targets { importance: Importance::UNIFORM, ..training.targets(&own) };
    Some(targets.rms(&training.poses.stacked()))
}
