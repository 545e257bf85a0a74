//! Names of frames.

use super::Clip;
use serde::Serialize;
use std::fmt;

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
        // Numbers of the source.
        let run = Clip::numbered("run".to_owned(), 3, vec![67, 69, 71]);
        assert_eq!(FrameName::new(std::slice::from_ref(&run), 4).to_string(), "69");
        let clips = [clips[0].clone(), run];
        let name = |frame| FrameName::new(&clips, frame).to_string();
        assert_eq!([name(2), name(3), name(5)], ["2 (walk 2)", "67 (run)", "71 (run)"]);
    }
}
