//! Kernel map in f64, with bounds of the error of its f32 evaluation (METHOD §2.7).

use super::arithmetic::{Arithmetic, U, gamma};
use super::confidence::{ExpectedError, ExpectedErrorBounds, MapConfidence};
use super::function::Exact;
use faer::Mat;
use sinew_runtime::envelope::GroupKernel;

/// Bound of the error of any kernel's change. Exact and computed changes lie between -1 and 1.
const CHANGE_ERROR: f64 = 2.1;

/// Map of d inputs to r outputs that is zero at zero: `Σ_k c_k (G(|x - t_k|²) - G(|t_k|²)) + A x`.
#[derive(Clone, Debug)]
pub struct KernelMap {
    /// Kernel G.
    pub kernel: GroupKernel,
    /// Centres t, d x n.
    pub centres: Mat<f64>,
    /// Coefficients `[c A]`, (r + m) x (n + d): the rows of the outputs, then the rows of the variance roots.
    pub coefficients: Mat<f64>,
    /// Parameters of the map's confidence.
    pub confidence: MapConfidence,
}

/// Value of a map at an input.
pub struct Value {
    /// Outputs, r, without the map's weight.
    pub outputs: Vec<f64>,
    /// Expected error at the input.
    pub expected_error: ExpectedError,
}

/// Bounds of the error of a value.
pub struct ValueError {
    /// Bound of the error of each output, r.
    pub outputs: Vec<f64>,
    /// Bounds of the expected error.
    pub expected_error: ExpectedErrorBounds,
}

impl KernelMap {
    /// Makes a map of no inputs to no outputs.
    pub fn nothing() -> Self {
        Self {
            kernel: GroupKernel::Gaussian,
            centres: Mat::zeros(0, 0),
            coefficients: Mat::zeros(0, 0),
            confidence: MapConfidence::default(),
        }
    }

    /// Evaluates the map at an input of d values.
    pub fn evaluate(&self, input: &[f64]) -> Value {
        let mut outputs = self.values(input);
        let values = outputs.split_off(self.rank());
        let has_centres = self.centres.ncols() > 0;
        let first = has_centres.then(|| Squared::new(input, self.centres.col_as_slice(0)));
        let change = first.map_or(0.0, |first| first.change(self.kernel));
        let apart = input.iter().map(|x| x * x).sum();
        Value { outputs, expected_error: self.confidence.expected_error(apart, change, &values) }
    }

    /// Computes the values of all rows, r + m.
    fn values(&self, input: &[f64]) -> Vec<f64> {
        let mut values = vec![0.0; self.coefficients.nrows()];
        let mut add = |column: usize, value: f64| {
            let column = self.coefficients.col_as_slice(column);
            values.iter_mut().zip(column).for_each(|(out, c)| *out += c * value);
        };
        for k in 0..self.centres.ncols() {
            add(k, Squared::new(input, self.centres.col_as_slice(k)).change(self.kernel));
        }
        for (i, x) in input.iter().enumerate() {
            add(self.centres.ncols() + i, *x);
        }
        values
    }

    /// Counts the outputs, r.
    pub fn rank(&self) -> usize {
        self.coefficients.nrows() - self.confidence.len
    }

    /// Bounds the error of the runtime's evaluation at an input whose values are products of exact f32 numbers.
    pub fn error(&self, input: &[f64]) -> ValueError {
        let rounded: Vec<f64> = input.iter().map(|x| U * x.abs()).collect();
        self.error_from(input, &rounded, Arithmetic::IEEE)
    }

    /// Bounds the error of an f32 evaluation whose inputs have errors of up to `input_error` each.
    ///
    /// The error of a sum of n + d products is the error of its terms and γₙ₊d of their magnitudes.
    pub fn error_from(
        &self,
        input: &[f64],
        input_error: &[f64],
        arithmetic: Arithmetic,
    ) -> ValueError {
        let n = self.centres.ncols();
        let rounding = gamma(n + self.centres.nrows());
        let mut outputs = vec![0.0; self.coefficients.nrows()];
        let mut add = |column: usize, value: f64, error: f64| {
            let error = error + (value.abs() + error) * rounding;
            let column = self.coefficients.col_as_slice(column);
            outputs.iter_mut().zip(column).for_each(|(out, c)| *out += c.abs() * error);
        };
        let mut change = (0.0, 0.0);
        for k in (0..n).rev() {
            let at = Distance::new(input, input_error, self.centres.col_as_slice(k));
            let error = at.change_error(self.kernel, arithmetic).min(CHANGE_ERROR);
            change = (at.squared.change(self.kernel), error);
            add(k, change.0, error);
        }
        for (i, (x, error)) in input.iter().zip(input_error).enumerate() {
            add(n + i, *x, *error);
        }
        let errors = outputs.split_off(self.rank());
        let values = self.values(input).split_off(self.rank());
        let squares = || input.iter().zip(input_error);
        let apart: f64 = input.iter().map(|x| x * x).sum();
        let inherited: f64 = squares().map(|(x, e)| (2.0 * x.abs() + e) * e).sum();
        let apart = (apart, inherited + gamma(input.len() + 1) * (apart + inherited));
        let expected_error = self.confidence.bounds(apart, change, &values, &errors, arithmetic);
        ValueError { outputs, expected_error }
    }
}

/// Squared distances from a centre t.
struct Squared {
    /// Squared distance of x, s.
    here: f64,
    /// Squared distance of 0, |t|².
    rest: f64,
    /// s - |t|².
    gain: f64,
}

impl Squared {
    fn new(input: &[f64], centre: &[f64]) -> Self {
        let mut out = Self { here: 0.0, rest: 0.0, gain: 0.0 };
        for (x, t) in input.iter().zip(centre) {
            out.here += (x - t) * (x - t);
            out.rest += t * t;
            out.gain += x * (x - 2.0 * t);
        }
        out
    }

    /// Returns `G(s) - G(|t|²)`. A gaussian's change is exact to the last places, also if s and |t|² are close.
    fn change(&self, kernel: GroupKernel) -> f64 {
        let (value, rest) = (kernel.exact(self.here), kernel.exact(self.rest));
        match kernel {
            GroupKernel::Gaussian if self.gain < 0.0 => -value * self.gain.exp_m1(),
            GroupKernel::Gaussian => rest * (-self.gain).exp_m1(),
            _ => value - rest,
        }
    }
}

/// Distance of an input from a centre, with bounds of the error of its f32 evaluation.
struct Distance {
    /// Number of inputs, d.
    dimensions: usize,
    /// Exact squared distances.
    squared: Squared,
    /// Error of the gain.
    gain_error: f64,
    /// Length of the inputs' errors.
    input_error: f64,
}

impl Distance {
    /// Measures an input, d values with a bound of the error of each.
    ///
    /// Each product of `Σ x (x - 2 t)` is behind d + 2 roundings. An error e of x changes a term by `2 (x - t) e + e²`.
    fn new(input: &[f64], input_error: &[f64], centre: &[f64]) -> Self {
        let dimensions = input.len();
        let squared = Squared::new(input, centre);
        let (mut inherited, mut rounded, mut length) = (0.0, 0.0, 0.0);
        for ((&x, &error), &t) in input.iter().zip(input_error).zip(centre) {
            let apart = (x - t).abs();
            inherited += (2.0 * apart + error) * error;
            length += error * error;
            rounded += (x.abs() + error) * gamma(dimensions + 2) * ((x - 2.0 * t).abs() + error);
        }
        Self {
            dimensions,
            squared,
            gain_error: inherited + rounded,
            input_error: f64::sqrt(length),
        }
    }

    /// Bounds the error of a kernel's change.
    ///
    /// A gaussian's change is `e^-s (1 - e^gain)` or `e^-|t|² (1 - e^-gain)`, with s = |t|² + gain. The first factor
    /// passes its error on to the change. The second factor passes the gain's error on to the lesser of the two values.
    /// If the sign of the gain is uncertain, the change is at most the gain's error. Roundings: 1 ULP, 2 ULP and a
    /// product.
    fn change_error(&self, kernel: GroupKernel, arithmetic: Arithmetic) -> f64 {
        let Squared { here, rest, gain } = self.squared;
        let change = self.squared.change(kernel).abs();
        let (inherited, roundings) = if kernel == GroupKernel::Gaussian {
            let rest_error = gamma(self.dimensions) * rest;
            let inherited = rest_error + self.gain_error;
            let error = inherited + U * (here + inherited);
            let taken = if gain < 0.0 { error } else { rest_error };
            let both = (error + inherited).exp();
            let least = kernel.exact(here.max(rest));
            (change * taken.exp_m1() + least * self.gain_error.exp_m1() * both, 7)
        } else {
            let of_value = self.value_error(kernel, here, self.input_error, arithmetic);
            (of_value + self.value_error(kernel, rest, 0.0, arithmetic), 1)
        };
        inherited + gamma(roundings) * (change + inherited)
    }

    /// Bounds the error of a Matérn kernel's value.
    ///
    /// The kernel's argument is √s, times √3 or √5 inside the root. Its error consists of the input's error, half of
    /// the roundings of s, and the roundings of the root. The value falls by at most -dG/d√s times that error. The
    /// slope is taken at the far end, and for an exponential at the near end. The value is also behind 1 ULP, and
    /// behind a polynomial of 1 or 4 roundings and its product.
    fn value_error(
        &self,
        kernel: GroupKernel,
        s: f64,
        input_error: f64,
        arithmetic: Arithmetic,
    ) -> f64 {
        let most = s.sqrt() + input_error;
        let error = input_error + most * gamma(self.dimensions / 2 + 2 + arithmetic.root);
        let far = most + error;
        let inherited = 2.0 * kernel.steepness(far * far) * (5.0 * error).exp() * error;
        let roundings = match kernel {
            GroupKernel::Gaussian | GroupKernel::Matern12 => 2,
            GroupKernel::Matern32 => 4,
            GroupKernel::Matern52 => 7,
        };
        inherited + gamma(roundings) * (kernel.exact(s) + inherited)
    }
}

#[cfg(test)]
mod tests {
    use super::super::function::SMOOTHEST_FIRST;
    use super::*;

    fn map() -> KernelMap {
        KernelMap {
            kernel: GroupKernel::Matern52,
            centres: Mat::from_fn(2, 3, |r, k| 0.5 * k as f64 - 0.2 * r as f64),
            coefficients: Mat::from_fn(2, 5, |row, k| {
                [[1.0, -2.0, 0.5, 0.3, -0.7], [0.2, 0.6, -0.1, 0.4, 0.3]][row][k]
            }),
            confidence: MapConfidence {
                len: 1,
                reach: 4.0,
                linear: 0.2,
                signal: 20.0,
                noise: 30.0,
            },
        }
    }

    #[test]
    fn rest_is_zero_and_errors_of_inputs_stay_within_the_bound() {
        for kernel in SMOOTHEST_FIRST {
            let map = KernelMap { kernel, ..map() };
            assert_eq!(map.evaluate(&[0.0, 0.0]).outputs, [0.0]);
            // On a centre, where Matérn 1/2 has its cone; where |x - t| = |t|; and far away.
            for x in [[1.0, -0.2], [0.5, -0.2], [1.0, -0.4], [0.1, 0.4], [2.6, 0.0]] {
                for off in [0.0, U, 1e-3] {
                    let error = map.error_from(&x, &[off, off], Arithmetic::IEEE);
                    let (least, most) = error.expected_error.confidence(1, Arithmetic::IEEE);
                    let error = error.outputs[0];
                    let exact = map.evaluate(&x);
                    assert!(error < 200.0 * U + 50.0 * off, "{kernel:?} {error:?}");
                    for moved in [[off, off], [-off, off], [off, -off], [-off, -off]] {
                        let moved = map.evaluate(&[x[0] + moved[0], x[1] + moved[1]]);
                        let change = (moved.outputs[0] - exact.outputs[0]).abs();
                        assert!(change <= error, "{kernel:?} {x:?} {off}");
                        let confidence = moved.expected_error.confidence();
                        assert!((least..=most).contains(&confidence), "{kernel:?} {x:?} {off}");
                    }
                }
                let rounded = x.map(|x| U * x.abs());
                let expected = map.error_from(&x, &rounded, Arithmetic::IEEE);
                assert_eq!(map.error(&x).outputs, expected.outputs);
            }
        }
        let far = map().evaluate(&[1e5, 0.0]).expected_error.map_weight();
        assert!(far < 1e-80, "no weight far away");
    }
}
