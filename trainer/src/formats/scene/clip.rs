//! Runs of frames that play one after another.

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
}
