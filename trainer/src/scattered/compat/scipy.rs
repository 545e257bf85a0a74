//! SciPy's `RBFInterpolator` (1.17) by its own names and rules: a named mode, which warns where our fit would be
//! refused.
//!
//! Epsilon multiplies unscaled distances, λ has the kernel's units, and a polynomial has every monomial of its degree.
//! Nothing is merged, dropped or lowered. SciPy scales polynomials by the box of the sites. This mode scales them by
//! epsilon, which gives the same function.

use crate::Error;
use crate::numeric::columns::ends;
use crate::regression::function::{is_scale_invariant, order};
use crate::scattered::problem::Smoothing;
use crate::scattered::solver::matrix::some_rows;
use crate::scattered::solver::options::out_of_range;
use crate::scattered::solver::polynomial::Space;
use crate::scattered::solver::samples::check;
use crate::scattered::solver::system::solve;
use crate::scattered::sum::{KernelSum, monomials};
use faer::{ColRef, Mat};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};
use serde_json::Value;
use sinew_runtime::kernel::Kernel;
use std::cmp::Ordering;

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
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ScipyOptions {
    /// Name of the kernel; upper and lower case are equal; default: thin_plate_spline.
    pub kernel: Option<String>,
    /// Factor of distances; required for kernels with a width.
    pub epsilon: Option<f64>,
    /// Smoothing λ, one or one for each sample; default: 0.
    #[serde(deserialize_with = "given")]
    pub smoothing: Option<Smoothing>,
    /// Degree of the polynomial, -1 for none; by default the kernel's least degree, at least 0.
    pub degree: Option<i32>,
    /// Number of nearest samples that determine the function at a query; by default all.
    pub neighbors: Option<usize>,
}

/// Reads a smoothing that is not chosen.
fn given<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Smoothing>, D::Error> {
    let value = Value::deserialize(from)?;
    match Smoothing::try_from(value.clone()) {
        Ok(smoothing) if smoothing != Smoothing::Chosen => Ok(Some(smoothing)),
        _ => Err(D::Error::custom(format!(
            "smoothing: expected a number or a list of numbers (one a sample), found {value}"
        ))),
    }
}

/// Function that SciPy finds.
#[derive(Clone, Debug)]
pub struct RbfInterpolator {
    problem: Problem,
    /// Function of all samples, and the reciprocal condition of its system; `None` if each query has its own system.
    pub whole: Option<(KernelSum, f64)>,
    /// Number of neighbours that determine the function at a query.
    neighbours: usize,
    /// Warnings of SciPy, or of METHOD.
    pub warnings: Vec<String>,
}

impl RbfInterpolator {
    /// Fits values (n x m) at sites (n x d).
    ///
    /// # Errors
    /// - If there are no samples, sites and values have different numbers of rows, or a number is not finite.
    /// - If SciPy has no such kernel, or the smoothing is to be chosen.
    /// - If epsilon, degree, smoothing or neighbours are out of range.
    /// - If there are fewer samples or neighbours than monomials, or they do not determine the polynomial.
    /// - If the system is singular.
    pub fn new(sites: &Mat<f64>, values: &Mat<f64>, options: &ScipyOptions) -> Result<Self, Error> {
        if options.smoothing == Some(Smoothing::Chosen) {
            return Err(Error::unsupported("SciPy chooses no smoothing: give a number"));
        }
        check(sites, values)?;
        let (n, inputs) = sites.shape();
        let kernel = kernel(options.kernel.as_deref().unwrap_or("thin_plate_spline"))?;
        let smoothing = smoothing(options.smoothing.as_ref(), n)?;
        let epsilon = epsilon(kernel, options.epsilon)?;
        let least = order(kernel).and_then(|order| order.checked_sub(1));
        let degree = degree(options.degree, least)?;
        let mut warnings = Vec::new();
        if let (Some(degree), Some(least)) = (degree, least)
            && degree < least
        {
            warnings.push(format!(
                "the degree {degree} is below the kernel's least, {least}: the function may not be unique"
            ));
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
            warnings.push(format!("the fit is ill-conditioned (reciprocal condition {rcond:.1e})"));
        }
        Ok(Self { problem, whole: Some((sum, rcond)), neighbours: used, warnings })
    }

    /// Evaluates the function at d inputs: m values, and the reciprocal condition of the solved system.
    ///
    /// # Errors
    /// - If the query has another length.
    /// - If the system of the query's neighbours is singular.
    pub fn evaluate(&self, x: &[f64]) -> Result<(Vec<f64>, f64), Error> {
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
        self.check_repeated(some)?;
        let (sites, values) = (some_rows(&self.sites, some), some_rows(&self.values, some));
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

fn kernel(given: &str) -> Result<Kernel, Error> {
    let name = given.to_lowercase();
    let found = KERNELS.into_iter().find(|(own, _)| *own == name);
    let expected = KERNELS.map(|(name, _)| name).join(", ");
    let unknown = format!("\"{given}\" is no kernel of SciPy's: expected one of {expected}");
    found.map(|(_, kernel)| kernel).ok_or_else(|| Error::value(unknown))
}

fn smoothing(of: Option<&Smoothing>, samples: usize) -> Result<Vec<f64>, Error> {
    let all = match of {
        Some(Smoothing::Given(lambda)) => vec![*lambda; samples],
        Some(Smoothing::Each(all)) => all.clone(),
        None | Some(Smoothing::Chosen) => vec![0.0; samples],
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
