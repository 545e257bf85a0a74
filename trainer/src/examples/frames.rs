//! Names of frames, and the choice of held-out frames.

use super::{Clip, Examples, Split, Warning};
use crate::Error;
use crate::formats::scene::faults::unknown_clip;
use serde::Serialize;
use std::fmt;

/// Number of runs of frames; the end of each run is held out. Neighbouring frames have almost equal poses, so single
/// frames would not test anything. A few blocks sample the whole animation.
const RUNS: usize = 5;

/// Name of a frame: index, source number and clip.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FrameName {
    /// Index among all frames.
    pub frame: usize,
    /// Number in the source, if any.
    pub number: Option<i64>,
    /// Name of the clip and index within the clip, if there are several clips.
    pub clip: Option<(String, usize)>,
}

impl FrameName {
    /// Creates the name of a frame within clips.
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

/// Returns the source's number of a frame; the frame index if the source has no number.
fn called(frame: i64, clips: &[Clip]) -> i64 {
    let within = |clip: &Clip| clip.number(usize::try_from(frame).ok()?.checked_sub(clip.first)?);
    clips.iter().find_map(within).unwrap_or(frame)
}

/// Replaces the frame index of an error by the source's frame number.
pub fn numbered(error: Error, clips: &[Clip]) -> Error {
    error.with_frame(|frame| called(frame, clips))
}

impl Warning {
    /// Replaces the frame index by the source's frame number.
    pub(crate) fn called(mut self, clips: &[Clip]) -> Self {
        if let Self::NonRigidJoint { worst_frame: Some(frame), .. } = &mut self {
            *frame = called(*frame, clips);
        }
        self
    }
}

/// Checks a share of held-out frames.
///
/// # Errors
/// The share is not between 0 and 1.
pub fn check_share(share: f64) -> Result<(), Error> {
    if share > 0.0 && share < 1.0 {
        return Ok(());
    }
    Err(Error::value(format!(
        "the share of held-out frames must lie between 0 and 1, found {share}"
    )))
}

impl Examples {
    /// Holds out about `share` of the frames, in contiguous blocks. Replaces the split, except for extreme frames.
    ///
    /// Training and held-out frames together are cut into five equal runs, or into fewer if five would have less than
    /// two frames each. The last `share` of every run is held out, at least one frame; the rest trains. For example, 25
    /// % of 400 frames holds out every fourth block of 20. Returns a warning if the runs are too short for the share.
    ///
    /// # Errors
    /// - The share is not between 0 and 1.
    /// - There are fewer than two frames to divide.
    pub fn hold_out(&mut self, share: f64) -> Result<Option<Warning>, Error> {
        check_share(share)?;
        let frames: Vec<usize> =
            (0..self.frame_len()).filter(|&frame| self.split[frame] != Split::Extreme).collect();
        if frames.len() < 2 {
            return Err(Error::missing(match frames.is_empty() {
                true => "no frame is left to train: all are held out or extreme",
                false => "1 frames are too few, 2 are needed",
            }));
        }
        let runs = RUNS.min(frames.len() / 2);
        for run in 0..runs {
            let frames = &frames[run * frames.len() / runs..(run + 1) * frames.len() / runs];
            let held_out = (share * frames.len() as f64).round() as usize;
            let train_len = frames.len() - held_out.clamp(1, frames.len() - 1);
            for (place, &frame) in frames.iter().enumerate() {
                self.split[frame] = if place < train_len { Split::Train } else { Split::HeldOut };
            }
        }
        self.place_joints();
        let (held, all) = (self.frames_of(Split::HeldOut).len(), frames.len());
        // Each run may round by half a frame.
        let is_near = (held as f64 - share * all as f64).abs() <= 0.5 * runs as f64;
        Ok((!is_near).then_some(Warning::HoldOutRounded { share, held, all, runs }))
    }

    /// Holds out the frames of named clips; other frames keep their use. A name may include the file before the clip
    /// (`FILE:CLIP`) or not.
    ///
    /// # Errors
    /// No clip has one of the names.
    pub fn hold_out_clips(&mut self, clips: &[Clip], names: &[String]) -> Result<(), Error> {
        for name in names {
            let bare = |clip: &Clip| clip.name.rsplit_once(':').is_some_and(|(_, own)| own == name);
            let is_named = |clip: &&Clip| clip.name == *name || bare(clip);
            let named: Vec<&Clip> = clips.iter().filter(is_named).collect();
            if named.is_empty() {
                let known: Vec<String> = clips.iter().map(|clip| clip.name.clone()).collect();
                return Err(unknown_clip(name, &known));
            }
            for clip in named {
                self.split[clip.first..][..clip.times.len()].fill(Split::HeldOut);
            }
        }
        self.place_joints();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::triangle;
    use super::*;
    use crate::ErrorKind;

    #[test]
    fn a_frame_is_named_by_its_clip_where_there_are_several() {
        let clip = |name: &str, first| Clip::regular(name.to_owned(), first, 3);
        let [walk, run] = [clip("walk", 0), clip("run", 3)];
        assert_eq!(FrameName::new(std::slice::from_ref(&walk), 2).to_string(), "2");
        let clips = [walk, run];
        let name = |frame| FrameName::new(&clips, frame).to_string();
        assert_eq!([name(2), name(3), name(5)], ["2 (walk 2)", "3 (run 0)", "5 (run 2)"]);
        // The clip has frame numbers from its source.
        let run = Clip::numbered("run".to_owned(), 3, vec![67, 69, 71]);
        assert_eq!(FrameName::new(std::slice::from_ref(&run), 4).to_string(), "69");
        let clips = [clips[0].clone(), run];
        let name = |frame| FrameName::new(&clips, frame).to_string();
        assert_eq!([name(2), name(3), name(5)], ["2 (walk 2)", "67 (run)", "71 (run)"]);
    }

    #[test]
    fn a_quarter_of_400_frames_is_every_fourth_block_of_20() {
        let mut examples = triangle(400);
        examples.hold_out(0.25).unwrap();
        for (frame, split) in examples.split.iter().enumerate() {
            let expected = if frame / 20 % 4 == 3 { Split::HeldOut } else { Split::Train };
            assert_eq!(*split, expected, "frame {frame}");
        }
    }

    #[test]
    fn extreme_frames_stay_and_do_not_count() {
        let mut examples = triangle(30);
        examples.split[..10].fill(Split::Extreme);
        examples.hold_out(0.5).unwrap();
        assert_eq!(examples.frames_of(Split::Extreme), Vec::from_iter(0..10));
        assert_eq!(examples.frames_of(Split::HeldOut).len(), 10);
    }

    #[test]
    fn every_share_leaves_frames_on_both_sides() {
        for frame_len in 2..40 {
            for share in [0.001, 0.2, 0.5, 0.999] {
                let mut examples = triangle(frame_len);
                examples.hold_out(share).unwrap();
                assert!(!examples.frames_of(Split::Train).is_empty());
                assert!(!examples.frames_of(Split::HeldOut).is_empty());
            }
        }
    }

    #[test]
    fn a_share_that_short_runs_cannot_have_gives_a_warning() {
        let warning_of = |frame_len, share| triangle(frame_len).hold_out(share).unwrap();
        // Runs have 2 or 3 frames, and each keeps one training frame.
        let Some(Warning::HoldOutRounded { held, all, runs, .. }) = warning_of(13, 0.99) else {
            panic!()
        };
        assert_eq!((held, all, runs), (8, 13, 5));
        let text = warning_of(13, 0.99).map(|warning| warning.to_string());
        let words = "8 of 13 frames are held out, 62 % and not 99 %: ";
        assert!(text.as_ref().is_some_and(|text| text.starts_with(words)), "{text:?}");
        assert!(warning_of(13, 0.001).is_some() && warning_of(10, 0.1).is_some());
        for share in [0.07, 0.25, 0.5, 0.9] {
            assert_eq!(warning_of(400, share), None, "{share}");
        }
        assert_eq!(warning_of(13, 0.5), None);
    }

    #[test]
    fn bad_shares_and_single_frames_are_refused() {
        for share in [0.0, 1.0, -1.0, f64::NAN] {
            let refused = triangle(9).hold_out(share).unwrap_err();
            assert_eq!(refused.kind(), ErrorKind::Value);
            assert!(refused.message().ends_with(&format!("between 0 and 1, found {share}")));
        }
        let refused = triangle(1).hold_out(0.5).unwrap_err();
        assert_eq!(refused.message(), "1 frames are too few, 2 are needed");
        let mut none = triangle(1);
        none.split.fill(Split::Extreme);
        let refused = none.hold_out(0.5).unwrap_err();
        assert_eq!(refused.message(), "no frame is left to train: all are held out or extreme");
    }

    #[test]
    fn clips_are_held_out_by_name() {
        let mut examples = triangle(6);
        let clip = |name: &str, first, len| Clip {
            name: name.into(),
            first,
            times: (0..len).map(f64::from).collect(),
            numbers: None,
        };
        let clips = [clip("walk", 0, 2), clip("run", 2, 3), clip("walk", 5, 1)];
        examples.hold_out_clips(&clips, &["walk".to_owned()]).unwrap();
        assert_eq!(examples.frames_of(Split::HeldOut), [0, 1, 5]);
        let error = examples.hold_out_clips(&clips, &["jump".to_owned()]).unwrap_err();
        assert!(error.to_string().starts_with("has no clip jump, there are: walk, run"), "{error}");
    }
}
