//! A prior over the weights of a skin's shapes, in f64, and its part in a file.

use super::key::wide;
use crate::Error;
use crate::bake::sections::{check_len, check_shape, floats, names, narrow, words};
use crate::bake::{Part, Sections};
use faer::linalg::solvers::DenseSolveCore;
use faer::{Mat, MatRef, Side};
use sinew_runtime::Prior;
use sinew_runtime::format::{Element, PartKind, SectionKind};
use sinew_runtime::prior::{PriorCounts, PriorFit};

/// Mean and covariance of the weights of a skin's S shapes, with bounds and pairs.
#[derive(Clone, Debug)]
pub struct PriorModel {
    /// Name of the part.
    pub name: String,
    /// Index of the skin in the [`FileModel`](super::FileModel).
    pub skin: usize,
    /// Mean weights, S.
    pub mean: Vec<f64>,
    /// Σ, S x S, including the floor of variances.
    pub covariance: Mat<f64>,
    /// Smallest and largest weight, S.
    pub bounds: Vec<[f64; 2]>,
    /// Pairs of mirrored shapes, and their stiffness: the reciprocal of a mean squared difference.
    pub symmetry: Vec<([usize; 2], f64)>,
    /// Pairs of mutually exclusive shapes.
    pub cancel: Vec<[usize; 2]>,
    /// Default stiffness of pins, and measured errors.
    pub fit: PriorFit,
}

impl PriorModel {
    /// Converts a loaded prior to f64.
    ///
    /// - `skin`: index of the skin in the [`FileModel`](super::FileModel).
    pub fn from_file(prior: &Prior<'_>, skin: usize) -> Self {
        let n = prior.shape_len();
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

    /// Returns the number of shapes, S.
    pub fn shape_len(&self) -> usize {
        self.mean.len()
    }

    /// Creates the prior part as FORMAT.md defines it.
    ///
    /// - `skin`: index of the skin among the file's parts.
    ///
    /// # Errors
    /// - Arrays differ in length.
    /// - An index or a size does not fit the file.
    /// - The covariance has no inverse.
    pub fn part(&self, skin: usize) -> Result<Part, Error> {
        let n = self.shape_len();
        check_shape(
            ["rows of the covariance", "columns of the covariance"],
            [n, n],
            &self.covariance,
        )?;
        check_len("bounds of weights", n, self.bounds.len())?;
        let no_inverse = || Error::value("the covariance of the weights has no inverse");
        let factor = factor(&self.covariance).ok_or_else(no_inverse)?;
        let rows: Vec<f64> =
            (0..n).flat_map(|i| (i..n).map(move |j| (i, j))).map(|at| factor[at]).collect();
        let counts = PriorCounts {
            skin: narrow("parts", skin)?,
            shape_len: narrow("shapes", n)?,
            symmetry_len: narrow("pairs that mirror", self.symmetry.len())?,
            cancel_len: narrow("pairs that cancel", self.cancel.len())?,
        };
        let mut symmetry = Vec::new();
        for (pair, stiffness) in &self.symmetry {
            symmetry.extend(shapes(*pair)?);
            symmetry.extend(floats(&[*stiffness]));
        }
        let mut cancel = Vec::new();
        for pair in &self.cancel {
            cancel.extend(shapes(*pair)?);
        }
        let sections: Sections = vec![
            (SectionKind::PriorCounts, true, words(&counts.words())),
            (SectionKind::Names, true, names([&self.name].into_iter())?),
            (SectionKind::PriorMean, true, floats(&self.mean)),
            (SectionKind::PriorFactor, true, floats(&rows)),
            (SectionKind::WeightBounds, true, floats(self.bounds.as_flattened())),
            (SectionKind::Symmetry, true, symmetry),
            (SectionKind::CancelPairs, true, cancel),
            (SectionKind::PriorFit, true, floats(&self.fit.figures().map(f64::from))),
        ];
        Ok(Part { kind: PartKind::Prior, sections, element: Element::F32 })
    }
}

/// Computes the upper triangle U with `Σ⁻¹ = Uᵀ U`; `None` if Σ is not positive definite.
fn factor(covariance: &Mat<f64>) -> Option<Mat<f64>> {
    let precision = covariance.llt(Side::Lower).ok()?.inverse();
    Some(precision.llt(Side::Lower).ok()?.L().transpose().to_owned())
}

/// Computes (Uᵀ U)⁻¹ for an upper triangle U.
fn inverse_of_square(factor: MatRef<'_, f64>) -> Mat<f64> {
    let square = factor.transpose() * factor;
    match square.llt(Side::Lower) {
        Ok(llt) => llt.inverse(),
        // Cannot happen for a loaded prior: loading checks the factor.
        Err(_) => Mat::full(factor.nrows(), factor.ncols(), f64::NAN),
    }
}

/// Encodes a pair of shape indices.
fn shapes(pair: [usize; 2]) -> Result<Vec<u8>, Error> {
    let mut out = Vec::new();
    for shape in pair {
        out.extend(narrow::<u16>("shapes", shape)?.to_le_bytes());
    }
    Ok(out)
}
