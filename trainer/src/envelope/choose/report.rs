//! Report of a training.

use crate::envelope::clean::OutlierFrame;
use crate::envelope::correction::candidates::GroupReport;
use crate::envelope::fitted::BoneErrors;
use crate::envelope::s3::{Method, RotationalReport};
use serde::Serialize;

/// Report of the candidates and the chosen model. Errors are RMS, as shares of the rest diagonal.
#[derive(Clone, Debug, Serialize)]
pub struct TrainingReport {
    /// Outlier frames that were left out, the worst first.
    pub left_out: Vec<OutlierFrame>,
    /// Error of LBS on the training frames.
    pub lbs_rms: f64,
    /// Error of LBS with the mesh's own weights on the training frames; `None` if the mesh has no weights.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub own_weights_rms: Option<f64>,
    /// Pose indices of each fold among the training frames.
    pub folds: Vec<Vec<usize>>,
    /// Reports of all candidates in the order of their fits.
    pub candidates: Vec<CandidateReport>,
    /// Index of the chosen candidate.
    pub chosen: usize,
    /// The candidate with helpers that LBS replaces; `None` if no candidate was refused.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refused: Option<Refused>,
    /// Error of the chosen model on the training frames.
    pub training_rms: f64,
    /// Error of bones of translation, rotation and scale in place of the chosen model's palette, on the training frames.
    pub bones: BoneErrors,
    /// Forecast of the chosen model's error on more frames of the training clips.
    pub same_clips_rms: f64,
    /// Forecast of the chosen model's error on another clip; `None` if training had one clip.
    pub other_clip_rms: Option<f64>,
    /// Report of the reconstruction; `None` if the model has no reconstruction.
    pub rotational: Option<RotationalReport>,
    /// Largest |θ_j| in the training poses, J values in radians.
    pub angle_ranges: Vec<f64>,
}

/// A candidate with helpers that loses to LBS on clips that were left out.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Refused {
    /// Index of the candidate.
    pub candidate: usize,
    /// Forecast of its error on another clip.
    pub other_clip_rms: f64,
}

/// Report of a candidate.
#[derive(Clone, Debug, Serialize)]
pub struct CandidateReport {
    /// Name of the predictor.
    pub predictor: &'static str,
    /// Method of fitting c1 and c2; `None` without a reconstruction.
    pub method: Option<Method>,
    /// Number of proxies P.
    pub proxies: usize,
    /// Whether the file's skins have tangent coefficients.
    pub tangent_coefficients: bool,
    /// Bytes of the file; `None` if the file exceeds the budget.
    pub bytes: Option<usize>,
    /// Cross-validated error; `None` if the file exceeds the budget.
    pub validated_rms: Option<f64>,
    /// Reports of the groups' maps.
    pub groups: Vec<GroupReport>,
}

/// Angle |θ| in radians above which a joint is near the seam of its rotation vector at π.
pub const SEAM: f64 = 0.9 * std::f64::consts::PI;

impl TrainingReport {
    /// Returns the chosen candidate.
    pub fn chosen(&self) -> &CandidateReport {
        &self.candidates[self.chosen]
    }
}
