//! Enveloping: how a skin follows its skeleton (S3, METHOD §1).

pub mod blend;
pub mod choose;
mod columns;
pub mod fitted;
pub mod helpers;
pub mod levels;
pub mod motion;
pub mod oracle;
pub mod rotational;
mod rounding;
pub mod simplex;
pub mod so3;
pub mod training;
pub mod weights;

use crate::bake::BakeError;
use crate::examples::Examples;
use crate::progress::Progress;
use levels::{AddError, Level, LevelReport};
use rotational::proxies::ProxyCount;
use sinew_runtime::envelope::Predictor;
use training::Training;

/// What predicts the palette from the pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Predict {
    /// Whatever cross-validation finds best.
    Auto,
    /// This one.
    Only(Predictor),
}

/// What a training is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// What predicts.
    pub predictor: Predict,
    /// P, or the error that decides it; chosen by cross-validation where none is given.
    pub proxies: Option<ProxyCount>,
    /// K, the most maps of the palette that a vertex follows.
    pub influences: usize,
    /// Whether c1 and c2 may be refined on the training meshes; S3 as published does not.
    pub refine: bool,
    /// Most bytes of the file, all of its skins included.
    pub budget: Option<usize>,
    /// The meshes that the file holds.
    pub meshes: Meshes,
}

/// The meshes that a model's file holds.
#[derive(Clone, Debug, PartialEq)]
pub enum Meshes {
    /// The examples' own, then further ones, each as a skin.
    Skins(Vec<Level>),
    /// None: a palette alone, for an engine that keeps its meshes and their weights.
    PaletteAlone,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            predictor: Predict::Auto,
            proxies: None,
            influences: 4,
            refine: true,
            budget: None,
            meshes: Meshes::Skins(Vec::new()),
        }
    }
}

/// A trained model.
pub struct Trained {
    /// The file's bytes.
    pub model: Vec<u8>,
    /// How it was fitted.
    pub report: choose::Report,
    /// How the further meshes follow, in their order.
    pub levels: Vec<LevelReport>,
}

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

/// Fits an envelope to the training frames of the examples and bakes it.
///
/// The same examples give the same bytes for any number of threads.
///
/// # Errors
/// Every [`TrainError`].
pub fn train(
    examples: &Examples,
    options: &Options,
    progress: &dyn Progress,
) -> Result<Trained, TrainError> {
    let training = Training::new(examples, progress)?;
    choose::choose(&training, examples, options, progress)
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
    /// The full reconstruction could not be set up.
    #[error(transparent)]
    Poisson(#[from] rotational::poisson::PoissonError),
    /// No candidate gives a regular system.
    #[error("the reduced reconstruction is singular for every choice of near-rigid vertices")]
    Singular,
}
