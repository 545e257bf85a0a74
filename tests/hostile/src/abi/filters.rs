//! The filter functions and their arguments.

use super::arena::bytes;
use super::call::Call;
use super::expected::SAMPLES_MAX;
use super::shared::unknown;
use crate::recipe;
use arbitrary::Result;
use sinew_capi::*;
use sinew_runtime::filter::Samples;
use sinew_runtime::{Filter, Model};

use sinew_argument as Argument;
use sinew_status as Status;

pub(super) fn describe(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let (filter, out) = (call.filter()?, call.output_one(Argument::Result)?);
    let error = call.ready(unknown);
    // SAFETY: as for each call of `functions`.
    Ok(unsafe { sinew_filter_describe(filter, out, error) })
}

pub(super) fn apply(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let filter = call.filter()?;
    let own = call.arena.frame.filter.as_ref();
    let (factor, tap_len) = own.map_or((0, 0), |own| (own.factor, own.tap_len));
    let shape = shape(call, tap_len)?;
    let Samples { signal_len, sample_len, lane_len } = shape;
    let len = signal_len * sample_len * lane_len;
    let mut samples: Vec<f32> = (0..len).map(|at| 0.25 * (at % 7) as f32 - 0.5).collect();
    if call.one_in(4)? {
        let at = call.u.choose_index(len.max(1))?;
        let float = recipe::float(call.u)?;
        samples.iter_mut().skip(at).take(1).for_each(|sample| *sample = float);
    }
    let start = call.arena.samples.start;
    call.arena.write(start, &bytes(samples.iter().copied()));
    let place = call.arena.argument.start;
    let at = call.arena.at::<sinew_samples>(place);
    // SAFETY: the place is aligned and large enough, and the structure has no padding.
    unsafe { at.write(sinew_samples { signal_len, sample_len, lane_len }) };
    // Other bytes would be numbers whose effect is unknown.
    let at_shape = call.input_fixed(place, Argument::Shape)?;
    let (given, given_len) = call.input(start..start + 4 * len, len, Argument::Samples)?;
    let (out, out_len) = call.output_exact(factor * len, factor * len, Argument::Outputs)?;
    let right = call.by_runtime(|arena| {
        let Ok(model) = Model::from_bytes(arena.file_bytes()) else { return Ok(Vec::new()) };
        let Some(filter) = model.first::<Filter>() else { return Ok(Vec::new()) };
        let mut fine = vec![f32::NAN; factor * len];
        filter.apply(shape, &samples, &mut fine)?;
        Ok(bytes(fine))
    });
    let error = call.ready(|_| right);
    // SAFETY: as above.
    Ok(unsafe { sinew_filter_apply(filter, at_shape, given, given_len, out, out_len, error) })
}

/// Draws the shape of samples.
fn shape(call: &mut Call<'_, '_>, tap_len: usize) -> Result<Samples> {
    let [signals, more, lanes] = SAMPLES_MAX;
    let is_short = tap_len > 0 && call.one_in(8)?;
    call.fault_if(is_short, Status::TooShort, Argument::Samples);
    let sample_len =
        if is_short { tap_len - 1 } else { tap_len + call.u.int_in_range(0..=more)? };
    let (signal_len, lane_len) =
        (call.u.int_in_range(0..=signals)?, call.u.int_in_range(0..=lanes)?);
    Ok(Samples { signal_len, sample_len, lane_len })
}
