//! How well a group knows a pose: the posterior variance of its kernel map (METHOD §2.6).

use crate::linear::Le;
use crate::numeric::{greater, lesser, nearness, smoothstep};

/// What is left to doubt where nothing is known.
const DOUBT: f32 = 1.0e30;

/// What a group holds of the variance of its map.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Trust {
    /// Squared distance from rest up to which the variance tells; four times as far nothing is known any more.
    pub reach: f32,
    /// Share of the linear kernel: the prior variance is `1 - G(|x|^2)^2 + linear |x|^2`.
    pub linear: f32,
    /// Expected squared distance of the base from the truth, over what counts as none, per unit of variance.
    pub signal: f32,
    /// The same of the map, per unit of the variance that is left.
    pub noise: f32,
}

/// What is known of a pose, and what is in doubt: expected squared distances over what counts as none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Evidence {
    /// What of the base's error is known.
    pub known: f32,
    /// What may be left of it.
    pub doubted: f32,
}

impl Trust {
    /// Returns the numbers as a row holds them.
    pub(crate) fn words(&self) -> [Le; 4] {
        [self.reach, self.linear, self.signal, self.noise].map(f32::to_le_bytes)
    }

    /// Weighs the variance that the training poses explain against what they leave.
    ///
    /// - `input`: x, 0 at rest.
    /// - `change`: what the kernel of the first centre, which is the rest pose, changes by.
    /// - `certainty`: values whose squares sum to the variance that is explained.
    pub(crate) fn evidence<'a>(
        &self,
        input: &[f32],
        change: f32,
        certainty: impl Iterator<Item = &'a f32>,
    ) -> Evidence {
        let mut apart = 0.0;
        for x in input {
            apart += x * x;
        }
        let near = nearness(apart, (self.reach, 4.0 * self.reach));
        if near == 0.0 {
            return Evidence { known: 0.0, doubted: DOUBT };
        }
        let prior = greater(0.0, -change * (2.0 + change) + self.linear * apart);
        let mut explained = 0.0;
        for value in certainty {
            explained += value * value;
        }
        let explained = near * lesser(prior, explained);
        Evidence { known: self.signal * explained, doubted: self.noise * (prior - explained) }
    }
}

impl Evidence {
    /// Adds what is known of other vertices.
    pub(crate) fn and(self, other: Self) -> Self {
        Self { known: self.known + other.known, doubted: self.doubted + other.doubted }
    }

    /// Returns the confidence, in [0, 1]: the expected share of what is known.
    pub fn confidence(self) -> f32 {
        let known = 1.0 + self.known;
        known / (known + self.doubted)
    }

    /// Returns w, what a map is multiplied by: 1 but where it is much more likely to spoil than to mend.
    pub(crate) fn share(self) -> f32 {
        smoothstep(lesser(1.0, 8.0 * self.confidence()))
    }
}
