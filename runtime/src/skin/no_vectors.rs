//! Small processors have no vector units: jobs use no scratch, and skin one vertex at a time.

use super::job::SkinJob;
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

#[inline(always)]
pub(super) const fn run(_: &SkinJob<'_>) -> Option<()> {
    None
}
