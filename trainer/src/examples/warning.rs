//! What does not stop a fit and is worth saying.

use super::Clip;
use super::error::called;
use crate::formats::FormatWarning;
use crate::formats::scene::RATE;
use std::fmt;

/// How many triangles a message lists before it only counts.
const LISTED: usize = 8;

/// How much something matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// Worth knowing; a training does without a change.
    Note,
    /// Likely a mistake, which costs accuracy.
    Warning,
}

/// Something that does not stop a fit but that the user should know.
#[derive(Clone, Debug, PartialEq)]
pub enum Warning {
    /// What a file holds was left out.
    Format(FormatWarning),
    /// A joint's maps are not quite rigid; a fit uses the rotation nearest to each.
    NonRigidJoint {
        /// The joint.
        joint: String,
        /// How many of its matrices are off.
        matrix_len: usize,
        /// The frame of the worst, its place or its number in the source; `None` for the rest pose.
        worst_frame: Option<i64>,
        /// How far the worst is off.
        deviation: f64,
    },
    /// Triangles that name a vertex twice; they carry no equation.
    RepeatedVertex {
        /// The triangles.
        triangles: Vec<usize>,
    },
    /// Triangles without area in the rest pose; they carry no equation.
    ZeroArea {
        /// The triangles.
        triangles: Vec<usize>,
    },
    /// Several joints have no parent: the first is the reference, the others become its children.
    SeveralRoots {
        /// The roots, the reference first.
        joints: Vec<String>,
    },
    /// Joints of the character that an animation does not have.
    FollowParents {
        /// The joints.
        joints: Vec<String>,
        /// What keeps names from matching, and the option that mends it.
        mismatch: Option<String>,
    },
    /// Joints that move nothing are scaled, which was taken out.
    IdleScaled {
        /// The joints.
        joints: Vec<String>,
    },
    /// An animation's joints stand otherwise where nothing is animated than the character's at rest, which is taken.
    RestOfCharacter,
    /// The meshes to learn are the scene's own linear blend skinning.
    PlainSkin,
    /// Meshes among the targets are none of the scene's, and are left out.
    TargetsLeftOut {
        /// The meshes.
        meshes: Vec<String>,
    },
    /// The targets hold the frames of all clips, of which some are asked for.
    TargetsCut {
        /// The clips that are.
        clips: Vec<String>,
        /// How many frames those have.
        frames: usize,
        /// How many the targets hold.
        held: usize,
    },
    /// The targets follow the clips in another order, and were sorted.
    ClipsSorted {
        /// The clips in the order of the targets.
        clips: Vec<String>,
        /// How far vertices are from where one joint carries them, as sorted and as given, in % of the diagonal.
        percent: [f64; 2],
    },
    /// Another share of the frames is held out than was asked for, as each run keeps a frame on both sides.
    HoldOutRounded {
        /// The share that was asked for.
        share: f64,
        /// Frames held out.
        held: usize,
        /// Frames held out or training.
        all: usize,
        /// Runs that the frames are cut into.
        runs: usize,
    },
    /// Nothing says how fast the frames follow each other.
    NoRate,
    /// Joints or targets came in other axes or units and were moved.
    Moved {
        /// What was moved.
        what: &'static str,
        /// Where to.
        how: String,
    },
}

impl Warning {
    /// Tells how much it matters: what was put right asks for nothing.
    pub fn severity(&self) -> Severity {
        match self {
            Self::Moved { .. }
            | Self::TargetsCut { .. }
            | Self::ClipsSorted { .. }
            | Self::RestOfCharacter
            | Self::RepeatedVertex { .. }
            | Self::ZeroArea { .. }
            | Self::IdleScaled { .. }
            | Self::Format(FormatWarning::NormalsRepaired { .. }) => Severity::Note,
            _ => Severity::Warning,
        }
    }

    /// Returns whether [`Examples::validate`](super::Examples::validate) finds it: a check of examples reports it too.
    pub fn is_of_validation(&self) -> bool {
        matches!(
            self,
            Self::NonRigidJoint { .. } | Self::RepeatedVertex { .. } | Self::ZeroArea { .. }
        )
    }

    /// Calls the frame that it points at as its source does, of frames of these clips.
    pub(crate) fn called(mut self, clips: &[Clip]) -> Self {
        if let Self::NonRigidJoint { worst_frame: Some(frame), .. } = &mut self {
            *frame = called(*frame, clips);
        }
        self
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
            Warning::RepeatedVertex { triangles } => {
                write!(
                    f,
                    "triangles that name a vertex twice are left out of the fit: {}",
                    FirstFew(triangles)
                )
            }
            Warning::ZeroArea { triangles } => {
                write!(
                    f,
                    "triangles without area at rest are left out of the fit: {}",
                    FirstFew(triangles)
                )
            }
            Warning::SeveralRoots { joints } => {
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
                write!(
                    f,
                    "joints that it does not have follow their parents: {}",
                    joints.join(", ")
                )?;
                mismatch.as_ref().map_or(Ok(()), |mismatch| write!(f, "; {mismatch}"))
            }
            Warning::IdleScaled { joints } => {
                write!(
                    f,
                    "scaled joints that move no vertex are taken without their scale: {}",
                    joints.join(", ")
                )
            }
            Warning::RestOfCharacter => f.write_str(
                "its joints without the animation are not at rest: the rest pose of the character is taken",
            ),
            Warning::PlainSkin => f.write_str(
                "no shapes move and no targets are given: the meshes are the scene's own linear \
                 blend skinning, of which there is nothing to learn; give the posed meshes as \
                 --targets",
            ),
            Warning::TargetsLeftOut { meshes } => {
                write!(
                    f,
                    "meshes of the targets that the scene lacks are left out: {}",
                    meshes.join(", ")
                )
            }
            Warning::TargetsCut { clips, frames, held } => {
                write!(
                    f,
                    "the targets hold the frames of all clips, {held}, of which the {frames} of {} are taken",
                    clips.join(", ")
                )
            }
            Warning::ClipsSorted { clips, percent: [sorted, given] } => {
                write!(
                    f,
                    "the targets follow the clips in another order, {}, and were sorted: vertices are {sorted:.2} % of \
                     the diagonal from where one joint carries them, {given:.2} % as given",
                    clips.join(", ")
                )
            }
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
                "it says no frames a second (fps), and plays at {RATE}: say another rate with --fps"
            ),
            Warning::Moved { what, how } => {
                write!(f, "the {what} came in other axes or units and were moved: {how}")
            }
        }
    }
}

struct FirstFew<'a>(&'a [usize]);

impl fmt::Display for FirstFew<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (place, number) in self.0.iter().take(LISTED).enumerate() {
            write!(f, "{}{number}", if place == 0 { "" } else { ", " })?;
        }
        if self.0.len() > LISTED { f.write_str(", ...") } else { Ok(()) }
    }
}
