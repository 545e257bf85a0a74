//! Scratch of a job: the palette as columns.

use crate::error::{Argument, CallError};
use core::cell::Cell;

/// A transform in the scratch of a job: a cache line with pairs of columns.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(64))]
pub struct CacheLine(pub(super) [[f32; 8]; 2]);

/// Scratch of a job, empty without.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Scratch<'a>(&'a [Cell<CacheLine>]);

impl<'a> Scratch<'a> {
    pub(super) fn new(lines: &'a mut [CacheLine]) -> Self {
        Self(Cell::from_mut(lines).as_slice_of_cells())
    }

    /// Returns the cache lines of scratch for a palette.
    pub(super) const fn least(palette_len: usize) -> usize {
        palette_len
    }

    /// Refuses scratch that is too short for a palette.
    pub(super) fn check(&self, palette_len: usize) -> Result<(), CallError> {
        match self.0.len() {
            0 => Ok(()),
            len => Argument::Scratch.check_least(palette_len, len),
        }
    }

    /// Returns the lines for a palette. `None` without scratch.
    pub(super) fn lines(&self, palette_len: usize) -> Option<&'a [Cell<CacheLine>]> {
        self.0.get(..palette_len).filter(|lines| !lines.is_empty())
    }
}
