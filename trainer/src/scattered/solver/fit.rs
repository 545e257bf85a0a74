//! Fits of scattered data (METHOD §2.2): every sample a centre, or fewer centres than samples.
//!
//! A fit of fewer centres is a least-squares fit: `min Σ_i |y_i - f(x_i)|² + λ n (|c|² + |b|²)`.

use super::leave_one_out::{LeaveOneOut, Variance};
use super::matrix::{greedy, matrix, some_rows};
use super::options::Options;
use super::polynomial::{Polynomial, RANK_F64, Space};
use super::refusal::Refusal;
use super::samples::Samples;
use super::system::{Solved, norm_l1, reciprocal_condition, solve};
use crate::Error;
use crate::scattered::sum::KernelSum;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::{Mat, Par};

/// Least reciprocal condition of a solved system. Below it, f64 has no correct digit left.
pub const RCOND: f64 = 1e-14;
/// Largest residual of the equations, over the values' range: METHOD §2.7 promises this of samples.
pub const MISSED: f64 = 1e-10;

/// Fit of samples.
pub struct Fit {
    /// Fitted function.
    pub sum: KernelSum,
    /// Degree of the polynomials.
    pub degree: Option<usize>,
    /// Rank of the polynomials, r.
    pub rank: usize,
    /// Residuals of the values, n x m.
    pub residuals: Mat<f64>,
    /// Reciprocal condition of the system, or of the triangular factor of least squares, in the 1-norm.
    pub rcond: f64,
    factors: Factors,
}

/// Factors of a solution.
enum Factors {
    /// Every sample is a centre: the system, and the smoothing λ of each sample, n.
    Every(Box<Solved>, Vec<f64>),
    /// k centres by least squares: factor h of the hat matrix `h hᵀ`, n x (k + r).
    Fewer(Mat<f64>),
}

impl Fit {
    /// Fits samples.
    ///
    /// Fewer centres are samples that the power function chooses. Without smoothing they are at most as many as the
    /// samples can determine besides the polynomials.
    ///
    /// # Errors
    /// Errors of [`Options::check`]; if rounding errors would determine the function.
    pub fn new(samples: &Samples, options: &Options) -> Result<Self, Error> {
        options.check()?;
        let scaling = &samples.scaling;
        let points = scaling.apply(&samples.sites) * faer::Scale(options.epsilon);
        let inputs = scaling.kept();
        let space = Space { points: &points, inputs: &inputs, tolerance: RANK_F64 };
        let polynomial = space.determined(options.degree);
        let prepared = Prepared { samples, options, points, polynomial };
        Ok(match options.centres {
            Some(most) if most < samples.sample_len() => prepared.fewer(most)?,
            _ => prepared.every()?,
        })
    }

    /// Predicts samples by the fit without them. Fewer centres stay the same.
    pub fn leave_one_out(&self) -> LeaveOneOut {
        match &self.factors {
            Factors::Every(solved, smoothing) => LeaveOneOut::of_solved(solved, smoothing),
            Factors::Fewer(hat) => LeaveOneOut::of_hat(hat.clone(), self.residuals.clone()),
        }
    }

    /// Computes the variance of a fit to values (n x m); `None` if the system is indefinite, or with fewer centres.
    pub fn variance(&self, values: &Mat<f64>) -> Option<Variance> {
        match &self.factors {
            Factors::Every(solved, _) => Variance::new(solved, values),
            Factors::Fewer(_) => None,
        }
    }
}

/// Points and polynomials of a fit.
struct Prepared<'a> {
    samples: &'a Samples,
    options: &'a Options,
    /// Scaled samples, n x d.
    points: Mat<f64>,
    /// Polynomials at the points.
    polynomial: Polynomial,
}

impl Prepared<'_> {
    /// Fits with every sample a centre.
    fn every(&self) -> Result<Fit, Refusal> {
        let Self { samples, options, points, polynomial } = self;
        let smoothing: Vec<f64> =
            samples.smoothing.iter().map(|own| options.smoothing + own).collect();
        let solved = solve(options.kernel, points, &smoothing, polynomial.clone(), &samples.values);
        let (rcond, missed) = (solved.system.rcond(), solved.missed);
        if rcond < RCOND || missed > MISSED {
            return Err(Refusal::IllConditioned { rcond, missed });
        }
        Ok(Fit {
            sum: self.sum(points, &solved.kernels, &solved.monomials),
            degree: polynomial.degree,
            rank: polynomial.rank(),
            residuals: solved.residuals.clone(),
            rcond,
            factors: Factors::Every(Box::new(solved), smoothing),
        })
    }

    /// Fits at most `most` centres; b are coefficients on the orthonormal basis of the polynomials.
    fn fewer(&self, most: usize) -> Result<Fit, Refusal> {
        let Self { samples, options, points, polynomial } = self;
        let n = samples.sample_len();
        let free = if options.smoothing > 0.0 { n } else { n - polynomial.rank() };
        let centres = greedy(options.kernel, points, &polynomial.values, free.min(most));
        let at = some_rows(points, &centres);
        let columns = faer::concat![[matrix(options.kernel, points, &at), &polynomial.values]];
        let unknowns = columns.ncols();
        let ridge = Mat::<f64>::identity(unknowns, unknowns)
            * faer::Scale((options.smoothing * n as f64).sqrt());
        let decomposed = faer::concat![[&columns], [&ridge]].qr();
        let r = decomposed.thin_R();
        let up = |mut x: Mat<f64>| {
            solve_upper_triangular_in_place(r, x.as_mut(), Par::Seq);
            x
        };
        let down = |mut x: Mat<f64>| {
            solve_lower_triangular_in_place(r.transpose(), x.as_mut(), Par::Seq);
            x
        };
        let rcond = reciprocal_condition(norm_l1(r), unknowns, up, down);
        if rcond < RCOND {
            return Err(Refusal::IllConditioned { rcond, missed: 0.0 });
        }
        let hat = decomposed.compute_thin_Q().subrows(0, n).to_owned();
        let solution = up(hat.transpose() * &samples.values);
        let (kernels, basis) = solution.split_at_row(centres.len());
        let monomials = &polynomial.basis * basis;
        Ok(Fit {
            sum: self.sum(&at, &kernels.to_owned(), &monomials),
            degree: polynomial.degree,
            rank: polynomial.rank(),
            residuals: &samples.values - &columns * &solution,
            rcond,
            factors: Factors::Fewer(hat),
        })
    }

    /// Makes the function.
    ///
    /// - `centres`: k x d.
    /// - `kernels`: coefficients of the kernels, k x m.
    /// - `monomials`: coefficients of the monomials, T x m.
    fn sum(&self, centres: &Mat<f64>, kernels: &Mat<f64>, monomials: &Mat<f64>) -> KernelSum {
        let (scaling, epsilon) = (&self.samples.scaling, self.options.epsilon);
        KernelSum {
            kernel: self.options.kernel,
            shift: scaling.shift.clone(),
            scale: scaling.scale.iter().map(|scale| scale * epsilon).collect(),
            metric: None,
            centres: centres.transpose().to_owned(),
            terms: self.polynomial.terms.clone(),
            coefficients: faer::concat![[kernels.transpose(), monomials.transpose()]],
        }
    }
}
