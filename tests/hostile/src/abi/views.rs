//! The functions of views and their arguments.

use super::arena::{BLANK, bytes};
use super::call::Call;
use super::expected::{FrameArguments, PIXELS, PictureArguments, ViewsCase};
use super::shared::{laid, optional, unknown};
use crate::recipe;
use arbitrary::Result;
use sinew_capi::*;
use std::ptr::null_mut;

use sinew_argument as Argument;
use sinew_status as Status;

/// Width of a picture.
const WIDTH: usize = 12;

pub(super) fn describe(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let (views, out) = (call.views()?, call.output_one(Argument::Result)?);
    let error = call.ready(unknown);
    // SAFETY: as for each call of `functions`.
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
    let (arguments, least) = frame_arguments(call)?;
    let start = call.arena.parameters.start;
    let content = bytes(arguments.parameters.iter().copied());
    call.arena.write(start, &content);
    let right = arguments.parameters.len();
    let (parameters, parameters_len) =
        call.input(start..start + content.len(), right, Argument::Query)?;
    let (k, n) = (own(call, |views| views.points.len()), own(call, |views| views.scores.len()));
    let (points, points_len) = call.output_exact(k, k, Argument::Points)?;
    let (visibility, visibility_len) = call.output_exact(k, k, Argument::Visibility)?;
    let (scores, scores_len) = call.output_exact(n, n, Argument::Scores)?;
    let l = own(call, |views| views.layers.len());
    let (layers, layers_len) = call.output_exact(l, l, Argument::Layers)?;
    let found = call.output_one(Argument::Result)?;
    let (scratch, scratch_len) = call.output(least, Argument::Scratch)?;
    call.used = call.arena.place(scratch, scratch_len);
    let place = call.arena.argument.start;
    let job = call.arena.at::<sinew_frame_job>(place);
    // SAFETY: the place is aligned and large enough, and the structure has no padding.
    unsafe {
        job.write(sinew_frame_job {
            views,
            map: arguments.map,
            parameters,
            parameters_len,
            scratch,
            scratch_len,
            points,
            points_len,
            visibility,
            visibility_len,
            scores,
            scores_len,
            layers,
            layers_len,
        });
    }
    // Other bytes would be pointers to memory that the caller does not own.
    let job = call.input_fixed(place, Argument::Job)?;
    let right = call.by_runtime(|arena| {
        let Some(given) = arguments.frame(arena.file_bytes())? else { return Ok(Vec::new()) };
        let confidence = bytes([given.found.confidence]);
        Ok(laid([
            bytes(given.points.into_iter().flatten()),
            bytes(given.visibility),
            bytes(given.scores),
            bytes(given.layers.into_iter().flatten()),
            given.found.view.to_ne_bytes().into_iter().chain(confidence).collect(),
        ]))
    });
    let error = call.ready(|_| right);
    // SAFETY: as above.
    Ok(unsafe { sinew_views_frame(job, found, error) })
}

/// Draws the arguments of a frame job, and the length of its scratch.
fn frame_arguments(call: &mut Call<'_, '_>) -> Result<(FrameArguments, usize)> {
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
        // Zeros make a rotation without a direction.
        1 => parameters.fill(0.0),
        _ => {}
    }
    Ok((FrameArguments { map, parameters }, scratch_len))
}

pub(super) fn render(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let views = call.views()?;
    let arguments = picture_arguments(call)?;
    let (k, n) = (own(call, |views| views.points.len()), own(call, |views| views.scores.len()));
    let l = own(call, |views| views.layers.len());
    let [at_points, at_visibility] = [&call.arena.points, &call.arena.visibility].map(Clone::clone);
    let [at_scores, at_layers] = [&call.arena.scores, &call.arena.layers].map(Clone::clone);
    call.arena.write(at_points.start, &bytes(arguments.points.as_flattened().iter().copied()));
    call.arena.write(at_layers.start, &bytes(arguments.layers.as_flattened().iter().copied()));
    let (points, points_len) = call.input(at_points, k, Argument::Points)?;
    let (visibility, visibility_len) = call.input(at_visibility, k, Argument::Visibility)?;
    let (scores, scores_len) = call.input(at_scores, n, Argument::Scores)?;
    let (layers, layers_len) = call.input(at_layers, l, Argument::Layers)?;
    let len = if call.arena.frame.views.is_some() { PIXELS } else { 0 };
    let (pixels, pixels_len) = call.output_any::<[u8; 4]>(len, Argument::Pixels)?;
    let rows = pixels_len.checked_div(arguments.width).unwrap_or_default();
    call.fault_if(rows * arguments.width != pixels_len, Status::Length, Argument::Pixels);
    let drawn: *mut sinew_drawn =
        if call.one_in(4)? { null_mut() } else { optional(call, Argument::Result)? };
    let (v, order_len) = (own(call, |views| views.vertex_len), own(call, |views| views.order_len));
    let (vertices, vertices_len) = call.output_exact(v, v, Argument::Vertices)?;
    let (order, order_len) = call.output_exact(order_len, order_len, Argument::Scratch)?;
    let has_depth = own(call, |views| views.has_depth.into()) > 0;
    let (depths, depths_len) = by_pixel(call, has_depth, len, pixels_len, Argument::Depths)?;
    let has_groups = own(call, |views| views.has_groups.into()) > 0;
    let (group, group_len) = by_pixel(call, has_groups, len, pixels_len, Argument::Group)?;
    let has_clips = own(call, |views| views.has_clips.into()) > 0;
    let (clips, clips_len) = by_pixel(call, has_clips, len, pixels_len, Argument::Clips)?;
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
            layers,
            layers_len,
            width: arguments.width,
            pixels,
            pixels_len,
            vertices,
            vertices_len,
            order,
            order_len,
            depths,
            depths_len,
            group,
            group_len,
            clips,
            clips_len,
        });
    }
    // Other bytes would be pointers to memory that the caller does not own.
    let job = call.input_fixed(place, Argument::Job)?;
    let right = call.by_runtime(|arena| {
        let Some(own) = &arena.frame.views else { return Ok(Vec::new()) };
        let mut pixels = vec![[BLANK; 4]; len];
        let counts = arguments.draw(arena.file_bytes(), own, &mut pixels)?;
        let counts = counts.filter(|_| !drawn.is_null());
        let counts = counts.into_iter().flat_map(|counts| [counts.element_len, counts.flipped_len]);
        let counts = counts.flat_map(usize::to_ne_bytes).collect();
        Ok(laid([pixels.into_iter().flatten().collect(), counts]))
    });
    let error = call.ready(|_| right);
    // SAFETY: as above.
    Ok(unsafe { sinew_views_render(job, drawn, error) })
}

/// Draws scratch with one element per pixel. The job needs at least `pixels_len` elements, or none
/// if it does not use this scratch. Room is for `len`.
fn by_pixel<T>(
    call: &mut Call<'_, '_>,
    is_asked: bool,
    len: usize,
    pixels_len: usize,
    argument: Argument,
) -> Result<(*mut T, usize)> {
    let len = if is_asked || call.one_in(4)? { len } else { 0 };
    call.output_least(len, if is_asked { pixels_len } else { 0 }, argument)
}

/// Draws the arguments of a render job: mostly points and layers of the frame.
fn picture_arguments(call: &mut Call<'_, '_>) -> Result<PictureArguments> {
    let views = call.arena.frame.views.as_ref();
    let mut points = views.map_or(Vec::new(), |views| views.points.clone());
    let mut layers = views.map_or(Vec::new(), |views| views.layers.clone());
    if call.one_in(8)? {
        let at = call.u.choose_index(points.len().max(1))?;
        let (axis, float) = (call.u.choose_index(3)?, recipe::float(call.u)?);
        points.iter_mut().skip(at).take(1).for_each(|point| point[axis] = float);
    }
    // The runtime refuses no opacity and no order.
    if call.one_in(4)? {
        let at = call.u.choose_index(layers.len().max(1))?;
        let (number, float) = (call.u.choose_index(2)?, recipe::float(call.u)?);
        layers.iter_mut().skip(at).take(1).for_each(|layer| layer[number] = float);
    }
    let width = if call.one_in(8)? { call.u.int_in_range(0..=2 * WIDTH)? } else { WIDTH };
    Ok(PictureArguments { points, layers, width })
}

/// Returns a count of the first views; 0 if there are none.
fn own(call: &Call<'_, '_>, ask: impl FnOnce(&ViewsCase) -> usize) -> usize {
    call.arena.frame.views.as_ref().map_or(0, ask)
}
