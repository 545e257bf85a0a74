//! Skinning on the CPU.

use crate::border::{self, Array};
use crate::{sinew_envelope, sinew_error, sinew_matrix, sinew_status, sinew_subject};
use sinew_runtime::Matrix3x4;
use sinew_runtime::envelope::{Attribute, Buffer, SkinJob};

/// Which output buffer of a `sinew_skin_job` an attribute is written to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum sinew_buffer {
    /// None: the attribute is not wanted.
    None = 0,
    /// `out_a`.
    A = 1,
    /// `out_b`.
    B = 2,
}

/// Where an attribute is written: that of the i-th vertex *of the range* at `offset + i * stride`.
/// Zeros mean that it is not wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct sinew_attribute {
    /// A `sinew_buffer`.
    pub buffer: u32,
    /// Where the range's first vertex goes, in floats.
    pub offset: usize,
    /// Floats from one vertex to the next; at least the attribute's own.
    pub stride: usize,
}

/// Skins a range of vertices. Floats between attributes are left alone; where attributes overlap,
/// the later field of this structure wins.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct sinew_skin_job {
    /// The envelope.
    pub envelope: *const sinew_envelope,
    /// `sinew_envelope_info.palette_len` maps, rest to posed.
    pub palette: *const sinew_matrix,
    /// Their number.
    pub palette_len: usize,
    /// First vertex.
    pub start: usize,
    /// One more than the last vertex.
    pub end: usize,
    /// Where to put positions: 3 floats, model space.
    pub positions: sinew_attribute,
    /// Where to put normals: 3 floats of length 1; where a map leaves one no direction, the rest
    /// normal.
    pub normals: sinew_attribute,
    /// Where to put tangents: 3 floats of length 1 (the rest tangent where a map leaves one no
    /// direction), then the handedness.
    pub tangents: sinew_attribute,
    /// Buffer A, as long as its attributes need: `offset + (n - 1) * stride + 3` floats for n
    /// positions, say. Null if none is in it.
    pub out_a: *mut f32,
    /// Its length in floats.
    pub out_a_len: usize,
    /// Buffer B; likewise.
    pub out_b: *mut f32,
    /// Its length in floats.
    pub out_b_len: usize,
}

/// Runs a skin job. Jobs may run at the same time, on any threads, if none of the buffers given to
/// one overlaps those given to another.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `LENGTH`, `OUT_OF_RANGE`, `BUFFER`, `NO_TANGENTS`,
/// `STRIDE`, `TOO_SHORT`, `TOO_LONG`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_skin(
    job: *const sinew_skin_job,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        let job = Array::one(job, sinew_subject::Job)?;
        let job_span = job.span();
        // SAFETY: lent by the caller; copied at once.
        let job = unsafe { job.read() }.first().copied();
        let job = job.ok_or(sinew_error::new(sinew_status::Null, sinew_subject::Job))?;
        // SAFETY: the caller's promise is passed on.
        let (envelope, [handle, file]) = unsafe { border::object(job.envelope) }?;
        let palette =
            Array::new(job.palette.cast::<Matrix3x4>(), job.palette_len, sinew_subject::Palette)?;
        let out_a = Array::new(job.out_a, job.out_a_len, sinew_subject::OutA)?;
        let out_b = Array::new(job.out_b, job.out_b_len, sinew_subject::OutB)?;
        border::apart(&[out_a.span(), out_b.span()], &[handle, file, palette.span(), job_span])?;
        let positions = attribute(job.positions, sinew_subject::Positions)?;
        let normals = attribute(job.normals, sinew_subject::Normals)?;
        let tangents = attribute(job.tangents, sinew_subject::Tangents)?;
        // SAFETY: lent by the caller; what is written is apart from all else.
        let (palette, out_a, out_b) = unsafe { (palette.read(), out_a.write(), out_b.write()) };
        SkinJob {
            envelope: *envelope,
            palette,
            vertices: job.start..job.end,
            positions,
            normals,
            tangents,
            out_a,
            out_b,
        }
        .run()?;
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

fn attribute(
    attribute: sinew_attribute,
    subject: sinew_subject,
) -> Result<Option<Attribute>, sinew_error> {
    let sinew_attribute { buffer, offset, stride } = attribute;
    let buffer = match buffer {
        number if number == sinew_buffer::None as u32 => return Ok(None),
        number if number == sinew_buffer::A as u32 => Buffer::A,
        number if number == sinew_buffer::B as u32 => Buffer::B,
        other => {
            return Err(sinew_error::new(sinew_status::Buffer, subject).found(u64::from(other)));
        }
    };
    Ok(Some(Attribute { buffer, offset, stride }))
}
