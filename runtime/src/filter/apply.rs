//! A filter on samples: one after the other, in as many lanes as there are beside each other.

use super::view::Filter;
use crate::error::{Argument, CallError, CallErrorKind};
use crate::format::MAGNITUDE_MAX;
use crate::linear::Le;

/// How samples lie: `signal_len` signals one after the other, each of `sample_len` rows of `lane_len` numbers.
///
/// A signal by itself has one lane. An image of H rows of W pixels of C channels has W C lanes along its columns, where
/// it is one signal of H rows; along its rows it is H signals of W rows of C lanes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Samples {
    /// Signals, one after the other.
    pub signal_len: usize,
    /// Samples of each signal.
    pub sample_len: usize,
    /// Numbers of each sample, each of which goes by itself.
    pub lane_len: usize,
}

/// Lanes that are summed side by side.
const WIDE: usize = 8;

impl Samples {
    /// Makes those of a signal by itself.
    pub const fn of_signal(sample_len: usize) -> Self {
        Self { signal_len: 1, sample_len, lane_len: 1 }
    }

    /// Counts the numbers; `usize::MAX` stands for more.
    const fn len(&self) -> usize {
        self.signal_len.saturating_mul(self.sample_len).saturating_mul(self.lane_len)
    }
}

impl Filter<'_> {
    /// Makes samples F times as fine.
    ///
    /// Fine sample `F i + p` is the sum, first to last, of the N coarse samples of the window of coarse sample i times
    /// the taps of its place there and of phase p (METHOD §4). Two calls make an image finer, one along its columns and
    /// one along its rows.
    ///
    /// - `shape`: how `samples` lie; what is written lies likewise, with F times as many samples a signal.
    /// - `samples`: the numbers.
    /// - `out`: where to write F times as many.
    ///
    /// # Errors
    /// - [`CallErrorKind::TooShort`]: a signal has fewer than N samples.
    /// - [`CallErrorKind::Length`]: `samples` or `out` has another length.
    /// - [`CallErrorKind::NonFinite`]: a number is not finite, or larger than [`MAGNITUDE_MAX`].
    pub fn apply(&self, shape: Samples, samples: &[f32], out: &mut [f32]) -> Result<(), CallError> {
        Argument::Samples.check_least(self.tap_len(), shape.sample_len)?;
        Argument::Samples.check_len(shape.len(), samples.len())?;
        Argument::Outputs.check_len(shape.len().saturating_mul(self.factor()), out.len())?;
        let is_sound = |x: &f32| x.abs() <= MAGNITUDE_MAX;
        if let Some(at) = samples.iter().position(|x| !is_sound(x)) {
            return Err(CallError::new(CallErrorKind::NonFinite, Argument::Samples).at(at));
        }
        let Samples { sample_len, lane_len, .. } = shape;
        // Of no number there is nothing to make; chunks of none would panic.
        let coarse = samples.chunks_exact((sample_len * lane_len).max(1));
        let fine = out.chunks_exact_mut((sample_len * self.factor() * lane_len).max(1));
        for (coarse, fine) in coarse.zip(fine) {
            self.apply_to_signal(shape, coarse, fine);
        }
        Ok(())
    }

    /// Makes one signal finer. `None` stands for what a loaded filter does not have.
    fn apply_to_signal(&self, shape: Samples, coarse: &[f32], fine: &mut [f32]) -> Option<()> {
        let Samples { sample_len, lane_len, .. } = shape;
        let (tap_len, factor, taps) = (self.tap_len(), self.factor(), self.taps());
        let fine = fine.chunks_exact_mut((factor * lane_len).max(1));
        for (sample, fine) in (0..sample_len).zip(fine) {
            let (start, place) = self.window(sample, sample_len);
            let window = coarse.get(start * lane_len..)?.get(..tap_len * lane_len)?;
            let phases = taps.get(place * factor * tap_len..)?.chunks_exact(tap_len.max(1));
            for (taps, out) in phases.zip(fine.chunks_exact_mut(lane_len.max(1))) {
                sum_lanes(taps, window, out);
            }
        }
        Some(())
    }
}

/// Sums a window's samples times their taps, lane by lane.
fn sum_lanes(taps: &[Le], window: &[f32], out: &mut [f32]) {
    let lane_len = out.len();
    let (wide, rest) = out.as_chunks_mut::<WIDE>();
    for (chunk, out) in wide.iter_mut().enumerate() {
        *out = sums(taps, window, lane_len, WIDE * chunk);
    }
    let first = lane_len - rest.len();
    for (lane, out) in rest.iter_mut().enumerate() {
        [*out] = sums(taps, window, lane_len, first + lane);
    }
}

/// Sums L lanes from one of them on, one tap after the other.
#[inline(always)]
fn sums<const L: usize>(taps: &[Le], window: &[f32], lane_len: usize, first: usize) -> [f32; L] {
    let mut sums = [0.0; L];
    for (tap, row) in taps.iter().zip(window.chunks_exact(lane_len.max(1))) {
        let tap = f32::from_le_bytes(*tap);
        let lanes = row.get(first..).and_then(<[f32]>::first_chunk::<L>);
        for (sum, x) in sums.iter_mut().zip(lanes.unwrap_or(&[0.0; L])) {
            *sum += tap * x;
        }
    }
    sums
}
