//! Scratch on small processors, which have no vector units: jobs use none.

use super::blend::Fours;
use super::output::Output;
use crate::error::CallError;
use crate::linear::{Le, Matrix3x4};
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

    #[inline(always)]
    pub(super) const fn positions(
        &self,
        _: &[Matrix3x4],
        _: &[[Le; 3]],
        _: Fours<'_>,
        _: &Output<'_>,
    ) -> Option<()> {
        None
    }
}
