//! What a training tried and took.

use crate::envelope::clean::Doubted;
use crate::envelope::correction::candidates::GroupReport;
use crate::envelope::s3::{Method, RotationalReport};
use serde::Serialize;

/// What was tried and what was taken; errors are RMS, as shares of the rest diagonal.
#[derive(Clone, Debug, Serialize)]
pub struct TrainingReport {
    /// The training frames that were left out, the worst first.
    pub left_out: Vec<Doubted>,
    /// LBS on the training frames.
    pub lbs_rms: f64,
    /// LBS by the joint weights that come with the mesh, on the training frames; `None` where there are none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub own_weights_rms: Option<f64>,
    /// The folds, each as the numbers of its poses among the training frames.
    pub folds: Vec<Vec<usize>>,
    /// Every candidate in the order in which they were tried.
    pub candidates: Vec<CandidateReport>,
    /// Which of them was taken.
    pub chosen: usize,
    /// It on the training frames.
    pub training_rms: f64,
    /// Forecast of its error on more frames of the training clips.
    pub same_clips_rms: f64,
    /// Forecast of its error on another clip; `None` if training had one clip.
    pub other_clip_rms: Option<f64>,
    /// How its reconstruction was fitted, where it has one.
    pub rotational: Option<RotationalReport>,
    /// Largest |θ_j| in the training poses, J values in radians.
    pub angle_ranges: Vec<f64>,
}

/// A candidate and its score.
#[derive(Clone, Debug, Serialize)]
pub struct CandidateReport {
    /// What predicts.
    pub predictor: &'static str,
    /// How c1 and c2 came about; none without them.
    pub method: Option<Method>,
    /// P.
    pub proxies: usize,
    /// Whether the file's skins have tangent coefficients.
    pub tangent_coefficients: bool,
    /// Bytes of the file; none where it would be larger than allowed.
    pub bytes: Option<usize>,
    /// Cross-validated error; none where the file would be too large.
    pub validated_rms: Option<f64>,
    /// The maps of its groups.
    pub groups: Vec<GroupReport>,
}

/// |θ| beyond which a joint comes near the seam of its rotation vector at π.
pub const SEAM: f64 = 0.9 * std::f64::consts::PI;

impl TrainingReport {
    /// The candidate that was taken.
    pub fn chosen(&self) -> &CandidateReport {
        &self.candidates[self.chosen]
    }
}
