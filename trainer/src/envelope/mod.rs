//! Enveloping: how a skin follows its skeleton (S3, METHOD §1).

pub mod blend;
mod columns;
pub mod helpers;
pub mod motion;
pub mod oracle;
pub mod rotational;
pub mod simplex;
pub mod so3;
pub mod weights;

use crate::bake::{BakeError, bake};
use crate::examples::Examples;
use crate::progress::Progress;

/// A trained model.
pub struct Trained {
    /// The file's bytes.
    pub model: Vec<u8>,
    /// P.
    pub proxies: usize,
    /// How it was fitted.
    pub report: rotational::Report,
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
}

/// Fits an envelope to the training frames of the examples and bakes it.
///
/// The same examples give the same bytes for any number of threads.
///
/// # Errors
/// [`TrainError::Fit`] and [`TrainError::Bake`].
pub fn train(
    examples: &Examples,
    options: &rotational::Options,
    progress: &dyn Progress,
) -> Result<Trained, TrainError> {
    let fitted = rotational::fit(examples, options, progress)?;
    let model = bake(&fitted.parts(examples))?;
    Ok(Trained { model, proxies: fitted.keys.len(), report: fitted.report })
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
