//! The golden filter, and its hash over seeded signals, which is equal on all CPUs.

use super::{Rng, add, cut};
use sinew_runtime::filter::Samples;
use sinew_runtime::{CallError, Filter, Model};

/// A file of a filter that multiplies the sample rate of a sensor's signal by four.
pub(crate) const FILTER: &[u8] = include_bytes!("filter-11.snw");

/// Hash of the filter, the promise of METHOD §7: change it only with a reason that the commit
/// states.
pub(crate) const BITS: u64 = 0x50fb_0458_9f2c_00b9;

/// Signals per hash and number of lanes.
const SIGNALS: usize = 16;
/// Samples of a signal.
const SAMPLES: usize = 9;
/// Numbers of lanes: scalar code, SIMD code, and both.
const LANES: [usize; 3] = [1, 8, 11];

/// Hashes the filter's output on seeded signals; `nudge` is added to each sample.
///
/// # Errors
/// Errors of the call; a length error if the filter does not fit in the memory.
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

/// Loads the golden filter; `None` on failure.
pub(crate) fn load() -> Option<Model<&'static [u8]>> {
    Model::from_bytes(FILTER).ok()
}
