//! A prior in f64: what is learned, baked, and read back.

use faer::Side;
use faer::linalg::solvers::DenseSolveCore;
use faer::{Mat, MatRef};
use sinew_runtime::Prior;
use sinew_runtime::prior::PriorFit;

/// Mean and covariance of the weights of a skin's S shapes, and what else is known of them.
#[derive(Clone, Debug)]
pub struct PriorModel {
    /// Name of the part.
    pub name: String,
    /// Its skin's number in the file.
    pub skin: usize,
    /// Mean weights, S.
    pub mean: Vec<f64>,
    /// Σ, S x S, its floor included.
    pub covariance: Mat<f64>,
    /// Least and greatest weight, S.
    pub bounds: Vec<[f64; 2]>,
    /// Pairs of shapes that mirror each other, with their stiffness: the reciprocal of a mean square.
    pub symmetry: Vec<([usize; 2], f64)>,
    /// Pairs of shapes of which one alone is at work.
    pub cancel: Vec<[usize; 2]>,
    /// How stiff pins are by default, and what was measured.
    pub fit: PriorFit,
}

impl PriorModel {
    /// Widens what a file holds.
    ///
    /// - `skin`: the number of its skin among those of the file.
    pub fn from_file(prior: &Prior<'_>, skin: usize) -> Self {
        let n = prior.shape_len();
        let wide = |x: Option<f32>| x.map_or(f64::NAN, f64::from);
        let factor = Mat::from_fn(n, n, |i, j| wide(prior.factor_entry(i, j)));
        let bounds = (0..n).map(|s| prior.weight_bounds(s).unwrap_or([f32::NAN; 2]));
        Self {
            name: prior.name().to_owned(),
            skin,
            mean: (0..n).map(|shape| wide(prior.mean(shape))).collect(),
            covariance: inverse_of_square(factor.as_ref()),
            bounds: bounds.map(|bounds| bounds.map(f64::from)).collect(),
            symmetry: prior.symmetry().map(|(pair, x)| (pair, x.into())).collect(),
            cancel: prior.cancel_pairs().collect(),
            fit: prior.fit(),
        }
    }

    /// Counts the shapes.
    pub fn shape_len(&self) -> usize {
        self.mean.len()
    }

    /// Computes Σ⁻¹; `None` where Σ is not positive.
    pub fn precision(&self) -> Option<Mat<f64>> {
        Some(self.covariance.llt(Side::Lower).ok()?.inverse())
    }

    /// Computes the upper triangle U of `Σ⁻¹ = Uᵀ U`; `None` where Σ is not positive.
    pub fn factor(&self) -> Option<Mat<f64>> {
        let precision = self.precision()?;
        Some(precision.llt(Side::Lower).ok()?.L().transpose().to_owned())
    }
}

/// Computes (Uᵀ U)⁻¹ of an upper triangle.
fn inverse_of_square(factor: MatRef<'_, f64>) -> Mat<f64> {
    let square = factor.transpose() * factor;
    match square.llt(Side::Lower) {
        Ok(llt) => llt.inverse(),
        // A loaded prior has one.
        Err(_) => Mat::full(factor.nrows(), factor.ncols(), f64::NAN),
    }
}
