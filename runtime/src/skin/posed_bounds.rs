//! The box that a posed skin stays within.

use super::bounds::Bounds;
use super::counts::WEIGHT_SUM_TOLERANCE;
use super::view::Skin;
use crate::error::{Argument, CallError, CallErrorKind};
use crate::linear::{Matrix3x4, floats};

impl Skin<'_> {
    /// Computes a box that holds every vertex of the posed skin; `None` if there are no vertices.
    ///
    /// It is the union of what each transform makes of its rest box, rounded outward. Conservative,
    /// because a skinned vertex is a weighted mean of where its transforms take it. A skin without an
    /// envelope has the box of its rest positions.
    ///
    /// - `palette`: [`Skin::palette_len`] transforms.
    /// - `rest_offset`: how far a rest mesh of the caller's ([`super::SkinJob::rest`]) has any
    ///   position from the file's, along each axis at most; 0 for the file's own.
    ///
    /// # Errors
    /// - [`CallErrorKind::Length`]: `palette` has another length.
    /// - [`CallErrorKind::OutOfRange`]: `rest_offset` is negative or no number.
    pub fn bounds(
        &self,
        palette: &[Matrix3x4],
        rest_offset: f32,
    ) -> Result<Option<Bounds>, CallError> {
        Argument::Palette.check_len(self.palette_len(), palette.len())?;
        if !(0.0..=f32::MAX).contains(&rest_offset) {
            return Err(CallError::new(CallErrorKind::OutOfRange, Argument::RestPositions));
        }
        Ok(self.posed_bounds(palette, |rest| rest.widen(rest_offset)))
    }

    /// Computes a box that holds every vertex of the posed skin, after `widen` has widened each box at rest.
    ///
    /// - `palette`: as many transforms as it takes.
    pub(super) fn posed_bounds(
        &self,
        palette: &[Matrix3x4],
        widen: impl Fn(&mut Bounds),
    ) -> Option<Bounds> {
        // A weighted mean of K terms and a product of 4 err by less than K + 8 roundings.
        let slack = WEIGHT_SUM_TOLERANCE + (self.influence_len() as f32 + 8.0) * f32::EPSILON;
        let mut union: Option<Bounds> = None;
        let mut join = |own: &Bounds| match &mut union {
            Some(union) => union.join(own),
            None => union = Some(*own),
        };
        for (rest, transform) in self.boxes().iter().zip(palette) {
            if let Some(mut rest) = Bounds::from_corners(rest) {
                widen(&mut rest);
                join(&rest.moved(transform, slack));
            }
        }
        let fixed = if self.envelope_part().is_none() { self.positions() } else { &[] };
        for position in fixed {
            let mut rest = Bounds::of(floats(position));
            widen(&mut rest);
            join(&rest);
        }
        union
    }
}
