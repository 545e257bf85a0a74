//! Outputs of a job: strided arrays of one attribute.

use super::simd::EIGHT;
use crate::error::{Argument, CallError, CallErrorKind};
use core::cell::Cell;
use core::ops::Range;

/// Output of one attribute. The i-th vertex *of the range* is written at float `i * stride`.
#[derive(Clone, Copy, Debug)]
pub struct Output<'a> {
    /// Floats of the caller, from [`cells`]. For interleaved vertices, the attributes share floats, each from its own
    /// first float on.
    pub floats: &'a [Cell<f32>],
    /// Floats from one vertex to the next; at least the length of the attribute, 3 or 4.
    pub stride: usize,
}

/// Lends floats to several attributes of a [`super::SkinJob`], which writes the floats and never reads them.
pub fn cells(floats: &mut [f32]) -> &[Cell<f32>] {
    Cell::from_mut(floats).as_slice_of_cells()
}

/// Outputs of a job, each with the floats of its attribute and the argument to name in errors.
#[derive(Clone, Copy)]
pub(super) struct Outputs<'a>([(Option<Output<'a>>, usize, Argument); 3]);

impl<'a> Outputs<'a> {
    /// Collects the outputs of a job; an error if there is none.
    pub(super) fn new(
        positions: Option<Output<'a>>,
        normals: Option<Output<'a>>,
        tangents: Option<Output<'a>>,
    ) -> Result<Self, CallError> {
        if positions.is_none() && normals.is_none() && tangents.is_none() {
            return Err(CallError::new(CallErrorKind::NoOutput, Argument::Call));
        }
        Ok(Self([
            (positions, 3, Argument::Positions),
            (normals, 3, Argument::Normals),
            (tangents, 4, Argument::Tangents),
        ]))
    }

    /// Checks that every output has room for `vertex_len` vertices.
    pub(super) fn check(&self, vertex_len: usize) -> Result<(), CallError> {
        for (output, len, argument) in self.0 {
            if let Some(output) = output {
                output.check(vertex_len, len, argument)?;
            }
        }
        Ok(())
    }
}

/// Checks that a range is inside `0..most`.
pub(super) fn check_range(vertices: &Range<usize>, most: usize) -> Result<(), CallError> {
    let Range { start, end } = *vertices;
    if start > end || end > most {
        let error = CallError::new(CallErrorKind::OutOfRange, Argument::Vertices);
        return Err(error.at(start).values(most, end));
    }
    Ok(())
}

impl Output<'_> {
    /// Checks that `vertex_len` vertices fit, with an attribute of `len` floats each.
    pub(super) fn check(
        &self,
        vertex_len: usize,
        len: usize,
        argument: Argument,
    ) -> Result<(), CallError> {
        if self.stride < len {
            let error = CallError::new(CallErrorKind::Stride, argument);
            return Err(error.values(len, self.stride));
        }
        let Some(last) = vertex_len.checked_sub(1) else { return Ok(()) };
        let least = last.checked_mul(self.stride).and_then(|at| at.checked_add(len));
        argument.check_least(least.unwrap_or(usize::MAX), self.floats.len())
    }

    /// Writes the attribute of eight vertices, from the i-th vertex of the range on. `None` cannot happen after
    /// [`Self::check`].
    #[inline(always)]
    pub(super) fn put_rows(&self, i: usize, rows: &[[f32; 4]; EIGHT]) -> Option<()> {
        // Chunks of 0 would panic.
        let chunks = self.floats.get(i * self.stride..)?.chunks(self.stride.max(1));
        for (out, [x, y, z, _]) in chunks.zip(rows) {
            let [out_x, out_y, out_z] = out.first_chunk()?;
            out_x.set(*x);
            out_y.set(*y);
            out_z.set(*z);
        }
        Some(())
    }

    /// Writes the attribute of the i-th vertex of the range. `None` cannot happen after [`Self::check`].
    #[inline(always)]
    pub(super) fn put<const N: usize>(&self, i: usize, value: [f32; N]) -> Option<()> {
        put(self.floats.get(i * self.stride..)?, value)
    }
}

/// Writes an attribute to the first N floats. `None` cannot happen after [`Output::check`].
#[inline(always)]
pub(super) fn put<const N: usize>(out: &[Cell<f32>], value: [f32; N]) -> Option<()> {
    debug_assert!(out.len() >= N, "an output is too short after its check");
    out.first_chunk::<N>()?.iter().zip(value).for_each(|(out, value)| out.set(value));
    Some(())
}
