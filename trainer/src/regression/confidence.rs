//! How well a map knows an input: its posterior variance, from the values that its last rows give (METHOD §2.6).
//! The fade of a kernel map: how near a query is to the centres, by their squared distances (METHOD §2.6).

use super::arithmetic::{Arithmetic, U, gamma};
use serde::Serialize;

/// What a map holds of its variance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Certainty {
    /// How many rows of the coefficients, the last, give values whose squares sum to the variance explained, m.
    pub len: usize,
    /// Squared distance from rest up to which the variance tells; four times as far nothing is known any more.
    pub reach: f64,
    /// Share of the linear kernel: the prior variance is `1 - G(|x|²)² + linear |x|²`.
    pub linear: f64,
    /// Expected squared distance of the base from the truth, over what counts as none, per unit of variance.
    pub signal: f64,
    /// The same of the map, per unit of the variance that is left.
    pub noise: f64,
}

/// What is known of an input, and what is in doubt.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Evidence {
    /// What of the base's error is known.
    pub known: f64,
    /// What may be left of it.
    pub doubted: f64,
}

/// Evidence between two others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Between {
    /// The least known, and the most doubted.
    pub least: Evidence,
    /// The most known, and the least doubted.
    pub most: Evidence,
}

impl Certainty {
    /// Weighs the variance explained against what it leaves.
    ///
    /// - `apart`: the squared distance from rest.
    /// - `change`: what the kernel at rest changes by.
    /// - `values`: m.
    pub fn evidence(&self, apart: f64, change: f64, values: &[f64]) -> Evidence {
        let near = self.fade().confidence(std::iter::once(apart));
        if near == 0.0 {
            return Evidence::NONE;
        }
        let prior = self.prior(apart, change);
        let explained = values.iter().map(|value| value * value).sum::<f64>().min(prior);
        self.weighed(near * explained, prior)
    }

    /// Bounds what the runtime makes of distance, change and values that are off by up to an error each.
    pub fn between(
        &self,
        (apart, apart_error): (f64, f64),
        (change, change_error): (f64, f64),
        values: &[f64],
        errors: &[f64],
        arithmetic: Arithmetic,
    ) -> Between {
        let prior = self.prior(apart, change);
        let inherited = 2.0 * ((1.0 + change).abs() + change_error) * change_error;
        let terms =
            change.abs() * (2.0 + change).abs() + inherited + self.linear * (apart + apart_error);
        let off = inherited + self.linear * apart_error + gamma(4) * terms;
        let (least_prior, most_prior) = ((prior - off).max(0.0), prior + off);
        let sum = |sign: f64| -> f64 {
            let squares = values.iter().zip(errors);
            squares.map(|(value, error)| (value.abs() + sign * error).max(0.0).powi(2)).sum()
        };
        let near = self.fade().confidence(std::iter::once(apart));
        let near_error = self.fade().error(&[(apart, apart_error)], arithmetic);
        let (least_near, most_near) = ((near - near_error).max(0.0), (near + near_error).min(1.0));
        let rounding = gamma(values.len() + 2);
        let least = least_near * (sum(-1.0) * (1.0 - rounding)).min(least_prior);
        let most = most_near * (sum(1.0) * (1.0 + rounding)).min(most_prior);
        let weighed = |near: f64, explained, whole, known, doubted| {
            if near == 0.0 {
                Evidence::NONE
            } else {
                self.weighed(explained, whole).times(known, doubted)
            }
        };
        Between {
            least: weighed(least_near, least, most_prior, 1.0 - gamma(1), 1.0 + gamma(2)),
            most: weighed(most_near, most, least_prior, 1.0 + gamma(1), 1.0 - gamma(2)),
        }
    }

    fn prior(&self, apart: f64, change: f64) -> f64 {
        (-change * (2.0 + change) + self.linear * apart).max(0.0)
    }

    fn weighed(&self, explained: f64, prior: f64) -> Evidence {
        let doubted = self.noise * (prior - explained).max(0.0);
        Evidence { known: self.signal * explained, doubted }
    }

    fn fade(&self) -> Fade {
        Fade { start: self.reach, end: 4.0 * self.reach }
    }
}

impl Evidence {
    /// Of what is too far away.
    pub const NONE: Self = Self { known: 0.0, doubted: 1e30 };

    /// Adds what is known of other vertices.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self { known: self.known + other.known, doubted: self.doubted + other.doubted }
    }

    /// Returns the confidence, in [0, 1].
    pub fn confidence(self) -> f64 {
        (1.0 + self.known) / (1.0 + self.known + self.doubted)
    }

    /// Returns w, the factor of a map: 1 but where it is much more likely to spoil than to mend.
    pub fn share(self) -> f64 {
        step(8.0 * self.confidence())
    }

    fn times(self, known: f64, doubted: f64) -> Self {
        Self { known: known * self.known, doubted: doubted * self.doubted }
    }
}

impl Between {
    /// What nothing is off by.
    pub const NOTHING: Self = Self {
        least: Evidence { known: 0.0, doubted: 0.0 },
        most: Evidence { known: 0.0, doubted: 0.0 },
    };

    /// Adds what is known of other vertices.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self { least: self.least.and(other.least), most: self.most.and(other.most) }
    }

    /// Returns the least and the greatest w.
    pub fn shares(self, arithmetic: Arithmetic) -> (f64, f64) {
        let (least, most) = self.confidence(1, arithmetic);
        let rounded = |share: f64, sign: f64| {
            if share < 1.0 { (share * (1.0 + sign * (STEP_ERROR + U))).min(1.0) } else { 1.0 }
        };
        (rounded(step(8.0 * least), -1.0), rounded(step(8.0 * most), 1.0))
    }

    /// Returns the least and the greatest confidence, from sums of so many numbers.
    pub fn confidence(self, terms: usize, arithmetic: Arithmetic) -> (f64, f64) {
        let rounding = gamma(2 * terms + 3 + arithmetic.division);
        let (least, most) = (self.least.confidence(), self.most.confidence());
        (least * (1.0 - rounding), (most * (1.0 + rounding)).min(1.0))
    }
}

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

    const CERTAINTY: Certainty =
        Certainty { len: 2, reach: 4.0, linear: 0.5, signal: 30.0, noise: 60.0 };

    #[test]
    fn what_is_explained_is_known_and_the_rest_is_in_doubt() {
        let of = |apart, change, values: &[f64]| CERTAINTY.evidence(apart, change, values);
        let share = Evidence::share;
        assert_eq!(of(0.0, 0.0, &[0.0, 0.0]).confidence(), 1.0, "rest");
        // 1 - 0.5² + 0.5 · 2 = 1.75
        let found = of(2.0, -0.5, &[0.5, -1.0]);
        assert!((found.known - 37.5).abs() < 1e-12 && (found.doubted - 30.0).abs() < 1e-12);
        assert!((found.confidence() - 38.5 / 68.5).abs() < 1e-12 && share(found) == 1.0);
        let found = of(2.0, -0.5, &[0.0, 0.1]);
        assert!(found.confidence() < 0.02 && share(found) < 1e-2);
        assert!(of(2.0, -0.5, &[3.0, 0.0]).doubted == 0.0, "no more than there is");
        assert!(share(of(16.0, -1.0, &[3.0, 0.0])) < 1e-80, "nothing far away");
    }

    #[test]
    fn what_numbers_are_off_by_is_within_the_bounds() {
        for (apart, change, values) in [
            (2.0, -0.5, [0.5, -1.0]),
            (0.01, -0.01, [0.1, 0.08]),
            (5.0, -0.9, [1.8, 0.3]),
            (15.9, -1.0, [0.3, 0.2]),
        ] {
            for off in [0.0, 1e-6, 1e-3] {
                let found = CERTAINTY.between(
                    (apart, off),
                    (change, off),
                    &values,
                    &[off, off],
                    Arithmetic::IEEE,
                );
                let (least, most) = found.confidence(1, Arithmetic::IEEE);
                let (least_share, most_share) = found.shares(Arithmetic::IEEE);
                for signs in 0..16 {
                    let sign = |bit: u32| if signs >> bit & 1 == 1 { off } else { -off };
                    let moved = [values[0] + sign(2), values[1] + sign(3)];
                    let moved = CERTAINTY.evidence(apart + sign(0), change + sign(1), &moved);
                    assert!((least..=most).contains(&moved.confidence()), "{apart} {off}");
                    let share = moved.share();
                    assert!((least_share..=most_share).contains(&share), "{apart} {off}");
                }
                assert!(most - least < 1e-5 + 2e3 * off, "{apart} {off}: {least} {most}");
            }
        }
    }

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
