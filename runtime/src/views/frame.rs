//! Evaluation of a map: from parameters to points, visibilities, scores of the key views, and
//! layers (METHOD §6.1, §6.3, §6.6, §6.9).

use super::blend::Blend;
use super::counts::ViewsCounts;
use super::view::Views;
use crate::error::{Argument, CallError};
use crate::kernel::{KernelCounts, KernelMap};
use crate::linear::{floats, split};
use crate::numeric::{greater, lesser};

/// Evaluates a map of an object.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(not(feature = "internals"), non_exhaustive)]
pub struct FrameJob<'a> {
    /// The object.
    pub views: Views<'a>,
    /// One of the object's maps, from [`crate::Model::map_of`].
    pub map: KernelMap<'a>,
    /// [`KernelMap::query_len`] numbers, as for [`KernelMap::evaluate`].
    pub parameters: &'a [f32],
}

/// Outputs of a [`FrameJob`].
#[derive(Debug)]
#[cfg_attr(not(feature = "internals"), non_exhaustive)]
pub struct Frame<'o> {
    /// K points: x to the right and y down, in pixels of the screen, and the depth, which grows
    /// away from the viewer.
    pub points: &'o mut [[f32; 3]],
    /// K visibilities; above 0.5 a point is visible.
    pub visibility: &'o mut [f32],
    /// N scores of the key views.
    pub scores: &'o mut [f32],
    /// Opacity (0 to 1) and order of L layers. Layers of greater order are drawn later.
    pub layers: &'o mut [[f32; 2]],
}

/// Result of a [`FrameJob`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(not(feature = "internals"), non_exhaustive)]
pub struct Found {
    /// The characteristic view, with the highest score; among equal scores the first view.
    pub view: usize,
    /// The map's confidence in the parameters, from [`KernelMap::evaluate`].
    pub confidence: f32,
}

impl<'o> Frame<'o> {
    /// Collects the outputs.
    pub const fn new(
        points: &'o mut [[f32; 3]],
        visibility: &'o mut [f32],
        scores: &'o mut [f32],
        layers: &'o mut [[f32; 2]],
    ) -> Self {
        Self { points, visibility, scores, layers }
    }
}

impl ViewsCounts {
    /// Returns the floats of scratch that [`FrameJob::run`] needs with a map.
    pub const fn frame_scratch_len(&self, map: &KernelCounts) -> usize {
        map.scratch_len().saturating_add(self.result_len())
    }
}

impl<'a> FrameJob<'a> {
    /// Makes the job.
    pub const fn new(views: Views<'a>, map: KernelMap<'a>, parameters: &'a [f32]) -> Self {
        Self { views, map, parameters }
    }

    /// Returns the floats of scratch that [`FrameJob::run`] needs.
    pub const fn scratch_len(&self) -> usize {
        self.views.counts().frame_scratch_len(&self.map.counts())
    }

    /// Evaluates the map, finds the characteristic view, and deforms a transferred object like its
    /// prototype.
    ///
    /// - `scratch`: at least [`FrameJob::scratch_len`] floats, of any content.
    ///
    /// # Errors
    /// - [`crate::CallErrorKind::Length`]: `parameters` or an output has another length; or the map is not
    ///   a map of the object.
    /// - [`crate::CallErrorKind::TooShort`]: `scratch` is too short.
    /// - The errors of [`KernelMap::evaluate`].
    pub fn run(&self, scratch: &mut [f32], out: &mut Frame<'_>) -> Result<Found, CallError> {
        let k = self.views.point_len();
        let counts = self.views.counts();
        Argument::Points.check_len(k, out.points.len())?;
        Argument::Visibility.check_len(k, out.visibility.len())?;
        Argument::Scores.check_len(self.views.view_len(), out.scores.len())?;
        Argument::Layers.check_len(self.views.layer_len(), out.layers.len())?;
        let least = counts.frame_scratch_len(&self.map.counts());
        Argument::Scratch.check_least(least, scratch.len())?;
        let (result, scratch) = split(scratch, counts.result_len());
        let confidence = self.map.evaluate(self.parameters, scratch, result)?;
        let (points, others) = split(result, 3 * k);
        let (visibility, others) = split(others, k);
        let (scores, layers) = split(others, self.views.view_len());
        let (opacities, orders) = split(layers, self.views.layer_len());
        let (points, _) = points.as_chunks_mut();
        self.deform(points, scores);
        let is_unsound = |point: &[f32; 3]| !point.iter().all(|x| x.is_finite());
        Argument::Points.check_finite(points.iter().position(is_unsound))?;
        out.points.iter_mut().zip(points).for_each(|(out, point)| *out = *point);
        out.visibility.iter_mut().zip(visibility).for_each(|(out, x)| *out = *x);
        out.scores.iter_mut().zip(&*scores).for_each(|(out, x)| *out = *x);
        for ((out, opacity), order) in out.layers.iter_mut().zip(opacities).zip(orders) {
            *out = [lesser(1.0, greater(0.0, *opacity)), *order];
        }
        Ok(Found { view: characteristic(scores), confidence })
    }

    /// Deforms a transferred object: `O' = R' + s (O - R)`, centred. R is the mean of the key
    /// views' references, weighted by their shares in the picture, so that no switch is visible.
    fn deform(&self, points: &mut [[f32; 3]], scores: &[f32]) {
        if !self.views.is_transferred() {
            return;
        }
        let blend = Blend::of_scores(scores);
        let deformations = || {
            let views = blend.views().iter();
            views.filter_map(|(view, share)| Some((*share, self.views.deformation(*view)?)))
        };
        // For s = 1 nothing is added, so no digit is lost.
        let growth: f32 = deformations().map(|(share, (ratio, _))| share * (ratio - 1.0)).sum();
        let centre = centre(points);
        for point in &mut *points {
            let [x, y, _] = point;
            (*x, *y) = (*x + growth * (*x - centre[0]), *y + growth * (*y - centre[1]));
        }
        for (share, (_, offsets)) in deformations() {
            for ([x, y, _], offset) in points.iter_mut().zip(offsets) {
                let [dx, dy] = floats(offset);
                (*x, *y) = (*x + share * dx, *y + share * dy);
            }
        }
    }
}

/// Returns the view with the highest score; among equal scores the first view.
fn characteristic(scores: &[f32]) -> usize {
    let (mut best, mut highest) = (0, f32::NEG_INFINITY);
    for (view, score) in scores.iter().enumerate() {
        if *score > highest {
            (best, highest) = (view, *score);
        }
    }
    best
}

/// Returns the mean of points on the screen.
fn centre(points: &[[f32; 3]]) -> [f32; 2] {
    let mut sums = [0.0; 2];
    for [x, y, _] in points {
        (sums[0], sums[1]) = (sums[0] + x, sums[1] + y);
    }
    sums.map(|sum| sum / points.len() as f32)
}
