//! Enveloping: skins that follow a skeleton (S3, METHOD §1).
//!
//! | folder | content |
//! |---|---|
//! | [`lbs`] | poses and trajectories, LBS, prior weights: the input of every fit |
//! | [`folds`] | folds: groups of frames that validation leaves out together |
//! | [`clean`] | finds frames whose mesh does not belong to the pose |
//! | [`helpers`], [`s3`] | the two predictors: each fits a [`model`] |
//! | [`correction`] | kernel maps, which correct the helpers |
//! | [`choose`] | chooses predictor and number of helpers, within `--budget` |
//! | [`model`] | the model in f64: fitted, baked, evaluated, and loaded from a file |
//! | [`oracle`] | evaluates the model in f64, stage by stage; the runtime is tested against it |
//! | `bake` | writes the model's sections |
//! | [`normals`] | tangent coefficients of a skin, which correct its normals |
//! | [`levels`] | further meshes that follow the same palette |

mod bake;
pub mod choose;
pub mod clean;
pub mod correction;
pub mod fitted;
pub mod folds;
pub mod helpers;
pub mod lbs;
pub mod levels;
pub mod model;
pub mod normals;
mod options;
pub mod oracle;
pub mod posed;
pub mod s3;

pub use choose::Trained;
pub use options::{FileSkins, Options, Predict};

use crate::examples::Examples;
use crate::progress::Progress;
use crate::{Error, ErrorKind};
use clean::Inliers;
use sinew_runtime::envelope::{HelperKind, Predictor};

/// Two limits for the step of single precision at the mesh's distance from the origin, in diagonals. Above the first, a
/// fit to rounding errors may exceed the range of a model. Above the second, training is refused.
pub(crate) const COARSE: (f64, f64) = (1e-4, 1e-3);

/// Fits an envelope to the training frames of the examples and bakes it. Outlier frames are left out and reported.
///
/// Equal examples give equal bytes for any number of threads.
///
/// # Errors
/// - There are too few training poses, or all are one pose; no triangle of the rest mesh has an area.
/// - The character is too far from the origin for single precision.
/// - The predictor is rotational, and the examples have curves but no joints, or the helpers are not affine.
/// - The budget is too small, or the requested accuracy is out of reach.
/// - The reduced reconstruction is singular for every choice.
/// - A further mesh has the name of another, or does not lie on the surface.
/// - The runtime refuses the fitted model or a frame.
pub fn train(
    examples: &Examples,
    options: &Options,
    progress: &dyn Progress,
) -> Result<Trained, Error> {
    train_on(Inliers::new(examples, progress)?, options, progress)
}

/// Trains like [`train`], with the outliers already found.
///
/// # Errors
/// Those of [`train`].
pub fn train_on(
    inliers: Inliers<'_>,
    options: &Options,
    progress: &dyn Progress,
) -> Result<Trained, Error> {
    let examples = inliers.training.examples;
    if let Some(error) = too_far(examples, COARSE.1) {
        return Err(error);
    }
    let poses = &inliers.training.poses;
    if poses.are_equal() {
        return Err(one_pose(poses.len()));
    }
    let is_kernel = options.predictor == Predict::Only(Predictor::Kernel);
    if !is_kernel && examples.skeleton.is_still {
        return Err(Error::unsupported(
            "the predictor rotational follows joints, and these examples have only curves: use the predictor kernel",
        ));
    }
    if !is_kernel && options.helper_kind != HelperKind::Affine {
        return Err(Error::unsupported(format!(
            "helpers of kind {} need the predictor kernel: the reconstruction of the predictor rotational gives affine \
             transforms",
            options.helper_kind.name()
        )));
    }
    let left_out = inliers.left_out().to_vec();
    let mut training = inliers.weighted(progress)?;
    training.settings = options.settings.clone();
    if options.predictor == Predict::Published {
        training.lbs = training.free_lbs();
    }
    let trained = choose::choose(&training, options, progress);
    let mut trained = trained.map_err(|error| match error.kind() {
        // Only the baked file gives this kind: the runtime refuses numbers that are too large.
        ErrorKind::Damaged => too_far(examples, COARSE.0).unwrap_or(error),
        _ => error,
    })?;
    trained.report.left_out = left_out;
    Ok(trained)
}

/// Returns an error if the step of single precision is at least `least`, as a share of the diagonal.
pub(crate) fn too_far(examples: &Examples, least: f64) -> Option<Error> {
    let share = examples.coarseness();
    let diagonals = share / f64::from(f32::EPSILON);
    let error = || {
        Error::value(format!(
            "the character stands {diagonals:.0} diagonals from the origin, where positions in single precision are \
             {:.2} % of the diagonal apart: move mesh and skeleton to the origin before export",
            100.0 * share
        ))
    };
    (share >= least).then(error)
}

/// Returns the error of training frames that are all one pose.
pub(crate) fn one_pose(frames: usize) -> Error {
    Error::fit(format!("all {frames} training frames are one pose: there is no motion to learn"))
}
