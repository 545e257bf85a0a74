//! Observations as functionals: a value, a derivative or a box average; and their covariances (METHOD §4, S0 Eq. 1).

use super::covariance::Covariance;
use std::sync::OnceLock;

/// Quadrature nodes per piece. Within a piece the covariance is nearly a polynomial.
pub(super) const NODES: usize = 12;

/// A functional: the quantity that an observation measures or a prediction estimates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Functional {
    /// The function's value.
    Value {
        /// The place.
        at: f64,
    },
    /// The function's derivative.
    Derivative {
        /// The place.
        at: f64,
    },
    /// The function's mean over a box.
    Average {
        /// Start of the box.
        from: f64,
        /// End of the box, above `from`.
        to: f64,
    },
}

impl Functional {
    /// Returns the middle of the functional's support.
    pub const fn middle(&self) -> f64 {
        match *self {
            Self::Value { at } | Self::Derivative { at } => at,
            Self::Average { from, to } => 0.5 * (from + to),
        }
    }

    /// Returns the ends of the functional's support: for a value or a derivative, its place twice.
    pub const fn ends(&self) -> [f64; 2] {
        match *self {
            Self::Value { at } | Self::Derivative { at } => [at, at],
            Self::Average { from, to } => [from, to],
        }
    }

    /// Computes the covariance of two functionals: closed forms, except for integrals over boxes.
    pub fn covariance(&self, other: &Self, of: &Covariance) -> f64 {
        match (*self, *other) {
            (Self::Value { at: p }, Self::Value { at: q }) => of.value(p - q),
            (Self::Value { at: p }, Self::Derivative { at: q }) => -of.slope(p - q),
            (Self::Derivative { at: p }, Self::Value { at: q }) => of.slope(p - q),
            (Self::Derivative { at: p }, Self::Derivative { at: q }) => -of.curvature(p - q),
            (Self::Derivative { at: p }, Self::Average { from, to })
            | (Self::Average { from, to }, Self::Derivative { at: p }) => {
                (of.value(p - from) - of.value(p - to)) / (to - from)
            }
            (Self::Value { at: p }, Self::Average { from, to })
            | (Self::Average { from, to }, Self::Value { at: p }) => {
                integral(of, &[p - to, p - from], |_| 1.0) / (to - from)
            }
            (Self::Average { from: a, to: b }, Self::Average { from: c, to: d }) => {
                let overlap = |t: f64| (b.min(d + t) - a.max(c + t)).max(0.0);
                let mut cuts = [a - d, a - c, b - d, b - c];
                cuts.sort_by(f64::total_cmp);
                integral(of, &cuts, overlap) / ((b - a) * (d - c))
            }
        }
    }
}

/// Returns quadrature nodes over a box, with weights that sum to 1.
pub(super) fn nodes(from: f64, to: f64) -> impl Iterator<Item = (f64, f64)> {
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    legendre().iter().map(move |(x, w)| (middle + half * x, 0.5 * w))
}

/// Integrates a covariance times a weight that is linear between ascending cuts.
///
/// Each interval is also cut at multiples of the covariance's step. Multiples include 0, where some covariances have a
/// kink. The part beyond the covariance's reach counts as 0.
fn integral(of: &Covariance, cuts: &[f64], weight: impl Fn(f64) -> f64) -> f64 {
    let (step, reach) = (of.step(), of.reach());
    let mut sum = 0.0;
    for ends in cuts.windows(2) {
        let (mut from, to) = (ends[0].max(-reach), ends[1].min(reach));
        let mut multiple = (from / step).floor();
        while from < to {
            multiple += 1.0;
            let end = (step * multiple).min(to);
            // At a multiple of the step, rounding may give an empty piece.
            if end > from {
                let own = nodes(from, end).map(|(t, share)| share * weight(t) * of.value(t));
                sum += own.sum::<f64>() * (end - from);
                from = end;
            }
        }
    }
    sum
}

/// Returns Gauss-Legendre nodes and weights on [-1, 1].
fn legendre() -> &'static [(f64, f64); NODES] {
    static RULE: OnceLock<[(f64, f64); NODES]> = OnceLock::new();
    RULE.get_or_init(|| {
        std::array::from_fn(|i| {
            let n = NODES as f64;
            let mut x = -libm::cos(std::f64::consts::PI * (i as f64 + 0.75) / (n + 0.5));
            let mut slope = 1.0;
            // Newton's method doubles the number of correct digits in each step.
            for _ in 0..8 {
                let (mut before, mut value) = (1.0, x);
                for k in 2..=NODES {
                    let k = k as f64;
                    (before, value) =
                        (value, ((2.0 * k - 1.0) * x * value - (k - 1.0) * before) / k);
                }
                slope = n * (x * value - before) / (x * x - 1.0);
                x -= value / slope;
            }
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        })
    })
}

#[cfg(test)]
mod tests {
    use super::super::covariance::tests::families;
    use super::*;

    /// Sums over a fine grid, as a reference without cuts.
    fn brute(of: &Covariance, a: [f64; 2], b: [f64; 2]) -> f64 {
        let steps = 2000;
        let at = |[from, to]: [f64; 2], k: usize| {
            from + (to - from) * (k as f64 + 0.5) / f64::from(steps)
        };
        let all = (0..steps as usize).map(|i| {
            let p = at(a, i);
            (0..steps as usize).map(|j| of.value(p - at(b, j))).sum::<f64>()
        });
        all.sum::<f64>() / f64::from(steps * steps)
    }

    #[test]
    fn averages_match_a_fine_sum() {
        for of in families() {
            for (a, b) in
                [([0.0, 1.0], [0.0, 1.0]), ([0.0, 1.0], [2.25, 2.5]), ([0.0, 3.0], [0.5, 0.75])]
            {
                let [x, y] = [a, b].map(|[from, to]| Functional::Average { from, to });
                let found = x.covariance(&y, &of);
                assert!((found - brute(&of, a, b)).abs() < 2e-6, "{of:?} {a:?} {b:?} {found}");
                assert!((found - y.covariance(&x, &of)).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn averages_of_ornstein_and_uhlenbeck_have_their_closed_form() {
        let length = 1.7;
        let of = Covariance::OrnsteinUhlenbeck { length };
        let unit = Functional::Average { from: 0.0, to: 1.0 };
        let e = |x: f64| (-x / length).exp();
        let own = 2.0 * length * (1.0 - length * (1.0 - e(1.0)));
        assert!((unit.covariance(&unit, &of) - own).abs() < 1e-14);
        let far = Functional::Average { from: 4.0, to: 5.0 };
        let expected = length * length * (e(3.0) - 2.0 * e(4.0) + e(5.0));
        assert!((unit.covariance(&far, &of) - expected).abs() < 1e-14);
        let value = Functional::Value { at: 0.25 };
        let expected = length * (2.0 - e(0.25) - e(0.75));
        assert!((unit.covariance(&value, &of) - expected).abs() < 1e-14);
        // A box of a million lengths: only the part within reach contributes.
        let wide = Functional::Average { from: -1e6, to: 1e6 };
        assert!((wide.covariance(&value, &of) / (2.0 * length / 2e6) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn derivatives_match_differences() {
        let h = 1e-4;
        for of in families().into_iter().filter(Covariance::is_smooth) {
            let p = Functional::Derivative { at: 0.4 };
            let others = [
                Functional::Value { at: 1.3 },
                Functional::Derivative { at: -0.8 },
                Functional::Average { from: 0.9, to: 1.4 },
            ];
            for other in others {
                let at = |at: f64| Functional::Value { at }.covariance(&other, &of);
                let expected = (at(0.4 + h) - at(0.4 - h)) / (2.0 * h);
                assert!((p.covariance(&other, &of) - expected).abs() < 1e-6, "{of:?} {other:?}");
                assert!((p.covariance(&other, &of) - other.covariance(&p, &of)).abs() < 1e-14);
            }
        }
    }
}
