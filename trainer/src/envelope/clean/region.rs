//! Predictions of training poses from each other: kernel ridge regression of the residuals of LBS. The inputs for a
//! joint's skin are the joints near this joint (METHOD §1.9).

use crate::envelope::correction::features::{Features, near};
use crate::envelope::folds::Folds;
use crate::envelope::lbs::training::Residuals;
use crate::envelope::lbs::training::Training;
use crate::examples::spread;
use crate::regression::gram::{GramRegression, SampleErrors};
use crate::regression::inputs::Inputs;
use crate::regression::outputs::Block;
use faer::Mat;
use rayon::prelude::*;

/// Largest number of poses that are compared: the work grows with its cube.
pub(super) const POSES: usize = 300;
/// Number of poses that choose width and ridge.
const TRIED: usize = 100;
/// Number of sampled vertices. More vertices add no information about the poses.
pub(super) const VERTICES: usize = 4000;
/// Hops from a joint to the input joints for its skin, the most frequent choice of kernel maps.
pub const HOPS: usize = 2;

/// Residuals of LBS on the skin of one joint, as a function of the pose.
pub struct Region {
    /// Joint that dominates the skin.
    pub joint: usize,
    /// Number of sampled vertices.
    pub vertex_len: usize,
    /// Regression of the residuals in the compared poses.
    pub regression: GramRegression,
}

/// Samples the compared poses from n training poses.
pub fn compared(n: usize) -> Vec<usize> {
    spread(n, POSES)
}

/// Creates the regions of all joints that have skin and inputs that move.
pub fn regions(residuals: Residuals<'_>, poses: &[usize]) -> Vec<Region> {
    let stride = residuals.dominant.len().div_ceil(VERTICES);
    let skins = residuals.skins();
    let training = residuals.training;
    let features = Features::of(training);
    let own = |joint: usize| {
        let skin: Vec<usize> = skins[joint].iter().copied().step_by(stride).collect();
        let joints = features.inputs(&training.poses, &near(features.parents, joint, HOPS));
        let inputs = [joints, features.curves(&training.poses)].concat();
        let all = features.evaluate(&training.poses, &inputs);
        let inputs = Mat::from_fn(all.nrows(), poses.len(), |r, i| all[(r, poses[i])]);
        let inputs = Inputs::new(inputs)?;
        let gram = residuals.gram(joint, &skin, poses);
        let some = spread(poses.len(), TRIED);
        let tried: Vec<usize> = some.iter().map(|&place| poses[place]).collect();
        let blocks = blocks(training, &tried);
        let regression = GramRegression::choose(&inputs, gram, &some, &blocks)?;
        Some(Region { joint, vertex_len: skin.len(), regression })
    };
    (0..skins.len()).into_par_iter().filter_map(own).collect()
}

impl Region {
    /// Predicts every compared pose from the others by cross-validation.
    pub fn errors(&self, training: &Training, poses: &[usize]) -> Option<SampleErrors> {
        self.regression.errors(&blocks(training, poses))
    }
}

/// Returns folds of some of the training poses.
fn blocks(training: &Training, poses: &[usize]) -> Vec<Block> {
    Folds::new(&training.poses.only(poses)).runs().to_vec()
}
