//! What the kernel maps add to the palette (METHOD §1.9).

use crate::kernel::map::{Fade, KernelMap};
use faer::Mat;
use nalgebra::{DMatrix, DVector, Matrix3x4};
use std::ops::Range;

/// Proxies that share a dominant joint and a kernel map.
pub struct Group {
    /// The dominant joint.
    pub joint: usize,
    /// The proxies, of 0..P.
    pub proxies: Range<usize>,
    /// Feature, 12 j + 4 r + c, and weight of each input, d.
    pub inputs: Vec<(usize, f64)>,
    /// From d inputs to r latent values. Its values at rest are its own, not the file's.
    pub map: KernelMap,
    /// From the latent values to the proxies' maps, 12p x r: row 12 l + 4 r + c is entry r, c.
    pub outputs: DMatrix<f64>,
}

impl Group {
    /// Widens a group's arrays.
    pub(super) fn new(group: &sinew_runtime::envelope::Group<'_>) -> Self {
        let (d, n, r) = (group.input_len(), group.centre_len(), group.rank());
        let widened = |value: Option<f32>| value.map_or(f64::NAN, f64::from);
        let input = |(feature, weight): (usize, f32)| (feature, f64::from(weight));
        Self {
            joint: group.joint,
            proxies: group.proxies.clone(),
            inputs: (0..d).filter_map(|i| group.input(i)).map(input).collect(),
            map: KernelMap {
                kernel: group.kernel,
                centres: Mat::from_fn(d, n, |i, k| widened(group.centre(k, i))),
                coefficients: Mat::from_fn(r, n + d, |r, c| widened(group.coefficient(r, c))),
                fade: Fade { start: group.fade.0.into(), end: group.fade.1.into() },
            },
            outputs: DMatrix::from_fn(12 * group.proxies.len(), r, |row, c| {
                widened(group.output(row, c))
            }),
        }
    }

    /// Whether it adds anything.
    pub fn has_centres(&self) -> bool {
        self.map.centres.ncols() > 0
    }

    /// Picks and weights the inputs of J matrices of features.
    pub fn input(&self, features: &[Matrix3x4<f64>]) -> Vec<f64> {
        let value = |&(feature, weight): &(usize, f64)| {
            weight * features[feature / 12][(feature / 4 % 3, feature % 4)]
        };
        self.inputs.iter().map(value).collect()
    }

    /// Cuts 12 values a proxy into maps, row by row.
    pub fn maps(values: &DVector<f64>) -> impl Iterator<Item = Matrix3x4<f64>> {
        values.as_slice().chunks(12).map(Matrix3x4::from_row_slice)
    }
}
