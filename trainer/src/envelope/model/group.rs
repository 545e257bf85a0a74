//! A group of proxies that share a dominant joint and a kernel map (METHOD §1.9).

use crate::regression::map::KernelMap;
use faer::Mat;
use nalgebra::Matrix3x4;
use serde::Serialize;
use std::ops::Range;

/// Adds `Q_dom K` to its proxies, `K = outputs z`, z the values of its kernel map.
#[derive(Clone, Debug)]
pub struct Group {
    /// The dominant joint.
    pub joint: usize,
    /// The proxies, of 0..P; those of one group follow those of the group before.
    pub proxies: Range<usize>,
    /// What the map listens to, d.
    pub inputs: Vec<Input>,
    /// From d inputs to r latent values.
    pub map: KernelMap,
    /// From the latent values to the proxies' maps, 12p x r: row 12 l + 4 r + c is entry r, c.
    pub outputs: Mat<f64>,
}

/// One weighted feature.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Input {
    /// 12 j + 4 r + c: entry r, c of joint j's `[half of its turn | displacement]`.
    pub feature: usize,
    /// What it is multiplied by.
    pub weight: f64,
}

impl Group {
    /// Makes a group that adds nothing.
    pub fn nothing(joint: usize, proxies: Range<usize>) -> Self {
        let outputs = Mat::zeros(12 * proxies.len(), 0);
        Self { joint, proxies, inputs: Vec::new(), map: KernelMap::nothing(), outputs }
    }

    /// Whether it adds anything.
    pub fn has_centres(&self) -> bool {
        self.map.centres.ncols() > 0
    }

    /// Picks and weights the inputs of J matrices of features.
    pub fn input(&self, features: &[Matrix3x4<f64>]) -> Vec<f64> {
        let value = |&Input { feature, weight }: &Input| {
            weight * features[feature / 12][(feature / 4 % 3, feature % 4)]
        };
        self.inputs.iter().map(value).collect()
    }

    /// Multiplies latent values into K of each proxy.
    pub fn maps(&self, latents: &[f64]) -> impl Iterator<Item = Matrix3x4<f64>> {
        (0..self.proxies.len()).map(move |l| {
            Matrix3x4::from_fn(|r, c| {
                let row = self.outputs.row(12 * l + 4 * r + c);
                row.iter().zip(latents).map(|(a, z)| a * z).sum()
            })
        })
    }
}

impl Input {
    /// Whether it is a coordinate of a displacement.
    pub fn is_displacement(&self) -> bool {
        self.feature % 4 == 3
    }
}
