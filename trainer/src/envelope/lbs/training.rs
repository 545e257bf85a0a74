//! The training frames as the fit sees them.

use super::blend::Weights;
use super::poses::{MIN_POSES, Poses, local, seen_from};
use super::prior::prior;
use super::targets::Targets;
use super::weights::{FREE, Lbs};
use crate::envelope::error::FitError;
use crate::envelope::folds::Folds;
use crate::examples::{Examples, Importance, Skeleton, Split};
use crate::numeric::basis::{Basis, basis};
use crate::numeric::columns;
use crate::progress::Progress;
use crate::settings::Settings;
use faer::Mat;
use nalgebra::Vector3;
use std::ops::Range;
use std::sync::OnceLock;

/// The training frames with the root's motion removed, about the centre of the rest mesh and with
/// all lengths in units of the rest diagonal, so that no constant and no rounding of the fit depends
/// on the units of the input or on where it stands.
pub struct Training<'a> {
    /// The examples.
    pub examples: &'a Examples,
    /// The rest diagonal, in units of the input.
    pub unit: f64,
    /// The centroid of the rest mesh, in units of the input.
    pub centre: [f64; 3],
    /// V rest positions.
    pub rest: Vec<[f64; 3]>,
    /// The triangles that have an area.
    pub triangles: Vec<[usize; 3]>,
    /// The joints.
    pub skeleton: Skeleton,
    /// Rest origin of each joint.
    pub origins: Vec<Vector3<f64>>,
    /// n poses.
    pub poses: Poses,
    /// The vertices' trajectories, 3n x V.
    pub trajectories: Mat<f64>,
    /// LBS fitted to them.
    pub lbs: Lbs,
    /// What the fit is set to.
    pub settings: Settings,
    /// How much each vertex counts, V numbers of mean 1; all alike without.
    importance: Option<Vec<f64>>,
    basis: OnceLock<Basis>,
    folds: OnceLock<Folds>,
}

impl<'a> Training<'a> {
    /// Gathers the training frames of the examples; no other frame is read.
    ///
    /// # Errors
    /// [`FitError::TooFewPoses`] and [`FitError::NoTriangles`].
    pub fn new(examples: &'a Examples, progress: &dyn Progress) -> Result<Self, FitError> {
        Ok(Self::of(examples, &examples.frames_of(Split::Train), progress)?.pulled())
    }

    /// Gathers some of the training frames, with LBS weights that the poses alone decide.
    ///
    /// # Errors
    /// As [`Training::new`].
    pub fn of(
        examples: &'a Examples,
        frames: &[usize],
        progress: &dyn Progress,
    ) -> Result<Self, FitError> {
        if frames.len() < MIN_POSES {
            return Err(FitError::TooFewPoses { found: frames.len(), needed: MIN_POSES });
        }
        let triangles = examples.solid_triangles();
        if triangles.is_empty() {
            return Err(FitError::NoTriangles);
        }
        let seen @ (centre, unit) = (examples.centroid(), examples.diagonal());
        let rest: Vec<_> = examples.rest.iter().map(|x| local(x, seen)).collect();
        let mut skeleton = examples.skeleton.clone();
        for frame in &mut skeleton.rest {
            let origin = local(&frame.map(|row| row[3]), seen);
            frame.iter_mut().zip(origin).for_each(|(row, x)| row[3] = x);
        }
        let (poses, trajectories) = seen_from(examples, frames, seen);
        progress.step("LBS weights", 1);
        let lbs = Lbs::pulled(&rest, &trajectories, &poses, (prior(examples, &poses), FREE));
        Ok(Self {
            examples,
            unit,
            centre,
            rest,
            triangles,
            origins: skeleton.rest.iter().map(|m| m.map(|row| row[3]).into()).collect(),
            skeleton,
            poses,
            folds: OnceLock::new(),
            trajectories,
            lbs,
            settings: Settings::default(),
            importance: examples.importance.clone(),
            basis: OnceLock::new(),
        })
    }

    /// Chooses the strength of the pull to prior weights, and fits LBS anew.
    #[must_use]
    pub fn pulled(self) -> Self {
        let (rest, trajectories, poses) = (&self.rest, &self.trajectories, &self.poses);
        let lbs = Lbs::new(rest, trajectories, (poses, self.folds()), self.lbs.prior.clone());
        Self { lbs, ..self }
    }

    /// Fits LBS by the poses alone.
    pub fn free_lbs(&self) -> Lbs {
        let pull = (self.lbs.prior.clone(), FREE);
        Lbs::pulled(&self.rest, &self.trajectories, &self.poses, pull)
    }

    /// Returns some of the vertices in some of the poses, with LBS fitted anew.
    #[must_use]
    pub fn part(&self, vertices: &[usize], poses: &[usize]) -> Self {
        let rest: Vec<_> = vertices.iter().map(|&v| self.rest[v]).collect();
        let trajectories = self.moved(vertices, poses);
        let poses = self.poses.only(poses);
        let prior = columns::some(&self.lbs.prior, vertices);
        let lbs = Lbs::pulled(&rest, &trajectories, &poses, (prior, self.lbs.strength));
        let mut place = vec![None; self.rest.len()];
        vertices.iter().enumerate().for_each(|(k, &v)| place[v] = Some(k));
        let moved = |corners: &[usize; 3]| {
            let [a, b, c] = corners.map(|v| place[v]);
            Some([a?, b?, c?])
        };
        Self {
            triangles: self.triangles.iter().filter_map(moved).collect(),
            skeleton: self.skeleton.clone(),
            origins: self.origins.clone(),
            settings: self.settings.clone(),
            folds: OnceLock::new(),
            importance: self.importance().some(vertices),
            basis: OnceLock::new(),
            rest,
            trajectories,
            poses,
            lbs,
            ..*self
        }
    }

    /// Returns the trajectories of some vertices in some of the poses, 3 rows of each.
    pub fn moved(&self, vertices: &[usize], poses: &[usize]) -> Mat<f64> {
        Mat::from_fn(3 * poses.len(), vertices.len(), |row, k| {
            self.trajectories[(3 * poses[row / 3] + row % 3, vertices[k])]
        })
    }

    /// Gives other frames of the examples as these are seen: poses, and trajectories 3n x V.
    pub fn view(&self, examples: &Examples, frames: &[usize]) -> (Poses, Mat<f64>) {
        seen_from(examples, frames, (self.centre, self.unit))
    }

    /// The training meshes, as vertices of these weights on a palette.
    pub fn targets<'t>(&'t self, weights: &'t Weights) -> Targets<'t> {
        Targets {
            rest: &self.rest,
            weights,
            trajectories: &self.trajectories,
            importance: self.importance(),
        }
    }

    /// Computes what LBS leaves, 3n x V, and the joint that each vertex follows most, V.
    pub fn left_by_lbs(&self) -> (Mat<f64>, Vec<usize>) {
        let weights = &self.lbs.weights;
        let dominant = (0..self.rest.len()).map(|v| weights.strongest(v).unwrap_or(0)).collect();
        (self.targets(weights).residuals(&self.poses.stacked()), dominant)
    }

    /// Returns the RMS error of LBS, in diagonals.
    pub fn lbs_rms(&self) -> f64 {
        let count = self.rest.len() * self.poses.len();
        (self.lbs.errors.iter().sum::<f64>() / count.max(1) as f64).sqrt()
    }

    /// Divides the squared errors of LBS, as they count, among a span of the palette, by the weights that each vertex
    /// has on it.
    pub fn lbs_errors(&self, weights: &Weights, span: Range<usize>) -> Vec<f64> {
        let mut errors = vec![0.0; span.len()];
        for (vertex, error) in self.lbs.errors.iter().enumerate() {
            let own = weights.of(vertex).filter(|(map, _)| span.contains(map));
            let sum: f64 = own.clone().map(|(_, weight)| weight).sum();
            let error = self.importance().of(vertex) * error;
            own.for_each(|(map, weight)| errors[map - span.start] += error * weight / sum);
        }
        errors
    }

    /// How much each vertex counts.
    pub fn importance(&self) -> Importance<'_> {
        Importance::by(self.importance.as_deref())
    }

    /// Which poses are left out together, found when this is first asked for.
    pub fn folds(&self) -> &Folds {
        self.folds.get_or_init(|| Folds::new(&self.poses))
    }

    /// A short basis of the trajectories, made when it is first asked for.
    pub fn basis(&self) -> &Basis {
        self.basis.get_or_init(|| basis(&self.trajectories))
    }
}
