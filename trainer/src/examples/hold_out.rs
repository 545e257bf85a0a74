//! Setting frames aside for sets that come without a split.

use super::{Clip, Examples, ExamplesError, Split, Warning};
use crate::formats::{FormatError, SceneError};

/// Runs of consecutive frames of which each gives its end. Neighbours in an animation are almost
/// the same pose, so frames are held out in blocks; a few blocks sample the whole animation.
const RUNS: usize = 5;

impl Examples {
    /// Holds out about `share` of the frames in contiguous blocks.
    ///
    /// The training and held-out frames together are cut into five equal runs (fewer if there are
    /// not two frames for each); the last `share` of every run is held out, at least one frame, and
    /// the rest trains. 25 % of 400 frames is thus every fourth block of 20. Extreme frames stay
    /// extreme. The former split is replaced. Returns a warning where runs are too short for the share.
    ///
    /// # Errors
    /// - [`ExamplesError::BadShare`] unless `0 < share < 1`.
    /// - [`ExamplesError::TooFewPoses`] with fewer than two frames to divide.
    pub fn hold_out(&mut self, share: f64) -> Result<Option<Warning>, ExamplesError> {
        if !(share > 0.0 && share < 1.0) {
            return Err(ExamplesError::BadShare { share });
        }
        let frames: Vec<usize> =
            (0..self.frame_len()).filter(|&frame| self.split[frame] != Split::Extreme).collect();
        if frames.len() < 2 {
            return Err(ExamplesError::TooFewPoses { found: frames.len(), needed: 2 });
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

    /// Holds out the frames of the clips with these names, with that of their file before them or without; the others
    /// keep their use.
    ///
    /// # Errors
    /// [`SceneError::UnknownClip`] for a name that none of `clips` has.
    pub fn hold_out_clips(
        &mut self,
        clips: &[Clip],
        names: &[String],
    ) -> Result<(), ExamplesError> {
        for name in names {
            let bare = |clip: &Clip| clip.name.rsplit_once(':').is_some_and(|(_, own)| own == name);
            let is_named = |clip: &&Clip| clip.name == *name || bare(clip);
            let named: Vec<&Clip> = clips.iter().filter(is_named).collect();
            if named.is_empty() {
                let known = clips.iter().map(|clip| clip.name.clone()).collect();
                let unknown = SceneError::UnknownClip { name: name.clone(), known };
                return Err(FormatError::from(unknown).into());
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
    fn a_share_that_short_runs_cannot_have_is_told() {
        let told = |frame_len, share| triangle(frame_len).hold_out(share).unwrap();
        // Runs have 2 or 3 frames, and each keeps one.
        let Some(Warning::HoldOutRounded { held, all, runs, .. }) = told(13, 0.99) else {
            panic!()
        };
        assert_eq!((held, all, runs), (8, 13, 5));
        let text = told(13, 0.99).map(|warning| warning.to_string());
        let words = "8 of 13 frames are held out, 62 % and not 99 %: ";
        assert!(text.as_ref().is_some_and(|text| text.starts_with(words)), "{text:?}");
        assert!(told(13, 0.001).is_some() && told(10, 0.1).is_some());
        for share in [0.07, 0.25, 0.5, 0.9] {
            assert_eq!(told(400, share), None, "{share}");
        }
        assert_eq!(told(13, 0.5), None);
    }

    #[test]
    fn refuses_what_cannot_be_divided() {
        use ExamplesError::{BadShare, TooFewPoses};
        for share in [0.0, 1.0, -1.0, f64::NAN] {
            assert!(matches!(triangle(9).hold_out(share), Err(BadShare { .. })));
        }
        let refused = triangle(1).hold_out(0.5);
        assert!(matches!(refused, Err(TooFewPoses { found: 1, needed: 2 })));
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
