//! The box that a shaped and posed skin stays within.

use super::super::bounds::Bounds;
use super::super::view::Skin;
use super::blocks::Blocks;
use crate::error::{Argument, CallError};
use crate::linear::Matrix3x4;
use crate::numeric::{greater, lesser};

impl Skin<'_> {
    /// Computes a box that holds every vertex of the shaped and posed skin, as [`Skin::bounds`] does of the skin at
    /// rest, each rest box widened by what the shapes of these weights may add.
    ///
    /// - `palette`: [`Skin::palette_len`] transforms.
    /// - `weights`: [`Skin::shape_len`] weights z.
    ///
    /// # Errors
    /// - [`crate::CallErrorKind::Length`]: `palette` or `weights` has another length.
    /// - [`crate::CallErrorKind::NonFinite`]: a weight is not finite.
    pub fn shaped_bounds(
        &self,
        palette: &[Matrix3x4],
        weights: &[f32],
    ) -> Result<Option<Bounds>, CallError> {
        Argument::Palette.check_len(self.palette_len(), palette.len())?;
        self.check_weights(weights)?;
        let added = self.added(weights);
        Ok(self.posed_bounds(palette, |rest| rest.add(&added)))
    }

    /// Computes the box of what shapes add to any vertex, 0 among it.
    fn added(&self, weights: &[f32]) -> Bounds {
        let (mut sum, mut magnitude) = (Bounds::of([0.0; 3]), [0.0; 3]);
        for (row, weight) in Blocks::of(self).rows.iter().zip(weights) {
            let Some(own) = row.last_chunk().and_then(Bounds::from_corners) else { continue };
            let sides = sum.min.iter_mut().zip(&mut sum.max).zip(&mut magnitude);
            for (((min, max), magnitude), (lo, hi)) in sides.zip(own.min.iter().zip(&own.max)) {
                let (a, b) = (weight * lo, weight * hi);
                *min += lesser(a, b);
                *max += greater(a, b);
                *magnitude += greater(a.abs(), b.abs());
            }
        }
        // A product, the step's rounding, and a sum a shape, here and where vertices are moved.
        let slack = 2.0 * (weights.len() as f32 + 4.0) * f32::EPSILON;
        let sides = sum.min.iter_mut().zip(&mut sum.max).zip(magnitude);
        sides.for_each(|((min, max), magnitude)| {
            *min -= slack * magnitude;
            *max += slack * magnitude;
        });
        sum
    }
}
