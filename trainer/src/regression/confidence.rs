//! Confidence in a kernel map (METHOD §2.6): from the variance that the samples explain, and from the distance of an
//! input to the centres.

use super::arithmetic::{Arithmetic, U, gamma};
use sinew_runtime::envelope::GroupConfidence;

/// End of a fade over its start, as squared distances (METHOD §2.6).
const FADE: f64 = 6.25;
/// Relative error of the runtime's smoothstep.
pub const STEP_ERROR: f64 = 4e-7;

/// Parameters of a map's confidence: how the variance of the map becomes an expected error.
///
/// Errors are squared distances, divided by the squared distance that counts as no error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MapConfidence {
    /// Number of values whose squares sum to the explained variance, m: the last rows of the map's coefficients.
    pub len: usize,
    /// Squared distance from rest where the explained variance starts to fade; it is 0 from four times `reach` on.
    pub reach: f64,
    /// Share of the linear kernel: the prior variance is `1 - G(|x|²)² + linear |x|²`.
    pub linear: f64,
    /// Expected error of the base, per unit of variance times growth.
    pub signal: f64,
    /// Expected error of the map, per unit of unexplained variance times growth.
    pub noise: f64,
}

/// Expected error of a base without its correction, in two parts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ExpectedError {
    /// Part that the samples explain. The correction removes this part.
    pub explained: f64,
    /// Part that the correction may leave.
    pub unexplained: f64,
}

/// Bounds of an expected error that rounding changes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ExpectedErrorBounds {
    /// Bound with the least confidence: least explained, most unexplained.
    pub least: ExpectedError,
    /// Bound with the most confidence: most explained, least unexplained.
    pub most: ExpectedError,
}

impl MapConfidence {
    /// Computes the expected error at an input.
    ///
    /// - `square`: the input's squared distance from rest.
    /// - `rest_change`: kernel of the rest pose at the input, less its value at rest.
    /// - `roots`: m values whose squares sum to the explained variance.
    pub fn expected_error(&self, square: f64, rest_change: f64, roots: &[f64]) -> ExpectedError {
        let near = self.fade().confidence(std::iter::once(square));
        if near == 0.0 {
            return ExpectedError::FAR;
        }
        let prior = self.prior(square, rest_change);
        let explained = roots.iter().map(|root| root * root).sum::<f64>().min(prior);
        self.of_variance(near * explained, prior).scaled([self.growth(square); 2])
    }

    /// Returns the growth of an error at a squared distance from rest, in [0, 1].
    pub fn growth(&self, square: f64) -> f64 {
        let turned = f64::from(GroupConfidence::TURN) * square;
        turned / (turned + self.reach)
    }

    /// Bounds the expected error that the runtime computes from rounded numbers.
    ///
    /// - `square`, `rest_change`: as for [`Self::expected_error`], each with a bound of its error.
    /// - `roots`, `errors`: m values, and a bound of the error of each.
    pub fn bounds(
        &self,
        (square, square_error): (f64, f64),
        (rest_change, change_error): (f64, f64),
        roots: &[f64],
        errors: &[f64],
        arithmetic: Arithmetic,
    ) -> ExpectedErrorBounds {
        let prior = self.prior(square, rest_change);
        let inherited = 2.0 * ((1.0 + rest_change).abs() + change_error) * change_error;
        let terms = rest_change.abs() * (2.0 + rest_change).abs()
            + inherited
            + self.linear * (square + square_error);
        let prior_error = inherited + self.linear * square_error + gamma(4) * terms;
        let (least_prior, most_prior) = ((prior - prior_error).max(0.0), prior + prior_error);
        let sum = |sign: f64| -> f64 {
            let squares = roots.iter().zip(errors);
            squares.map(|(root, error)| (root.abs() + sign * error).max(0.0).powi(2)).sum()
        };
        let near = self.fade().confidence(std::iter::once(square));
        let near_error = self.fade().error(&[(square, square_error)], arithmetic);
        let (least_near, most_near) = ((near - near_error).max(0.0), (near + near_error).min(1.0));
        let rounding = gamma(roots.len() + 2);
        let least = least_near * (sum(-1.0) * (1.0 - rounding)).min(least_prior);
        let most = most_near * (sum(1.0) * (1.0 + rounding)).min(most_prior);
        // The growth is behind a sum, a division and two products; the unexplained part is a difference, too.
        let rounding = gamma(4 + arithmetic.division);
        let least_growth = self.growth((square - square_error).max(0.0)) * (1.0 - rounding);
        let most_growth = self.growth(square + square_error) * (1.0 + rounding);
        let grown = |near: f64, explained, prior, growths: [f64; 2]| {
            if near == 0.0 {
                ExpectedError::FAR
            } else {
                self.of_variance(explained, prior).scaled(growths)
            }
        };
        ExpectedErrorBounds {
            least: grown(least_near, least, most_prior, [least_growth, most_growth]),
            most: grown(most_near, most, least_prior, [most_growth, least_growth]),
        }
    }

    fn prior(&self, square: f64, rest_change: f64) -> f64 {
        (-rest_change * (2.0 + rest_change) + self.linear * square).max(0.0)
    }

    fn of_variance(&self, explained: f64, prior: f64) -> ExpectedError {
        let unexplained = self.noise * (prior - explained).max(0.0);
        ExpectedError { explained: self.signal * explained, unexplained }
    }

    fn fade(&self) -> Fade {
        Fade { start: self.reach, end: 4.0 * self.reach }
    }
}

impl ExpectedError {
    /// Expected error far from every sample, where nothing is explained.
    pub const FAR: Self = Self { explained: 0.0, unexplained: 1e30 };

    /// Adds the error of other vertices.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self {
            explained: self.explained + other.explained,
            unexplained: self.unexplained + other.unexplained,
        }
    }

    /// Returns the confidence, in [0, 1]: the share of the error that is explained.
    pub fn confidence(self) -> f64 {
        (1.0 + self.explained) / (1.0 + self.explained + self.unexplained)
    }

    /// Returns w, the weight of the kernel map: 1, unless the map is much likelier to harm than to help.
    pub fn map_weight(self) -> f64 {
        step(8.0 * self.confidence())
    }

    fn scaled(self, [explained, unexplained]: [f64; 2]) -> Self {
        Self { explained: explained * self.explained, unexplained: unexplained * self.unexplained }
    }
}

impl ExpectedErrorBounds {
    /// Adds the error of other vertices.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self { least: self.least.plus(other.least), most: self.most.plus(other.most) }
    }

    /// Returns the least and the greatest w.
    pub fn map_weights(self, arithmetic: Arithmetic) -> (f64, f64) {
        let (least, most) = self.confidence(1, arithmetic);
        let rounded = |weight: f64, sign: f64| {
            if weight < 1.0 { (weight * (1.0 + sign * (STEP_ERROR + U))).min(1.0) } else { 1.0 }
        };
        (rounded(step(8.0 * least), -1.0), rounded(step(8.0 * most), 1.0))
    }

    /// Returns the least and the greatest confidence.
    ///
    /// - `terms`: number of expected errors that were added up.
    pub fn confidence(self, terms: usize, arithmetic: Arithmetic) -> (f64, f64) {
        let rounding = gamma(2 * terms + 3 + arithmetic.division);
        let (least, most) = (self.least.confidence(), self.most.confidence());
        (least * (1.0 - rounding), (most * (1.0 + rounding)).min(1.0))
    }
}

/// Range of squared distances over which a confidence falls: 1 within `start` of a centre, 0 beyond `end` of every
/// centre (METHOD §2.6).
///
/// Squared distances are smooth where an input meets a centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fade {
    /// Squared scaled distance up to which the confidence is 1.
    pub start: f64,
    /// Squared scaled distance from which the confidence is 0.
    pub end: f64,
}

impl Fade {
    /// Makes the fade that starts at a squared distance.
    pub fn beyond(start: f64) -> Self {
        Self { start, end: FADE * start }
    }

    /// Returns the confidence at given squared distances to all centres; 1 of an empty fade.
    pub fn confidence(&self, squared: impl Iterator<Item = f64>) -> f64 {
        if self.end <= self.start {
            return 1.0;
        }
        1.0 - squared.map(|s| 1.0 - step(self.position(s))).product::<f64>()
    }

    /// Bounds the confidence's error, given the distances and their errors: 0 where every centre is certainly too far.
    ///
    /// A position in the fade is behind two differences and a division. Its step is exact where the step is 1. `1 - b`,
    /// the product of the steps below 1, and the difference from 1 round once each.
    pub fn error(&self, distances: &[(f64, f64)], arithmetic: Arithmetic) -> f64 {
        if self.end <= self.start {
            return 0.0;
        }
        let of_position = gamma(2 + arithmetic.division);
        let (mut uncertainty, mut least, mut most) = (1.0, 1.0, 1.0f64);
        for &(s, error) in distances {
            let near = step(self.position(s - error) * (1.0 + of_position));
            let far = step(self.position(s + error) * (1.0 - of_position));
            if near == 0.0 {
                continue;
            }
            let far = if far < 1.0 { far * (1.0 - STEP_ERROR) } else { 1.0 };
            uncertainty *= 1.0 - step(self.position(s));
            least *= (1.0 - near * (1.0 + STEP_ERROR)).max(0.0) * (1.0 - gamma(2));
            most *= (1.0 - far) * (1.0 + gamma(2));
        }
        let [exact, least, most] = [uncertainty, most, least].map(|uncertainty| 1.0 - uncertainty);
        (exact - least * (1.0 - U)).max(most * (1.0 + U) - exact)
    }

    /// Returns the position of a squared distance in the fade: 1 at the start, 0 at the end.
    fn position(&self, s: f64) -> f64 {
        (self.end - s) / (self.end - self.start)
    }
}

/// Returns `u³ (10 - 15 u + 6 u²)`, with u limited to [0, 1].
pub fn step(u: f64) -> f64 {
    let u = u.clamp(0.0, 1.0);
    u.powi(3) * (10.0 - 15.0 * u + 6.0 * u * u)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CONFIDENCE: MapConfidence =
        MapConfidence { len: 2, reach: 4.0, linear: 0.5, signal: 30.0, noise: 60.0 };

    #[test]
    fn confidence_is_the_explained_share_of_the_error() {
        let of = |apart, change, values: &[f64]| CONFIDENCE.expected_error(apart, change, values);
        let weight = ExpectedError::map_weight;
        assert_eq!(of(0.0, 0.0, &[0.0, 0.0]).confidence(), 1.0, "rest");
        // A variance of 1 - 0.5² + 0.5 · 2 = 1.75, and a growth of 8 / (8 + 4).
        let found = of(2.0, -0.5, &[0.5, -1.0]);
        assert!((found.explained - 25.0).abs() < 1e-12 && (found.unexplained - 20.0).abs() < 1e-12);
        assert!((found.confidence() - 26.0 / 46.0).abs() < 1e-12 && weight(found) == 1.0);
        let found = of(2.0, -0.5, &[0.0, 0.1]);
        assert!(found.confidence() < 0.02 && weight(found) < 3e-2);
        assert!(of(2.0, -0.5, &[3.0, 0.0]).unexplained == 0.0, "at most the prior is explained");
        assert!(weight(of(16.0, -1.0, &[3.0, 0.0])) < 1e-80, "no weight far away");
    }

    #[test]
    fn errors_grow_with_the_fourth_power_of_the_distance_near_rest_and_with_the_square_beyond() {
        let of_twice = |distance: f64| {
            let of = |x: f64| CONFIDENCE.expected_error(x * x, 0.0, &[]).unexplained;
            of(2.0 * distance) / of(distance)
        };
        assert!((of_twice(1e-3) - 16.0).abs() < 1e-3);
        assert!(of_twice(1.5) < 6.0);
    }

    #[test]
    fn rounded_numbers_stay_within_the_bounds_of_the_error() {
        for (apart, change, values) in [
            (2.0, -0.5, [0.5, -1.0]),
            (0.01, -0.01, [0.1, 0.08]),
            (5.0, -0.9, [1.8, 0.3]),
            (15.9, -1.0, [0.3, 0.2]),
        ] {
            for off in [0.0, 1e-6, 1e-3] {
                let found = CONFIDENCE.bounds(
                    (apart, off),
                    (change, off),
                    &values,
                    &[off, off],
                    Arithmetic::IEEE,
                );
                let (least, most) = found.confidence(1, Arithmetic::IEEE);
                let (least_weight, most_weight) = found.map_weights(Arithmetic::IEEE);
                for signs in 0..16 {
                    let sign = |bit: u32| if signs >> bit & 1 == 1 { off } else { -off };
                    let changed = [values[0] + sign(2), values[1] + sign(3)];
                    let changed =
                        CONFIDENCE.expected_error(apart + sign(0), change + sign(1), &changed);
                    assert!((least..=most).contains(&changed.confidence()), "{apart} {off}");
                    let weight = changed.map_weight();
                    assert!((least_weight..=most_weight).contains(&weight), "{apart} {off}");
                }
                assert!(most - least < 1e-5 + 2e3 * off, "{apart} {off}: {least} {most}");
            }
        }
    }

    #[test]
    fn confidence_falls_from_one_to_zero() {
        let of = |x: f64| Fade { start: 1.0, end: 4.0 }.confidence(std::iter::once(x * x));
        assert_eq!(of(1.0), 1.0);
        assert!((0.01..0.99).contains(&of(1.6)));
        assert_eq!(of(2.0), 0.0);
        let falling: Vec<f64> = (5..25).map(|i| of(0.1 * f64::from(i))).collect();
        assert!(falling.is_sorted_by(|a, b| a >= b));
    }

    #[test]
    fn rounded_distances_stay_within_the_bound_of_the_confidence() {
        let fade = Fade { start: 1.0, end: 4.0 };
        for apart in [[0.5, 2.0], [1.2, 3.0], [2.0, 3.9]] {
            for off in [0.0, 1e-6, 1e-3] {
                let distances = apart.map(|s| (s, off));
                let bound = fade.error(&distances, Arithmetic::IEEE);
                let exact = fade.confidence(apart.into_iter());
                for sign in [-1.0, 1.0] {
                    let changed = fade.confidence(apart.into_iter().map(|s| s + sign * off));
                    assert!((changed - exact).abs() <= bound);
                }
            }
        }
        assert_eq!(fade.error(&[(81.0, 0.0)], Arithmetic::IEEE), 0.0, "certainly none");
    }
}
