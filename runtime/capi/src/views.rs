//! Views: opens and describes a drawn object, evaluates its frames and renders them.

use crate::argument::sinew_argument;
use crate::border::{self, Array, Loaded};
use crate::error::{sinew_error, sinew_status};
use crate::part::{self, Opened};
use core::ffi::c_char;
use sinew_runtime::views::RenderScratch;
use sinew_runtime::{Frame, FrameJob, KernelMap, Model, RenderJob, Views};

/// A drawn object, interpolated between its key views.
///
/// The views point to their model. Every call refuses the views once the model was cleared or has loaded
/// another file.
pub struct sinew_views(Loaded<Opened>);

part::part! { sinew_views: Views, tag b"SnwV", argument Views }

/// Counts and measured errors of views. Lengths are in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_views_info {
    /// Name in UTF-8, in the file's bytes, without a terminating zero.
    pub name: *const c_char,
    /// Length of the name in bytes.
    pub name_len: usize,
    /// Index among the file's parts.
    pub part: u32,
    /// 1 if the object takes its motion from another object, otherwise 0.
    pub is_transferred: u32,
    /// 1 if elements of a layer hide each other by depth, otherwise 0. If 1, a render job needs depths.
    pub has_depth: u32,
    /// 1 if a layer clips another, otherwise 0. If 1, a render job needs clips.
    pub has_clips: u32,
    /// 1 if a layer is drawn separately before it is blended, otherwise 0. If 1, a render job needs a
    /// group.
    pub has_groups: u32,
    /// Always 0.
    pub reserved: u32,
    /// K, the number of control points.
    pub point_len: usize,
    /// V, the number of vertices.
    pub vertex_len: usize,
    /// E, the number of elements.
    pub element_len: usize,
    /// L, the number of layers.
    pub layer_len: usize,
    /// N, the number of key views.
    pub view_len: usize,
    /// M, the number of maps.
    pub map_len: usize,
    /// E + L, the length of `sinew_render_job.order`.
    pub order_len: usize,
    /// Width of the screen that points refer to, in pixels.
    pub width: usize,
    /// Height of that screen in pixels.
    pub height: usize,
    /// RMS distance to the examples over points and examples.
    pub rms_error: f32,
    /// Left-out RMS distance: the prediction of each example comes from a fit without the example; 0 if not
    /// measured.
    pub left_out_rms: f32,
    /// Share of points with the visibility of the examples.
    pub visibility: f32,
}

/// A map of a drawn object: a kernel that `sinew_part_open` opens by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct sinew_map_info {
    /// Name in UTF-8, in the file's bytes, without a terminating zero.
    pub name: *const c_char,
    /// Length of the name in bytes.
    pub name_len: usize,
    /// Index among the file's parts.
    pub part: u32,
    /// Length of the map's parameters.
    pub parameters_len: usize,
    /// Floats of scratch that a frame job needs.
    pub scratch_len: usize,
}

/// Evaluates a map of a drawn object.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct sinew_frame_job {
    /// The views.
    pub views: *const sinew_views,
    /// Index of the map.
    pub map: usize,
    /// `sinew_map_info.parameters_len` numbers, in the form of a query of `sinew_kernel_evaluate`.
    pub parameters: *const f32,
    /// Length of `parameters`.
    pub parameters_len: usize,
    /// At least `sinew_map_info.scratch_len` floats with any content.
    pub scratch: *mut f32,
    /// Length of `scratch`.
    pub scratch_len: usize,
    /// Receives K points: x to the right and y down, in pixels of the screen, and depth, which grows away
    /// from the viewer.
    pub points: *mut [f32; 3],
    /// Length of `points`.
    pub points_len: usize,
    /// Receives K visibilities; a point is visible above 0.5.
    pub visibility: *mut f32,
    /// Length of `visibility`.
    pub visibility_len: usize,
    /// Receives the scores of N key views.
    pub scores: *mut f32,
    /// Length of `scores`.
    pub scores_len: usize,
    /// Receives opacity, from 0 to 1, and order of L layers. A layer with a larger order is drawn over one
    /// with a smaller order.
    pub layers: *mut [f32; 2],
    /// Length of `layers`.
    pub layers_len: usize,
}

/// Result of a frame job.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_found {
    /// Characteristic view: the index of the view with the highest score, the first of equal ones.
    pub view: usize,
    /// Confidence of the map in the parameters.
    pub confidence: f32,
}

/// Draws a drawn object into a picture.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct sinew_render_job {
    /// The views.
    pub views: *const sinew_views,
    /// K points from a frame job.
    pub points: *const [f32; 3],
    /// Length of `points`.
    pub points_len: usize,
    /// K visibilities. Each element is drawn from the key views that show as much of it.
    pub visibility: *const f32,
    /// Length of `visibility`.
    pub visibility_len: usize,
    /// Scores of N key views, used to blend them.
    pub scores: *const f32,
    /// Length of `scores`.
    pub scores_len: usize,
    /// Opacity and order of L layers from a frame job.
    pub layers: *const [f32; 2],
    /// Length of `layers`.
    pub layers_len: usize,
    /// Width of the picture in pixels.
    pub width: usize,
    /// Pixels row by row from the top: red, green, blue and alpha in sRGB, premultiplied by alpha. The
    /// object is drawn over them.
    pub pixels: *mut [u8; 4],
    /// Number of pixels: whole rows.
    pub pixels_len: usize,
    /// Scratch: V positions with any content.
    pub vertices: *mut [f32; 3],
    /// Length of `vertices`.
    pub vertices_len: usize,
    /// Scratch: `sinew_views_info.order_len` numbers with any content.
    pub order: *mut u16,
    /// Length of `order`.
    pub order_len: usize,
    /// Scratch: at least one float per pixel if `sinew_views_info.has_depth` is 1, otherwise null is
    /// enough.
    pub depths: *mut f32,
    /// Length of `depths`.
    pub depths_len: usize,
    /// Scratch: at least one RGBA value per pixel if `sinew_views_info.has_groups` is 1, otherwise null is
    /// enough.
    pub group: *mut [u8; 4],
    /// Length of `group`.
    pub group_len: usize,
    /// Scratch: at least one byte per pixel if `sinew_views_info.has_clips` is 1, otherwise null is enough.
    pub clips: *mut u8,
    /// Length of `clips`.
    pub clips_len: usize,
}

/// Result of a render job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct sinew_drawn {
    /// Number of drawn elements.
    pub element_len: usize,
    /// Number of drawn elements that are mirrored against their texture or folded, although all of their
    /// points are visible.
    pub flipped_len: usize,
}

/// Describes views.
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
        border::check_disjoint(&[out.span()], &reads)?;
        let map = map_of(model, &views, map)?;
        let info = sinew_map_info {
            name: map.name().as_ptr().cast(),
            name_len: map.name().len(),
            part: map.part() as u32,
            parameters_len: map.query_len(),
            scratch_len: views.counts().frame_scratch_len(&map.counts()),
        };
        // SAFETY: one element, which the caller allows to be written.
        unsafe { out.store(info) };
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Runs a frame job: computes points, visibilities, scores, layers and the characteristic view from
/// parameters.
///
/// - `out_found`: receives view and confidence.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `TOO_SHORT`, `OUT_OF_RANGE`,
/// `NON_FINITE`, `ZERO_ROTATION`, `TOO_LONG`, `OVERLAP`.
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
        border::check_disjoint(&written, &[own, handle, file, job_span, parameters.span()])?;
        let map = map_of(model, &views, job.map)?;
        // SAFETY: lent by the caller; written memory overlaps nothing else.
        let (parameters, scratch) = unsafe { (parameters.read(), scratch.write()) };
        // SAFETY: lent by the caller; written memory overlaps nothing else.
        let (points, visibility, scores, layers) =
            unsafe { (points.write(), visibility.write(), scores.write(), layers.write()) };
        let mut frame = Frame::new(points, visibility, scores, layers);
        let found = FrameJob::new(views, map, parameters).run(scratch, &mut frame)?;
        // SAFETY: one element, which the caller allows to be written.
        unsafe { out.store(sinew_found { view: found.view, confidence: found.confidence }) };
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Runs a render job: draws the object over the picture.
///
/// - `out_drawn`: null, or receives the counts of drawn elements.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `TOO_SHORT`, `NON_FINITE`, `TOO_LONG`,
/// `OVERLAP`.
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
        border::check_disjoint(&written, &reads)?;
        // SAFETY: lent by the caller; written memory overlaps nothing else.
        let (points, visibility, scores, layers) =
            unsafe { (points.read(), visibility.read(), scores.read(), layers.read()) };
        let run = RenderJob { views, points, visibility, scores, layers, width: job.width };
        // SAFETY: lent by the caller; written memory overlaps nothing else.
        let (pixels, vertices, order) =
            unsafe { (pixels.write(), vertices.write(), order.write()) };
        // SAFETY: lent by the caller; written memory overlaps nothing else.
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

/// Returns a map of a drawn object.
///
/// # Errors
/// `OUT_OF_RANGE`.
fn map_of<'a>(
    model: &'a Model<&'static [u8]>,
    views: &Views<'_>,
    map: usize,
) -> Result<KernelMap<'a>, sinew_error> {
    let outside =
        sinew_error::out_of_range(sinew_argument::Map, map, views.counts().map_len as usize);
    model.map_of(views, map).ok_or(outside)
}
