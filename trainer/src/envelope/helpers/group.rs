//! A group of proxies that share a kernel map.

use super::super::motion::Poses;
use super::features::{Input, Joints};
use crate::kernel::map::{KernelMap, Value};
use faer::Mat;
use nalgebra::{Matrix3, Matrix3x4};
use std::ops::Range;

/// A group's kernel map.
pub struct Group {
    /// The dominant joint that the proxies share.
    pub joint: usize,
    /// The proxies.
    pub proxies: Range<usize>,
    /// What the map listens to.
    pub inputs: Vec<Input>,
    /// The map to r latent outputs.
    pub map: KernelMap,
    /// Entries of the proxies' maps from the latent outputs, 12p x r, row 12 l + 4 r + c.
    pub outputs: Mat<f64>,
}

/// Predicts the correction of n poses, 3n x 4P.
pub fn predict(groups: &[Group], poses: &Poses, joints: Joints<'_>) -> Mat<f64> {
    let count = groups.iter().map(|group| group.proxies.len()).sum::<usize>();
    let mut out = Mat::zeros(3 * poses.len(), 4 * count);
    for group in groups {
        let inputs = joints.evaluate(poses, &group.inputs);
        for pose in 0..poses.len() {
            let Value { outputs, confidence } = group.map.evaluate(inputs.col_as_slice(pose));
            let latents: Vec<f64> = outputs.iter().map(|z| confidence * z).collect();
            group.add(&latents, poses, pose, &mut out);
        }
    }
    out
}

impl Group {
    /// Adds `Q_dom K` of latent outputs to a pose's row of maps.
    pub(super) fn add(&self, latents: &[f64], poses: &Poses, pose: usize, out: &mut Mat<f64>) {
        let turn: Matrix3<f64> = poses.map(pose, self.joint).fixed_columns::<3>(0).into();
        for (k, proxy) in self.proxies.clone().enumerate() {
            let local = Matrix3x4::from_fn(|r, c| {
                let row = self.outputs.row(12 * k + 4 * r + c);
                row.iter().zip(latents).map(|(a, z)| a * z).sum::<f64>()
            });
            let added = turn * local;
            for c in 0..4 {
                for r in 0..3 {
                    out[(3 * pose + r, 4 * proxy + c)] += added[(r, c)];
                }
            }
        }
    }
}
