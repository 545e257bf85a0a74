//! How far f32 arithmetic may be from a function: the bound E of METHOD §2.7, for the order of sums that
//! the runtime documents.

use super::sum::{KernelSum, Term};
use crate::numeric::columns;
use crate::numeric::columns::ends;
use crate::regression::arithmetic::{Arithmetic, U, gamma};
use crate::regression::function::Exact;
use faer::Mat;
use sinew_runtime::kernel::Kernel;

/// ULPs of the runtime's exponential and logarithm.
const ULPS: f64 = 1.0;
/// Above where the runtime's exponential stops falling, and its least normal number.
const FLOOR: f64 = 2e-38;
/// Points of the samples' box at which a bound is taken, beside the samples.
const BOX_POINTS: usize = 1000;

/// Rounds a function to what a file holds: every number to the nearest f32.
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

/// Bounds the error of each value, m, of a rounded function at inputs x (d) that an f32 evaluation
/// takes off by up to `input_error` (d) each: 0 of numbers that are f32.
pub fn bound(sum: &KernelSum, x: &[f64], input_error: &[f64], arithmetic: Arithmetic) -> Vec<f64> {
    let Point { u, u_error, z, moved } = Point::new(sum, x, input_error);
    let products = (sum.centres.ncols() + sum.terms.len() + 1) as f64;
    let mut out = vec![0.0; sum.value_len()];
    let mut add = |column: usize, value: f64, error: f64| {
        let column = sum.coefficients.col(column);
        let error = error + U * products * value.abs();
        out.iter_mut().zip(column.iter()).for_each(|(out, c)| *out += c.abs() * error);
    };
    for (k, s) in sum.squared_distances(&z).enumerate() {
        add(k, sum.kernel.exact(s), kernel_error(sum.kernel, s, z.len(), moved, arithmetic));
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

/// Computes the squared distances of inputs from the centres, n, each with what an f32 evaluation may be off
/// by: a term of the sum is behind e + 2 roundings of e coordinates.
pub fn distances(sum: &KernelSum, x: &[f64], input_error: &[f64]) -> Vec<(f64, f64)> {
    let Point { z, moved, .. } = Point::new(sum, x, input_error);
    let from = |s: f64| {
        let moved = (2.0 * s.sqrt() + moved) * moved;
        (s, moved + gamma(z.len() + 2) * (s + moved))
    };
    sum.squared_distances(&z).map(from).collect()
}

/// Inputs as the kernels see them, and how far an f32 evaluation may take them off.
struct Point {
    /// d.
    u: Vec<f64>,
    /// d.
    u_error: Vec<f64>,
    /// e, or d.
    z: Vec<f64>,
    /// Length of z's errors.
    moved: f64,
}

impl Point {
    fn new(sum: &KernelSum, x: &[f64], input_error: &[f64]) -> Self {
        let u = sum.scaled(x);
        let error = |i: usize| {
            let scale = sum.scale[i].abs();
            // What is 0 is not rounded when it is taken off, nor is a power of 2 as a factor.
            let roundings = [sum.shift[i] != 0.0, scale.to_bits() << 12 != 0];
            let roundings = f64::from(roundings.map(u8::from).iter().sum::<u8>());
            scale * input_error[i] + U * roundings * (u[i].abs() + scale * input_error[i])
        };
        let u_error: Vec<f64> = (0..u.len()).map(error).collect();
        let z = sum.measured(&u);
        let z_error = measured_error(sum, &u, &u_error);
        let moved = z_error.iter().map(|e| e * e).sum::<f64>().sqrt();
        Self { u, u_error, z, moved }
    }
}

/// Returns the largest bound of each value, m, over sites (n x d) and over 1,000 points of their box, those
/// of the Halton sequence in the first d primes.
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

/// Returns the error of each coordinate that distances are measured in.
fn measured_error(sum: &KernelSum, u: &[f64], u_error: &[f64]) -> Vec<f64> {
    let Some(w) = &sum.metric else { return u_error.to_vec() };
    let rounding = U * u.len() as f64;
    let row = |r: usize| {
        let terms = u.iter().zip(u_error).enumerate();
        terms.map(|(i, (u, e))| w[(r, i)].abs() * (e + rounding * (u.abs() + e))).sum()
    };
    (0..w.nrows()).map(row).collect()
}

/// Bounds the error of a kernel's value at a squared distance s of e coordinates, where the point has moved.
///
/// METHOD's `(e + 6) |s G'|` is the steepest slope by r times `r (e + 6) / 2`; taken over all of where the
/// distance may be, it holds at cones and edges too.
///
/// A root that counts for more than one rounding takes the distance off by those; a quotient, and the root of
/// 1 + s, count in the value.
fn kernel_error(
    kernel: Kernel,
    s: f64,
    coordinates: usize,
    moved: f64,
    arithmetic: Arithmetic,
) -> f64 {
    let r = s.sqrt();
    let [root, division] =
        [arithmetic.root, arithmetic.division].map(|roundings| roundings as f64 - 1.0);
    let error = moved + U * r * ((coordinates + 6) as f64 / 2.0 + root);
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

/// Returns how many roundings a value is behind, ρ of METHOD §2.7.
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

/// Returns element i of van der Corput's sequence: the digits of i behind the point, reversed.
fn halton(mut i: usize, base: usize) -> f64 {
    let (mut value, mut place) = (0.0, 1.0);
    while i > 0 {
        place /= base as f64;
        value += place * (i % base) as f64;
        i /= base;
    }
    value
}
