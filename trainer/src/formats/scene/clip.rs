//! Runs of frames that play one after another.
//! What of a scene is sampled, and when.
//! The times at which a clip is sampled.

use super::SceneError;
use std::ops::RangeInclusive;
use std::path::Path;

/// Frames a second where a source names no times.
pub(crate) const RATE: f64 = 30.0;
/// Share by which two times, or rates, may differ that are one but for rounding.
const SAME: f64 = 1e-9;
/// Frames a second that an animation may have.
pub const RATES: RangeInclusive<f64> = 0.001..=10_000.0;

/// Consecutive frames of one animation.
#[derive(Clone, Debug, PartialEq)]
pub struct Clip {
    /// Its name in the source.
    pub name: String,
    /// Its first frame among those of all clips.
    pub first: usize,
    /// When each of its frames plays, in the source's seconds, ascending.
    pub times: Vec<f64>,
    /// What its source calls each of its frames, ascending; without, they have no numbers but their places.
    pub numbers: Option<Vec<i64>>,
}

impl Clip {
    /// Makes the one frame of a scene that nothing moves.
    pub(in crate::formats) fn still() -> Self {
        Self::regular("rest".to_owned(), 0, 1)
    }

    /// Names the one clip of a file that names none.
    pub(crate) fn name_of(file: &Path) -> String {
        file.file_stem().unwrap_or_default().to_string_lossy().into_owned()
    }

    /// Makes a clip of `frame_len` frames from `first` on, at 30 a second.
    pub fn regular(name: String, first: usize, frame_len: usize) -> Self {
        let mut clip = Self { name, first, times: vec![0.0; frame_len], numbers: None };
        clip.play_at(RATE);
        clip
    }

    /// Makes a clip from `first` on of frames that its source calls by these numbers, ascending, at 30 a second.
    pub(crate) fn numbered(name: String, first: usize, numbers: Vec<i64>) -> Self {
        let mut clip =
            Self { name, first, times: vec![0.0; numbers.len()], numbers: Some(numbers) };
        clip.play_at(RATE);
        clip
    }

    /// Makes a clip from `first` on of frames at these times of its source, ascending.
    pub(in crate::formats) fn at(name: String, first: usize, times: &[f64]) -> Self {
        Self { name, first, times: times.to_vec(), numbers: None }
    }

    /// Plays it at so many frames a second: of the source's, where it numbers them, so that of every second
    /// frame each takes the time of two.
    pub fn play_at(&mut self, fps: f64) {
        self.times = self.places().map(|place| place / fps).collect();
    }

    /// Gives the one rate at which some clips play, as [`Clip::play_at`] takes it; none where they have no one rate, or
    /// no second frame.
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

    /// Counts the source's frames from the first to each.
    fn places(&self) -> impl Iterator<Item = f64> {
        (0..self.times.len()).map(|frame| match (self.number(0), self.number(frame)) {
            (Some(first), Some(number)) => number as f64 - first as f64,
            _ => frame as f64,
        })
    }

    /// Gives what its source calls its `frame`-th frame.
    pub fn number(&self, frame: usize) -> Option<i64> {
        self.numbers.as_ref()?.get(frame).copied()
    }

    /// Says what it is called and how many frames it has.
    pub(crate) fn describe(&self) -> String {
        format!("{}: {}", self.name, self.times.len())
    }
}

/// What of a scene is sampled, and when.
pub(crate) struct Sampling<'a> {
    /// Frames a second; at the keys where none is given.
    pub(crate) fps: Option<f64>,
    /// The clips to read; all of them where none is given.
    pub(crate) clips: &'a [String],
    /// Whether the scene's own posed positions are wanted.
    pub(crate) shapes: bool,
    /// Whether the one frame is what the scene shows without any clip.
    pub(crate) still: bool,
    /// Whether clips are sampled to be played, and not to be learned from.
    pub(crate) played: bool,
}

impl Sampling<'_> {
    /// Tells whether a clip is to be read.
    pub(crate) fn takes(&self, clip: &str) -> bool {
        self.clips.is_empty() || self.clips.iter().any(|wanted| wanted == clip)
    }

    /// Names a clip that was asked for and is not there.
    ///
    /// # Errors
    /// [`SceneError::UnknownClip`], and [`SceneError::NoAnimation`] where there is none at all.
    pub(crate) fn check(&self, known: Vec<String>) -> Result<(), SceneError> {
        if known.is_empty() {
            return Err(SceneError::NoAnimation);
        }
        match self.clips.iter().find(|name| !known.contains(name)) {
            Some(name) => Err(SceneError::UnknownClip { name: name.clone(), known }),
            None => Ok(()),
        }
    }
}

/// Keys nearer than this, in seconds, are one: files hold times in single precision.
pub(super) const SAME_TIME: f64 = 1e-5;
/// Steps between keys are even while they differ by less than this share.
pub(crate) const EVEN: f64 = 0.01;
/// Most frames of a clip: ten hours at thirty a second.
const FRAMES_MAX: f64 = 1_080_000.0;

/// Chooses the times at which the clip `name` is sampled, in seconds, ascending: its keys, of which
/// `keys` holds those of every channel in any order, or as many a second as asked for.
///
/// # Errors
/// [`SceneError::KeyTimes`] for keys that are not finite or reach too far.
pub(in crate::formats) fn sample_times(
    name: &str,
    mut keys: Vec<f64>,
    sampling: &Sampling<'_>,
) -> Result<Vec<f64>, SceneError> {
    keys.sort_by(f64::total_cmp);
    keys.dedup_by(|next, kept| *next - *kept < SAME_TIME);
    let (first, last) = match (keys.first(), keys.last()) {
        (Some(&first), Some(&last)) => (first, last),
        _ => return Ok(keys),
    };
    let Some(fps) = sampling.fps else {
        let finite = first.is_finite() && last.is_finite();
        return if finite { Ok(keys) } else { Err(SceneError::KeyTimes { clip: name.to_owned() }) };
    };
    let frames = ((last - first) * fps + EVEN).floor();
    // Not finite keys fail here too.
    if !(0.0..FRAMES_MAX).contains(&frames) {
        return Err(SceneError::KeyTimes { clip: name.to_owned() });
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

    fn sample(keys: &[f64], fps: Option<f64>) -> Result<Vec<f64>, SceneError> {
        sample_times(
            "walk",
            keys.to_vec(),
            &Sampling { fps, clips: &[], shapes: true, still: false, played: false },
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
        // A third of a second does not divide a clip of single-precision keys evenly.
        let keys = [0.0, f64::from(1.0_f32 / 3.0), f64::from(2.0_f32 / 3.0)];
        assert_eq!(sample(&keys, Some(3.0)).unwrap().len(), 3);
    }

    #[test]
    fn times_without_end_are_refused() {
        for keys in [[0.0, f64::INFINITY], [0.0, f64::NAN], [f64::NEG_INFINITY, 0.0]] {
            assert!(matches!(sample(&keys, None), Err(SceneError::KeyTimes { .. })));
            assert!(matches!(sample(&keys, Some(30.0)), Err(SceneError::KeyTimes { .. })));
        }
        assert!(matches!(sample(&[0.0, 1e30], Some(30.0)), Err(SceneError::KeyTimes { .. })));
    }
}
