//! The fade of a kernel map: how near a query is to the centres, by their squared distances (METHOD §2.6).

use super::arithmetic::{Arithmetic, U, gamma};
use serde::Serialize;

/// Where a fade ends, in squared distances of its start (METHOD §2.6).
const FADE: f64 = 6.25;
/// Relative error of the runtime's smoothstep.
pub const STEP_ERROR: f64 = 4e-7;

/// The confidence of an input: full within `start` of a centre, none beyond `end` of all
/// (METHOD §2.6, on squared distances, which are smooth).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Fade {
    /// Squared scaled distance.
    pub start: f64,
    /// Likewise.
    pub end: f64,
}

impl Fade {
    /// Fades beyond a squared distance.
    pub fn beyond(start: f64) -> Self {
        Self { start, end: FADE * start }
    }

    /// Returns the confidence of squared distances to all centres: 1 where nothing fades.
    pub fn confidence(&self, squared: impl Iterator<Item = f64>) -> f64 {
        if self.end <= self.start {
            return 1.0;
        }
        1.0 - squared.map(|s| 1.0 - step(self.place(s))).product::<f64>()
    }

    /// Bounds the confidence's error, given the distances and their errors: 0 where every centre
    /// is beyond doubt too far.
    ///
    /// A place in the fade is behind two differences and a division, and its step is exact where it
    /// is 1. `1 - b`, the product of those that are not 1, and the difference from 1 round once each.
    pub fn error(&self, distances: &[(f64, f64)], arithmetic: Arithmetic) -> f64 {
        if self.end <= self.start {
            return 0.0;
        }
        let of_place = gamma(2 + arithmetic.division);
        let (mut doubt, mut least, mut most) = (1.0, 1.0, 1.0f64);
        for &(s, error) in distances {
            let near = step(self.place(s - error) * (1.0 + of_place));
            let far = step(self.place(s + error) * (1.0 - of_place));
            if near == 0.0 {
                continue;
            }
            let far = if far < 1.0 { far * (1.0 - STEP_ERROR) } else { 1.0 };
            doubt *= 1.0 - step(self.place(s));
            least *= (1.0 - near * (1.0 + STEP_ERROR)).max(0.0) * (1.0 - gamma(2));
            most *= (1.0 - far) * (1.0 + gamma(2));
        }
        let [exact, least, most] = [doubt, most, least].map(|doubt| 1.0 - doubt);
        (exact - least * (1.0 - U)).max(most * (1.0 + U) - exact)
    }

    /// Returns where a squared distance is in the fade: 1 at its start, 0 at its end.
    fn place(&self, s: f64) -> f64 {
        (self.end - s) / (self.end - self.start)
    }
}

/// Returns `u³ (10 - 15 u + 6 u²)` of u kept within 0 and 1.
pub fn step(u: f64) -> f64 {
    let u = u.clamp(0.0, 1.0);
    u.powi(3) * (10.0 - 15.0 * u + 6.0 * u * u)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn confidence_falls_from_one_to_nothing() {
        let of = |x: f64| Fade { start: 1.0, end: 4.0 }.confidence(std::iter::once(x * x));
        assert_eq!(of(1.0), 1.0);
        assert!((0.01..0.99).contains(&of(1.6)));
        assert_eq!(of(2.0), 0.0);
        let falling: Vec<f64> = (5..25).map(|i| of(0.1 * f64::from(i))).collect();
        assert!(falling.is_sorted_by(|a, b| a >= b));
    }

    #[test]
    fn what_distances_are_off_by_is_within_the_bound() {
        let fade = Fade { start: 1.0, end: 4.0 };
        for apart in [[0.5, 2.0], [1.2, 3.0], [2.0, 3.9]] {
            for off in [0.0, 1e-6, 1e-3] {
                let distances = apart.map(|s| (s, off));
                let bound = fade.error(&distances, Arithmetic::IEEE);
                let exact = fade.confidence(apart.into_iter());
                for sign in [-1.0, 1.0] {
                    let moved = fade.confidence(apart.into_iter().map(|s| s + sign * off));
                    assert!((moved - exact).abs() <= bound);
                }
            }
        }
        assert_eq!(fade.error(&[(81.0, 0.0)], Arithmetic::IEEE), 0.0, "none beyond doubt");
    }
}
