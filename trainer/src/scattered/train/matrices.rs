//! A problem's rows as matrices.

use super::error::TrainError;
use crate::scattered::model::{Output, OutputKind, features};
use crate::scattered::problem::Problem;
use faer::Mat;

/// Samples, as fits take them.
pub(super) struct Matrices {
    /// Features of the sites, n x d.
    pub(super) features: Mat<f64>,
    /// Values of the function, n x m.
    pub(super) values: Mat<f64>,
}

impl Matrices {
    /// Takes a problem's rows; `outputs` learn what they are at the neutral sample.
    ///
    /// # Errors
    /// [`TrainError::Site`], [`TrainError::Neutral`] and [`TrainError::Value`].
    pub(super) fn new(problem: &Problem, outputs: &mut [Output]) -> Result<Self, TrainError> {
        let site = |(row, site): (usize, &Vec<f64>)| {
            features(&problem.inputs, site)
                .map_err(|error| TrainError::Site { place: problem.place(row, "sites"), error })
        };
        let sites = problem.sites.iter().enumerate().map(site).collect::<Result<Vec<_>, _>>()?;
        let (row, samples) = (problem.options.neutral, problem.values.len());
        let neutral = problem.values.get(row).ok_or(TrainError::Neutral { row, samples })?;
        let mut rest = neutral.as_slice();
        for Output { kind, name } in outputs.iter_mut() {
            let own;
            (own, rest) = rest.split_at(kind.number_len());
            match (kind, own) {
                (OutputKind::Scalar { neutral, .. }, &[x]) => *neutral = x,
                (OutputKind::Vector3 { neutral }, &[x, y, z]) => *neutral = [x, y, z],
                (OutputKind::Rotation { neutral }, &[x, y, z, w]) => {
                    let length = (x * x + y * y + z * z + w * w).sqrt();
                    // What is no rotation is refused with its value.
                    *neutral = [x, y, z, w].map(|part| part / length);
                    if !length.is_normal() {
                        let error = crate::regression::rotations::RotationError::Zero;
                        let place = problem.place(row, "values");
                        return Err(TrainError::Value { place, output: name.clone(), error });
                    }
                }
                _ => {}
            }
        }
        let mut values = Vec::with_capacity(samples);
        for (row, numbers) in problem.values.iter().enumerate() {
            let (mut rest, mut out) = (numbers.as_slice(), Vec::new());
            for Output { kind, name } in outputs.iter() {
                let own;
                (own, rest) = rest.split_at(kind.number_len());
                let place = || problem.place(row, "values");
                let wrong =
                    |error| TrainError::Value { place: place(), output: name.clone(), error };
                out.extend(kind.to_values(own).map_err(wrong)?);
            }
            values.push(out);
        }
        Ok(Self { features: matrix(&sites), values: matrix(&values) })
    }
}

fn matrix(rows: &[Vec<f64>]) -> Mat<f64> {
    Mat::from_fn(rows.len(), rows.first().map_or(0, Vec::len), |i, c| rows[i][c])
}
