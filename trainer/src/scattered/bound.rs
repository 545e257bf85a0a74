//! Bound of the f32 rounding error of a function: E of METHOD §2.7, for the order of sums that the runtime documents.

use super::sum::{KernelSum, Term};
use crate::numeric::columns;
use crate::numeric::columns::ends;
use crate::regression::arithmetic::{Arithmetic, U, gamma};
use crate::regression::function::Exact;
use faer::Mat;
use sinew_runtime::kernel::Kernel;

/// ULPs of the runtime's exponential and logarithm.
const ULPS: f64 = 1.0;
/// Error of the runtime's exponential far out: above its least value and above its least normal number.
const FLOOR: f64 = 2e-38;
/// Points of the samples' box at which a bound is computed, besides the samples.
const BOX_POINTS: usize = 1000;

/// Rounds a function to the numbers of a file: every number to the nearest f32.
pub fn rounded(sum: &KernelSum) -> KernelSum {
    let round = |x: &f64| f64::from(*x as f32);
    let matrix = |m: &Mat<f64>| Mat::from_fn(m.nrows(), m.ncols(), |r, c| round(&m[(r, c)]));
    KernelSum {
        kernel: sum.kernel,
        shift: sum.shift.iter().map(round).collect(),
        scale: sum.scale.iter().map(round).collect(),
        metric: sum.metric.as_ref().map(matrix),
        centres: matrix(&sum.centres),
        terms: sum.terms.clone(),
        coefficients: matrix(&sum.coefficients),
    }
}

/// Bounds the f32 error of each value, m, of a rounded function.
///
/// - `x`: inputs, d.
/// - `input_error`: bound of the error of each input, d; 0 for f32 numbers.
pub fn bound(sum: &KernelSum, x: &[f64], input_error: &[f64], arithmetic: Arithmetic) -> Vec<f64> {
    let Point { u, u_error, z, z_error_norm } = Point::new(sum, x, input_error);
    let products = (sum.centres.ncols() + sum.terms.len() + 1) as f64;
    let mut out = vec![0.0; sum.value_len()];
    let mut add = |column: usize, value: f64, error: f64| {
        let column = sum.coefficients.col(column);
        let error = error + U * products * value.abs();
        out.iter_mut().zip(column.iter()).for_each(|(out, c)| *out += c.abs() * error);
    };
    for (k, s) in sum.squared_distances(&z).enumerate() {
        add(k, sum.kernel.exact(s), kernel_error(sum.kernel, s, z.len(), z_error_norm, arithmetic));
    }
    let mut powers: Vec<(f64, f64)> = Vec::with_capacity(sum.terms.len());
    for (t, term) in sum.terms.iter().enumerate() {
        let power = match *term {
            Term::One => (1.0, 0.0),
            Term::Product { earlier, input } => {
                let (earlier, error) = powers[earlier];
                let exact = earlier * u[input];
                let most = (earlier.abs() + error) * (u[input].abs() + u_error[input]);
                (exact, most * (1.0 + U) - exact.abs())
            }
        };
        add(sum.centres.ncols() + t, power.0, power.1);
        powers.push(power);
    }
    out
}

/// Computes the squared distances of inputs from the centres, n, each with a bound of its f32 error.
///
/// A term of the sum is behind e + 2 roundings, for e coordinates.
pub fn distances(sum: &KernelSum, x: &[f64], input_error: &[f64]) -> Vec<(f64, f64)> {
    let Point { z, z_error_norm, .. } = Point::new(sum, x, input_error);
    let from = |s: f64| {
        let inherited = (2.0 * s.sqrt() + z_error_norm) * z_error_norm;
        (s, inherited + gamma(z.len() + 2) * (s + inherited))
    };
    sum.squared_distances(&z).map(from).collect()
}

/// Coordinates of an input, with bounds of their f32 errors.
struct Point {
    /// Shifted and scaled input, d.
    u: Vec<f64>,
    /// Error of each u, d.
    u_error: Vec<f64>,
    /// Coordinates that distances are measured in: e, or d without a metric.
    z: Vec<f64>,
    /// Length of the errors of z.
    z_error_norm: f64,
}

impl Point {
    fn new(sum: &KernelSum, x: &[f64], input_error: &[f64]) -> Self {
        let u = sum.scaled(x);
        let error = |i: usize| {
            let scale = sum.scale[i].abs();
            // Subtracting 0 does not round, nor does multiplying by a power of 2.
            let roundings = [sum.shift[i] != 0.0, scale.to_bits() << 12 != 0];
            let roundings = f64::from(roundings.map(u8::from).iter().sum::<u8>());
            scale * input_error[i] + U * roundings * (u[i].abs() + scale * input_error[i])
        };
        let u_error: Vec<f64> = (0..u.len()).map(error).collect();
        let z = sum.measured(&u);
        let z_error = measured_error(sum, &u, &u_error);
        let z_error_norm = z_error.iter().map(|e| e * e).sum::<f64>().sqrt();
        Self { u, u_error, z, z_error_norm }
    }
}

/// Returns the largest bound of each value, m, over sites (n x d) and over 1,000 points of their box.
///
/// The points are the Halton sequence of the first d primes.
pub fn largest(sum: &KernelSum, sites: &Mat<f64>) -> Vec<f64> {
    columns::narrow_registers();
    let none = vec![0.0; sites.ncols()];
    let mut out = vec![0.0f64; sum.value_len()];
    let mut take = |x: &[f64]| {
        let x: Vec<f64> = x.iter().map(|x| f64::from(*x as f32)).collect();
        let bound = bound(sum, &x, &none, Arithmetic::IEEE);
        out.iter_mut().zip(bound).for_each(|(most, bound)| *most = most.max(bound));
    };
    sites.row_iter().for_each(|site| take(&site.iter().copied().collect::<Vec<f64>>()));
    let ends: Vec<[f64; 2]> = sites.col_iter().map(|column| ends(column.iter())).collect();
    let primes = primes(ends.len());
    for i in 1..=BOX_POINTS {
        let at = |([low, high], prime): (&[f64; 2], &usize)| low + (high - low) * halton(i, *prime);
        take(&ends.iter().zip(&primes).map(at).collect::<Vec<f64>>());
    }
    out
}

/// Returns the error of each coordinate z.
fn measured_error(sum: &KernelSum, u: &[f64], u_error: &[f64]) -> Vec<f64> {
    let Some(w) = &sum.metric else { return u_error.to_vec() };
    let rounding = U * u.len() as f64;
    let row = |r: usize| {
        let terms = u.iter().zip(u_error).enumerate();
        terms.map(|(i, (u, e))| w[(r, i)].abs() * (e + rounding * (u.abs() + e))).sum()
    };
    (0..w.nrows()).map(row).collect()
}

/// Bounds the error of a kernel's value at a squared distance s.
///
/// - `coordinates`: number of coordinates, e.
/// - `point_error`: distance between the exact and the computed point.
///
/// METHOD's `(e + 6) |s G'|` is the steepest slope by r, times `r (e + 6) / 2`. The steepest slope over all possible
/// distances also holds at cones and edges.
///
/// A root that counts for more than one rounding adds its roundings to the distance. A quotient, and the root of 1 + s,
/// add their roundings to the value.
fn kernel_error(
    kernel: Kernel,
    s: f64,
    coordinates: usize,
    point_error: f64,
    arithmetic: Arithmetic,
) -> f64 {
    let r = s.sqrt();
    let [root, division] =
        [arithmetic.root, arithmetic.division].map(|roundings| roundings as f64 - 1.0);
    let error = point_error + U * r * ((coordinates + 6) as f64 / 2.0 + root);
    let steepness = |r: f64| 2.0 * kernel.steepness(r * r).abs();
    let steepest = steepness((r - error).max(0.0)).max(steepness(r + error));
    let more = match kernel {
        Kernel::Multiquadric => root,
        Kernel::InverseMultiquadric => root + division,
        Kernel::InverseQuadratic => division,
        _ => 0.0,
    };
    let own = U * (roundings(kernel) + more) * kernel.exact(s).abs();
    own + steepest * error + FLOOR * (2.0 + 5.0 * s)
}

/// Returns the number of roundings behind a value, ρ of METHOD §2.7.
fn roundings(kernel: Kernel) -> f64 {
    match kernel {
        Kernel::Gaussian | Kernel::Matern12 => 2.0 * ULPS,
        Kernel::Matern32 => 2.0 * ULPS + 2.0,
        Kernel::Matern52 => 2.0 * ULPS + 5.0,
        Kernel::ThinPlate => 2.0 * ULPS + 1.0,
        Kernel::Linear | Kernel::Hat { .. } => 1.0,
        Kernel::Cubic | Kernel::Multiquadric | Kernel::InverseQuadratic => 2.0,
        Kernel::Quintic | Kernel::InverseMultiquadric => 3.0,
        Kernel::Wendland { l } => 2.0 * f64::from(l) + 4.0,
    }
}

/// Lists the first primes.
fn primes(count: usize) -> Vec<usize> {
    let is_prime = |n: &usize| (2..*n).take_while(|k| k * k <= *n).all(|k| !n.is_multiple_of(k));
    (2..).filter(is_prime).take(count).collect()
}

/// Returns element i of van der Corput's sequence: the digits of i after the point, reversed.
fn halton(mut i: usize, base: usize) -> f64 {
    let (mut value, mut place) = (0.0, 1.0);
    while i > 0 {
        place /= base as f64;
        value += place * (i % base) as f64;
        i /= base;
    }
    value
}
