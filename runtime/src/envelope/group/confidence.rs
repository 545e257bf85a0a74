//! Confidence of a group, from the variance of its kernel map (METHOD §2.6).

use crate::linear::Le;
use crate::numeric::{greater, lesser, nearness, smoothstep};

/// Unexplained error far from the training poses, where nothing is explained.
const FAR: f32 = 1.0e30;
/// Parameters of a group's confidence: how the variance of the group's kernel map becomes an expected error.
///
/// Errors are squared distances, divided by the squared distance that counts as no error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GroupConfidence {
    /// Squared distance from rest where the explained variance starts to fade; it is 0 from four times `reach` on.
    pub reach: f32,
    /// Share of the linear kernel: the prior variance is `1 - G(|x|^2)^2 + linear |x|^2`.
    pub linear: f32,
    /// Expected error of the base, per unit of variance times growth.
    pub signal: f32,
    /// Expected error of the map, per unit of unexplained variance times growth.
    pub noise: f32,
}

/// Expected error of a palette without its correction, in two parts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ExpectedError {
    /// Part that the training poses explain. The correction removes this part.
    explained: f32,
    /// Part that the correction may leave.
    unexplained: f32,
}

impl GroupConfidence {
    /// `reach` over the squared distance from rest where the error's growth turns from quartic to quadratic.
    pub const TURN: f32 = 4.0;

    /// Returns the four floats of a row in the file.
    pub(crate) fn words(&self) -> [Le; 4] {
        [self.reach, self.linear, self.signal, self.noise].map(f32::to_le_bytes)
    }

    /// Computes the expected error, from the variance that the training poses explain and the rest of the variance.
    ///
    /// - `input`: x, 0 at rest.
    /// - `rest_change`: kernel of the first centre, the rest pose, less its value at x = 0.
    /// - `roots`: h, values whose squares sum to the explained variance.
    pub(crate) fn expected_error<'a>(
        &self,
        input: &[f32],
        rest_change: f32,
        roots: impl Iterator<Item = &'a f32>,
    ) -> ExpectedError {
        let mut square = 0.0;
        for x in input {
            square += x * x;
        }
        let near = nearness(square, (self.reach, 4.0 * self.reach));
        if near == 0.0 {
            return ExpectedError { explained: 0.0, unexplained: FAR };
        }
        let prior = greater(0.0, -rest_change * (2.0 + rest_change) + self.linear * square);
        let mut explained = 0.0;
        for root in roots {
            explained += root * root;
        }
        let explained = near * lesser(prior, explained);
        let turned = Self::TURN * square;
        let growth = turned / (turned + self.reach);
        ExpectedError {
            explained: self.signal * (growth * explained),
            unexplained: self.noise * (growth * (prior - explained)),
        }
    }
}

impl ExpectedError {
    /// Adds the error of other vertices.
    pub(crate) fn plus(self, other: Self) -> Self {
        Self {
            explained: self.explained + other.explained,
            unexplained: self.unexplained + other.unexplained,
        }
    }

    /// Returns the confidence, in [0, 1]: the share of the error that is explained.
    pub(crate) fn confidence(self) -> f32 {
        let explained = 1.0 + self.explained;
        explained / (explained + self.unexplained)
    }

    /// Returns w, the weight of the kernel map: 1, unless the map is much likelier to harm than to help.
    pub(crate) fn map_weight(self) -> f32 {
        smoothstep(lesser(1.0, 8.0 * self.confidence()))
    }
}
