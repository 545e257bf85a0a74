//! Positions by columns on small processors, which have no vector units: never.

use super::blend::Fours;
use super::job::CacheLine;
use super::output::Output;
use crate::linear::{Le, Matrix3x4};
use core::cell::Cell;

#[inline(always)]
pub(super) const fn skin_positions(
    _: &[Matrix3x4],
    _: &[Cell<CacheLine>],
    _: &[[Le; 3]],
    _: Fours<'_>,
    _: &Output<'_>,
) -> Option<()> {
    None
}
