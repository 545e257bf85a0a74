//! Errors of a training.

use super::levels::AddError;
use crate::bake::BakeError;
use crate::evaluate::EvaluateError;
use crate::examples::Examples;

/// Two limits for the step of single precision at the mesh's distance from the origin, in diagonals. Above the first, a
/// fit to rounding errors may exceed the range of a model. Above the second, training is refused.
pub(crate) const COARSE: (f64, f64) = (1e-4, 1e-3);

/// Reason why a training failed.
#[derive(Debug, thiserror::Error)]
pub enum TrainError {
    /// The fit failed.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// The model could not be written.
    #[error(transparent)]
    Bake(#[from] BakeError),
    /// A further mesh cannot become a skin.
    #[error(transparent)]
    Level(#[from] AddError),
    /// The fitted model could not be measured.
    #[error(transparent)]
    Evaluate(#[from] EvaluateError),
    /// The skeleton and the mesh alone exceed the budget.
    #[error("a budget of {budget} bytes is too small: skeleton and mesh alone take {least}")]
    BudgetOfMesh {
        /// Bytes allowed.
        budget: usize,
        /// Bytes of the skeleton and the mesh.
        least: usize,
    },
    /// The file of every candidate exceeds the budget.
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

/// Reason why a fit failed.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum FitError {
    /// There are fewer training poses than the fit has unknowns.
    #[error("the fit needs {needed} training poses, found {found}")]
    TooFewPoses {
        /// Training poses found.
        found: usize,
        /// Training poses needed.
        needed: usize,
    },
    /// All training frames are equal.
    #[error("all {found} training frames are one pose: there is no motion to learn")]
    OnePose {
        /// Training frames found.
        found: usize,
    },
    /// Positions in single precision are too coarse at the character's distance from the origin.
    #[error(
        "the character stands {diagonals:.0} diagonals from the origin, where positions in single precision are {:.2} % of \
         the diagonal apart: move mesh and skeleton to the origin before export",
        100.0 * share
    )]
    TooFar {
        /// Distance of the character from the origin, in diagonals.
        diagonals: f64,
        /// Step of single precision, as a share of the diagonal.
        share: f64,
    },
    /// No triangle of the rest mesh has an area.
    #[error("no triangle of the rest mesh has an area")]
    NoTriangles,
    /// No number of proxies reaches the requested error.
    #[error(
        "{} % is out of reach: {proxies} helpers, the most there can be, come to {:.4} % of the \
         diagonal",
        100.0 * limit,
        100.0 * reached
    )]
    MaxError {
        /// Requested RMS error, as a share of the diagonal.
        limit: f64,
        /// Smallest RMS error reached, as a share of the diagonal.
        reached: f64,
        /// Number of proxies that reached this error.
        proxies: usize,
    },
    /// Every candidate gives a singular system.
    #[error("the reduced reconstruction is singular for every choice of near-rigid vertices")]
    Singular,
}

impl FitError {
    /// Returns an error if the step of single precision is at least `least`, as a share of the diagonal.
    pub(crate) fn too_far(examples: &Examples, least: f64) -> Option<Self> {
        let share = examples.coarseness();
        let diagonals = share / f64::from(f32::EPSILON);
        (share >= least).then_some(Self::TooFar { diagonals, share })
    }
}
