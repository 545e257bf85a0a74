//! Scratch memory on the stack.

use core::ops::{Deref, DerefMut};

/// N floats of scratch; pass `&mut workspace` as a scratch argument.
///
/// [`crate::envelope::scratch_len`] computes N at compile time, so the size can be a constant.
#[derive(Clone, Copy, Debug)]
pub struct Workspace<const N: usize>([f32; N]);

impl<const N: usize> Workspace<N> {
    /// Makes a workspace of N zeros.
    pub const fn new() -> Self {
        Self([0.0; N])
    }
}

impl<const N: usize> Default for Workspace<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> Deref for Workspace<N> {
    type Target = [f32];

    fn deref(&self) -> &[f32] {
        &self.0
    }
}

impl<const N: usize> DerefMut for Workspace<N> {
    fn deref_mut(&mut self) -> &mut [f32] {
        &mut self.0
    }
}
