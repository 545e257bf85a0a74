//! How well the training poses predict each other: kernel ridge regression of what LBS leaves, each
//! joint's skin from the joints near it (METHOD §1.9).

use crate::envelope::correction::features::{Features, near};
use crate::envelope::folds::Folds;
use crate::envelope::lbs::residuals::Residuals;
use crate::envelope::lbs::training::Training;
use crate::examples::spread;
use crate::regression::gram::{GramRegression, SampleErrors};
use crate::regression::inputs::Inputs;
use crate::regression::outputs::Block;
use faer::Mat;
use rayon::prelude::*;

/// Most poses that are compared: the work grows with their cube.
pub(super) const POSES: usize = 300;
/// Poses on which width and ridge are chosen.
const TRIED: usize = 100;
/// Vertices that are looked at; more tell no more of the poses.
pub(super) const VERTICES: usize = 4000;
/// Hops of the joints that a joint's skin listens to, as the kernel maps choose most often.
pub const HOPS: usize = 2;

/// What LBS leaves of one joint's skin, as a function of the poses.
pub struct Region {
    /// The joint.
    pub joint: usize,
    /// How many vertices of its skin are looked at.
    pub vertex_len: usize,
    /// What it leaves in the compared poses, predicted from each other.
    pub regression: GramRegression,
}

/// Chooses those of n training poses that are compared.
pub fn compared(n: usize) -> Vec<usize> {
    spread(n, POSES)
}

/// Makes the regions of all joints with skin that moves.
pub fn regions(residuals: Residuals<'_>, poses: &[usize]) -> Vec<Region> {
    let stride = residuals.dominant.len().div_ceil(VERTICES);
    let skins = residuals.skins();
    let own = |joint: usize| {
        let skin: Vec<usize> = skins[joint].iter().copied().step_by(stride).collect();
        Region::new(residuals, joint, &skin, poses)
    };
    (0..skins.len()).into_par_iter().filter_map(own).collect()
}

impl Region {
    fn new(
        residuals: Residuals<'_>,
        joint: usize,
        skin: &[usize],
        poses: &[usize],
    ) -> Option<Self> {
        let (training, features) = (residuals.training, Features::of(residuals.training));
        let inputs = features.inputs(&training.poses, &near(features.parents, joint, HOPS));
        let all = features.evaluate(&training.poses, &inputs);
        let inputs = Mat::from_fn(all.nrows(), poses.len(), |r, i| all[(r, poses[i])]);
        let inputs = Inputs::new(inputs)?;
        let gram = residuals.gram(joint, skin, poses);
        let some = spread(poses.len(), TRIED);
        let tried: Vec<usize> = some.iter().map(|&place| poses[place]).collect();
        let blocks = blocks(training, &tried);
        let regression = GramRegression::choose(&inputs, gram, &some, &blocks)?;
        Some(Self { joint, vertex_len: skin.len(), regression })
    }

    /// Predicts every compared pose by the others.
    pub fn errors(&self, training: &Training, poses: &[usize]) -> Option<SampleErrors> {
        self.regression.errors(&blocks(training, poses))
    }
}

/// Folds of some of the training poses.
fn blocks(training: &Training, poses: &[usize]) -> Vec<Block> {
    Folds::new(&training.poses.only(poses)).runs().to_vec()
}
