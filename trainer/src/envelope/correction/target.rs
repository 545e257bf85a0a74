//! What a correction is fitted to.

use super::features::Features;
use crate::envelope::folds::Folds;
use crate::envelope::lbs::poses::Poses;
use faer::Mat;

/// Most values of a map's certainty, where nothing else is said.
pub const CERTAINTY: usize = 16;

/// What a correction is fitted to: on n training poses, the part of P proxies' transforms that
/// joints do not predict.
#[derive(Clone, Copy)]
pub struct CorrectionTarget<'a> {
    /// n training poses.
    pub poses: &'a Poses,
    /// Which of them are left out together.
    pub folds: &'a Folds,
    /// The joints' rest geometry.
    pub features: Features<'a>,
    /// Dominant joint of each of the P proxies; those of one joint stand together.
    pub dominant: &'a [usize],
    /// Which of the lists that maps of its joint listen to each of the proxies takes; those of one stand together. Empty
    /// where joints have one.
    pub listens: &'a [usize],
    /// The transforms less those of the base, 3n x 4P.
    pub left_over: &'a Mat<f64>,
    /// Σ φ φᵀ over the vertices, 4P x 4P.
    pub gram: &'a Mat<f64>,
    /// Squared error of LBS that each of the proxies is to mend, P, summed over the poses.
    pub lbs_errors: &'a [f64],
    /// Most values of a map's certainty.
    pub certainty: usize,
    /// V.
    pub vertices: usize,
}

impl CorrectionTarget<'_> {
    /// The dominant joint of a proxy, and which of its lists it takes.
    pub fn place(&self, proxy: usize) -> (usize, usize) {
        (self.dominant[proxy], self.listens.get(proxy).copied().unwrap_or(0))
    }
}
