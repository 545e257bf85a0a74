//! What a check finds, with its place.

pub use crate::examples::{FrameName, Severity};
use serde::Serialize;
use std::fmt;

/// The part of a check that a finding belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Topic {
    /// Size and place.
    Size,
    /// The rest mesh against joints and poses.
    Rest,
    /// The joints by themselves.
    Joints,
    /// The faces.
    Faces,
    /// The frames against each other.
    Frames,
}

/// What was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// The mesh stands far from the origin.
    FarAway,
    /// It stands so far that single precision is too coarse.
    TooFar,
    /// The largest extent suits a character in no usual unit.
    OddSize,
    /// Mesh and skeleton have other units.
    OtherUnits,
    /// Mesh and skeleton have other axes.
    OtherAxes,
    /// Mesh and skeleton stand apart.
    Shifted,
    /// Most meshes stand elsewhere than their joints.
    Elsewhere,
    /// The posed meshes' vertices have another order than the rest mesh's.
    VertexOrder,
    /// The meshes near rest are not the rest mesh.
    RestDiffers,
    /// No frame is near rest.
    RestUntested,
    /// A joint's maps are not rigid.
    NonRigid,
    /// A joint never moves in training.
    Still,
    /// A joint comes near a half turn.
    HalfTurn,
    /// A joint moves no vertex.
    Idle,
    /// The joint weights that come with the mesh mislead about a joint's skin.
    Weights,
    /// Triangles without area at rest.
    NoArea,
    /// Neighbouring triangles look to opposite sides.
    Winding,
    /// Edges of more than two triangles.
    NonManifold,
    /// Vertices of no triangle.
    Unreferenced,
    /// Vertices that stand and move together.
    Unwelded,
    /// Triangles that lose their area in a pose.
    Collapsed,
    /// Triangles that fold over a neighbour in a pose.
    Folded,
    /// Triangles that look to the other side than their joints take them, too many for a fold.
    Flipped,
    /// Frames of one pose and one mesh.
    Repeated,
    /// Frames of one pose and different meshes.
    Contradicting,
    /// Meshes that belong to the frame before or after.
    OutOfStep,
    /// Meshes that follow the clips in another order.
    ClipOrder,
    /// A clip whose meshes are not of its joints.
    WrongClip,
    /// Clips that no weights fit together.
    UnlikeClips,
    /// Meshes that do not belong to their poses.
    Broken,
    /// All training frames are one pose.
    OnePose,
}

impl Kind {
    /// The part of a check that it belongs to.
    pub fn subject(self) -> Topic {
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
            | Self::OnePose => Topic::Frames,
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

/// Something that an artist should know.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// What.
    pub kind: Kind,
    /// How much it matters.
    pub severity: Severity,
    /// A line that says it, with the worst places.
    pub text: String,
    /// All its places, the worst first.
    pub places: Vec<Place>,
}

/// Places that a line names before it only counts.
pub const LISTED: usize = 5;

/// Joins the first few of some words and counts the rest.
pub fn listed(words: impl IntoIterator<Item = impl fmt::Display>) -> String {
    let mut words = words.into_iter();
    let mut out: Vec<String> = words.by_ref().take(LISTED).map(|word| word.to_string()).collect();
    let more = words.count();
    if more > 0 {
        out.push(format!("and {more} more"));
    }
    out.join(", ")
}

/// Names frames in order, runs as `first-last`, by what their source calls them, where it does.
pub fn runs(frames: &[FrameName]) -> Vec<String> {
    let mut frames: Vec<&FrameName> = frames.iter().collect();
    frames.sort_unstable_by_key(|frame| frame.frame);
    let mut runs: Vec<[&FrameName; 2]> = Vec::new();
    for frame in frames {
        // Numbers may begin anew with a clip.
        let follows = |last: &FrameName| {
            last.frame + 1 == frame.frame && (frame.number.is_none() || last.number < frame.number)
        };
        match runs.last_mut() {
            Some([_, last]) if follows(last) => *last = frame,
            _ => runs.push([frame; 2]),
        }
    }
    let run = |run: [&FrameName; 2]| {
        let [first, last] = run.map(|frame| frame.number.unwrap_or(frame.frame as i64));
        if first == last { format!("{first}") } else { format!("{first}-{last}") }
    };
    runs.into_iter().map(run).collect()
}

/// Writes a length with as many places as it needs to be read.
pub fn short(length: f64) -> String {
    if length >= 100.0 {
        format!("{length:.0}")
    } else if length >= 0.1 {
        format!("{length:.2}")
    } else {
        format!("{length:.2e}")
    }
}

/// Counts things, in the singular where there is one.
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
