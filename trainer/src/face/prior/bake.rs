//! A prior as a part of a file: its sections, as FORMAT.md has them.

use super::model::PriorModel;
use crate::bake::sections::{check_len, check_shape, floats, names, narrow, words};
use crate::bake::{BakeError, Part, Sections};
use sinew_runtime::format::{Element, PartKind, SectionKind};
use sinew_runtime::prior::PriorCounts;

impl PriorModel {
    /// Writes the part.
    ///
    /// - `skin`: the place of its skin among the parts of the file.
    ///
    /// # Errors
    /// - [`BakeError::Length`]: arrays do not fit each other.
    /// - [`BakeError::Size`]: an index or a size does not fit the file.
    /// - [`BakeError::Covariance`]: the covariance has no inverse.
    pub fn part(&self, skin: usize) -> Result<Part, BakeError> {
        let n = self.shape_len();
        check_shape(
            ["rows of the covariance", "columns of the covariance"],
            [n, n],
            &self.covariance,
        )?;
        check_len("bounds of weights", n, self.bounds.len())?;
        let factor = self.factor().ok_or(BakeError::Covariance)?;
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

/// Writes a pair of shapes.
fn shapes(pair: [usize; 2]) -> Result<Vec<u8>, BakeError> {
    let mut out = Vec::new();
    for shape in pair {
        out.extend(narrow::<u16>("shapes", shape)?.to_le_bytes());
    }
    Ok(out)
}
