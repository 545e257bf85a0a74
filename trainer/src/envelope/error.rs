//! Why a training failed.

use super::levels::AddError;
use crate::bake::BakeError;
use crate::evaluate::EvaluateError;
use crate::examples::Examples;

/// Steps of single precision at the mesh's distance from the origin, in diagonals. From the first on, a fit to the
/// rounding may exceed the range of a model. From the second on, nothing is trained.
pub(crate) const COARSE: (f64, f64) = (1e-4, 1e-3);

/// A training that failed.
#[derive(Debug, thiserror::Error)]
pub enum TrainError {
    /// The fit could not be made.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// The fit could not be written.
    #[error(transparent)]
    Bake(#[from] BakeError),
    /// A further mesh cannot become a skin.
    #[error(transparent)]
    Level(#[from] AddError),
    /// What was fitted could not be measured.
    #[error(transparent)]
    Evaluate(#[from] EvaluateError),
    /// No model can be small enough: skeleton and mesh alone are not.
    #[error("a budget of {budget} bytes is too small: skeleton and mesh alone take {least}")]
    BudgetOfMesh {
        /// Bytes allowed.
        budget: usize,
        /// Bytes without anything that is learnt.
        least: usize,
    },
    /// No candidate's file is small enough.
    #[error(
        "a budget of {budget} bytes is too small: the smallest model that was tried takes {least}, \
         most of which is the mesh itself"
    )]
    Budget {
        /// Bytes allowed.
        budget: usize,
        /// Bytes of the smallest candidate.
        least: usize,
    },
}

/// A fit that could not be made.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum FitError {
    /// Fewer training poses than the fit has unknowns for.
    #[error("the fit needs {needed} training poses, found {found}")]
    TooFewPoses {
        /// Training poses found.
        found: usize,
        /// Training poses needed.
        needed: usize,
    },
    /// The training frames are one and the same.
    #[error("all {found} training frames are one pose: there is no motion to learn")]
    OnePose {
        /// Training frames found.
        found: usize,
    },
    /// Positions in single precision are too coarse where the character stands.
    #[error(
        "the character stands {diagonals:.0} diagonals from the origin, where positions in single precision are {:.2} % of \
         the diagonal apart: move mesh and skeleton to the origin before export",
        100.0 * share
    )]
    TooFar {
        /// How far it stands, in diagonals.
        diagonals: f64,
        /// How far apart positions are, as a share of the diagonal.
        share: f64,
    },
    /// No triangle has an area.
    #[error("no triangle of the rest mesh has an area")]
    NoTriangles,
    /// No number of proxies comes as near as was asked.
    #[error(
        "{} % is out of reach: {proxies} proxies, the most there can be, come to {:.4} % of the \
         diagonal",
        100.0 * limit,
        100.0 * reached
    )]
    MaxError {
        /// RMS asked for, as a share of the diagonal.
        limit: f64,
        /// RMS reached.
        reached: f64,
        /// With so many.
        proxies: usize,
    },
    /// No candidate gives a regular system.
    #[error("the reduced reconstruction is singular for every choice of near-rigid vertices")]
    Singular,
}

impl FitError {
    /// Returns the error of examples whose positions are at least so coarse, as a share of the diagonal.
    pub(crate) fn too_far(examples: &Examples, least: f64) -> Option<Self> {
        let share = examples.coarseness();
        let diagonals = share / f64::from(f32::EPSILON);
        (share >= least).then_some(Self::TooFar { diagonals, share })
    }
}
