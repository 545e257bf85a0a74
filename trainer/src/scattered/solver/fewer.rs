//! A function of fewer centres than samples, by least squares (METHOD §2.2):
//! `min Σ_i |y_i - f(x_i)|² + λ n (|c|² + |b|²)`.

use super::condition;
use super::error::KernelError;
use super::fit::RCOND;
use super::leave_one_out::LeaveOneOut;
use super::matrix::matrix;
use super::options::Options;
use super::power::greedy;
use super::prepared::Prepared;
use super::samples::Samples;
use crate::scattered::sum::KernelSum;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::{Mat, Par};

/// Which samples are centres.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Centres {
    /// At most so many, by the power function.
    Greedy(usize),
    /// These.
    Given(Vec<usize>),
}

/// A function of fewer centres, and what it was fitted with.
pub struct FewerFit {
    /// The function.
    pub sum: KernelSum,
    /// The samples that are centres, k.
    pub centres: Vec<usize>,
    /// Rank of the polynomials, r.
    pub rank: usize,
    /// Their degree.
    pub degree: Option<usize>,
    /// What the function leaves of the values, n x m.
    pub residuals: Mat<f64>,
    /// Reciprocal condition of the triangular factor, in the 1-norm.
    pub rcond: f64,
    /// h of the hat matrix `h hᵀ`, n x (k + r).
    hat: Mat<f64>,
}

impl FewerFit {
    /// Fits samples; b are coefficients on the orthonormal basis of the polynomials. Without smoothing the
    /// power function chooses no more centres than samples determine beside the polynomials.
    ///
    /// # Errors
    /// Those of [`Options::check`]; if a given centre is not a sample or stands twice; if there are
    /// more given centres and polynomials than samples and smoothing determine.
    pub fn new(
        samples: &Samples,
        options: &Options,
        centres: &Centres,
    ) -> Result<Self, KernelError> {
        options.check()?;
        let n = samples.sample_len();
        let prepared = Prepared::new(samples, options);
        let Prepared { points, polynomial, .. } = &prepared;
        let centres = match centres {
            Centres::Greedy(most) => {
                let free = if options.smoothing > 0.0 { n } else { n - polynomial.rank() };
                greedy(options.kernel, points, &polynomial.values, free.min(*most))
            }
            Centres::Given(centres) => {
                distinct(centres, n)?;
                centres.clone()
            }
        };
        let at = Mat::from_fn(centres.len(), points.ncols(), |k, c| points[(centres[k], c)]);
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
        let rcond = condition::reciprocal(condition::norm(r), unknowns, up, down);
        if rcond < RCOND {
            return Err(KernelError::IllConditioned { rcond, missed: 0.0 });
        }
        let hat = decomposed.compute_thin_Q().subrows(0, n).to_owned();
        let solution = up(hat.transpose() * &samples.values);
        let residuals = &samples.values - &columns * &solution;
        let (kernels, basis) = solution.split_at_row(centres.len());
        let monomials = &polynomial.basis * basis;
        let sum = prepared.sum(&at, &kernels.to_owned(), &monomials);
        let (rank, degree) = (polynomial.rank(), polynomial.degree);
        Ok(Self { sum, centres, rank, degree, residuals, rcond, hat })
    }

    /// Predicts samples by the fit with the same centres and without their values.
    pub fn leave_one_out(&self) -> LeaveOneOut {
        LeaveOneOut::of_hat(self.hat.clone(), self.residuals.clone())
    }
}

/// Refuses centres that are not samples, or stand twice.
fn distinct(centres: &[usize], samples: usize) -> Result<(), KernelError> {
    let mut taken = vec![false; samples];
    for &centre in centres {
        match taken.get_mut(centre) {
            Some(taken) if !*taken => *taken = true,
            _ => return Err(KernelError::Centre { centre, samples }),
        }
    }
    Ok(())
}
