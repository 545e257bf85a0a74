//! Kriging: the likeliest function given observations (METHOD §4, S0 Eq. 13).

use super::covariance::Covariance;
use super::faults::{check_positive, no_observations};
use super::functional::Functional;
use super::solved::{REMEDY, Solved, ill_conditioned};
use crate::Error;
use crate::numeric::columns::ends;
use faer::Mat;
use serde::Deserialize;

/// Least pivot of the mean's basis, below which the basis counts as rank-deficient.
const RANK: f64 = 1e-10;
/// Largest magnitude of an observation: the largest f32.
const MOST: f64 = f32::MAX as f64;

/// Prior model of a function: covariance, mean and noise.
#[derive(Clone, Debug)]
pub struct Process {
    /// C, the covariance.
    pub covariance: Covariance,
    /// m, the mean.
    pub mean: Mean,
    /// τ, the variance of the observations' noise in units of C(0).
    pub noise: f64,
}

/// Form of a process's mean: as many coefficients as its number, which the observations determine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Mean {
    /// Zero, as in S0.
    Zero = 0,
    /// A constant.
    #[default]
    Constant = 1,
    /// A straight line.
    Linear = 2,
}

/// Posterior of a function after n observations.
pub struct Kriging {
    process: Process,
    functionals: Vec<Functional>,
    scale: [f64; 2],
    solved: Solved,
}

/// Predicted value of a functional, with its variance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prediction {
    /// The expected value.
    pub value: f64,
    /// The variance, in units of C(0).
    pub variance: f64,
}

/// Reason why observations have no posterior.
enum Unsolved {
    /// The observations do not determine the mean.
    Mean,
    /// Rounding errors dominate the solution. Field: the reciprocal condition.
    IllConditioned(f64),
}

impl Process {
    /// Checks the covariance's parameters and the noise.
    ///
    /// # Errors
    /// If a parameter is not positive and finite, or the noise is negative or not finite.
    pub fn check(&self) -> Result<(), Error> {
        self.covariance.clone().checked()?;
        if self.noise == 0.0 { Ok(()) } else { check_positive("noise", self.noise) }
    }
}

impl Mean {
    /// Counts the coefficients.
    pub const fn term_len(self) -> usize {
        self as usize
    }

    /// Returns the name used in JSON and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Zero => "zero",
            Self::Constant => "constant",
            Self::Linear => "linear",
        }
    }

    /// Applies a functional to the mean's basis: 1 and `(x - shift) scale`, up to [`Self::term_len`].
    pub(super) fn terms(self, of: &Functional, [shift, scale]: [f64; 2]) -> Vec<f64> {
        let line = (of.middle() - shift) * scale;
        let both = match of {
            Functional::Derivative { .. } => [0.0, scale],
            Functional::Value { .. } | Functional::Average { .. } => [1.0, line],
        };
        both.into_iter().take(self.term_len()).collect()
    }
}

impl Kriging {
    /// Fits observed values (n) of functionals.
    ///
    /// # Errors
    /// - Errors of [`Process::check`].
    /// - If there are no observations, a number is out of range, or a box has no width.
    /// - If a derivative is observed, but the covariance has no derivative.
    /// - If the observations do not determine the mean.
    /// - If rounding errors dominate the solution.
    pub fn new(
        process: &Process,
        functionals: &[Functional],
        values: &[f64],
    ) -> Result<Self, Error> {
        Self::numbered(process, functionals, values, |at| at, REMEDY)
    }

    /// Fits as [`Self::new`], with other words about a solution that rounding errors dominate.
    ///
    /// - `number`: returns the number of an observation.
    /// - `remedy`: suggested change.
    pub(super) fn numbered(
        process: &Process,
        functionals: &[Functional],
        values: &[f64],
        number: impl Fn(usize) -> usize,
        remedy: &str,
    ) -> Result<Self, Error> {
        process.check()?;
        check(process, functionals, values)?;
        Self::solved(process, functionals, values).map_err(|reason| match reason {
            Unsolved::Mean => {
                let mean = process.mean.name();
                Error::fit(format!(
                    "these observations do not determine a {mean} mean: take a simpler one, or observe values"
                ))
            }
            Unsolved::IllConditioned(rcond) => {
                let redundant = first_redundant(process, functionals, values, number);
                ill_conditioned(rcond, redundant, remedy)
            }
        })
    }

    fn solved(
        process: &Process,
        functionals: &[Functional],
        values: &[f64],
    ) -> Result<Self, Unsolved> {
        let scale = scale(functionals);
        let matrix = gram(process, functionals);
        let rows: Vec<Vec<f64>> =
            functionals.iter().map(|of| process.mean.terms(of, scale)).collect();
        let basis = Mat::from_fn(rows.len(), process.mean.term_len(), |i, t| rows[i][t]);
        if !determines_mean(&basis) {
            return Err(Unsolved::Mean);
        }
        let solved = Solved::new(matrix, &basis, values).map_err(Unsolved::IllConditioned)?;
        Ok(Self { process: process.clone(), functionals: functionals.to_vec(), scale, solved })
    }

    /// Predicts a functional's value, without the variance.
    pub fn value(&self, of: &Functional) -> f64 {
        let (r, p) = self.row(of);
        self.solved.value(&r, &p)
    }

    /// Predicts a functional's value and variance.
    pub fn predict(&self, of: &Functional) -> Prediction {
        let (r, p) = self.row(of);
        let own = of.covariance(of, &self.process.covariance);
        Prediction { value: self.solved.value(&r, &p), variance: self.solved.variance(own, &r, &p) }
    }

    /// Computes the weight of each observation in the prediction of a functional, n.
    pub fn weights(&self, of: &Functional) -> Vec<f64> {
        let (r, p) = self.row(of);
        self.solved.weights(&r, &p)
    }

    /// Estimates the variance of the process. Multiply the variances of predictions by this number.
    pub fn variance(&self) -> f64 {
        self.solved.scale()
    }

    /// Returns the coefficients of the covariances (n) and of the mean, and the mean's `[shift, scale]` of places.
    pub fn coefficients(&self) -> (Vec<f64>, Vec<f64>, [f64; 2]) {
        let (kernels, terms) = self.solved.coefficients();
        (kernels, terms, self.scale)
    }

    fn row(&self, of: &Functional) -> (Vec<f64>, Vec<f64>) {
        let r = self.functionals.iter().map(|x| x.covariance(of, &self.process.covariance));
        (r.collect(), self.process.mean.terms(of, self.scale))
    }
}

/// Describes the first observation at which the system becomes ill-conditioned: the earlier ones nearly determine this
/// observation. Bisects, since more observations never improve the condition.
///
/// - `number`: returns the number of an observation.
fn first_redundant(
    process: &Process,
    functionals: &[Functional],
    values: &[f64],
    number: impl Fn(usize) -> usize,
) -> Option<String> {
    let fails = |len: usize| {
        let found = Kriging::solved(process, &functionals[..len], &values[..len]);
        matches!(found, Err(Unsolved::IllConditioned(_)))
    };
    let (mut sound, mut failed) = (0, functionals.len());
    while failed - sound > 1 {
        let middle = sound.midpoint(failed);
        if fails(middle) { failed = middle } else { sound = middle }
    }
    let before = Kriging::solved(process, &functionals[..sound], &values[..sound]).ok()?;
    let (at, found, expected) = (number(sound), values[sound], before.value(&functionals[sound]));
    Some(format!(
        "observation {at} says {found:.6} where earlier ones nearly determine {expected:.6}"
    ))
}

/// Computes K = C₀ + τI, n x n.
pub fn gram(process: &Process, functionals: &[Functional]) -> Mat<f64> {
    let n = functionals.len();
    let mut matrix = Mat::zeros(n, n);
    for (i, a) in functionals.iter().enumerate() {
        for (k, b) in functionals[..=i].iter().enumerate() {
            let value = a.covariance(b, &process.covariance);
            matrix[(i, k)] = value;
            matrix[(k, i)] = value;
        }
        matrix[(i, i)] += process.noise;
    }
    matrix
}

/// Checks observations: their numbers, the width of boxes, and that derivatives exist.
///
/// # Errors
/// If there are no observations, a number is out of range, a box has no width, or a derivative does not exist.
pub(super) fn check(
    process: &Process,
    functionals: &[Functional],
    values: &[f64],
) -> Result<(), Error> {
    if functionals.is_empty() || functionals.len() != values.len() {
        return Err(no_observations());
    }
    for (at, (of, value)) in functionals.iter().zip(values).enumerate() {
        let wrong = |what: &str| Err(Error::value(format!("observation {at}: {what}")));
        let [from, to] = of.ends();
        // NaN fails the comparison too.
        if ![from, to, *value].iter().all(|x| x.abs() <= MOST) {
            return wrong(
                "expected numbers from -3.4e38 to 3.4e38, as single precision holds them",
            );
        }
        if matches!(of, Functional::Average { .. }) && from >= to {
            return wrong("expected `from` below `to`");
        }
        if matches!(of, Functional::Derivative { .. }) && !process.covariance.is_smooth() {
            let covariance = process.covariance.name();
            return Err(Error::unsupported(format!(
                "observation {at}: functions of covariance {covariance} have no derivative"
            )));
        }
    }
    Ok(())
}

/// Returns the mean's `[shift, scale]`: the middle of all places, rounded to f32, and 1 over half their range.
fn scale(functionals: &[Functional]) -> [f64; 2] {
    let places: Vec<f64> = functionals.iter().map(Functional::middle).collect();
    let [low, high] = ends(&places);
    let middle = f64::from((0.5 * (low + high)) as f32);
    [middle, if high > low { 2.0 / (high - low) } else { 1.0 }]
}

/// Returns whether the observations determine the mean's coefficients.
fn determines_mean(basis: &Mat<f64>) -> bool {
    let (n, r) = basis.shape();
    if n < r {
        return false;
    }
    let pivoted = basis.col_piv_qr();
    let corner = |k: usize| pivoted.thin_R()[(k, k)].abs();
    (0..r).all(|k| corner(k) > RANK)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn observations_are_predicted_exactly() {
        let functionals = [
            Functional::Value { at: 0.3 },
            Functional::Derivative { at: 1.0 },
            Functional::Average { from: 1.5, to: 2.5 },
            Functional::Value { at: 4.0 },
        ];
        let values = [1.0, -0.5, 0.2, 3.0];
        for mean in [Mean::Zero, Mean::Constant, Mean::Linear] {
            let covariance = Covariance::Matern52 { length: 1.5 };
            let process = Process { covariance, mean, noise: 0.0 };
            let kriging = Kriging::new(&process, &functionals, &values).unwrap();
            for (at, (of, value)) in functionals.iter().zip(values).enumerate() {
                let found = kriging.predict(of);
                assert!((found.value - value).abs() < 1e-10, "{mean:?} {of:?}");
                assert!(found.variance < 1e-10, "{mean:?} {of:?}");
                let weights = kriging.weights(of);
                assert!((weights[at] - 1.0).abs() < 1e-10, "{weights:?}");
            }
            let far = Functional::Value { at: 2.9 };
            let sum: f64 = kriging.weights(&far).iter().zip(values).map(|(w, y)| w * y).sum();
            assert!((sum - kriging.predict(&far).value).abs() < 1e-12);
        }
    }

    #[test]
    fn units_of_places_do_not_matter() {
        let functionals = |unit: f64| {
            [
                Functional::Value { at: 0.0 },
                Functional::Derivative { at: unit },
                Functional::Average { from: 1.5 * unit, to: 2.5 * unit },
            ]
        };
        for mean in [Mean::Zero, Mean::Constant, Mean::Linear] {
            let found = |unit: f64| {
                let covariance = Covariance::SquaredExponential { length: unit };
                let process = Process { covariance, mean, noise: 0.0 };
                let values = [1.0, -0.5 / unit, 0.2];
                let fit = Kriging::new(&process, &functionals(unit), &values).unwrap();
                fit.predict(&Functional::Value { at: 0.7 * unit })
            };
            let one = found(1.0);
            for unit in [1e-12, 1e-7, 1e7, 1e12] {
                let other = found(unit);
                assert!((other.value - one.value).abs() < 1e-9, "{mean:?} {unit} {other:?}");
                assert!((other.variance - one.variance).abs() < 1e-9, "{mean:?} {unit} {other:?}");
            }
        }
    }

    #[test]
    fn invalid_observations_are_refused_by_number() {
        let covariance = Covariance::OrnsteinUhlenbeck { length: 1.0 };
        let process = Process { covariance, mean: Mean::Zero, noise: 0.0 };
        let first = Functional::Value { at: 0.0 };
        let refused = |process: &Process, of: Functional, value: f64| {
            Kriging::new(process, &[first, of], &[1.0, value]).err().unwrap().to_string()
        };
        let range = "observation 1: expected numbers from -3.4e38 to 3.4e38, as single precision holds them";
        let bad = Functional::Average { from: 1.0, to: 1.0 };
        let empty = "observation 1: expected `from` below `to`";
        assert_eq!(refused(&process, bad, 0.0), empty);
        for at in [f64::NAN, f64::INFINITY, -1e39] {
            let bad = Functional::Value { at };
            assert_eq!(refused(&process, bad, 0.0), range);
        }
        let good = Functional::Value { at: 1.0 };
        assert_eq!(refused(&process, good, f64::NAN), range);
        let rough = Functional::Derivative { at: 1.0 };
        assert_eq!(
            refused(&process, rough, 0.0),
            "observation 1: functions of covariance ornstein-uhlenbeck have no derivative"
        );
        let twice = refused(&process, first, 1.0);
        assert!(twice.starts_with("the observations' covariance is ill-conditioned ("), "{twice}");
        let noisy = Process { noise: -1.0, ..process.clone() };
        let negative = "noise: expected a finite number above 0, found -1";
        assert_eq!(refused(&noisy, good, 0.0), negative);
        let none = Kriging::new(&process, &[], &[]).err().unwrap();
        assert_eq!(none.to_string(), "there are no observations");
        let slopes = Process {
            covariance: Covariance::Matern32 { length: 1.0 },
            mean: Mean::Constant,
            noise: 0.0,
        };
        let of = Functional::Derivative { at: 0.0 };
        let open = Kriging::new(&slopes, &[of], &[1.0]).err().unwrap();
        assert_eq!(
            open.to_string(),
            "these observations do not determine a constant mean: take a simpler one, or observe values"
        );
    }
}
