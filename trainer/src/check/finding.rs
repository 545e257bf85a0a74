//! Findings of a check and their places, and helpers for their texts.

pub use crate::examples::{FrameName, Severity};
use serde::Serialize;
use std::fmt;

/// The part of the examples that a finding is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Topic {
    /// Size and position of the mesh.
    Size,
    /// The rest mesh, compared with joints and poses.
    Rest,
    /// Single joints.
    Joints,
    /// The faces.
    Faces,
    /// Frames, compared with each other.
    Frames,
}

/// The kind of a finding. The kinds are in the order of their topics.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// The mesh is far from the origin.
    FarAway,
    /// The mesh is so far from the origin that single precision is too coarse.
    TooFar,
    /// In no usual unit does the largest extent suit a character.
    OddSize,
    /// Mesh and skeleton have different units.
    OtherUnits,
    /// Mesh and skeleton have different axes.
    OtherAxes,
    /// The mesh is shifted against the skeleton.
    Shifted,
    /// Most meshes have a rigid offset from their joints.
    Elsewhere,
    /// The posed meshes have another vertex order than the rest mesh.
    VertexOrder,
    /// The meshes near rest differ from the rest mesh.
    RestDiffers,
    /// No frame is near rest.
    RestUntested,
    /// A joint's maps are not rigid.
    NonRigid,
    /// A joint never moves in training.
    Still,
    /// A joint turns by nearly 180°.
    HalfTurn,
    /// A joint moves no vertex.
    Idle,
    /// The mesh's own joint weights are wrong for the skin of a joint.
    Weights,
    /// Triangles without area in the rest mesh.
    NoArea,
    /// Neighbouring triangles face opposite sides.
    Winding,
    /// Edges shared by more than two triangles.
    NonManifold,
    /// Vertices without a triangle.
    Unreferenced,
    /// Vertices that share their positions in all frames.
    Unwelded,
    /// Triangles that lose their area in a pose.
    Collapsed,
    /// Triangles that fold over a neighbour in a pose.
    Folded,
    /// Triangles that face away from the direction given by their joints, too many for a fold.
    Flipped,
    /// Frames with the same pose and the same mesh.
    Repeated,
    /// Frames with the same pose and different meshes.
    Contradicting,
    /// Meshes that belong to an earlier or later frame.
    OutOfStep,
    /// Meshes in another order of clips.
    ClipOrder,
    /// A clip whose meshes do not belong to its joints.
    WrongClip,
    /// Clips that no common set of weights fits.
    UnlikeClips,
    /// Meshes that do not belong to their poses.
    Broken,
    /// All training frames are one pose.
    OnePose,
    /// The poses do not explain the skin.
    Unexplained,
}

impl Kind {
    /// Returns the topic of the kind.
    pub fn topic(self) -> Topic {
        match self {
            Self::FarAway | Self::TooFar | Self::OddSize => Topic::Size,
            Self::OtherUnits
            | Self::OtherAxes
            | Self::Shifted
            | Self::Elsewhere
            | Self::VertexOrder
            | Self::RestDiffers
            | Self::RestUntested => Topic::Rest,
            Self::NonRigid | Self::Still | Self::HalfTurn | Self::Idle | Self::Weights => {
                Topic::Joints
            }
            Self::NoArea
            | Self::Winding
            | Self::NonManifold
            | Self::Unreferenced
            | Self::Unwelded
            | Self::Collapsed
            | Self::Folded
            | Self::Flipped => Topic::Faces,
            Self::Repeated
            | Self::Contradicting
            | Self::OutOfStep
            | Self::ClipOrder
            | Self::WrongClip
            | Self::UnlikeClips
            | Self::Broken
            | Self::OnePose
            | Self::Unexplained => Topic::Frames,
        }
    }
}

/// A place in the examples.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Place {
    /// A frame.
    Frame(FrameName),
    /// A joint by name.
    Joint(String),
    /// A vertex by number.
    Vertex(usize),
    /// A triangle by number.
    Triangle(usize),
    /// An edge, by its vertices.
    Edge([usize; 2]),
}

/// A fact about the examples that an artist should know.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// The kind.
    pub kind: Kind,
    /// The severity.
    pub severity: Severity,
    /// The text, one line, with the worst places.
    pub text: String,
    /// All places, the worst first.
    pub places: Vec<Place>,
}

impl Finding {
    pub(super) fn new(severity: Severity, kind: Kind, text: String, places: Vec<Place>) -> Self {
        Self { kind, severity, text, places }
    }

    pub(super) fn warning(kind: Kind, text: String, places: Vec<Place>) -> Self {
        Self::new(Severity::Warning, kind, text, places)
    }

    pub(super) fn note(kind: Kind, text: String, places: Vec<Place>) -> Self {
        Self::new(Severity::Note, kind, text, places)
    }
}

/// Number of places that a text names; further places are counted.
pub const LISTED: usize = 5;

/// Joins the first [`LISTED`] words and counts the rest.
pub fn listed(words: impl IntoIterator<Item = impl fmt::Display>) -> String {
    let mut words = words.into_iter();
    let mut out: Vec<String> = words.by_ref().take(LISTED).map(|word| word.to_string()).collect();
    let more = words.count();
    if more > 0 {
        out.push(format!("and {more} more"));
    }
    out.join(", ")
}

/// Names frames in order. Runs become `first-last`. Names are the source's frame numbers if there are any.
pub fn runs(frames: &[FrameName]) -> Vec<String> {
    let mut frames: Vec<&FrameName> = frames.iter().collect();
    frames.sort_unstable_by_key(|frame| frame.frame);
    // Numbers may start again with a clip.
    let runs = frames.chunk_by(|last, frame| {
        last.frame + 1 == frame.frame && (frame.number.is_none() || last.number < frame.number)
    });
    let run = |run: &[&FrameName]| {
        let ends = [run[0], run[run.len() - 1]];
        let [first, last] = ends.map(|frame| frame.number.unwrap_or(frame.frame as i64));
        if first == last { format!("{first}") } else { format!("{first}-{last}") }
    };
    runs.map(run).collect()
}

/// Formats a length with three significant digits.
pub fn short(length: f64) -> String {
    if length >= 100.0 {
        format!("{length:.0}")
    } else if length >= 0.1 {
        format!("{length:.2}")
    } else {
        format!("{length:.2e}")
    }
}

/// Formats a number of things, with the singular for one.
pub fn count(number: usize, one: &str, many: &str) -> String {
    format!("{number} {}", if number == 1 { one } else { many })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lists_are_cut_and_counted() {
        assert_eq!(listed(0..5), "0, 1, 2, 3, 4");
        assert_eq!(listed(0..9), "0, 1, 2, 3, 4, and 4 more");
        assert_eq!(count(1, "frame", "frames"), "1 frame");
        assert_eq!([514.9, 5.149, 0.0514].map(short), ["515", "5.15", "5.14e-2"]);
    }
}
