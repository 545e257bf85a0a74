//! Weights and maps fitted in turn.

use super::items::{Items, Maps, Supports, Weights};
use super::maps::fit_maps;
use super::weights::fit_weights;
use crate::progress::Progress;

/// Pull of an alternation's maps to where they were.
const PROXIMAL: f64 = 1e-7;

/// Weights and maps fitted in turn.
#[derive(Clone, Copy)]
pub struct Alternation {
    /// Most rounds.
    pub rounds: usize,
    /// Gain of a round, relative to the RMS error, below which it is the last.
    pub gain: f64,
}

/// What an alternation comes to.
pub struct Blend {
    /// Weights of the items.
    pub weights: Weights,
    /// The maps.
    pub maps: Maps,
    /// Squared error, summed over the items as they count.
    pub error: f64,
}

impl Alternation {
    /// Fits blends of at most `most` maps an item, starting from given maps.
    pub fn run(
        &self,
        items: &Items<'_>,
        maps: Maps,
        most: usize,
        progress: &dyn Progress,
    ) -> Blend {
        let supports = Supports::Free(most);
        let (weights, errors) = fit_weights(items, &maps, supports);
        let mut blend = Blend { weights, maps, error: items.sum(&errors) };
        for _ in 0..self.rounds {
            progress.advance(1);
            let maps = fit_maps(items, &blend.weights, &blend.maps, PROXIMAL);
            let (weights, errors) = fit_weights(items, &maps, supports);
            let last = blend.error;
            blend = Blend { weights, maps, error: items.sum(&errors) };
            if last.sqrt() - blend.error.sqrt() < self.gain * last.sqrt() {
                break;
            }
        }
        blend
    }
}
