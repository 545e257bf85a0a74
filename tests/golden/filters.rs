//! The golden filter, and its bits over seeded signals, which all CPUs agree on.

use super::{Rng, add, cut};
use sinew_runtime::filter::Samples;
use sinew_runtime::{CallError, Filter, Model};

/// A file of a filter that makes a sensor's signal four times as fine.
pub(crate) const FILTER: &[u8] = include_bytes!("filter-8.snw");

/// A hash of it. Change it only with a reason that the commit states: it is the promise of METHOD §7.
pub(crate) const BITS: u64 = 0x50fb_0458_9f2c_00b9;

/// Signals of a hash, of each number of lanes.
const SIGNALS: usize = 16;
/// Samples of a signal.
const SAMPLES: usize = 9;
/// Lanes: one by one, side by side, and both.
const LANES: [usize; 3] = [1, 8, 11];

/// Hashes signals that a filter makes finer; `nudge` is added to each sample.
///
/// # Errors
/// Those of the call; lengths, if the filter is larger than the memory.
pub(crate) fn hash(
    filter: &Filter<'_>,
    nudge: f32,
    scratch: &mut [f32],
    out: &mut [f32],
) -> Result<u64, CallError> {
    let mut hash = 0;
    let mut rng = Rng(1960);
    for lane_len in LANES {
        for _ in 0..SIGNALS {
            let shape = Samples { signal_len: 1, sample_len: SAMPLES, lane_len };
            let samples = cut(scratch, SAMPLES * lane_len);
            samples.iter_mut().for_each(|x| *x = 3.0 * rng.unit() + nudge);
            let fine = cut(out, SAMPLES * lane_len * filter.factor());
            filter.apply(shape, samples, fine)?;
            add(&mut hash, fine);
        }
    }
    Ok(hash)
}

/// Loads the golden filter; `None` if that fails.
pub(crate) fn load() -> Option<Model<&'static [u8]>> {
    Model::from_bytes(FILTER).ok()
}
