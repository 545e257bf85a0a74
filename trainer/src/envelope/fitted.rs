//! A fitted envelope of any predictor, and its palette in f64.

use super::blend::Weights;
use super::helpers::group::{Group, predict};
use super::motion::Poses;
use super::rotational::predictor::{GradientPredictor, predict_stacked};
use super::rotational::reduce::Reduced;
use super::training::Training;
use faer::Mat;
use sinew_runtime::envelope::Predictor;

/// A fitted envelope, in training units.
pub struct Fitted {
    /// The vertices' weights on the palette.
    pub weights: Weights,
    /// What moves the proxies before any correction.
    pub base: Base,
    /// The correction.
    pub groups: Vec<Group>,
}

/// What moves the proxies before any correction.
pub enum Base {
    /// `c1 d + c2 q` of key gradients.
    Reconstruction(Vec<GradientPredictor>, Reduced),
    /// The dominant joint of each helper; the palette holds the joints too.
    Joints(Vec<usize>),
}

impl Fitted {
    /// The kind of predictor.
    pub fn predictor(&self) -> Predictor {
        match self.base {
            Base::Joints(_) => Predictor::Kernel,
            Base::Reconstruction(..) if self.groups.is_empty() => Predictor::Rotational,
            Base::Reconstruction(..) => Predictor::Hybrid,
        }
    }

    /// Returns P.
    pub fn proxies(&self) -> usize {
        match &self.base {
            Base::Joints(dominant) => dominant.len(),
            Base::Reconstruction(keys, _) => keys.len(),
        }
    }

    /// The palette of n poses, 3n x 4 a map.
    pub fn palette(&self, training: &Training, poses: &Poses) -> Mat<f64> {
        let base = match &self.base {
            Base::Joints(dominant) => {
                let joints = poses.stacked();
                let helpers = super::helpers::stacked::bases(&joints, dominant);
                faer::concat![[joints, helpers]]
            }
            Base::Reconstruction(keys, reduced) => {
                reduced.palette(&predict_stacked(keys, poses), poses)
            }
        };
        corrected(base, &predict(&self.groups, poses, training.joints()))
    }
}

/// Adds a correction to the proxies, which stand last in a palette.
pub(super) fn corrected(mut palette: Mat<f64>, correction: &Mat<f64>) -> Mat<f64> {
    let first = palette.ncols() - correction.ncols();
    let mut proxies = palette.subcols_mut(first, correction.ncols());
    proxies += correction;
    palette
}
