//! What a check finds, with its place.

use crate::examples::Clip;
pub use crate::examples::Severity;
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

/// A frame, what its source calls it, and the clip that it comes from where there are several.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FrameName {
    /// Its number among all frames.
    pub frame: usize,
    /// What its source calls it, where it does.
    pub number: Option<i64>,
    /// The clip's name and the number within it.
    pub clip: Option<(String, usize)>,
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

impl FrameName {
    /// Names a frame of some clips.
    pub fn new(clips: &[Clip], frame: usize) -> Self {
        let of = clips.iter().rev().find(|clip| clip.first <= frame);
        let number = of.and_then(|clip| clip.number(frame - clip.first));
        let several = of.filter(|_| clips.len() > 1);
        Self { frame, number, clip: several.map(|clip| (clip.name.clone(), frame - clip.first)) }
    }
}

impl fmt::Display for FrameName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.number, &self.clip) {
            (Some(number), Some((clip, _))) => write!(f, "{number} ({clip})"),
            (Some(number), None) => write!(f, "{number}"),
            (None, Some((clip, inner))) => write!(f, "{} ({clip} {inner})", self.frame),
            (None, None) => write!(f, "{}", self.frame),
        }
    }
}

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
    fn a_frame_is_named_by_its_clip_where_there_are_several() {
        let clip = |name: &str, first| Clip::regular(name.to_owned(), first, 3);
        let [walk, run] = [clip("walk", 0), clip("run", 3)];
        assert_eq!(FrameName::new(std::slice::from_ref(&walk), 2).to_string(), "2");
        let clips = [walk, run];
        let name = |frame| FrameName::new(&clips, frame).to_string();
        assert_eq!([name(2), name(3), name(5)], ["2 (walk 2)", "3 (run 0)", "5 (run 2)"]);
        // What the source calls them, where it does.
        let run = Clip::numbered("run".to_owned(), 3, vec![67, 69, 71]);
        assert_eq!(FrameName::new(std::slice::from_ref(&run), 4).to_string(), "69");
        let clips = [clips[0].clone(), run];
        let name = |frame| FrameName::new(&clips, frame).to_string();
        assert_eq!([name(2), name(3), name(5)], ["2 (walk 2)", "67 (run)", "71 (run)"]);
    }

    #[test]
    fn long_lists_are_cut_and_counted() {
        assert_eq!(listed(0..5), "0, 1, 2, 3, 4");
        assert_eq!(listed(0..9), "0, 1, 2, 3, 4, and 4 more");
        assert_eq!(count(1, "frame", "frames"), "1 frame");
        assert_eq!([514.9, 5.149, 0.0514].map(short), ["515", "5.15", "5.14e-2"]);
    }
}
