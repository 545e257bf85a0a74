//! Views, what the file says of them, their frames and their pictures.

use crate::argument::sinew_argument;
use crate::border::{self, Array, Loaded};
use crate::error::{sinew_error, sinew_status};
use crate::model::sinew_model;
use crate::part::{self, Opened, Opening};
use core::ffi::{c_char, c_void};
use core::mem::{align_of, size_of};
use sinew_runtime::views::{RenderScratch, ViewsLayout};
use sinew_runtime::{Frame, FrameJob, KernelMap, Model, RenderJob, Views};

/// Elements of a `uintptr_t` array that holds views on every target: `uintptr_t memory[SINEW_VIEWS_WORDS]`.
pub const SINEW_VIEWS_WORDS: usize = 48;

/// A drawn object between its key views. It points to its model: where that has been loaded again with another
/// file, or is loaded no more, every call refuses the views.
pub struct sinew_views(Loaded<Opened<ViewsLayout>>);

part::part! {
    sinew_views: ViewsLayout to Views, of Model::all_views,
    tag b"SnwV", argument Views, within SINEW_VIEWS_WORDS
}

/// What views are made of, and what they were measured to reach; lengths are in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_views_info {
    /// Their name: UTF-8 in the file's bytes, not ended by a zero.
    pub name: *const c_char,
    /// Bytes of the name.
    pub name_len: usize,
    /// Their number among the file's parts.
    pub part: u32,
    /// 1 if they move as another object does, else 0.
    pub is_transferred: u32,
    /// 1 if elements of a layer hide each other by depth, else 0: then a render job needs depths.
    pub has_depth: u32,
    /// 1 if a layer is clipped by another, else 0: then a render job needs clips.
    pub has_clips: u32,
    /// 1 if a layer is drawn by itself before it is blended, else 0: then a render job needs a group.
    pub has_groups: u32,
    /// 0.
    pub reserved: u32,
    /// K, control points.
    pub point_len: usize,
    /// V, vertices.
    pub vertex_len: usize,
    /// E, elements.
    pub element_len: usize,
    /// L, layers.
    pub layer_len: usize,
    /// N, key views.
    pub view_len: usize,
    /// M, maps.
    pub map_len: usize,
    /// E + L, the numbers that a render job sorts.
    pub order_len: usize,
    /// Width of the screen on which points are, in pixels.
    pub width: usize,
    /// Height of that screen.
    pub height: usize,
    /// RMS over points and examples of the distance to the examples.
    pub rms_error: f32,
    /// The same, each example left out of its own fit; 0 if it was not measured.
    pub left_out_rms: f32,
    /// Share of the points whose visibility is that of the examples.
    pub visibility: f32,
}

/// A map of an object: a kernel, which `sinew_kernel_open` opens by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct sinew_map_info {
    /// Its name: UTF-8 in the file's bytes, not ended by a zero.
    pub name: *const c_char,
    /// Bytes of the name.
    pub name_len: usize,
    /// Its number among the file's parts.
    pub part: u32,
    /// Numbers of its parameters.
    pub parameters_len: usize,
    /// Floats of scratch that a frame needs.
    pub scratch_len: usize,
}

/// Evaluates a map of an object.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct sinew_frame_job {
    /// The object.
    pub views: *const sinew_views,
    /// The number of the map.
    pub map: usize,
    /// `sinew_map_info.parameters_len` numbers, as `sinew_kernel_evaluate` takes a query.
    pub parameters: *const f32,
    /// Their number.
    pub parameters_len: usize,
    /// At least `sinew_map_info.scratch_len` floats, of any content.
    pub scratch: *mut f32,
    /// Their number.
    pub scratch_len: usize,
    /// Receives K points: x to the right and y down, in pixels of the screen, and depth, which grows away from the
    /// viewer.
    pub points: *mut [f32; 3],
    /// Their number.
    pub points_len: usize,
    /// Receives K visibilities; above 0.5 a point is visible.
    pub visibility: *mut f32,
    /// Their number.
    pub visibility_len: usize,
    /// Receives N scores of key views.
    pub scores: *mut f32,
    /// Their number.
    pub scores_len: usize,
    /// Receives opacity, from 0 to 1, and order of L layers: those of a greater order are drawn over those of a lesser
    /// one.
    pub layers: *mut [f32; 2],
    /// Their number.
    pub layers_len: usize,
}

/// What a frame job found.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_found {
    /// The characteristic view: the one with the highest score, the first of equal ones.
    pub view: usize,
    /// The map's confidence in the parameters.
    pub confidence: f32,
}

/// Draws an object into a picture.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct sinew_render_job {
    /// The object.
    pub views: *const sinew_views,
    /// K points, as a frame job gives them.
    pub points: *const [f32; 3],
    /// Their number.
    pub points_len: usize,
    /// K visibilities: an element between points is drawn from key views that show as much of it.
    pub visibility: *const f32,
    /// Their number.
    pub visibility_len: usize,
    /// N scores of key views, by which they are blended.
    pub scores: *const f32,
    /// Their number.
    pub scores_len: usize,
    /// Opacity and order of L layers, as a frame job gives them.
    pub layers: *const [f32; 2],
    /// Their number.
    pub layers_len: usize,
    /// Width of the picture in pixels.
    pub width: usize,
    /// Pixels row by row from the top, red, green, blue and alpha: sRGB, each times its alpha. Drawn over.
    pub pixels: *mut [u8; 4],
    /// Their number, of whole rows.
    pub pixels_len: usize,
    /// V places of scratch, of any content.
    pub vertices: *mut [f32; 3],
    /// Their number.
    pub vertices_len: usize,
    /// `sinew_views_info.order_len` numbers of scratch, of any content.
    pub order: *mut u16,
    /// Their number.
    pub order_len: usize,
    /// Scratch of any content: at least a float a pixel if `sinew_views_info.has_depth`, else null will do.
    pub depths: *mut f32,
    /// Their number.
    pub depths_len: usize,
    /// Scratch of any content: at least a pixel each if `sinew_views_info.has_groups`, else null will do.
    pub group: *mut [u8; 4],
    /// Their number.
    pub group_len: usize,
    /// Scratch of any content: at least a byte a pixel if `sinew_views_info.has_clips`, else null will do.
    pub clips: *mut u8,
    /// Their number.
    pub clips_len: usize,
}

/// What a render job drew.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct sinew_drawn {
    /// Elements drawn.
    pub element_len: usize,
    /// Those of them that are turned over against their texture, or folded, with all of their points visible.
    pub flipped_len: usize,
}

/// Returns the bytes of memory that views need: at most those of `SINEW_VIEWS_WORDS` words.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_views_bytes() -> usize {
    size_of::<sinew_views>()
}

/// Opens views of a model.
///
/// - `name`, `name_len`: their name, without a zero at its end; null and 0 for any.
/// - `index`: which of those; 0 for the first.
/// - `memory`, `memory_bytes`: for the views; at least `sinew_views_bytes()`, aligned as a `uintptr_t`.
/// - `out_views`: receives the handle, which is `memory`.
///
/// Returns `NULL`, `MISALIGNED`, `TOO_SHORT`, `TOO_LONG`, `OVERLAP`, `NOT_LOADED`, `NOT_FOUND`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_views_open(
    model: *const sinew_model,
    name: *const c_char,
    name_len: usize,
    index: usize,
    memory: *mut c_void,
    memory_bytes: usize,
    out_views: *mut *const sinew_views,
    out_error: *mut sinew_error,
) -> sinew_status {
    let opening = Opening { model, name, name_len, index, memory, memory_bytes };
    // SAFETY: the caller's promise is passed on.
    unsafe { opening.open(out_views, out_error) }
}

/// Says what views are made of.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_views_describe(
    views: *const sinew_views,
    out_info: *mut sinew_views_info,
    out_error: *mut sinew_error,
) -> sinew_status {
    let answer = |views: &Views<'_>| {
        let (fit, [width, height]) = (views.fit(), views.size());
        Ok(sinew_views_info {
            name: views.name().as_ptr().cast(),
            name_len: views.name().len(),
            part: views.part() as u32,
            is_transferred: u32::from(views.is_transferred()),
            has_depth: u32::from(views.has_depth()),
            has_clips: u32::from(views.has_clips()),
            has_groups: u32::from(views.has_groups()),
            reserved: 0,
            point_len: views.point_len(),
            vertex_len: views.vertex_len(),
            element_len: views.element_len(),
            layer_len: views.layer_len(),
            view_len: views.view_len(),
            map_len: views.counts().map_len as usize,
            order_len: views.order_len(),
            width,
            height,
            rms_error: fit.rms_error,
            left_out_rms: fit.left_out_rms,
            visibility: fit.visibility,
        })
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { part::describe(views, out_info, out_error, answer) }
}

/// Describes a map.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OVERLAP`, `OUT_OF_RANGE`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_views_map(
    views: *const sinew_views,
    map: usize,
    out_map: *mut sinew_map_info,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        // SAFETY: the caller's promise is passed on.
        let (views, model, reads) = unsafe { part::view_in(views) }?;
        let out = Array::one(out_map, sinew_argument::Result)?;
        border::apart(&[out.span()], &reads)?;
        let map = map_of(model, &views, map)?;
        let info = sinew_map_info {
            name: map.name().as_ptr().cast(),
            name_len: map.name().len(),
            part: map.part() as u32,
            parameters_len: map.query_len(),
            scratch_len: views.counts().frame_scratch_len(&map.counts()),
        };
        // SAFETY: one element, which the caller lets be written.
        unsafe { out.store(info) };
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Runs a frame job: from parameters to points, visibilities, scores, layers and the characteristic view.
///
/// - `out_found`: receives what it found.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `TOO_SHORT`, `OUT_OF_RANGE`, `NON_FINITE`,
/// `ZERO_ROTATION`, `TOO_LONG`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_views_frame(
    job: *const sinew_frame_job,
    out_found: *mut sinew_found,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        // SAFETY: lent by the caller.
        let (job, job_span) = unsafe { border::copied(job, sinew_argument::Job) }?;
        // SAFETY: the caller's promise is passed on.
        let (views, model, [own, handle, file]) = unsafe { part::view_in(job.views) }?;
        let parameters = Array::new(job.parameters, job.parameters_len, sinew_argument::Query)?;
        let scratch = Array::new(job.scratch, job.scratch_len, sinew_argument::Scratch)?;
        let points = Array::new(job.points, job.points_len, sinew_argument::Points)?;
        let visibility =
            Array::new(job.visibility, job.visibility_len, sinew_argument::Visibility)?;
        let scores = Array::new(job.scores, job.scores_len, sinew_argument::Scores)?;
        let layers = Array::new(job.layers, job.layers_len, sinew_argument::Layers)?;
        let out = Array::one(out_found, sinew_argument::Result)?;
        let [points_span, visibility_span] = [points.span(), visibility.span()];
        let [scores_span, layers_span] = [scores.span(), layers.span()];
        let written =
            [scratch.span(), points_span, visibility_span, scores_span, layers_span, out.span()];
        border::apart(&written, &[own, handle, file, job_span, parameters.span()])?;
        let map = map_of(model, &views, job.map)?;
        // SAFETY: lent by the caller; what is written is apart from all else.
        let (parameters, scratch) = unsafe { (parameters.read(), scratch.write()) };
        // SAFETY: likewise.
        let (points, visibility, scores, layers) =
            unsafe { (points.write(), visibility.write(), scores.write(), layers.write()) };
        let run = FrameJob { views, map, parameters };
        let found = run.run(scratch, Frame { points, visibility, scores, layers })?;
        // SAFETY: one element, which the caller lets be written.
        unsafe { out.store(sinew_found { view: found.view, confidence: found.confidence }) };
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Runs a render job: from points to a picture, over what it holds.
///
/// - `out_drawn`: null, or receives what it drew.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `TOO_SHORT`, `NON_FINITE`, `TOO_LONG`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_views_render(
    job: *const sinew_render_job,
    out_drawn: *mut sinew_drawn,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        // SAFETY: lent by the caller.
        let (job, job_span) = unsafe { border::copied(job, sinew_argument::Job) }?;
        // SAFETY: the caller's promise is passed on.
        let (views, [own, handle, file]) = unsafe { part::view(job.views) }?;
        let points = Array::new(job.points, job.points_len, sinew_argument::Points)?;
        let visibility =
            Array::new(job.visibility, job.visibility_len, sinew_argument::Visibility)?;
        let scores = Array::new(job.scores, job.scores_len, sinew_argument::Scores)?;
        let layers = Array::new(job.layers, job.layers_len, sinew_argument::Layers)?;
        let pixels = Array::new(job.pixels, job.pixels_len, sinew_argument::Pixels)?;
        let vertices = Array::new(job.vertices, job.vertices_len, sinew_argument::Vertices)?;
        let order = Array::new(job.order, job.order_len, sinew_argument::Scratch)?;
        let depths = Array::new(job.depths, job.depths_len, sinew_argument::Depths)?;
        let group = Array::new(job.group, job.group_len, sinew_argument::Group)?;
        let clips = Array::new(job.clips, job.clips_len, sinew_argument::Clips)?;
        let drawn = Array::optional(out_drawn, sinew_argument::Result)?;
        let [places, numbers] = [vertices.span(), order.span()];
        let [distances, layer, masks] = [depths.span(), group.span(), clips.span()];
        let written = [pixels.span(), places, numbers, distances, layer, masks, drawn.span()];
        let [points_span, visibility_span] = [points.span(), visibility.span()];
        let [scores_span, layers_span] = [scores.span(), layers.span()];
        let reads =
            [own, handle, file, job_span, points_span, visibility_span, scores_span, layers_span];
        border::apart(&written, &reads)?;
        // SAFETY: lent by the caller; what is written is apart from all else.
        let (points, visibility, scores, layers) =
            unsafe { (points.read(), visibility.read(), scores.read(), layers.read()) };
        let run = RenderJob { views, points, visibility, scores, layers, width: job.width };
        // SAFETY: likewise.
        let (pixels, vertices, order) =
            unsafe { (pixels.write(), vertices.write(), order.write()) };
        // SAFETY: likewise.
        let (depths, group, clips, drawn) =
            unsafe { (depths.write(), group.write(), clips.write(), drawn.write()) };
        let done = run.run(RenderScratch { vertices, order, depths, group, clips }, pixels)?;
        let (element_len, flipped_len) = (done.element_len, done.flipped_len);
        drawn.fill(sinew_drawn { element_len, flipped_len });
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Finds a map of an object.
fn map_of<'a>(
    model: &'a Model<&'static [u8]>,
    views: &Views<'_>,
    map: usize,
) -> Result<KernelMap<'a>, sinew_error> {
    let beyond = sinew_error::beyond(sinew_argument::Map, map, views.counts().map_len as usize);
    model.map_of(views, map).ok_or(beyond)
}
