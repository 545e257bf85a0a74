//! Errors of several parts of a training.

use crate::Error;
use crate::examples::Examples;

/// Two limits for the step of single precision at the mesh's distance from the origin, in diagonals. Above the first, a
/// fit to rounding errors may exceed the range of a model. Above the second, training is refused.
pub(crate) const COARSE: (f64, f64) = (1e-4, 1e-3);

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

/// Returns the error of a fit that cannot reach the requested error.
///
/// - `limit`: requested RMS error, as a share of the diagonal.
/// - `reached`: error with `proxies` proxies, the most there can be.
pub(super) fn out_of_reach(limit: f64, reached: f64, proxies: usize) -> Error {
    Error::fit(format!(
        "{} % is out of reach: {proxies} helpers, the most there can be, come to {:.4} % of the \
         diagonal",
        100.0 * limit,
        100.0 * reached
    ))
}
