//! Jobs use no scratch on small processors, which have no vector units.

use crate::error::CallError;
use core::marker::PhantomData;

/// A transform in the scratch of a job. Small processors use none.
#[derive(Clone, Copy, Debug, Default)]
pub struct CacheLine;

/// Scratch of a job.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Scratch<'a>(PhantomData<&'a mut [CacheLine]>);

impl<'a> Scratch<'a> {
    pub(super) const fn new(_: &'a mut [CacheLine]) -> Self {
        Self(PhantomData)
    }

    pub(super) const fn least(_: usize) -> usize {
        0
    }

    #[inline(always)]
    pub(super) const fn check(&self, _: usize) -> Result<(), CallError> {
        Ok(())
    }
}
