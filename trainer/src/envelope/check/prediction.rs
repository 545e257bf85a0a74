//! How well the training poses predict each other: kernel ridge regression of what LBS leaves, each
//! joint's skin from the joints near it (METHOD §1.9).

use super::context::Context;
use crate::envelope::correction::features::Features;
use crate::envelope::skin::folds::folds;
use crate::envelope::skin::poses::Time;
use crate::examples::spread;
use crate::kernel::gram::{GramRegression, SampleErrors};
use crate::kernel::inputs::Inputs;
use crate::kernel::outputs::Block;
use faer::Mat;
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

/// Most poses that are compared: the work grows with their cube.
const POSES: usize = 300;
/// Poses on which width and ridge are chosen.
const TRIED: usize = 100;
/// Vertices that are looked at; more tell no more of the poses.
const VERTICES: usize = 4000;
/// Hops of the joints that a joint's skin listens to, as the kernel maps choose most often.
pub(super) const HOPS: usize = 2;

/// What LBS leaves of one joint's skin, as a function of the poses.
pub(super) struct Region {
    pub(super) joint: usize,
    /// What it leaves in the compared poses, predicted from each other.
    pub(super) regression: GramRegression,
}

/// Chooses the training poses that are compared, by their number among the training frames.
pub(super) fn compared(context: &Context<'_>) -> Vec<usize> {
    spread(context.frames.len(), POSES)
}

/// Makes the regions of all joints with skin that moves.
pub(super) fn regions(context: &Context<'_>, poses: &[usize]) -> Vec<Region> {
    let stride = context.dominant.len().div_ceil(VERTICES);
    let skins = context.skins();
    let own = |joint: usize| {
        let skin: Vec<usize> = skins[joint].iter().copied().step_by(stride).collect();
        Region::new(context, joint, &skin, poses)
    };
    (0..skins.len()).into_par_iter().filter_map(own).collect()
}

impl Region {
    fn new(context: &Context<'_>, joint: usize, skin: &[usize], poses: &[usize]) -> Option<Self> {
        let (training, features) = (&context.training, Features::of(&context.training));
        let inputs = features.inputs(&training.poses, joint, HOPS);
        let all = features.evaluate(&training.poses, &inputs);
        let inputs = Mat::from_fn(all.nrows(), poses.len(), |r, i| all[(r, poses[i])]);
        let inputs = Inputs::new(inputs)?;
        let gram = gram(context, joint, skin, poses);
        let some = spread(poses.len(), TRIED);
        let tried: Vec<usize> = some.iter().map(|&place| poses[place]).collect();
        let blocks = blocks(context, &tried);
        let regression = GramRegression::choose(&inputs, gram, &some, &blocks)?;
        Some(Self { joint, regression })
    }

    /// Predicts every compared pose by the others.
    pub(super) fn errors(&self, context: &Context<'_>, poses: &[usize]) -> Option<SampleErrors> {
        self.regression.errors(&blocks(context, poses))
    }
}

/// Folds of some of the training poses.
fn blocks(context: &Context<'_>, poses: &[usize]) -> Vec<Block> {
    let times = context.training.poses.times();
    let times: Vec<Time> = poses.iter().map(|&pose| times[pose]).collect();
    folds(&times).into_iter().map(Block::from).collect()
}

/// Inner products of what LBS leaves, in the joint's own frame.
fn gram(context: &Context<'_>, joint: usize, skin: &[usize], poses: &[usize]) -> Mat<f64> {
    let mut left = Mat::zeros(3 * skin.len(), poses.len());
    for (i, &pose) in poses.iter().enumerate() {
        let turn: Matrix3<f64> =
            context.training.poses.map(pose, joint).fixed_columns::<3>(0).transpose();
        for (k, &vertex) in skin.iter().enumerate() {
            let column = context.residuals.col_as_slice(vertex);
            let own = turn * Vector3::from_column_slice(&column[3 * pose..3 * pose + 3]);
            (0..3).for_each(|axis| left[(3 * k + axis, i)] = own[axis]);
        }
    }
    left.transpose() * &left
}
