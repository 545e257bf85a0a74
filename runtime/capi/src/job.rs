//! Jobs of a skin: skinning, shapes, and the bounds of the posed skin.

use crate::argument::sinew_argument;
use crate::border::{self, Array, Span};
use crate::envelope::sinew_matrix;
use crate::error::{sinew_error, sinew_status};
use crate::part;
use crate::skin::{scratch_len, sinew_skin};
use core::ffi::c_char;
use sinew_runtime::skin::{Bounds, Output};
use sinew_runtime::{Matrix3x4, ShapesJob, Skin, SkinJob};

/// Destination of an attribute. The i-th vertex *of the range* is written at `floats[i * stride]`. An
/// output of zeros is left out; a stride without floats gives `NULL`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct sinew_output {
    /// Address for the range's first vertex. Attributes may share a buffer, each from another first float,
    /// so that vertices are interleaved.
    pub floats: *mut f32,
    /// Number of floats from `floats` on: for n vertices at least `(n - 1) * stride` plus the floats of the
    /// attribute.
    pub len: usize,
    /// Floats from one vertex to the next: at least the 3 or 4 floats of the attribute.
    pub stride: usize,
}

/// Skins a range of vertices. Floats between attributes are left unchanged.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct sinew_skin_job {
    /// The skin.
    pub skin: *const sinew_skin,
    /// `sinew_skin_info.palette_len` transforms, rest to posed.
    pub palette: *const sinew_matrix,
    /// Length of `palette`.
    pub palette_len: usize,
    /// First vertex: an index into the remap if there is one, otherwise into the skin.
    pub start: usize,
    /// One more than the last vertex; for all, the length of the remap or V. A job from 0 to 0 writes nothing.
    pub end: usize,
    /// Null, or the skin vertex that each engine vertex copies. Vertices that were split along seams or
    /// reordered then need no second pass.
    pub remap: *const u32,
    /// Length of `remap`.
    pub remap_len: usize,
    /// Null, or rest positions that replace the file's: 3 floats for each of the skin's V vertices, of
    /// another face or body with the same topology.
    pub rest_positions: *const f32,
    /// Null, or rest normals that replace the file's: 3 floats of length 1 each.
    pub rest_normals: *const f32,
    /// Null, or rest tangents that replace the file's: 3 floats of length 1, and the handedness.
    pub rest_tangents: *const f32,
    /// V, the number of vertices of each of these three arrays that is not null.
    pub rest_len: usize,
    /// Output positions: 3 floats in model space.
    pub positions: sinew_output,
    /// Output normals: 3 floats of length 1, outward even if the palette mirrors. If the palette gives a
    /// normal no direction, the job writes the rest normal; with tangent coefficients, turned by the
    /// strongest influence.
    pub normals: sinew_output,
    /// Output tangents: 3 floats of length 1, then the handedness. If the palette gives a tangent no
    /// direction, the job writes the rest tangent.
    pub tangents: sinew_output,
    /// Null, or `sinew_skin_info.scratch_len` floats with any content, which make positions faster: one array per
    /// thread. The content after the call has no meaning.
    pub scratch: *mut f32,
    /// Length of `scratch`; 0 without.
    pub scratch_len: usize,
}

/// An axis-aligned box in model space.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_bounds {
    /// Smallest coordinates.
    pub min: [f32; 3],
    /// Largest coordinates.
    pub max: [f32; 3],
}

/// Runs a skin job. Its outputs may share a buffer, but no float, and no memory that the job reads. Jobs may run at
/// the same time on any threads if no output of one overlaps an output of another.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `NO_OUTPUT`, `LENGTH`, `OUT_OF_RANGE`,
/// `NO_ATTRIBUTE`, `STRIDE`, `TOO_SHORT`, `TOO_LONG`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_skin_run(
    job: *const sinew_skin_job,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        // SAFETY: lent by the caller.
        let (job, job_span) = unsafe { border::copied(job, sinew_argument::Job) }?;
        // SAFETY: the caller's promise is passed on.
        let (skin, [own, model, file]) = unsafe { part::view(job.skin) }?;
        let palette = job.palette.cast::<Matrix3x4>();
        let palette = Array::new(palette, job.palette_len, sinew_argument::Palette)?;
        let remap = Array::given(job.remap, job.remap_len, sinew_argument::Remap)?;
        let rest_positions = rest(job.rest_positions, &job, sinew_argument::RestPositions)?;
        let rest_normals = rest(job.rest_normals, &job, sinew_argument::RestNormals)?;
        let rest_tangents = rest(job.rest_tangents, &job, sinew_argument::RestTangents)?;
        let scratch = Array::given(job.scratch, job.scratch_len, sinew_argument::Scratch)?;
        if let Some(scratch) = &scratch {
            scratch.check_least(scratch_len(&skin))?;
        }
        // The job writes to the scratch, and reads the others.
        let lent = [
            scratch.as_ref().map_or(Span::EMPTY, Array::span),
            own,
            model,
            file,
            job_span,
            palette.span(),
            remap.as_ref().map_or(Span::EMPTY, Array::span),
            rest_positions.as_ref().map_or(Span::EMPTY, Array::span),
            rest_normals.as_ref().map_or(Span::EMPTY, Array::span),
            rest_tangents.as_ref().map_or(Span::EMPTY, Array::span),
        ];
        let [scratch_span, reads @ ..] = &lent;
        border::check_disjoint(&[*scratch_span], reads)?;
        let wanted = [job.positions, job.normals, job.tangents];
        // SAFETY: lent by the caller for this call.
        let [positions, normals, tangents] = unsafe { outputs(wanted, &lent) }?;
        // SAFETY: lent by the caller; written memory overlaps none of it.
        unsafe {
            let mut own = SkinJob::new(skin, palette.read()).vertices(job.start..job.end);
            if let Some(remap) = remap {
                own = own.remap(remap.read());
            }
            if let Some(positions) = rest_positions {
                own = own.rest_positions(positions.read());
            }
            if let Some(normals) = rest_normals {
                own = own.rest_normals(normals.read());
            }
            if let Some(tangents) = rest_tangents {
                own = own.rest_tangents(tangents.read());
            }
            if let Some(scratch) = scratch {
                own = own.scratch(scratch.aligned().write());
            }
            Ok(own.positions(positions).normals(normals).tangents(tangents).run()?)
        }
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Computes a box that contains every vertex of the posed skin, from the palette alone.
///
/// - `palette`, `palette_len`: `sinew_skin_info.palette_len` transforms.
/// - `rest_offset`: largest distance along an axis between a position of the caller's rest mesh and the
///   file's; 0 for the file's own mesh.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `OUT_OF_RANGE`, `NO_VERTICES`,
/// `TOO_LONG`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_skin_bounds(
    skin: *const sinew_skin,
    palette: *const sinew_matrix,
    palette_len: usize,
    rest_offset: f32,
    out_bounds: *mut sinew_bounds,
    out_error: *mut sinew_error,
) -> sinew_status {
    let palette = Array::new(palette.cast(), palette_len, sinew_argument::Palette);
    let answer = |skin: &Skin<'_>, palette: &[Matrix3x4], _: &[f32]| {
        checked_bounds(skin.bounds(palette, rest_offset)?)
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { part::compute(skin, (palette, Array::none()), out_bounds, out_error, answer) }
}

/// A shape of a skin.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_shape {
    /// Name in UTF-8, in the file's bytes, without a terminating zero.
    pub name: *const c_char,
    /// Length of the name in bytes.
    pub name_len: usize,
    /// Box of the offsets of all vertices at weight 1; the box contains 0.
    pub bounds: sinew_bounds,
}

/// Applies shapes to vertices at rest. A `sinew_skin_job` takes the result as its rest mesh.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct sinew_shapes_job {
    /// The skin.
    pub skin: *const sinew_skin,
    /// `sinew_skin_info.shape_len` weights.
    pub weights: *const f32,
    /// Length of `weights`.
    pub weights_len: usize,
    /// First vertex. Ranges that start at multiples of 64 compute no sum twice.
    pub start: usize,
    /// One more than the last vertex.
    pub end: usize,
    /// Output positions: 3 floats in model space.
    pub positions: sinew_output,
    /// Output normals: 3 floats of length 1. If the shapes give a normal no direction, the job writes the
    /// file's.
    pub normals: sinew_output,
    /// Output tangents: 3 floats of length 1, then the handedness. If the shapes give a tangent no
    /// direction, the job writes the file's.
    pub tangents: sinew_output,
}

/// Describes a shape.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OVERLAP`, `OUT_OF_RANGE`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_skin_shape(
    skin: *const sinew_skin,
    shape: usize,
    out_shape: *mut sinew_shape,
    out_error: *mut sinew_error,
) -> sinew_status {
    let answer = |skin: &Skin<'_>| {
        let outside = sinew_error::out_of_range(sinew_argument::Shape, shape, skin.shape_len());
        let found = skin.shape_name(shape).zip(skin.shape_box(shape));
        let (name, Bounds { min, max }) = found.ok_or(outside)?;
        let bounds = sinew_bounds { min, max };
        Ok(sinew_shape { name: name.as_ptr().cast(), name_len: name.len(), bounds })
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { part::describe(skin, out_shape, out_error, answer) }
}

/// Runs a shapes job. Its outputs may share a buffer, but no float, and no memory that the job reads. Jobs may run at
/// the same time on any threads if no output of one overlaps an output of another.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `NO_OUTPUT`, `LENGTH`, `NON_FINITE`,
/// `OUT_OF_RANGE`, `NO_ATTRIBUTE`, `STRIDE`, `TOO_SHORT`, `TOO_LONG`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_shapes_run(
    job: *const sinew_shapes_job,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        // SAFETY: lent by the caller.
        let (job, job_span) = unsafe { border::copied(job, sinew_argument::Job) }?;
        // SAFETY: the caller's promise is passed on.
        let (skin, [own, model, file]) = unsafe { part::view(job.skin) }?;
        let weights = Array::new(job.weights, job.weights_len, sinew_argument::ShapeWeights)?;
        let reads = [own, model, file, job_span, weights.span()];
        let wanted = [job.positions, job.normals, job.tangents];
        // SAFETY: lent by the caller for this call.
        let [positions, normals, tangents] = unsafe { outputs(wanted, &reads) }?;
        // SAFETY: lent by the caller; written memory overlaps none of it.
        let job = ShapesJob::new(skin, unsafe { weights.read() })
            .vertices(job.start..job.end)
            .positions(positions)
            .normals(normals)
            .tangents(tangents);
        Ok(job.run()?)
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Computes a box that contains every vertex of the shaped and posed skin, from weights and palette alone.
///
/// - `palette`, `palette_len`: `sinew_skin_info.palette_len` transforms.
/// - `weights`, `weights_len`: `sinew_skin_info.shape_len` weights.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `NON_FINITE`, `NO_VERTICES`, `TOO_LONG`,
/// `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_shapes_bounds(
    skin: *const sinew_skin,
    palette: *const sinew_matrix,
    palette_len: usize,
    weights: *const f32,
    weights_len: usize,
    out_bounds: *mut sinew_bounds,
    out_error: *mut sinew_error,
) -> sinew_status {
    let palette = Array::new(palette.cast(), palette_len, sinew_argument::Palette);
    let weights = Array::new(weights, weights_len, sinew_argument::ShapeWeights);
    let answer = |skin: &Skin<'_>, palette: &[Matrix3x4], weights: &[f32]| {
        checked_bounds(skin.shaped_bounds(palette, weights)?)
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { part::compute(skin, (palette, weights), out_bounds, out_error, answer) }
}

/// Checks an attribute of the caller's rest mesh, which may be left out.
fn rest<const N: usize>(
    at: *const f32,
    job: &sinew_skin_job,
    argument: sinew_argument,
) -> Result<Option<Array<[f32; N]>>, sinew_error> {
    let len = if at.is_null() { 0 } else { job.rest_len };
    Array::given(at.cast(), len, argument)
}

/// Borrows the floats that a job writes: positions, normals and tangents. They may share a buffer, but no memory
/// in `reads`. An output of zeros is `None`.
///
/// # Safety
/// For `'a` only the job that takes the outputs uses their floats.
unsafe fn outputs<'a>(
    wanted: [sinew_output; 3],
    reads: &[Span],
) -> Result<[Option<Output<'a>>; 3], sinew_error> {
    let arguments = [sinew_argument::Positions, sinew_argument::Normals, sinew_argument::Tangents];
    let mut found = [None, None, None];
    for ((found, output), argument) in found.iter_mut().zip(wanted).zip(arguments) {
        let sinew_output { floats, len, stride } = output;
        let array = Array::given(floats, len, argument)?;
        if array.is_none() && stride > 0 {
            return Err(sinew_error::new(sinew_status::Null, argument));
        }
        *found = array.map(|array| (array, stride));
    }
    for (array, _) in found.iter().flatten() {
        border::check_disjoint(&[array.span()], reads)?;
    }
    // SAFETY: lent by the caller, apart from all memory that is read, and used through cells only.
    let output =
        |(array, stride): (Array<f32>, usize)| Output::shared(unsafe { array.share() }, stride);
    Ok(found.map(|found| found.map(output)))
}

/// Converts a box; a mesh without vertices has none.
///
/// # Errors
/// `NO_VERTICES`.
fn checked_bounds(bounds: Option<Bounds>) -> Result<sinew_bounds, sinew_error> {
    let none = sinew_error::new(sinew_status::NoVertices, sinew_argument::Skin);
    bounds.map(|Bounds { min, max }| sinew_bounds { min, max }).ok_or(none)
}
