//! Weights and maps fitted in turn.

use super::items::{Items, Maps, Supports, Weights};
use super::maps::fit_maps;
use super::weights::fit_weights;

/// Pull of items' maps to where they were.
const PROXIMAL: f64 = 1e-7;

/// What weights and maps are fitted in turn to.
pub trait InTurn {
    /// Fits weights to maps; gives them and what squared error they leave.
    fn weights(&self, maps: &Maps, supports: Supports<'_>) -> (Weights, f64);
    /// Fits maps to weights, starting from others.
    fn maps(&self, weights: &Weights, from: &Maps) -> Maps;
}

impl InTurn for Items<'_> {
    fn weights(&self, maps: &Maps, supports: Supports<'_>) -> (Weights, f64) {
        let (weights, errors) = fit_weights(self, maps, supports);
        (weights, self.sum(&errors))
    }

    fn maps(&self, weights: &Weights, from: &Maps) -> Maps {
        fit_maps(self, weights, from, PROXIMAL)
    }
}

/// Weights and maps, and what squared error they leave.
pub struct Blend {
    /// Weights of the items.
    pub weights: Weights,
    /// The maps.
    pub maps: Maps,
    /// Squared error, summed over the items as they count.
    pub error: f64,
}

/// How weights and maps are fitted in turn.
#[derive(Clone, Copy)]
pub struct Alternation {
    /// Rounds at the start. In some rounds each item also chooses its maps.
    pub choices: usize,
    /// Items choose in every `every`-th of the first rounds. Between choices the maps settle.
    pub every: usize,
    /// Rounds after them, in which items keep their maps.
    pub rounds: usize,
    /// Most of its last step that a round starts ahead.
    pub ahead: f64,
}

impl Alternation {
    /// Returns how many rounds there are.
    pub fn count(&self) -> usize {
        self.choices + self.rounds
    }

    /// Starts from maps, and of each item from what serves it better of the nearest maps and those that it follows by some
    /// weights.
    ///
    /// - `most`: most maps that an item follows.
    /// - `advance`: called once a round.
    pub fn run(
        &self,
        fit: &impl InTurn,
        (others, maps): (&Weights, Maps),
        most: usize,
        advance: impl Fn(),
    ) -> (Weights, Maps) {
        let mut now = Round::first(others.clone(), maps);
        for round in 0..self.count() {
            let last = &now.weights;
            let supports = if round < self.choices && round.is_multiple_of(self.every) {
                Supports::Better { most, others, last }
            } else {
                Supports::Fixed(last)
            };
            now = now.next(fit, supports, self.ahead);
            advance();
        }
        (now.weights, now.maps)
    }

    /// Fits items with at most `most` maps each, from maps alone.
    pub fn blend(&self, items: &Items<'_>, maps: Maps, most: usize, advance: impl Fn()) -> Blend {
        let (nearest, _) = items.weights(&maps, Supports::Free(most));
        let (weights, maps) = self.run(items, (&nearest, maps), most, advance);
        let (weights, error) = items.weights(&maps, Supports::Fixed(&weights));
        Blend { weights, maps, error }
    }
}

/// What a round comes to.
#[derive(Clone)]
struct Round {
    weights: Weights,
    /// Squared error before the maps were fitted.
    error: f64,
    /// The maps, and those to go on from.
    maps: Maps,
    ahead: Maps,
    /// Rounds since one went too far.
    steps: f64,
}

impl Round {
    fn first(weights: Weights, maps: Maps) -> Self {
        Self { weights, error: f64::INFINITY, ahead: maps.clone(), maps, steps: 0.0 }
    }

    /// Fits weights, then maps. A round starts a step ahead of where the last one came to (Nesterov 1983), or there where
    /// that was too far.
    fn next(&self, fit: &impl InTurn, supports: Supports<'_>, most_ahead: f64) -> Self {
        let (weights, error) = fit.weights(&self.ahead, supports);
        if self.steps > 0.0 && error > self.error {
            return Self { ahead: self.maps.clone(), steps: 0.0, ..self.clone() };
        }
        let maps = fit.maps(&weights, &self.ahead);
        let step = most_ahead * self.steps / (self.steps + 3.0);
        let columns = &maps.columns + (&maps.columns - &self.maps.columns) * faer::Scale(step);
        let ahead = Maps { width: maps.width, columns };
        Self { weights, error, maps, ahead, steps: self.steps + 1.0 }
    }
}
