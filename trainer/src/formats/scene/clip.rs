//! Clips, and the times at which they are sampled.

use super::faults;
use crate::Error;
use std::ops::RangeInclusive;
use std::path::Path;

/// Frames a second of a source without times.
pub(crate) const RATE: f64 = 30.0;
/// Largest relative difference of two times or rates that count as equal, because of rounding.
const SAME: f64 = 1e-9;
/// Allowed frames a second of an animation.
pub const RATES: RangeInclusive<f64> = 0.001..=10_000.0;

/// Seconds below which two keys count as one: files store times in single precision.
pub(super) const SAME_TIME: f64 = 1e-5;
/// Largest relative difference of steps between keys that count as even.
pub(crate) const EVEN: f64 = 0.01;
/// Most frames of a clip: ten hours at 30 a second.
const FRAMES_MAX: f64 = 1_080_000.0;

/// Consecutive frames of one animation.
#[derive(Clone, Debug, PartialEq)]
pub struct Clip {
    /// Name of the clip in the source.
    pub name: String,
    /// Index of its first frame among the frames of all clips.
    pub first: usize,
    /// Time of each frame, in seconds of the source, ascending.
    pub times: Vec<f64>,
    /// The source's number of each frame, ascending; `None` if the source does not number them.
    pub numbers: Option<Vec<i64>>,
}

impl Clip {
    /// Makes the single frame of a scene without motion.
    pub(in crate::formats) fn still() -> Self {
        Self::regular("rest".to_owned(), 0, 1)
    }

    /// Names the clip of a file that does not name it, after the file.
    pub(crate) fn name_of(file: &Path) -> String {
        file.file_stem().unwrap_or_default().to_string_lossy().into_owned()
    }

    /// Makes a clip of `frame_len` frames from frame `first`, at 30 frames a second.
    pub fn regular(name: String, first: usize, frame_len: usize) -> Self {
        let mut clip = Self { name, first, times: vec![0.0; frame_len], numbers: None };
        clip.play_at(RATE);
        clip
    }

    /// Makes a clip from frame `first` at 30 frames a second; `numbers` are the source's frame numbers, ascending.
    pub(crate) fn numbered(name: String, first: usize, numbers: Vec<i64>) -> Self {
        let mut clip =
            Self { name, first, times: vec![0.0; numbers.len()], numbers: Some(numbers) };
        clip.play_at(RATE);
        clip
    }

    /// Makes a clip from frame `first`, with a frame for each sample.
    pub(in crate::formats) fn sampled(name: String, first: usize, samples: &[Sample]) -> Self {
        let times = samples.iter().map(|sample| sample.time).collect();
        Self { name, first, times, numbers: None }
    }

    /// Sets the frame rate, counted in frames of the source: if the source numbers every second frame, each frame lasts twice
    /// as long.
    pub fn play_at(&mut self, fps: f64) {
        self.times = self.places().map(|place| place / fps).collect();
    }

    /// Returns the rate that some clips share, as [`Clip::play_at`] takes it; `None` without a common rate or a second
    /// frame.
    pub fn rate_of(clips: &[Self]) -> Option<f64> {
        let longest = clips.iter().max_by_key(|clip| clip.times.len())?;
        let fps = longest.places().last()? / (longest.times.last()? - longest.times.first()?);
        let whole = fps.round();
        let fps = if (fps - whole).abs() <= SAME * fps { whole } else { fps };
        let plays = |clip: &Self| {
            let begin = clip.times.first().copied().unwrap_or_default();
            let mut times = clip.places().zip(&clip.times);
            times.all(|(place, time)| (place / fps - (time - begin)).abs() <= SAME * time.abs())
        };
        (RATES.contains(&fps) && clips.iter().all(plays)).then_some(fps)
    }

    /// Returns each frame's distance from the first frame, in frames of the source.
    fn places(&self) -> impl Iterator<Item = f64> {
        (0..self.times.len()).map(|frame| match (self.number(0), self.number(frame)) {
            (Some(first), Some(number)) => number as f64 - first as f64,
            _ => frame as f64,
        })
    }

    /// Returns the source's number of the clip's frame `frame`.
    pub fn number(&self, frame: usize) -> Option<i64> {
        self.numbers.as_ref()?.get(frame).copied()
    }

    /// Describes the clip by its name and number of frames.
    pub(crate) fn describe(&self) -> String {
        format!("{}: {}", self.name, self.times.len())
    }
}

/// A moment of a clip, in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::formats) struct Sample {
    /// Time at which the clip has the pose.
    pub(in crate::formats) at: f64,
    /// Time at which the pose plays.
    pub(in crate::formats) time: f64,
}

/// Choice of the clips to sample, and of their sample times.
pub(crate) struct Sampling<'a> {
    /// Frames a second; `None` samples at the keys.
    pub(crate) fps: Option<f64>,
    /// Names of the clips to read; empty for all.
    pub(crate) clips: &'a [String],
    /// Whether to evaluate the scene's posed positions too.
    pub(crate) shapes: bool,
    /// Whether to read a single frame: the scene without any clip.
    pub(crate) still: bool,
    /// Whether clips are sampled for playback instead of training.
    pub(crate) played: bool,
    /// Whether to read the weights of named shapes.
    pub(crate) curves: bool,
}

impl Sampling<'_> {
    /// Returns whether a clip is to be read.
    pub(crate) fn takes(&self, clip: &str) -> bool {
        self.clips.is_empty() || self.clips.iter().any(|wanted| wanted == clip)
    }

    /// Checks that all requested clips exist.
    ///
    /// # Errors
    /// A requested clip does not exist, or `known` is empty.
    pub(crate) fn check(&self, known: Vec<String>) -> Result<(), Error> {
        if known.is_empty() {
            return Err(Error::missing(
                "holds no animation: export the poses as keys of an animation clip",
            ));
        }
        match self.clips.iter().find(|name| !known.contains(name)) {
            Some(name) => Err(faults::unknown_clip(name, &known)),
            None => Ok(()),
        }
    }
}

/// Chooses the times at which the clip `name` is sampled, in seconds, ascending: its keys, or a given rate from the
/// first key to the last.
///
/// - `keys`: key times of all channels, in any order.
///
/// # Errors
/// The keys are not finite or too far apart.
pub(in crate::formats) fn sample_times(
    name: &str,
    mut keys: Vec<f64>,
    sampling: &Sampling<'_>,
) -> Result<Vec<f64>, Error> {
    keys.sort_by(f64::total_cmp);
    keys.dedup_by(|next, kept| *next - *kept < SAME_TIME);
    let (first, last) = match (keys.first(), keys.last()) {
        (Some(&first), Some(&last)) => (first, last),
        _ => return Ok(keys),
    };
    let Some(fps) = sampling.fps else {
        let finite = first.is_finite() && last.is_finite();
        return if finite { Ok(keys) } else { Err(faults::key_times(name)) };
    };
    let frames = ((last - first) * fps + EVEN).floor();
    // Keys that are not finite fail here too.
    if !(0.0..FRAMES_MAX).contains(&frames) {
        return Err(faults::key_times(name));
    }
    Ok((0..=frames as usize).map(|frame| (first + frame as f64 / fps).min(last)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_play_at_the_rate_of_the_source_s_own() {
        let mut clip = Clip::regular("walk".into(), 0, 3);
        assert_eq!(clip.times, [0.0, 1.0 / 30.0, 2.0 / 30.0]);
        clip.play_at(24.0);
        assert_eq!(clip.times, [0.0, 1.0 / 24.0, 2.0 / 24.0]);
        let mut twos = Clip::numbered("walk".into(), 0, vec![-1, 1, 5]);
        assert_eq!(twos.times, [0.0, 2.0 / 30.0, 6.0 / 30.0]);
        twos.play_at(24.0);
        assert_eq!(twos.times, [0.0, 2.0 / 24.0, 6.0 / 24.0]);
        assert_eq!(Clip::rate_of(&[clip.clone(), twos.clone()]), Some(24.0));
        clip.play_at(23.976);
        let found = Clip::rate_of(&[clip.clone()]).unwrap();
        assert!((found - 23.976).abs() < 1e-12, "{found}");
        assert_eq!(Clip::rate_of(&[clip.clone(), twos.clone()]), None);
        assert_eq!(Clip::rate_of(&[Clip::still()]), None);
        clip.times.iter_mut().for_each(|time| *time += 1.5);
        assert!((Clip::rate_of(&[clip.clone()]).unwrap() - 23.976).abs() < 1e-9);
        clip.times[1] += 1e-3;
        assert_eq!(Clip::rate_of(&[clip]), None);
        assert_eq!([0, 2, 3].map(|frame| twos.number(frame)), [Some(-1), Some(5), None]);
    }

    fn sample(keys: &[f64], fps: Option<f64>) -> Result<Vec<f64>, Error> {
        sample_times(
            "walk",
            keys.to_vec(),
            &Sampling { fps, clips: &[], shapes: true, still: false, played: false, curves: false },
        )
    }

    #[test]
    fn keys_of_all_channels_are_joined() {
        let found = sample(&[0.5, 0.0, 1.0, 0.5 + 1e-7, 0.0], None).unwrap();
        assert_eq!(found, [0.0, 0.5, 1.0]);
        assert!(sample(&[], None).unwrap().is_empty());
    }

    #[test]
    fn a_rate_reaches_from_the_first_key_to_the_last() {
        assert_eq!(sample(&[1.0, 2.0], Some(4.0)).unwrap(), [1.0, 1.25, 1.5, 1.75, 2.0]);
        assert_eq!(sample(&[1.0, 1.9], Some(4.0)).unwrap(), [1.0, 1.25, 1.5, 1.75]);
        assert_eq!(sample(&[3.0], Some(4.0)).unwrap(), [3.0]);
        // A third of a second is not exact in single precision, so the last frame must still count.
        let keys = [0.0, f64::from(1.0_f32 / 3.0), f64::from(2.0_f32 / 3.0)];
        assert_eq!(sample(&keys, Some(3.0)).unwrap().len(), 3);
    }

    #[test]
    fn times_without_end_are_refused() {
        let refuses = |keys: &[f64], fps: Option<f64>| {
            let error = sample(keys, fps).unwrap_err();
            assert!(
                error.message().starts_with("clip walk: its key times are not finite"),
                "{error}"
            );
        };
        for keys in [[0.0, f64::INFINITY], [0.0, f64::NAN], [f64::NEG_INFINITY, 0.0]] {
            refuses(&keys, None);
            refuses(&keys, Some(30.0));
        }
        refuses(&[0.0, 1e30], Some(30.0));
    }
}
