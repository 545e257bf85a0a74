//! SciPy's `RBFInterpolator` (1.17) by its own names and rules: a named mode, which warns where our fit would be
//! refused.
//!
//! Epsilon multiplies unscaled distances, λ has the kernel's units, and a polynomial has every monomial of its degree.
//! Nothing is merged, dropped or lowered. SciPy scales polynomials by the box of the sites. This mode scales them by
//! epsilon, which gives the same function.

use crate::Error;
use crate::numeric::columns::ends;
use crate::regression::function::{is_scale_invariant, order};
use crate::scattered::solver::options::out_of_range;
use crate::scattered::solver::polynomial::Space;
use crate::scattered::solver::samples::check;
use crate::scattered::solver::system::solve;
use crate::scattered::sum::{KernelSum, monomials};
use faer::{ColRef, Mat};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use sinew_runtime::kernel::Kernel;
use std::cmp::Ordering;
use std::fmt::{Display, Formatter};

/// Kernels by SciPy's names.
const KERNELS: [(&str, Kernel); 8] = [
    ("linear", Kernel::Linear),
    ("thin_plate_spline", Kernel::ThinPlate),
    ("cubic", Kernel::Cubic),
    ("quintic", Kernel::Quintic),
    ("multiquadric", Kernel::Multiquadric),
    ("inverse_multiquadric", Kernel::InverseMultiquadric),
    ("inverse_quadratic", Kernel::InverseQuadratic),
    ("gaussian", Kernel::Gaussian),
];
/// Reciprocal condition below which a fit has a warning: METHOD §2.7 promises agreement above it.
const RCOND: f64 = 1e-10;

/// Arguments of SciPy's interpolator. An omitted argument has SciPy's default.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ScipyOptions {
    /// Name of the kernel; upper and lower case are equal.
    pub kernel: String,
    /// Factor of distances; required for kernels with a width.
    pub epsilon: Option<f64>,
    /// Smoothing λ.
    pub smoothing: Smoothing,
    /// Degree of the polynomial, -1 for none; by default the kernel's least degree, at least 0.
    pub degree: Option<i32>,
    /// Number of nearest samples that determine the function at a query; by default all.
    pub neighbors: Option<usize>,
}

/// Smoothing λ of all samples, or of each sample.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(try_from = "Value")]
pub enum Smoothing {
    /// One λ for all samples.
    All(f64),
    /// λ of each sample, n.
    Each(Vec<f64>),
}

impl TryFrom<Value> for Smoothing {
    type Error = String;

    /// Reads a number or numbers.
    fn try_from(value: Value) -> Result<Self, String> {
        let numbers = |all: &[Value]| all.iter().map(Value::as_f64).collect::<Option<Vec<f64>>>();
        let read = match &value {
            Value::Array(all) => numbers(all).map(Self::Each),
            one => one.as_f64().map(Self::All),
        };
        read.ok_or_else(|| {
            format!(
                "smoothing: expected a number or a list of numbers (one a sample), found {value}"
            )
        })
    }
}

/// Warnings of SciPy, or of METHOD.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum ScipyWarning {
    /// The degree is below the kernel's least degree: the function may not be unique.
    Degree {
        /// Degree of the polynomial.
        degree: usize,
        /// Least degree of the kernel.
        least: usize,
    },
    /// Rounding may change the function.
    IllConditioned {
        /// Reciprocal condition.
        rcond: f64,
    },
}

impl Display for ScipyWarning {
    fn fmt(&self, to: &mut Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Degree { degree, least } => write!(
                to,
                "the degree {degree} is below the kernel's least, {least}: the function may not be unique"
            ),
            Self::IllConditioned { rcond } => {
                write!(to, "the fit is ill-conditioned (reciprocal condition {rcond:.1e})")
            }
        }
    }
}

/// Function that SciPy finds.
#[derive(Clone, Debug)]
pub struct RbfInterpolator {
    problem: Problem,
    /// Function of all samples, and the reciprocal condition of its system; `None` if each query has its own system.
    whole: Option<(KernelSum, f64)>,
    /// Number of neighbours that determine the function at a query.
    neighbours: usize,
    /// Warnings of the fit.
    pub warnings: Vec<ScipyWarning>,
}

impl Default for ScipyOptions {
    fn default() -> Self {
        Self {
            kernel: "thin_plate_spline".into(),
            epsilon: None,
            smoothing: Smoothing::All(0.0),
            degree: None,
            neighbors: None,
        }
    }
}

impl RbfInterpolator {
    /// Fits values (n x m) at sites (n x d).
    ///
    /// # Errors
    /// - If there are no samples, sites and values have different numbers of rows, or a number is not finite.
    /// - If SciPy has no such kernel.
    /// - If epsilon, degree, smoothing or neighbours are out of range.
    /// - If there are fewer samples or neighbours than monomials, or they do not determine the polynomial.
    /// - If the system is singular.
    pub fn new(sites: &Mat<f64>, values: &Mat<f64>, options: &ScipyOptions) -> Result<Self, Error> {
        check(sites, values)?;
        let (n, inputs) = sites.shape();
        let name = options.kernel.to_lowercase();
        let kernel = KERNELS.into_iter().find(|(own, _)| *own == name);
        let kernel = kernel.ok_or_else(|| unknown_kernel(&options.kernel))?.1;
        let smoothing = smoothing(&options.smoothing, n)?;
        let epsilon = epsilon(kernel, options.epsilon)?;
        let least = order(kernel).and_then(|order| order.checked_sub(1));
        let degree = degree(options.degree, least)?;
        let mut warnings = Vec::new();
        if let (Some(degree), Some(least)) = (degree, least)
            && degree < least
        {
            warnings.push(ScipyWarning::Degree { degree, least });
        }
        let used = options.neighbors.map_or(n, |k| k.min(n));
        if used == 0 {
            return Err(out_of_range("neighbors", 0.0, "at least 1"));
        }
        let needed = degree.map_or(0, |degree| monomials(inputs, degree).len());
        if let Some(degree) = degree
            && needed > used
        {
            return Err(Error::fit(format!(
                "degree {degree} in {inputs} inputs needs {needed} samples, found {used}"
            )));
        }
        let (sites, values) = (sites.clone(), values.clone());
        let problem = Problem { sites, values, smoothing, kernel, epsilon, degree };
        if options.neighbors.is_some() {
            return Ok(Self { problem, whole: None, neighbours: used, warnings });
        }
        let (sum, rcond) = problem.solve(&(0..n).collect::<Vec<usize>>())?;
        if rcond < RCOND {
            warnings.push(ScipyWarning::IllConditioned { rcond });
        }
        Ok(Self { problem, whole: Some((sum, rcond)), neighbours: used, warnings })
    }

    /// Evaluates the function at d inputs: m values.
    ///
    /// # Errors
    /// - If the query has another length.
    /// - If the system of the query's neighbours is singular.
    pub fn evaluate(&self, x: &[f64]) -> Result<Vec<f64>, Error> {
        Ok(self.conditioned(x)?.0)
    }

    /// Evaluates the function at d inputs: m values, and the reciprocal condition of the solved system.
    ///
    /// # Errors
    /// Errors of [`Self::evaluate`].
    pub fn conditioned(&self, x: &[f64]) -> Result<(Vec<f64>, f64), Error> {
        let expected = self.problem.sites.ncols();
        if x.len() != expected {
            let found = x.len();
            return Err(Error::mismatch(format!(
                "expected a query of {expected} numbers, found {found}"
            )));
        }
        if let Some((sum, rcond)) = &self.whole {
            return Ok((sum.evaluate(x), *rcond));
        }
        let (sum, rcond) = self.problem.solve(&nearest(&self.problem.sites, x, self.neighbours))?;
        Ok((sum.evaluate(x), rcond))
    }

    /// Returns the function of all samples and the reciprocal condition of its system; `None` if each query has its own
    /// system.
    pub fn whole(&self) -> Option<&(KernelSum, f64)> {
        self.whole.as_ref()
    }
}

/// Samples and the parameters of their fit.
#[derive(Clone, Debug)]
struct Problem {
    sites: Mat<f64>,
    values: Mat<f64>,
    smoothing: Vec<f64>,
    kernel: Kernel,
    epsilon: f64,
    degree: Option<usize>,
}

impl Problem {
    /// Fits some samples; returns the function and the reciprocal condition.
    fn solve(&self, some: &[usize]) -> Result<(KernelSum, f64), Error> {
        let rows = |m: &Mat<f64>| Mat::from_fn(some.len(), m.ncols(), |i, c| m[(some[i], c)]);
        self.check_repeated(some)?;
        let (sites, values) = (rows(&self.sites), rows(&self.values));
        let smoothing: Vec<f64> = some.iter().map(|&i| self.smoothing[i]).collect();
        let d = sites.ncols();
        let shift: Vec<f64> = sites.col_iter().map(middle).collect();
        let points = Mat::from_fn(some.len(), d, |i, c| (sites[(i, c)] - shift[c]) * self.epsilon);
        let inputs: Vec<usize> = (0..d).collect();
        // Tolerance of numpy's matrix_rank.
        let tolerance = f64::EPSILON * some.len().max(d + 1) as f64;
        let space = Space { points: &points, inputs: &inputs, tolerance };
        let polynomial = space.polynomial(self.degree);
        let (rank, terms) = (polynomial.rank(), polynomial.terms.len());
        if rank < terms {
            return Err(Error::fit(format!(
                "the system is singular: the samples determine {rank} of {terms} monomials"
            )));
        }
        let solved = solve(self.kernel, &points, &smoothing, polynomial, &values);
        let rcond = solved.system.rcond();
        if !solved.missed.is_finite() {
            return Err(Error::fit("the system is singular"));
        }
        let sum = KernelSum {
            kernel: self.kernel,
            shift,
            scale: vec![self.epsilon; d],
            metric: None,
            centres: points.transpose().to_owned(),
            terms: solved.polynomial.terms,
            coefficients: faer::concat![[solved.kernels.transpose(), solved.monomials.transpose()]],
        };
        Ok((sum, rcond))
    }

    /// Checks that samples of one site are smoothed. Without smoothing their equations are equal.
    fn check_repeated(&self, some: &[usize]) -> Result<(), Error> {
        let exact = some.iter().copied().filter(|&i| self.smoothing[i] == 0.0);
        let mut order: Vec<usize> = exact.collect();
        let compare = |&a: &usize, &b: &usize| {
            let columns = self.sites.col_iter().map(|c| c[a].total_cmp(&c[b]));
            columns.fold(Ordering::Equal, Ordering::then)
        };
        order.sort_by(compare);
        match order.windows(2).find(|pair| compare(&pair[0], &pair[1]).is_eq()) {
            Some(pair) => Err(Error::fit(format!(
                "the system is singular: rows {} and {} have the same site",
                pair[0], pair[1]
            ))),
            None => Ok(()),
        }
    }
}

fn unknown_kernel(found: &str) -> Error {
    let expected = KERNELS.map(|(name, _)| name).join(", ");
    Error::value(format!("\"{found}\" is no kernel of SciPy's: expected one of {expected}"))
}

fn smoothing(of: &Smoothing, samples: usize) -> Result<Vec<f64>, Error> {
    let all = match of {
        Smoothing::All(lambda) => vec![*lambda; samples],
        Smoothing::Each(all) => all.clone(),
    };
    if all.len() != samples {
        let found = all.len();
        return Err(Error::mismatch(format!("expected one smoothing or {samples}, found {found}")));
    }
    match all.iter().find(|lambda| !lambda.is_finite()) {
        Some(&found) => Err(out_of_range("a smoothing", found, "a finite number")),
        None => Ok(all),
    }
}

fn epsilon(kernel: Kernel, given: Option<f64>) -> Result<f64, Error> {
    let default = is_scale_invariant(kernel).then_some(1.0);
    let found = given.or(default).ok_or_else(|| {
        Error::missing(format!("the kernel \"{}\" needs an epsilon", kernel.name()))
    })?;
    if found.is_finite() && found != 0.0 {
        return Ok(found);
    }
    Err(out_of_range("epsilon", found, "a finite number other than 0"))
}

fn degree(given: Option<i32>, least: Option<usize>) -> Result<Option<usize>, Error> {
    let Some(degree) = given else { return Ok(Some(least.unwrap_or(0))) };
    if degree < -1 {
        return Err(out_of_range("degree", degree.into(), "-1 or more"));
    }
    Ok(usize::try_from(degree).ok())
}

/// Returns the middle of a column's box.
fn middle(column: ColRef<'_, f64>) -> f64 {
    let [least, most] = ends(column.iter());
    0.5 * least + 0.5 * most
}

/// Lists the k sites (n x d) nearest to x, in ascending order of their index. The first of equally distant sites comes
/// first.
fn nearest(sites: &Mat<f64>, x: &[f64], k: usize) -> Vec<usize> {
    let mut squared = vec![0.0; sites.nrows()];
    for (column, x) in x.iter().enumerate() {
        let coordinates = sites.col_as_slice(column);
        squared.iter_mut().zip(coordinates).for_each(|(s, site)| *s += (site - x) * (site - x));
    }
    let mut order: Vec<usize> = (0..sites.nrows()).collect();
    order.sort_by(|&a, &b| squared[a].total_cmp(&squared[b]));
    order.truncate(k);
    order.sort_unstable();
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_are_found_in_order() {
        let sites = Mat::from_fn(5, 2, |i, c| {
            [[4.0, 0.0], [1.0, 0.0], [0.0, 1.0], [9.0, 9.0], [0.5, 0.0]][i][c]
        });
        assert_eq!(nearest(&sites, &[0.0, 0.0], 1), [4]);
        assert_eq!(nearest(&sites, &[0.0, 0.0], 2), [1, 4], "of two equally far the first");
        assert_eq!(nearest(&sites, &[0.0, 0.0], 9), [0, 1, 2, 3, 4]);
    }
}
