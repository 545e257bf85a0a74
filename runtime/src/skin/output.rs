//! Where a job writes an attribute of its vertices.

use super::eight::EIGHT;
use crate::error::{Argument, CallError, CallErrorKind};
use core::cell::Cell;

/// Where an attribute is written: the i-th vertex *of the range* at `i * stride`.
#[derive(Clone, Copy, Debug)]
pub struct Output<'a> {
    /// Floats of the caller, by [`cells`]. Attributes may share them, each from its own first float
    /// on: so a vertex can be interleaved.
    pub floats: &'a [Cell<f32>],
    /// Floats from one vertex to the next; at least the attribute's own, 3 or 4.
    pub stride: usize,
}

/// Lends floats to several attributes of a [`super::SkinJob`]; they are written and never read.
pub fn cells(floats: &mut [f32]) -> &[Cell<f32>] {
    Cell::from_mut(floats).as_slice_of_cells()
}

impl Output<'_> {
    /// Checks that so many vertices fit, each with an attribute of so many floats.
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

    /// Writes the attribute of eight vertices from the i-th of the range on.
    #[inline(always)]
    pub(super) fn put_rows(&self, i: usize, rows: &[[f32; 4]; EIGHT]) -> Option<()> {
        // Chunks of zero would panic.
        let chunks = self.floats.get(i * self.stride..)?.chunks(self.stride.max(1));
        for (out, [x, y, z, _]) in chunks.zip(rows) {
            let [out_x, out_y, out_z] = out.first_chunk()?;
            out_x.set(*x);
            out_y.set(*y);
            out_z.set(*z);
        }
        Some(())
    }

    /// Writes the attribute of the i-th vertex of the range.
    #[inline(always)]
    pub(super) fn put<const N: usize>(&self, i: usize, value: [f32; N]) -> Option<()> {
        put(self.floats.get(i * self.stride..)?, value)
    }
}

/// Writes an attribute to its first floats.
#[inline(always)]
pub(super) fn put<const N: usize>(out: &[Cell<f32>], value: [f32; N]) -> Option<()> {
    out.first_chunk::<N>()?.iter().zip(value).for_each(|(out, value)| out.set(value));
    Some(())
}
