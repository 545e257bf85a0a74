//! Frames whose meshes stand elsewhere than their joints, as a whole: moved, or with a motion of the root that the joints
//! lack.
//!
//! LBS blends what the joints do, and no blend moves a mesh as a whole from where they are. So it does not matter how
//! many frames are moved, and that they look alike.

use crate::envelope::lbs::residuals::Residuals;
use crate::numeric::so3;
use faer::Mat;
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

/// A mesh stands elsewhere from this on, RMS in diagonals: four times what is found of a sound frame.
const FAR: f64 = 0.02;
/// Share of its squared error that may be left where it is put back. Of a sound frame nearly all is, but where few frames
/// and one that is spoiled bend LBS, and then twice this.
const LEFT: f64 = 0.02;

/// How a frame's mesh stands to what LBS makes of its pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stand {
    /// How far the rigid motion takes it that brings the two nearest, RMS in diagonals.
    pub moved: f64,
    /// Share of the squared error that is left then.
    pub left: f64,
}

impl Stand {
    /// Whether it stands elsewhere, beyond doubt.
    pub fn is_elsewhere(&self) -> bool {
        self.looks_elsewhere(LEFT)
    }

    /// Whether it looks so, where it may leave this share of its squared error.
    pub fn looks_elsewhere(&self, left: f64) -> bool {
        self.moved > FAR && self.left < left
    }
}

/// Finds how each training frame's mesh stands, n.
pub fn stands(residuals: Residuals<'_>) -> Vec<Stand> {
    (0..residuals.training.poses.len()).into_par_iter().map(|pose| stand(residuals, pose)).collect()
}

fn stand(Residuals { training, left, .. }: Residuals<'_>, pose: usize) -> Stand {
    let len = training.rest.len();
    let at = |columns: &Mat<f64>, vertex: usize| {
        Vector3::from_column_slice(&columns.col_as_slice(vertex)[3 * pose..3 * pose + 3])
    };
    let truth = |vertex: usize| at(&training.trajectories, vertex);
    let skinned = |vertex: usize| truth(vertex) - at(left, vertex);
    let mean = |of: &dyn Fn(usize) -> Vector3<f64>| -> Vector3<f64> {
        (0..len).map(of).sum::<Vector3<f64>>() / len as f64
    };
    let [to, from] = [mean(&truth), mean(&skinned)];
    let spread: Matrix3<f64> =
        (0..len).map(|v| (truth(v) - to) * (skinned(v) - from).transpose()).sum();
    let turn = so3::polar(&spread).map_or(Matrix3::identity(), |(turn, _)| turn);
    let put = |v: usize| turn * (skinned(v) - from) + to;
    let sum = |of: &dyn Fn(usize) -> Vector3<f64>| -> f64 {
        (0..len).map(|v| of(v).norm_squared()).sum()
    };
    let moved = sum(&|v| put(v) - skinned(v));
    let error = sum(&|v| truth(v) - skinned(v)).max(f64::MIN_POSITIVE);
    Stand { moved: (moved / len as f64).sqrt(), left: sum(&|v| truth(v) - put(v)) / error }
}
