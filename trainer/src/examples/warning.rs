//! Warnings: problems in examples that do not stop a fit.

use crate::formats::FormatWarning;
use crate::formats::scene::RATE;
use std::fmt;

/// Triangles that a message lists before the list is cut.
const LISTED: usize = 8;

/// Severity of a warning.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// Information: needs no change.
    Note,
    /// Probably a mistake that costs accuracy.
    Warning,
}

/// A problem that does not stop a fit.
#[derive(Clone, Debug, PartialEq)]
pub enum Warning {
    /// Some content of a file was ignored.
    Format(FormatWarning),
    /// A joint's maps are not quite rigid, by rounding or by noise.
    NonRigidJoint {
        /// Name of the joint.
        joint: String,
        /// Number of matrices that are not rigid.
        matrix_len: usize,
        /// Frame index or source frame number of the largest deviation; `None` for the rest pose.
        worst_frame: Option<i64>,
        /// Largest deviation.
        deviation: f64,
    },
    /// Triangles with a repeated vertex, which a fit ignores.
    RepeatedVertex(Vec<usize>),
    /// Triangles without area in the rest pose, which a fit ignores.
    ZeroArea(Vec<usize>),
    /// Several joints have no parent; the first becomes the parent of the others.
    SeveralRoots(Vec<String>),
    /// An animation lacks joints of the character.
    FollowParents {
        /// Names of the missing joints.
        joints: Vec<String>,
        /// Reason why names do not match, with the option that fixes it.
        mismatch: Option<String>,
    },
    /// Idle joints had a scale, which was removed.
    IdleScaled(Vec<String>),
    /// The root scales the whole character in some frames; the scale was divided out.
    FramesScaled {
        /// Name of the joint.
        joint: String,
        /// Number of the frames.
        frames: usize,
        /// Scale that differs most from 1.
        most: f64,
    },
    /// The animation's rest pose differs from the character's, so the character's rest pose is used.
    RestOfCharacter,
    /// The meshes to learn are the scene's own linear blend skinning.
    PlainSkin,
    /// The targets contain meshes that the scene lacks; these meshes are ignored.
    TargetsLeftOut(Vec<String>),
    /// The targets contain the frames of all clips; only the requested clips are used.
    TargetsCut {
        /// Names of the requested clips.
        clips: Vec<String>,
        /// Number of their frames.
        frames: usize,
        /// Number of frames in the targets.
        held: usize,
    },
    /// The targets follow the clips in another order and were sorted.
    ClipsSorted {
        /// Names of the clips in the targets' order.
        clips: Vec<String>,
        /// Mean distance of vertices from their positions under one joint each, after sorting and before, in % of the
        /// diagonal.
        percent: [f64; 2],
    },
    /// The held-out share differs from the requested share, because each run keeps a frame on both sides.
    HoldOutRounded {
        /// Requested share.
        share: f64,
        /// Number of held-out frames.
        held: usize,
        /// Number of held-out and training frames.
        all: usize,
        /// Number of runs.
        runs: usize,
    },
    /// The frame rate is unknown.
    NoRate,
    /// Poses, joints or targets were converted from other axes or units.
    Moved {
        /// The converted items.
        what: &'static str,
        /// The conversion.
        how: String,
    },
}

impl Warning {
    /// Returns the severity; fixed problems are notes.
    pub fn severity(&self) -> Severity {
        match self {
            Self::Moved { .. }
            | Self::TargetsCut { .. }
            | Self::ClipsSorted { .. }
            | Self::RestOfCharacter
            | Self::RepeatedVertex(_)
            | Self::ZeroArea(_)
            | Self::IdleScaled(_)
            | Self::FramesScaled { .. }
            | Self::Format(FormatWarning::NormalsRepaired { .. }) => Severity::Note,
            _ => Severity::Warning,
        }
    }

    /// Returns whether [`Examples::validate`](super::Examples::validate) reports this warning; a check of examples
    /// repeats it.
    pub fn is_of_validation(&self) -> bool {
        matches!(self, Self::NonRigidJoint { .. } | Self::RepeatedVertex(_) | Self::ZeroArea(_))
    }
}

impl From<FormatWarning> for Warning {
    fn from(warning: FormatWarning) -> Self {
        Self::Format(warning)
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Warning::Format(warning) => warning.fmt(f),
            Warning::NonRigidJoint { joint, matrix_len, worst_frame, deviation } => {
                let off = 100.0 * deviation;
                write!(f, "joint {joint} is not rigid: ")?;
                match (worst_frame, matrix_len) {
                    (None, _) => write!(f, "its rest pose scales or shears by {off:.2} %"),
                    (Some(frame), 1) => write!(f, "it scales or shears by {off:.2} % in frame {frame}"),
                    (Some(frame), len) => write!(
                        f,
                        "it scales or shears in {len} frames, most in frame {frame}, by {off:.2} %"
                    ),
                }
            }
            Warning::RepeatedVertex(all) => {
                list(f, "triangles that name a vertex twice are left out of the fit", &few(all))
            }
            Warning::ZeroArea(all) => {
                list(f, "triangles without area at rest are left out of the fit", &few(all))
            }
            Warning::SeveralRoots(joints) => {
                let (reference, others) =
                    joints.split_first().map_or(("", &[][..]), |(a, b)| (a, b));
                write!(
                    f,
                    "{} joints have no parent: {reference} is the root, and the model has {} under it; \
                     where that is wrong, put all of them under one joint",
                    joints.len(),
                    others.join(", ")
                )
            }
            Warning::FollowParents { joints, mismatch } => {
                list(f, "joints that it does not have follow their parents", joints)?;
                mismatch.as_ref().map_or(Ok(()), |mismatch| write!(f, "; {mismatch}"))
            }
            Warning::FramesScaled { joint, frames, most } => write!(
                f,
                "joint {joint} scales the whole character in {frames} frames, by up to {most:.4}; the scale was divided \
                 out of joints and meshes"
            ),
            Warning::IdleScaled(joints) => {
                list(f, "scaled joints that move no vertex are taken without their scale", joints)
            }
            Warning::RestOfCharacter => f.write_str(
                "its pose without animation is not the rest pose: the character's rest pose is used",
            ),
            Warning::PlainSkin => f.write_str(
                "no shapes move and no targets are given: the meshes are the scene's own linear \
                 blend skinning, so there is nothing to learn; give the posed meshes as \
                 --targets",
            ),
            Warning::TargetsLeftOut(meshes) => {
                list(f, "meshes of the targets that the scene lacks are left out", meshes)
            }
            Warning::TargetsCut { clips, frames, held } => write!(
                f,
                "the targets hold all {held} frames of all clips; the {frames} frames of {} are used",
                clips.join(", ")
            ),
            Warning::ClipsSorted { clips, percent: [sorted, given] } => write!(
                f,
                "the targets follow the clips in another order, {}, and were sorted: vertices are {sorted:.2} % of \
                 the diagonal from where one joint carries them, {given:.2} % as given",
                clips.join(", ")
            ),
            Warning::HoldOutRounded { share, held, all, runs } => write!(
                f,
                "{held} of {all} frames are held out, {:.0} % and not {} %: the frames are cut into {runs} runs, and \
                 each keeps a frame to train and a frame to hold out; give another --hold-out, or whole clips as \
                 --hold-out-clip",
                100.0 * *held as f64 / *all as f64,
                (1e4 * share).round() / 1e2
            ),
            Warning::NoRate => write!(
                f,
                "it gives no frames per second (fps) and plays at {RATE}: give another rate with --fps"
            ),
            Warning::Moved { what, how } => {
                write!(f, "the {what} came in other axes or units and were moved: {how}")
            }
        }
    }
}

/// Writes words and the things that they are about.
fn list(f: &mut fmt::Formatter<'_>, words: &str, things: &[String]) -> fmt::Result {
    write!(f, "{words}: {}", things.join(", "))
}

/// Names the first few triangles.
fn few(triangles: &[usize]) -> Vec<String> {
    let more = (triangles.len() > LISTED).then(|| "...".to_owned());
    triangles.iter().take(LISTED).map(usize::to_string).chain(more).collect()
}
