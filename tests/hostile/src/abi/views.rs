//! The functions of views, with the arguments that they take.

use super::arena::{BLANK, bytes};
use super::call::Call;
use super::shared::{laid, optional, unknown, wanted};
use super::viewed::{AskedFrame, AskedPicture, PIXELS, Viewed};
use crate::recipe;
use arbitrary::Result;
use sinew_capi::*;
use std::ptr::null_mut;

use sinew_argument as Argument;
use sinew_status as Status;

/// Width of a picture.
const WIDTH: usize = 12;

pub(super) fn open(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let own = call.arena.frame.views.as_ref().map(|views| views.name.clone());
    let model = call.model()?;
    let (is_there, own) = (own.is_some(), own.unwrap_or_default());
    let (name, name_len, index) = wanted(call, is_there, own, Argument::Views)?;
    let (memory, bytes) = call.memory(sinew_views_bytes())?;
    let out = call.output_one(Argument::Result)?;
    let error = call.ready(unknown);
    // SAFETY: as for each call of `functions`: pointers are null, misaligned, or into the arena, with
    // lengths that stay within it or reach beyond the address space; handles are null, misaligned, or
    // point to enough of it, where an object is loaded or the memory is blank or empty.
    Ok(unsafe { sinew_views_open(model, name, name_len, index, memory, bytes, out, error) })
}

pub(super) fn describe(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let (views, out) = (call.views()?, call.output_one(Argument::Result)?);
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe { sinew_views_describe(views, out, error) })
}

pub(super) fn map(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let views = call.views()?;
    let map = call.number(own(call, |views| views.maps.len()), Argument::Map)?;
    let out = call.output_one(Argument::Result)?;
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe { sinew_views_map(views, map, out, error) })
}

pub(super) fn frame(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let views = call.views()?;
    let (asked, least) = asked_frame(call)?;
    let start = call.arena.parameters.start;
    let content = bytes(asked.parameters.iter().copied());
    call.arena.write(start, &content);
    let right = asked.parameters.len();
    let (parameters, parameters_len) =
        call.input(start..start + content.len(), right, Argument::Query)?;
    let (k, n) = (own(call, |views| views.points.len()), own(call, |views| views.scores.len()));
    let (points, points_len) = call.output_exact(k, k, Argument::Points)?;
    let (visibility, visibility_len) = call.output_exact(k, k, Argument::Visibility)?;
    let (scores, scores_len) = call.output_exact(n, n, Argument::Scores)?;
    let found = call.output_one(Argument::Result)?;
    let (scratch, scratch_len) = call.output(least, Argument::Scratch)?;
    call.used = call.arena.place(scratch, scratch_len);
    let last_view = match asked.last {
        Some(last) => last,
        None => call.u.arbitrary()?,
    };
    let place = call.arena.argument.start;
    let job = call.arena.at::<sinew_frame_job>(place);
    // SAFETY: the place is aligned and large enough, and the structure has no padding.
    unsafe {
        job.write(sinew_frame_job {
            views,
            map: asked.map,
            parameters,
            parameters_len,
            last_view,
            has_last: asked.last.is_some().into(),
            margin: asked.margin,
            scratch,
            scratch_len,
            points,
            points_len,
            visibility,
            visibility_len,
            scores,
            scores_len,
        });
    }
    // Any other bytes would be pointers to no memory of the caller.
    let job = call.input_fixed(place, Argument::Job)?;
    let right = call.by_runtime(|arena| {
        let Some(given) = asked.frame(arena.file_bytes())? else { return Ok(Vec::new()) };
        let confidence = bytes([given.found.confidence]);
        Ok(laid([
            bytes(given.points.into_iter().flatten()),
            bytes(given.visibility),
            bytes(given.scores),
            given.found.view.to_ne_bytes().into_iter().chain(confidence).collect(),
        ]))
    });
    let error = call.ready(|_| right);
    // SAFETY: as above.
    Ok(unsafe { sinew_views_frame(job, found, error) })
}

/// Draws what a frame is asked for, and the scratch that it needs.
fn asked_frame(call: &mut Call<'_, '_>) -> Result<(AskedFrame, usize)> {
    let map = call.number(own(call, |views| views.maps.len()), Argument::Map)?;
    let found = call.arena.frame.views.as_ref().and_then(|views| views.maps.get(map));
    let (mut parameters, scratch_len) = match found {
        Some(map) => (map.parameters.clone(), map.scratch_len),
        None => (Vec::new(), 0),
    };
    match call.u.int_in_range(0..=7)? {
        0 => {
            let at = call.u.choose_index(parameters.len().max(1))?;
            let float = recipe::float(call.u)?;
            parameters.iter_mut().skip(at).take(1).for_each(|parameter| *parameter = float);
        }
        // A rotation among them has no direction.
        1 => parameters.fill(0.0),
        _ => {}
    }
    let n = own(call, |views| views.scores.len());
    let last = if call.one_in(2)? { Some(call.number(n, Argument::Scores)?) } else { None };
    let margin = if call.one_in(16)? {
        recipe::float(call.u)?
    } else {
        call.arena.frame.views.as_ref().map_or(0.0, |views| views.margin)
    };
    Ok((AskedFrame { map, parameters, last, margin }, scratch_len))
}

pub(super) fn render(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let views = call.views()?;
    let asked = asked_picture(call)?;
    let (k, n) = (own(call, |views| views.points.len()), own(call, |views| views.scores.len()));
    let places = [&call.arena.points, &call.arena.visibility, &call.arena.scores];
    let [at_points, at_visibility, at_scores] = places.map(Clone::clone);
    call.arena.write(at_points.start, &bytes(asked.points.as_flattened().iter().copied()));
    let (points, points_len) = call.input(at_points, k, Argument::Points)?;
    let (visibility, visibility_len) = call.input(at_visibility, k, Argument::Visibility)?;
    let (scores, scores_len) = call.input(at_scores, n, Argument::Scores)?;
    let len = if call.arena.frame.views.is_some() { PIXELS } else { 0 };
    let (pixels, pixels_len) = call.output_any::<[u8; 4]>(len, Argument::Pixels)?;
    let rows = pixels_len.checked_div(asked.width).unwrap_or_default();
    call.fault_if(rows * asked.width != pixels_len, Status::Length, Argument::Pixels);
    let (mut depths, mut depths_len) = (null_mut(), 0);
    if asked.has_depths {
        call.arena.write(call.next_result, &bytes([f32::INFINITY; PIXELS])[..4 * len]);
        (depths, depths_len) = call.output_exact(len, pixels_len, Argument::Depths)?;
    }
    let drawn: *mut sinew_drawn =
        if call.one_in(4)? { null_mut() } else { optional(call, Argument::Result)? };
    let e = own(call, |views| views.element_len);
    let (order, order_len) = match asked.has_depths {
        true => call.output_any(e, Argument::Scratch)?,
        false => call.output_exact(e, e, Argument::Scratch)?,
    };
    let place = call.arena.argument.start;
    let job = call.arena.at::<sinew_render_job>(place);
    // SAFETY: the place is aligned and large enough, and the structure has no padding.
    unsafe {
        job.write(sinew_render_job {
            views,
            points,
            points_len,
            visibility,
            visibility_len,
            scores,
            scores_len,
            view: asked.view,
            width: asked.width,
            pixels,
            pixels_len,
            depths,
            depths_len,
            order,
            order_len,
        });
    }
    // Any other bytes would be pointers to no memory of the caller.
    let job = call.input_fixed(place, Argument::Job)?;
    let right = call.by_runtime(|arena| {
        let Some(own) = &arena.frame.views else { return Ok(Vec::new()) };
        let mut pixels = vec![[BLANK; 4]; len];
        let mut depths = vec![f32::INFINITY; len];
        let told = asked.draw(arena.file_bytes(), own, &mut pixels, &mut depths)?;
        let told = told.filter(|_| !drawn.is_null());
        let told = told.into_iter().flat_map(|told| [told.element_len, told.flipped_len]);
        let told = told.flat_map(usize::to_ne_bytes).collect();
        let pixels = pixels.into_iter().flatten().collect();
        Ok(match asked.has_depths {
            true => laid([pixels, bytes(depths), told]),
            false => laid([pixels, told]),
        })
    });
    let error = call.ready(|_| right);
    // SAFETY: as above.
    Ok(unsafe { sinew_views_render(job, drawn, error) })
}

/// Draws what a picture is asked for: mostly the frame's points.
fn asked_picture(call: &mut Call<'_, '_>) -> Result<AskedPicture> {
    let mut points =
        call.arena.frame.views.as_ref().map_or(Vec::new(), |views| views.points.clone());
    if call.one_in(8)? {
        let at = call.u.choose_index(points.len().max(1))?;
        let (axis, float) = (call.u.choose_index(3)?, recipe::float(call.u)?);
        points.iter_mut().skip(at).take(1).for_each(|point| point[axis] = float);
    }
    let n = own(call, |views| views.scores.len());
    Ok(AskedPicture {
        points,
        view: call.number(n, Argument::Scores)?,
        width: if call.one_in(8)? { call.u.int_in_range(0..=2 * WIDTH)? } else { WIDTH },
        has_depths: call.one_in(2)?,
    })
}

/// Asks the first views; where there are none, for none.
fn own(call: &Call<'_, '_>, ask: impl FnOnce(&Viewed) -> usize) -> usize {
    call.arena.frame.views.as_ref().map_or(0, ask)
}
