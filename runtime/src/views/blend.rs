//! Shares of the key views in a picture (METHOD §6.9).

use crate::numeric::greater;

/// Largest number of key views per element.
pub(super) const SOURCES_MAX: usize = 8;
/// Weight of a view with a score of 0 or less, against a score of 1. The weight matters if no other
/// view shows an element.
const FAR_WEIGHT: f32 = 1e-3;
/// Weight of a view that does not fit, against a fitting view.
const UNFIT_WEIGHT: f32 = 1e-6;
/// Share of the greatest weight at which a view enters the picture, with share 0.
const ENTRY_SHARE: f32 = 0.2;

/// Key views with their shares, the greatest first. The shares sum to 1. `RenderJob::blend` makes
/// the shares of an element's texture, and [`Self::of_scores`] the shares of an object's points.
#[derive(Clone, Copy, Debug)]
pub struct Blend {
    views: [(usize, f32); SOURCES_MAX],
    len: usize,
}

impl Blend {
    /// Computes the shares of N key views from their scores alone.
    ///
    /// A key view at its own parameters has share 1. Shares change continuously between key views.
    pub fn of_scores(scores: &[f32]) -> Self {
        Self::new(scores, |_| 1.0)
    }

    /// Computes the shares of key views from their scores. Shares are continuous in both arguments.
    ///
    /// - `fits`: how well a view shows the visible side, from 0 to 1.
    pub(super) fn new(scores: &[f32], fits: impl Fn(usize) -> f32) -> Self {
        let highest = scores.iter().copied().fold(f32::NEG_INFINITY, greater);
        // One place more than needed. The weight in this place is subtracted from all others, so
        // that no view drops out suddenly.
        let mut most = [(0, 0.0); SOURCES_MAX + 1];
        for (view, score) in scores.iter().enumerate() {
            let near = greater(*score, 0.0) + FAR_WEIGHT / (1.0 + (highest - score));
            let mut own = (view, near * (fits(view) + UNFIT_WEIGHT));
            for other in &mut most {
                if own.1 > other.1 {
                    core::mem::swap(&mut own, other);
                }
            }
        }
        let [first, .., last] = most;
        let least = greater(ENTRY_SHARE * first.1, last.1);
        let mut out = Self { views: [(0, 0.0); SOURCES_MAX], len: 0 };
        let mut whole = 0.0;
        for (out, (view, count)) in out.views.iter_mut().zip(most) {
            *out = (view, greater(count - least, 0.0));
            whole += out.1;
        }
        if whole > 0.0 {
            out.views.iter_mut().for_each(|(_, share)| *share /= whole);
        } else {
            // All places hold equal weights: take the first view.
            out.views[0] = (first.0, 1.0);
        }
        out.len = out.views.iter().take_while(|(_, share)| *share > 0.0).count();
        out
    }

    /// Lists the numbers of the views, each with its share.
    pub fn views(&self) -> &[(usize, f32)] {
        self.views.get(..self.len).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    fn shares(scores: &[f32], fits: &[f32]) -> Vec<f32> {
        let mut out = std::vec![0.0; scores.len()];
        let blend = Blend::new(scores, |view| fits[view]);
        blend.views().iter().for_each(|(view, share)| out[*view] += share);
        out
    }

    #[test]
    fn a_key_view_is_its_own_picture_and_between_two_both_count() {
        assert_eq!(shares(&[0.0, 1.0, 0.0], &[1.0; 3]), [0.0, 1.0, 0.0]);
        let [a, b, c] = shares(&[0.5, 0.5, -0.25], &[1.0; 3])[..] else { unreachable!() };
        assert_eq!((a, b, c), (0.5, 0.5, 0.0));
    }

    #[test]
    fn shares_are_those_of_the_formula() {
        // Scores 0.6 and 0.4: weights 0.601 and 0.4 + 0.001 / 1.2, less 0.2 x 0.601.
        let [a, b] = [0.601 - 0.1202, 0.4 + 0.001 / 1.2 - 0.1202];
        let found = Blend::of_scores(&[0.4, 0.6]);
        let [(0, low), (1, high)] = [found.views()[1], found.views()[0]] else { panic!() };
        assert!((high - a / (a + b)).abs() < 1e-6 && (low - b / (a + b)).abs() < 1e-6);
        // Nine equal views leave no weight over: the first view counts.
        assert_eq!(Blend::of_scores(&[0.1; 9]).views(), [(0, 1.0)]);
        assert_eq!(Blend::of_scores(&[-0.5]).views(), [(0, 1.0)]);
    }

    #[test]
    fn a_view_that_does_not_fit_counts_where_no_other_does() {
        assert_eq!(shares(&[0.0, 1.0, 0.0], &[1.0, 0.0, 0.0]), [1.0, 0.0, 0.0]);
        assert_eq!(shares(&[0.0, 1.0, 0.0], &[0.0; 3]), [0.0, 1.0, 0.0]);
        // Among fitting views without a score, the nearest counts most.
        let found = shares(&[-0.5, 1.0, -0.1], &[1.0, 0.0, 1.0]);
        assert!(found[1] == 0.0 && found[2] > found[0]);
    }

    /// Largest change of a share between steps, for twelve views along a line. A view's score falls
    /// with the distance.
    fn largest(steps: usize, fits: impl Fn(f32, usize) -> f32) -> f32 {
        let (mut before, mut largest): (Option<Vec<f32>>, _) = (None, 0.0f32);
        for step in 0..=steps {
            let x = 4.0 * step as f32 / steps as f32 - 2.0;
            let scores: Vec<f32> =
                (0..12).map(|k| 0.4 - (x - (k as f32 / 3.0 - 2.0)).abs() * 0.3).collect();
            let fits: Vec<f32> = (0..12).map(|k| fits(x, k)).collect();
            let found = shares(&scores, &fits);
            assert!((found.iter().sum::<f32>() - 1.0).abs() < 1e-5);
            if let Some(before) = before.replace(found.clone()) {
                let apart = before.iter().zip(&found).map(|(a, b)| (a - b).abs());
                largest = apart.fold(largest, f32::max);
            }
        }
        largest
    }

    #[test]
    fn shares_are_continuous() {
        // An element turns to the viewer; three of the views show it.
        let turns_up = |x: f32, k: usize| {
            let whole = crate::numeric::smoothstep((x + 0.5).clamp(0.0, 1.0));
            if k < 3 { whole } else { 1.0 - whole }
        };
        assert!(largest(4000, turns_up) < 0.02);
        assert!(largest(4000, |_, _| 1.0) < 0.001);
        // Where no view has fitted so far, a view that starts to fit takes over within a thousandth
        // of a fit. The change is steep but continuous.
        let begins = |x: f32, k: usize| (x + k as f32 / 6.0).clamp(0.0, 1.0);
        let [coarse, fine] = [4_000, 64_000].map(|steps| largest(steps, begins));
        assert!(fine < 0.04 && fine < coarse / 8.0, "{coarse} {fine}");
    }
}
