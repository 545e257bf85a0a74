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
    /// Rounds from each of two starts, before the one that comes nearer goes on alone.
    pub tries: usize,
    /// Rounds in which each item also chooses what it follows, the tries among them.
    pub choices: usize,
    /// Those after them.
    pub rounds: usize,
    /// Most of its last step that a round starts ahead.
    pub ahead: f64,
}

impl Alternation {
    /// Goes from the maps of a start, or of two, to weights and maps. An item follows what serves it better of the nearest
    /// maps and those that it follows by some weights; where there are none, by those of the round before.
    ///
    /// - `most`: most maps that an item follows.
    /// - `advance`: called once a round.
    pub fn run(
        &self,
        fit: &impl InTurn,
        others: Option<&Weights>,
        (start, rival): (Maps, Option<Maps>),
        most: usize,
        advance: impl Fn(),
    ) -> (Weights, Maps) {
        let free = others.map_or(Supports::Free(most), |others| Supports::Better {
            most,
            others,
            last: others,
        });
        let first = |maps: Maps| {
            advance();
            Round::first(fit, &maps, free)
        };
        let (mut now, mut rival) = (first(start), rival.map(first));
        for round in 1..self.choices + self.rounds {
            if round == self.tries {
                now = rival.take().filter(|rival| rival.error < now.error).unwrap_or(now);
            }
            let next = |now: Round| {
                advance();
                let last = &now.weights;
                let better = Supports::Better { most, others: others.unwrap_or(last), last };
                let is_choice = round < self.choices;
                now.next(fit, if is_choice { better } else { Supports::Fixed(last) }, self.ahead)
            };
            (now, rival) = (next(now), rival.map(next));
        }
        (now.weights, now.maps)
    }

    /// Counts the rounds from so many starts.
    pub fn count(&self, starts: usize) -> usize {
        self.choices + self.rounds + (starts - 1) * self.tries
    }

    /// Fits items with at most `most` maps each, from maps alone.
    pub fn blend(
        &self,
        items: &Items<'_>,
        starts: (Maps, Option<Maps>),
        most: usize,
        advance: impl Fn(),
    ) -> Blend {
        let (weights, maps) = self.run(items, None, starts, most, advance);
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
    /// Fits weights, then maps.
    fn first(fit: &impl InTurn, start: &Maps, supports: Supports<'_>) -> Self {
        let (weights, error) = fit.weights(start, supports);
        let maps = fit.maps(&weights, start);
        Self { weights, error, ahead: maps.clone(), maps, steps: 1.0 }
    }

    /// Does so again. A round starts a step ahead of where the last one came to (Nesterov 1983), or there where
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
