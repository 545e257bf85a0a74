//! Outputs of a job: strided arrays of one attribute.

use crate::error::{Argument, CallError, CallErrorKind};
use core::cell::Cell;
use core::ops::Range;

/// Output of one attribute: positions, normals or tangents. A job writes the i-th vertex *of its range* at float
/// `i * stride`, and leaves all other floats alone.
#[derive(Clone, Debug)]
pub struct Output<'a> {
    /// Floats from the attribute of the first vertex on. Interleaved attributes share floats.
    pub(super) floats: &'a [Cell<f32>],
    pub(super) stride: usize,
}

impl<'a> Output<'a> {
    /// Makes an output with its own floats.
    ///
    /// - `floats`: `stride` floats for each vertex; the last vertex needs only its attribute.
    /// - `stride`: floats from one vertex to the next; at least the length of the attribute, 3 or 4.
    pub fn new(floats: &'a mut [f32], stride: usize) -> Self {
        Self::shared(Cell::from_mut(floats).as_slice_of_cells(), stride)
    }

    /// Splits interleaved vertices into outputs: `let [positions, normals] = Output::interleaved(floats, 8, [0, 3])`.
    ///
    /// - `floats`: `stride` floats for each vertex.
    /// - `stride`: floats from one vertex to the next.
    /// - `offsets`: first float of each attribute in a vertex, in any order. A job refuses attributes that overlap.
    pub fn interleaved<const N: usize>(
        floats: &'a mut [f32],
        stride: usize,
        offsets: [usize; N],
    ) -> [Self; N] {
        let floats = Cell::from_mut(floats).as_slice_of_cells();
        offsets.map(|offset| Self::shared(floats.get(offset..).unwrap_or_default(), stride))
    }

    /// Makes an output whose floats other outputs may share.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) const fn shared(floats: &'a [Cell<f32>], stride: usize) -> Self {
        Self { floats, stride }
    }
}

/// Outputs of a job, each with the floats of its attribute and the argument to name in errors.
pub(super) struct Outputs<'o, 'a>([(Option<&'o Output<'a>>, usize, Argument); 3]);

impl<'o, 'a> Outputs<'o, 'a> {
    /// Collects the outputs of a job; an error if there is none.
    ///
    /// - `outputs`: positions, normals, tangents.
    pub(super) fn new(outputs: [Option<&'o Output<'a>>; 3]) -> Result<Self, CallError> {
        let [positions, normals, tangents] = outputs;
        if positions.is_none() && normals.is_none() && tangents.is_none() {
            return Err(CallError::new(CallErrorKind::NoOutput, Argument::Call));
        }
        Ok(Self([
            (positions, 3, Argument::Positions),
            (normals, 3, Argument::Normals),
            (tangents, 4, Argument::Tangents),
        ]))
    }

    /// Checks that every output has room for `vertex_len` vertices, and that no two outputs overlap.
    pub(super) fn check(&self, vertex_len: usize) -> Result<(), CallError> {
        let [positions, normals, tangents] = &self.0;
        for (output, len, argument) in self.0 {
            if let Some(output) = output {
                output.check(vertex_len, len, argument)?;
            }
        }
        // Without the feature, a job has no second output.
        let pairs = [[positions, normals], [positions, tangents], [normals, tangents]];
        let pairs = if cfg!(feature = "normals") { &pairs[..] } else { &[] };
        for [(first, first_len, _), (second, len, argument)] in pairs {
            if let (Some(first), Some(second)) = (first, second)
                && first.overlaps(*first_len, second, *len, vertex_len)
            {
                return Err(CallError::new(CallErrorKind::Overlap, *argument));
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

    /// Whether two checked outputs of `vertex_len` vertices write a common float, or could with other strides.
    ///
    /// - `own_len`, `other_len`: floats of the attributes.
    fn overlaps(&self, own_len: usize, other: &Self, other_len: usize, vertex_len: usize) -> bool {
        let starts = [self, other].map(|output| output.floats.as_ptr().addr() / size_of::<f32>());
        let end = |output: &Self, start: usize, len: usize| {
            start + output.stride * vertex_len.saturating_sub(1) + len
        };
        let [own, others] = starts;
        let apart = end(self, own, own_len) <= others || end(other, others, other_len) <= own;
        if vertex_len == 0 || apart {
            return false;
        }
        // Interleaved: the other attribute starts `ahead` floats behind this one in each vertex.
        let distance = others as isize - own as isize;
        let ahead = distance.checked_rem_euclid(self.stride as isize).unwrap_or(0) as usize;
        self.stride != other.stride || ahead < own_len || self.stride - ahead < other_len
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
