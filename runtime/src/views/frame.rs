//! From parameters to points, their visibility, and the key view that they are most like (METHOD §6.1, §6.3, §6.6).

use super::counts::ViewsCounts;
use super::view::Views;
use crate::error::{Argument, CallError, CallErrorKind};
use crate::kernel::{KernelCounts, KernelMap};
use crate::linear::{floats, split};
use crate::numeric::{greater, smoothstep};

/// Evaluates a map of an object.
#[derive(Clone, Copy, Debug)]
pub struct FrameJob<'a> {
    /// The object.
    pub views: Views<'a>,
    /// One of its maps, of [`crate::Model::map_of`].
    pub map: KernelMap<'a>,
    /// [`KernelMap::query_len`] numbers, as [`KernelMap::evaluate`] takes them.
    pub parameters: &'a [f32],
    /// The characteristic view of the frame before; `None` of a first frame, and of one that knows of no other.
    pub last: Option<usize>,
    /// By how much a key view's score must be above that of `last` to take over, and where the motion of what was
    /// transferred goes from one to the other; [`super::ViewsFit::margin`], or another.
    pub margin: f32,
}

/// What a [`FrameJob`] writes.
#[derive(Debug)]
pub struct Frame<'o> {
    /// K points: x to the right and y down, in pixels of the screen, and depth, which grows away from the viewer.
    pub points: &'o mut [[f32; 3]],
    /// K visibilities; above 0.5 a point is visible.
    pub visibility: &'o mut [f32],
    /// N scores of key views.
    pub scores: &'o mut [f32],
}

/// What a [`FrameJob`] found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// The characteristic view.
    pub view: usize,
    /// The map's confidence in the parameters, as [`KernelMap::evaluate`] returns it.
    pub confidence: f32,
}

impl ViewsCounts {
    /// Returns the floats of scratch that [`FrameJob::run`] needs with a map.
    pub const fn frame_scratch_len(&self, map: &KernelCounts) -> usize {
        map.scratch_len().saturating_add(self.result_len())
    }
}

impl FrameJob<'_> {
    /// Evaluates the map, chooses the characteristic view, and moves what was transferred as its prototype moves.
    ///
    /// - `scratch`: at least [`ViewsCounts::frame_scratch_len`] floats, of any content.
    ///
    /// # Errors
    /// - [`CallErrorKind::Length`]: `parameters` has another length; or an output; or the map is not one of the
    ///   object's.
    /// - [`CallErrorKind::TooShort`]: `scratch` is too short.
    /// - [`CallErrorKind::OutOfRange`]: `last` is no key view, or `margin` is negative or not finite.
    /// - Those of [`KernelMap::evaluate`].
    pub fn run(&self, scratch: &mut [f32], out: Frame<'_>) -> Result<Found, CallError> {
        let (k, n) = (self.views.point_len(), self.views.view_len());
        let counts = self.views.counts();
        Argument::Points.check_len(k, out.points.len())?;
        Argument::Visibility.check_len(k, out.visibility.len())?;
        Argument::Scores.check_len(n, out.scores.len())?;
        let least = counts.frame_scratch_len(&self.map.counts());
        Argument::Scratch.check_least(least, scratch.len())?;
        let unsound = |found| {
            Err(CallError::new(CallErrorKind::OutOfRange, Argument::Scores)
                .values(n.saturating_sub(1), found))
        };
        match self.last {
            Some(last) if last >= n => return unsound(last),
            _ if !(0.0..=f32::MAX).contains(&self.margin) => return unsound(n),
            _ => {}
        }
        let (result, scratch) = split(scratch, counts.result_len());
        let confidence = self.map.evaluate(self.parameters, scratch, result)?;
        let (points, others) = split(result, 3 * k);
        let (visibility, scores) = split(others, k);
        let (points, _) = points.as_chunks_mut();
        let view = self.characteristic(scores);
        self.deform(points, scores);
        if let Some(at) = points.as_flattened().iter().position(|x| !x.is_finite()) {
            return Err(CallError::new(CallErrorKind::NonFinite, Argument::Points).at(at / 3));
        }
        out.points.iter_mut().zip(points).for_each(|(out, point)| *out = *point);
        out.visibility.iter_mut().zip(visibility).for_each(|(out, x)| *out = *x);
        out.scores.iter_mut().zip(scores).for_each(|(out, x)| *out = *x);
        Ok(Found { view, confidence })
    }

    /// Returns the view of the highest score, of equal ones the first; the last one while no other is more than the
    /// margin above it.
    fn characteristic(&self, scores: &[f32]) -> usize {
        let (mut best, mut highest) = (0, f32::NEG_INFINITY);
        for (view, score) in scores.iter().enumerate() {
            if *score > highest {
                (best, highest) = (view, *score);
            }
        }
        match self.last {
            Some(last) if scores.get(last).is_some_and(|own| highest - own <= self.margin) => last,
            _ => best,
        }
    }

    /// Moves an object that was transferred: `O' = R' + s (O - R)`, centred, R the mean of the key views' references by
    /// how near each is to the highest score. That mean does not depend on the view before, and has gone all the
    /// way to another view when that takes over, so that no switch is seen.
    fn deform(&self, points: &mut [[f32; 3]], scores: &[f32]) {
        if !self.views.is_transferred() {
            return;
        }
        let highest = scores.iter().copied().fold(f32::NEG_INFINITY, greater);
        let share = |score: f32| {
            let behind = highest - score;
            if behind <= 0.0 {
                1.0
            } else if behind < self.margin {
                smoothstep(1.0 - behind / self.margin)
            } else {
                0.0
            }
        };
        let whole: f32 = scores.iter().map(|score| share(*score)).sum();
        let deformations = || {
            let shares = scores.iter().map(|score| share(*score) / whole).enumerate();
            shares
                .filter(|(_, share)| *share > 0.0)
                .filter_map(|(view, share)| Some((share, self.views.deformation(view)?)))
        };
        // Where s is 1 nothing is added, and no digit lost.
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

/// Returns the mean of points on the screen.
fn centre(points: &[[f32; 3]]) -> [f32; 2] {
    let mut sums = [0.0; 2];
    for [x, y, _] in points {
        (sums[0], sums[1]) = (sums[0] + x, sums[1] + y);
    }
    sums.map(|sum| sum / points.len() as f32)
}
