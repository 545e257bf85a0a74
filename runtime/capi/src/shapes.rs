//! Shapes of a skin: what they are, and the rest mesh that they make.

use crate::argument::sinew_argument;
use crate::border::{self, Array};
use crate::error::sinew_error;
use crate::job::{given, sinew_bounds, sinew_output};
use crate::matrix::sinew_matrix;
use crate::part;
use crate::skin::sinew_skin;
use crate::status::sinew_status;
use core::ffi::c_char;
use sinew_runtime::skin::Output;
use sinew_runtime::{Matrix3x4, ShapesJob};

/// A shape of a skin.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_shape {
    /// Its name: UTF-8 in the file's bytes, not ended by a zero.
    pub name: *const c_char,
    /// Bytes of the name.
    pub name_len: usize,
    /// The box of how far it moves any vertex at a weight of 1, 0 among it.
    pub bounds: sinew_bounds,
}

/// Shapes vertices at rest: what it writes a `sinew_skin_job` takes as its rest mesh.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct sinew_shapes_job {
    /// The skin.
    pub skin: *const sinew_skin,
    /// `sinew_skin_info.shape_len` weights.
    pub weights: *const f32,
    /// Their number.
    pub weights_len: usize,
    /// First vertex. Of ranges that start at multiples of 64 no sum is computed twice.
    pub start: usize,
    /// One more than the last vertex.
    pub end: usize,
    /// Where to put positions: 3 floats, model space.
    pub positions: sinew_output,
    /// Where to put normals: 3 floats of length 1; where the shapes leave one no direction, the file's.
    pub normals: sinew_output,
    /// Where to put tangents: 3 floats of length 1, likewise, then the handedness.
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
    let body = || {
        // SAFETY: the caller's promise is passed on.
        let (skin, reads) = unsafe { part::view(skin) }?;
        let out = Array::one(out_shape, sinew_argument::Result)?;
        border::apart(&[out.span()], &reads)?;
        let (name, bounds) = skin.shape_name(shape).zip(skin.shape_box(shape)).ok_or(
            sinew_error::new(sinew_status::OutOfRange, sinew_argument::Shape)
                .values(skin.shape_len().saturating_sub(1), shape),
        )?;
        let found = sinew_shape {
            name: name.as_ptr().cast(),
            name_len: name.len(),
            bounds: sinew_bounds { min: bounds.min, max: bounds.max },
        };
        // SAFETY: one element, which the caller lets be written.
        unsafe { out.store(found) };
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Runs a shapes job. Its outputs may overlap each other, but nothing that it reads. Jobs may run at the
/// same time, on any threads, if no output of one overlaps an output of another.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `NO_OUTPUT`, `LENGTH`, `NON_FINITE`, `OUT_OF_RANGE`,
/// `NO_ATTRIBUTE`, `STRIDE`, `TOO_SHORT`, `TOO_LONG`, `OVERLAP`.
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
        let [positions, normals, tangents] = [
            (job.positions, sinew_argument::Positions),
            (job.normals, sinew_argument::Normals),
            (job.tangents, sinew_argument::Tangents),
        ]
        .map(|(output, argument)| given(&output, argument));
        let (positions, normals, tangents) = (positions?, normals?, tangents?);
        let reads = [own, model, file, job_span, weights.span()];
        for output in [&positions, &normals, &tangents].into_iter().flatten() {
            border::apart(&[output.span()], &reads)?;
        }
        let output = |array: Option<Array<f32>>, stride| {
            // SAFETY: lent by the caller for this call, apart from all that is read, and referred to by
            // cells alone.
            array.map(|array| Output { floats: unsafe { array.share() }, stride })
        };
        let job = ShapesJob {
            skin,
            // SAFETY: lent by the caller; what is written is apart from it.
            weights: unsafe { weights.read() },
            vertices: job.start..job.end,
            positions: output(positions, job.positions.stride),
            normals: output(normals, job.normals.stride),
            tangents: output(tangents, job.tangents.stride),
        };
        Ok(job.run()?)
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Computes a box that holds every vertex of the shaped and posed skin, from weights and palette alone.
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
    let body = || {
        // SAFETY: the caller's promise is passed on.
        let (skin, [own, model, file]) = unsafe { part::view(skin) }?;
        let palette =
            Array::new(palette.cast::<Matrix3x4>(), palette_len, sinew_argument::Palette)?;
        let weights = Array::new(weights, weights_len, sinew_argument::ShapeWeights)?;
        let out = Array::one(out_bounds, sinew_argument::Result)?;
        border::apart(&[out.span()], &[own, model, file, palette.span(), weights.span()])?;
        // SAFETY: lent by the caller.
        let bounds = skin.shaped_bounds(unsafe { palette.read() }, unsafe { weights.read() })?;
        let bounds =
            bounds.ok_or(sinew_error::new(sinew_status::NoVertices, sinew_argument::Skin))?;
        // SAFETY: one element, which the caller lets be written.
        unsafe { out.store(sinew_bounds { min: bounds.min, max: bounds.max }) };
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}
