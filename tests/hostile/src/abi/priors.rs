//! The functions of priors and pins, and their arguments.

use super::arena::bytes;
use super::call::Call;
use super::expected::{FEW_PINS, PINS, PinArguments};
use super::shared::{laid, optional, unknown};
use crate::recipe;
use arbitrary::Result;
use sinew_capi::*;
use sinew_runtime::{Model, Skin};
use std::ptr::{null, null_mut};

use sinew_argument as Argument;

pub(super) fn describe(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let (prior, out) = (call.prior()?, call.output_one(Argument::Result)?);
    let error = call.ready(unknown);
    // SAFETY: as for each call of `functions`.
    Ok(unsafe { sinew_prior_describe(prior, out, error) })
}

pub(super) fn place(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let skin = call.skin()?;
    let vertex = call.number(call.arena.frame.vertex_len, Argument::Vertices)?;
    let vertex = u32::try_from(vertex).unwrap_or(u32::MAX);
    let p = call.arena.frame.skin_palette.len();
    let (palette, palette_len) =
        call.input(call.arena.skin_palette.clone(), p, Argument::Palette)?;
    let (weights, weights_len) =
        call.input_any(call.arena.weights.clone(), Argument::ShapeWeights)?;
    let out = call.output_one(Argument::Result)?;
    let error = call.ready(|arena| {
        let model = Model::from_bytes(arena.file_bytes()).ok();
        let skin = model.as_ref().and_then(|model| model.first::<Skin>());
        let frame = &arena.frame;
        let place = skin.and_then(|skin| skin.place(vertex, &frame.skin_palette, &frame.weights));
        bytes(place.into_iter().flatten())
    });
    // SAFETY: as above.
    Ok(unsafe {
        sinew_skin_place(skin, vertex, palette, palette_len, weights, weights_len, out, error)
    })
}

pub(super) fn solve(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let (prior, skin) = (call.prior()?, call.skin()?);
    let p = call.arena.frame.skin_palette.len();
    let (palette, palette_len) =
        call.input(call.arena.skin_palette.clone(), p, Argument::Palette)?;
    let arguments = arguments(call)?;
    let (pins, pins_len) = pins_pointer(call, &arguments.pins)?;
    let n = call.arena.frame.weights.len();
    let place = call.arena.weights.clone();
    let (last_weights, last_len) = match &arguments.last {
        Some(last) => {
            call.arena.write(place.start, &bytes(last.iter().copied()));
            call.input(place, n, Argument::ShapeWeights)?
        }
        None => (null(), 0),
    };
    call.arena.write(call.next_result, &bytes(arguments.weights.iter().copied()));
    let (weights, weights_len) = call.output_exact::<f32>(n, n, Argument::ShapeWeights)?;
    let edit: *mut sinew_edit =
        if call.one_in(4)? { null_mut() } else { optional(call, Argument::Result)? };
    let least = call.arena.frame.prior.as_ref().map_or(0, |prior| arguments.scratch_len(prior));
    let (scratch, scratch_len) = call.output::<f64>(least, Argument::Scratch)?;
    call.used = call.arena.place(scratch, scratch_len);
    let place = call.arena.argument.start;
    let job = call.arena.at::<sinew_pin_job>(place);
    // SAFETY: the place is aligned and large enough, and the structure has no padding.
    unsafe {
        job.write(sinew_pin_job {
            prior,
            skin,
            palette,
            palette_len,
            pins,
            pins_len,
            is_from_mean: arguments.is_from_mean.into(),
            is_bounded: arguments.is_bounded.into(),
            cancels: arguments.cancels.into(),
            beta: arguments.beta,
            symmetry: arguments.symmetry,
            temporal: arguments.temporal,
            last_weights,
            last_len,
            scratch,
            scratch_len,
            weights,
            weights_len,
        });
    }
    // Other bytes would be pointers to memory that the caller does not own.
    let job = call.input_fixed(place, Argument::Job)?;
    let right = call.by_runtime(|arena| {
        let (weights, done) = arguments.solve(arena.file_bytes(), &arena.frame.skin_palette)?;
        let numbers = [done.unreachable_len as u32, done.round_len, done.is_least.into()];
        let numbers = numbers.into_iter().flat_map(u32::to_ne_bytes);
        let edit_bytes = bytes([done.norm]).into_iter().chain(numbers);
        let edit_bytes = if edit.is_null() { Vec::new() } else { edit_bytes.collect() };
        Ok(laid([bytes(weights), edit_bytes]))
    });
    let error = call.ready(|_| right);
    // SAFETY: as above.
    Ok(unsafe { sinew_pins_solve(job, edit, error) })
}

/// Draws a pin job: mostly pins near vertices of the skin, and valid weights of the terms.
fn arguments(call: &mut Call<'_, '_>) -> Result<PinArguments> {
    let frame = &call.arena.frame;
    let (v, own_beta) = (frame.vertex_len, frame.prior.as_ref().map_or(1.0, |prior| prior.beta));
    let mut weights = [frame.weights.clone(), frame.weights.clone()];
    let pin_len = if call.one_in(16)? { PINS } else { call.u.int_in_range(0..=FEW_PINS)? };
    let mut pins = Vec::new();
    for at in 0..pin_len {
        // Most pins are copies, because each drawn pin uses up input bytes.
        let pin = if at < FEW_PINS { pin(call, v)? } else { pins[at - 1] };
        pins.push(pin);
    }
    let beta = if call.one_in(16)? { recipe::float(call.u)? } else { own_beta };
    let mut term = || match call.one_in(16)? {
        true => recipe::float(call.u),
        false => Ok(0.5 * f32::from(call.u.int_in_range(0..=3u8)?)),
    };
    let (symmetry, temporal) = (term()?, term()?);
    for weights in &mut weights {
        if call.one_in(16)? {
            let float = recipe::float(call.u)?;
            weights.iter_mut().take(1).for_each(|weight| *weight = float);
        }
    }
    let [last, weights] = weights;
    Ok(PinArguments {
        pins,
        is_from_mean: call.one_in(2)?,
        is_bounded: call.one_in(2)?,
        cancels: call.one_in(2)?,
        beta,
        symmetry,
        temporal,
        last: if call.one_in(2)? { Some(last) } else { None },
        weights,
    })
}

/// Draws a pin.
fn pin(call: &mut Call<'_, '_>, vertex_len: usize) -> Result<sinew_pin> {
    let vertex = match call.one_in(16)? {
        true => u32::try_from(vertex_len).unwrap_or(u32::MAX),
        false => call.u.choose_index(vertex_len.max(1))? as u32,
    };
    let mut rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    if call.one_in(4)? {
        rows[call.u.choose_index(3)?] = [0.0; 4];
    }
    let mut target = [0.25, 0.5, -0.125];
    if call.one_in(4)? {
        target[call.u.choose_index(3)?] = recipe::float(call.u)?;
    }
    let stiffness = if call.one_in(8)? { recipe::float(call.u)? } else { 1.0 };
    Ok(sinew_pin { vertex, rows, target, stiffness })
}

/// Draws the pointer to the pins.
fn pins_pointer(call: &mut Call<'_, '_>, pins: &[sinew_pin]) -> Result<(*const sinew_pin, usize)> {
    let start = call.arena.pins.start;
    let content = pins.iter().flat_map(|pin| {
        let floats = bytes(pin.rows.as_flattened().iter().chain(&pin.target).copied());
        let vertex = pin.vertex.to_ne_bytes().into_iter();
        vertex.chain(floats).chain(pin.stiffness.to_ne_bytes()).collect::<Vec<_>>()
    });
    let content = content.collect::<Vec<_>>();
    if call.arena.frame.prior.is_none() {
        // There is no room for the pins, and no prior to solve for.
        return Ok((null(), 0));
    }
    call.arena.write(start, &content);
    call.input_any(start..start + content.len(), Argument::Pins)
}
