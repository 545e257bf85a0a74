//! A kernel map in f64, and how far its f32 evaluation may be from it (METHOD §2.7).

use super::arithmetic::{Arithmetic, U, gamma};
use super::function::Exact;
use faer::Mat;
use serde::Serialize;
use sinew_runtime::envelope::GroupKernel;

/// Where a fade ends, in squared distances of its start (METHOD §2.6).
const FADE: f64 = 6.25;
/// Relative error of the runtime's smoothstep.
pub const STEP_ERROR: f64 = 4e-7;
/// More than any kernel's change may be off by: it lies between -1 and 1, computed or not.
const CHANGE_ERROR: f64 = 2.1;

/// A map of d inputs to r outputs that is zero at zero:
/// `Σ_k c_k (G(|x - t_k|²) - G(|t_k|²)) + A x`.
#[derive(Clone, Debug)]
pub struct KernelMap {
    /// G.
    pub kernel: GroupKernel,
    /// Centres t, d x n.
    pub centres: Mat<f64>,
    /// `[c A]`, r x (n + d).
    pub coefficients: Mat<f64>,
    /// Where the map fades out.
    pub fade: Fade,
}

/// The confidence of an input: full within `start` of a centre, none beyond `end` of all
/// (METHOD §2.6, on squared distances, which are smooth).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Fade {
    /// Squared scaled distance.
    pub start: f64,
    /// Likewise.
    pub end: f64,
}

/// What a map gives for an input.
pub struct Value {
    /// Outputs, not faded, r.
    pub outputs: Vec<f64>,
    /// What they are to be multiplied by.
    pub confidence: f64,
}

impl KernelMap {
    /// A map of no inputs to no outputs.
    pub fn nothing() -> Self {
        Self {
            kernel: GroupKernel::Gaussian,
            centres: Mat::zeros(0, 0),
            coefficients: Mat::zeros(0, 0),
            fade: Fade { start: 0.0, end: 0.0 },
        }
    }

    /// Evaluates the map at an input of d values.
    pub fn evaluate(&self, input: &[f64]) -> Value {
        let mut confidence = Vec::with_capacity(self.centres.ncols());
        let mut outputs = vec![0.0; self.coefficients.nrows()];
        let mut add = |column: usize, value: f64| {
            let column = self.coefficients.col_as_slice(column);
            outputs.iter_mut().zip(column).for_each(|(out, c)| *out += c * value);
        };
        for k in 0..self.centres.ncols() {
            let squared = Squared::new(input, self.centres.col_as_slice(k));
            add(k, squared.change(self.kernel));
            confidence.push(squared.here);
        }
        for (i, x) in input.iter().enumerate() {
            add(self.centres.ncols() + i, *x);
        }
        Value { outputs, confidence: self.fade.confidence(confidence.into_iter()) }
    }

    /// Bounds the error of the runtime's evaluation at an input whose values are products of exact
    /// f32 numbers: of each output, r, and of the confidence.
    pub fn error(&self, input: &[f64]) -> (Vec<f64>, f64) {
        let rounded: Vec<f64> = input.iter().map(|x| U * x.abs()).collect();
        self.error_from(input, &rounded, Arithmetic::IEEE)
    }

    /// Bounds it where an f32 evaluation takes inputs that are off by up to `input_error` each.
    ///
    /// A sum of n + d products is off by the errors of its terms and γₙ₊d of their magnitudes.
    pub fn error_from(
        &self,
        input: &[f64],
        input_error: &[f64],
        arithmetic: Arithmetic,
    ) -> (Vec<f64>, f64) {
        let n = self.centres.ncols();
        let rounding = gamma(n + self.centres.nrows());
        let mut outputs = vec![0.0; self.coefficients.nrows()];
        let mut add = |column: usize, value: f64, error: f64| {
            let error = error + (value.abs() + error) * rounding;
            let column = self.coefficients.col_as_slice(column);
            outputs.iter_mut().zip(column).for_each(|(out, c)| *out += c.abs() * error);
        };
        let mut distances = Vec::with_capacity(n);
        for k in 0..n {
            let at = Distance::new(input, input_error, self.centres.col_as_slice(k));
            let error = at.change_error(self.kernel, arithmetic).min(CHANGE_ERROR);
            add(k, at.squared.change(self.kernel), error);
            distances.push((at.squared.here, at.squared_error));
        }
        for (i, (x, error)) in input.iter().zip(input_error).enumerate() {
            add(n + i, *x, *error);
        }
        (outputs, self.fade.error(&distances, arithmetic))
    }
}

/// Squared distances from a centre t.
struct Squared {
    /// Of x, s.
    here: f64,
    /// Of 0, |t|².
    rest: f64,
    /// What the one exceeds the other by.
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

    /// Returns `G(s) - G(|t|²)`, of a gaussian to its last places also where the two are close.
    fn change(&self, kernel: GroupKernel) -> f64 {
        let (value, rest) = (kernel.exact(self.here), kernel.exact(self.rest));
        match kernel {
            GroupKernel::Gaussian if self.gain < 0.0 => -value * self.gain.exp_m1(),
            GroupKernel::Gaussian => rest * (-self.gain).exp_m1(),
            _ => value - rest,
        }
    }
}

/// An input's distance from a centre, and how far an f32 evaluation may be from it.
struct Distance {
    /// d.
    dimensions: usize,
    /// What it is.
    squared: Squared,
    /// Of s.
    squared_error: f64,
    /// Of the gain.
    gain_error: f64,
    /// Length of the inputs' errors.
    input_error: f64,
}

impl Distance {
    /// Each term of `Σ (x - t)²` is behind d + 2 roundings. `Σ x ((x - t) - t)` is one of products
    /// behind d + 1, of which the inner difference is off by u before. An error e of x moves either
    /// by `2 (x - t) e + e²`.
    fn new(input: &[f64], input_error: &[f64], centre: &[f64]) -> Self {
        let dimensions = input.len();
        let squared = Squared::new(input, centre);
        let (mut moved, mut rounded, mut length) = (0.0, 0.0, 0.0);
        for ((&x, &error), &t) in input.iter().zip(input_error).zip(centre) {
            let apart = (x - t).abs();
            moved += (2.0 * apart + error) * error;
            length += error * error;
            let of_difference = U * (1.0 + gamma(dimensions + 1)) * (apart + error);
            let of_product = gamma(dimensions + 1) * ((x - 2.0 * t).abs() + error);
            rounded += (x.abs() + error) * (of_difference + of_product);
        }
        Self {
            dimensions,
            squared_error: moved + gamma(dimensions + 2) * (squared.here + moved),
            squared,
            gain_error: moved + rounded,
            input_error: f64::sqrt(length),
        }
    }

    /// Bounds the error of a kernel's change.
    ///
    /// A gaussian's is `e^-s (1 - e^gain)` or `e^-|t|² (1 - e^-gain)`: the first factor passes its
    /// own error on to the change, the second the gain's to the lesser of the two values. Where the
    /// gain's error makes either possible, the change is no greater than that. Roundings: 1 ULP,
    /// 2 ULP and a product.
    fn change_error(&self, kernel: GroupKernel, arithmetic: Arithmetic) -> f64 {
        let Squared { here, rest, gain } = self.squared;
        let change = self.squared.change(kernel).abs();
        let (inherited, roundings) = if kernel == GroupKernel::Gaussian {
            let rest_error = gamma(self.dimensions) * rest;
            let taken = if gain < 0.0 { self.squared_error } else { rest_error };
            let both = (self.squared_error + rest_error + self.gain_error).exp();
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
    /// Its argument is √s, off by what the input is and by half of s's roundings, times √3 or √5
    /// below the root, and the root's own. The value falls by at most -dG/d√s times that, here
    /// taken at the far end and for an exponential at the near one; it is behind 1 ULP, and a
    /// polynomial of 1 or 4 roundings and its product.
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
    use super::super::function::SMOOTHEST_FIRST;
    use super::*;

    fn map() -> KernelMap {
        KernelMap {
            kernel: GroupKernel::Matern52,
            centres: Mat::from_fn(2, 3, |r, k| 0.5 * k as f64 - 0.2 * r as f64),
            coefficients: Mat::from_fn(1, 5, |_, k| [1.0, -2.0, 0.5, 0.3, -0.7][k]),
            fade: Fade { start: 1.0, end: 4.0 },
        }
    }

    #[test]
    fn confidence_falls_from_one_to_nothing() {
        let of = |x: f64| map().evaluate(&[x, 0.0]).confidence;
        assert_eq!(of(1.0), 1.0);
        assert!((0.01..0.99).contains(&of(2.6)));
        assert_eq!(of(4.0), 0.0);
        let falling: Vec<f64> = (10..40).map(|i| of(0.1 * f64::from(i))).collect();
        assert!(falling.is_sorted_by(|a, b| a >= b));
    }

    #[test]
    fn rest_is_zero_and_what_inputs_are_off_by_is_within_the_bound() {
        for kernel in SMOOTHEST_FIRST {
            let map = KernelMap { kernel, ..map() };
            assert_eq!(map.evaluate(&[0.0, 0.0]).outputs, [0.0]);
            // On a centre, where Matérn 1/2 has its cone, and where |x - t| = |t|; in the fade.
            for x in [[1.0, -0.2], [0.5, -0.2], [1.0, -0.4], [0.1, 0.4], [2.6, 0.0]] {
                for off in [0.0, U, 1e-3] {
                    let (error, of_confidence) = map.error_from(&x, &[off, off], Arithmetic::IEEE);
                    let exact = map.evaluate(&x);
                    assert!(error[0] < 200.0 * U + 50.0 * off, "{kernel:?} {error:?}");
                    for moved in [[off, off], [-off, off], [off, -off], [-off, -off]] {
                        let moved = map.evaluate(&[x[0] + moved[0], x[1] + moved[1]]);
                        let change = (moved.outputs[0] - exact.outputs[0]).abs();
                        assert!(change <= error[0], "{kernel:?} {x:?} {off}");
                        let change = (moved.confidence - exact.confidence).abs();
                        assert!(change <= of_confidence, "{kernel:?} {x:?} {off}");
                    }
                }
                let rounded = x.map(|x| U * x.abs());
                assert_eq!(map.error(&x), map.error_from(&x, &rounded, Arithmetic::IEEE));
            }
        }
        assert_eq!(map().error(&[9.0, 0.0]).1, 0.0, "none beyond doubt");
    }
}
