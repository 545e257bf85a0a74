//! The training frames as the fit sees them.

use super::super::FitError;
use super::super::motion::{Poses, trajectories};
use crate::examples::{Examples, Split};
use faer::Mat;

/// Fewest training poses: one row of H has six unknowns.
pub const MIN_POSES: usize = 6;

/// The training frames with the root's motion removed and all lengths in units of the rest
/// diagonal, so that no constant of the fit depends on the units of the input.
pub struct Training {
    /// The rest diagonal, in units of the input.
    pub unit: f64,
    /// V rest positions.
    pub rest: Vec<[f64; 3]>,
    /// The triangles that have an area.
    pub triangles: Vec<[usize; 3]>,
    /// n poses.
    pub poses: Poses,
    /// The vertices' trajectories, 3n x V.
    pub trajectories: Mat<f64>,
}

impl Training {
    /// Gathers the training frames of the examples; no other frame is read.
    ///
    /// # Errors
    /// [`FitError::TooFewPoses`] and [`FitError::NoTriangles`].
    pub fn new(examples: &Examples) -> Result<Self, FitError> {
        let frames = examples.frames_of(Split::Train);
        if frames.len() < MIN_POSES {
            return Err(FitError::TooFewPoses { found: frames.len(), needed: MIN_POSES });
        }
        let triangles = examples.solid_triangles();
        if triangles.is_empty() {
            return Err(FitError::NoTriangles);
        }
        let unit = examples.diagonal();
        let poses = Poses::new(examples, &frames);
        let mut trajectories = trajectories(examples, &frames, &poses);
        trajectories *= faer::Scale(1.0 / unit);
        Ok(Self {
            unit,
            rest: examples.rest.iter().map(|x| x.map(|x| x / unit)).collect(),
            triangles,
            poses: poses.in_units_of(unit),
            trajectories,
        })
    }
}
