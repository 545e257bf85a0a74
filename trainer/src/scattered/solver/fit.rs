//! Fits of scattered data (METHOD §2.2): every sample a centre, or fewer centres than samples.
//!
//! A fit of fewer centres is a least-squares fit: `min Σ_i |y_i - f(x_i)|² + λ n (|c|² + |b|²)`.

use super::leave_one_out::LeaveOneOut;
use super::matrix::{greedy, matrix};
use super::options::Options;
use super::polynomial::{Polynomial, Space};
use super::refusal::IllConditioned;
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

/// Fit with every sample a centre.
pub struct Fit {
    /// Fitted function.
    pub sum: KernelSum,
    /// Solution of the system.
    pub solved: Solved,
    /// Smoothing λ of each sample, n.
    pub smoothing: Vec<f64>,
}

impl Fit {
    /// Fits samples.
    ///
    /// # Errors
    /// Errors of [`Options::check`]; if rounding errors would determine the function.
    pub fn new(samples: &Samples, options: &Options) -> Result<Self, Error> {
        options.check()?;
        Ok(Self::checked(samples, options)?)
    }

    /// Fits samples with options that are checked.
    fn checked(samples: &Samples, options: &Options) -> Result<Self, IllConditioned> {
        let prepared = Prepared::new(samples, options);
        let smoothing: Vec<f64> =
            samples.smoothing.iter().map(|own| options.smoothing + own).collect();
        let Prepared { points, polynomial, .. } = &prepared;
        let solved = solve(options.kernel, points, &smoothing, polynomial.clone(), &samples.values);
        let (rcond, missed) = (solved.system.rcond(), solved.missed);
        if rcond < RCOND || missed > MISSED {
            return Err(IllConditioned { rcond, missed });
        }
        let sum = prepared.sum(points, &solved.kernels, &solved.monomials);
        Ok(Self { sum, solved, smoothing })
    }

    /// Predicts samples by the fit without them.
    pub fn leave_one_out(&self) -> LeaveOneOut {
        LeaveOneOut::of_solved(&self.solved, &self.smoothing)
    }
}

/// Choice of centres.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Centres {
    /// At most this number of samples, by the power function.
    Greedy(usize),
    /// Indices of samples.
    Given(Vec<usize>),
}

/// Fit of fewer centres than samples.
pub struct FewerFit {
    /// Fitted function.
    pub sum: KernelSum,
    /// Indices of the samples that are centres, k.
    pub centres: Vec<usize>,
    /// Rank of the polynomials, r.
    pub rank: usize,
    /// Degree of the polynomials.
    pub degree: Option<usize>,
    /// Residuals of the values, n x m.
    pub residuals: Mat<f64>,
    /// Reciprocal condition of the triangular factor, in the 1-norm.
    pub rcond: f64,
    /// Factor h of the hat matrix `h hᵀ`, n x (k + r).
    hat: Mat<f64>,
}

impl FewerFit {
    /// Fits samples; b are coefficients on the orthonormal basis of the polynomials.
    ///
    /// Without smoothing, the power function chooses at most as many centres as the samples can determine besides the
    /// polynomials.
    ///
    /// # Errors
    /// - Errors of [`Options::check`].
    /// - If a given centre is not a sample or occurs twice.
    /// - If samples and smoothing do not determine the given centres and polynomials.
    pub fn new(samples: &Samples, options: &Options, centres: &Centres) -> Result<Self, Error> {
        options.check()?;
        if let Centres::Given(centres) = centres {
            check_centres(centres, samples.sample_len())?;
        }
        Ok(Self::checked(samples, options, centres)?)
    }

    /// Fits samples with options and centres that are checked.
    fn checked(
        samples: &Samples,
        options: &Options,
        centres: &Centres,
    ) -> Result<Self, IllConditioned> {
        let n = samples.sample_len();
        let prepared = Prepared::new(samples, options);
        let Prepared { points, polynomial, .. } = &prepared;
        let centres = match centres {
            Centres::Greedy(most) => {
                let free = if options.smoothing > 0.0 { n } else { n - polynomial.rank() };
                greedy(options.kernel, points, &polynomial.values, free.min(*most))
            }
            Centres::Given(centres) => centres.clone(),
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
        let rcond = reciprocal_condition(norm_l1(r), unknowns, up, down);
        if rcond < RCOND {
            return Err(IllConditioned { rcond, missed: 0.0 });
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

    /// Predicts samples by the fit with the same centres and without the samples' values.
    pub fn leave_one_out(&self) -> LeaveOneOut {
        LeaveOneOut::of_hat(self.hat.clone(), self.residuals.clone())
    }
}

/// Checks that centres are different samples.
fn check_centres(centres: &[usize], samples: usize) -> Result<(), Error> {
    let mut taken = vec![false; samples];
    for &centre in centres {
        match taken.get_mut(centre) {
            Some(taken) if !*taken => *taken = true,
            _ => {
                return Err(Error::value(format!(
                    "centre {centre} is not one of {samples} samples, or is given twice"
                )));
            }
        }
    }
    Ok(())
}

/// Fit of either kind.
pub enum AnyFit {
    /// Every sample is a centre.
    Every(Box<Fit>),
    /// Fewer centres, by least squares.
    Fewer(Box<FewerFit>),
}

impl AnyFit {
    /// Fits samples.
    ///
    /// # Errors
    /// Errors of [`Fit::new`] or [`FewerFit::new`].
    pub fn new(samples: &Samples, options: &Options) -> Result<Self, Error> {
        options.check()?;
        Ok(Self::checked(samples, options)?)
    }

    /// Fits samples with options that are checked.
    pub(crate) fn checked(samples: &Samples, options: &Options) -> Result<Self, IllConditioned> {
        Ok(match options.centres {
            Some(most) if most < samples.sample_len() => {
                Self::Fewer(Box::new(FewerFit::checked(samples, options, &Centres::Greedy(most))?))
            }
            _ => Self::Every(Box::new(Fit::checked(samples, options)?)),
        })
    }

    /// Returns the function.
    pub fn sum(&self) -> &KernelSum {
        match self {
            Self::Every(fit) => &fit.sum,
            Self::Fewer(fit) => &fit.sum,
        }
    }

    /// Predicts samples by the fit without them.
    pub fn leave_one_out(&self) -> LeaveOneOut {
        match self {
            Self::Every(fit) => fit.leave_one_out(),
            Self::Fewer(fit) => fit.leave_one_out(),
        }
    }
}

/// Points and polynomials of a fit.
struct Prepared {
    /// Scaled samples, n x d.
    points: Mat<f64>,
    /// Polynomials at the points.
    polynomial: Polynomial,
    /// Function without centres and coefficients.
    empty: KernelSum,
}

impl Prepared {
    fn new(samples: &Samples, options: &Options) -> Self {
        let scaling = &samples.scaling;
        let points = scaling.apply(&samples.sites) * faer::Scale(options.epsilon);
        let inputs = scaling.kept();
        let space = Space { points: &points, inputs: &inputs, tolerance: options.rank };
        let polynomial = space.determined(options.degree);
        let empty = KernelSum {
            kernel: options.kernel,
            shift: scaling.shift.clone(),
            scale: scaling.scale.iter().map(|scale| scale * options.epsilon).collect(),
            metric: None,
            centres: Mat::new(),
            terms: polynomial.terms.clone(),
            coefficients: Mat::new(),
        };
        Self { points, polynomial, empty }
    }

    /// Makes the function.
    ///
    /// - `centres`: k x d.
    /// - `kernels`: coefficients of the kernels, k x m.
    /// - `monomials`: coefficients of the monomials, T x m.
    fn sum(&self, centres: &Mat<f64>, kernels: &Mat<f64>, monomials: &Mat<f64>) -> KernelSum {
        KernelSum {
            centres: centres.transpose().to_owned(),
            coefficients: faer::concat![[kernels.transpose(), monomials.transpose()]],
            ..self.empty.clone()
        }
    }
}
