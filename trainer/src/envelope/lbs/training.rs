//! Training frames in the units of the fit.

use super::blend::Weights;
use super::poses::{MIN_POSES, Poses, local, seen_from};
use super::prior::prior;
use super::targets::{Targets, in_poses};
use super::weights::{FREE, Lbs};
use crate::Error;
use crate::envelope::folds::Folds;
use crate::envelope::model::Curve;
use crate::examples::{Examples, Importance, Skeleton, Split};
use crate::numeric::affine::linear;
use crate::numeric::basis::{Basis, basis};
use crate::numeric::columns;
use crate::progress::Progress;
use crate::settings::Settings;
use faer::Mat;
use nalgebra::Vector3;
use std::ops::Range;
use std::sync::OnceLock;

/// Training frames in the units of the fit: n poses and the trajectories of V vertices.
///
/// The root's motion is removed. Lengths are in units of the rest diagonal, and the centre of the rest mesh is the
/// origin. So constants and rounding of the fit do not depend on the unit and the place of the input.
pub struct Training<'a> {
    /// The examples.
    pub examples: &'a Examples,
    /// Rest diagonal, in units of the input.
    pub unit: f64,
    /// Centroid of the rest mesh, in units of the input.
    pub centre: [f64; 3],
    /// V rest positions.
    pub rest: Vec<[f64; 3]>,
    /// Triangles with an area.
    pub triangles: Vec<[usize; 3]>,
    /// The joints.
    pub skeleton: Skeleton,
    /// Rest origin of each joint.
    pub origins: Vec<Vector3<f64>>,
    /// n poses.
    pub poses: Poses,
    /// Trajectories of the vertices, 3n x V.
    pub trajectories: Mat<f64>,
    /// LBS fitted to the trajectories.
    pub lbs: Lbs,
    /// Settings of the fit.
    pub settings: Settings,
    /// Importance of each vertex, V numbers of mean 1; `None` for equal importance.
    importance: Option<Vec<f64>>,
    basis: OnceLock<Basis>,
    folds: OnceLock<Folds>,
}

impl<'a> Training<'a> {
    /// Gathers the training frames of the examples. Other frames are not read.
    ///
    /// # Errors
    /// - [`ErrorKind::Fit`](crate::ErrorKind::Fit): there are fewer than [`MIN_POSES`] frames.
    /// - [`ErrorKind::Value`](crate::ErrorKind::Value): no triangle of the rest mesh has an area.
    pub fn new(examples: &'a Examples, progress: &dyn Progress) -> Result<Self, Error> {
        Ok(Self::of(examples, &examples.frames_of(Split::Train), progress)?.pulled())
    }

    /// Gathers some of the training frames. LBS has only the weakest pull to prior weights.
    ///
    /// # Errors
    /// Those of [`Training::new`].
    pub fn of(
        examples: &'a Examples,
        frames: &[usize],
        progress: &dyn Progress,
    ) -> Result<Self, Error> {
        if frames.len() < MIN_POSES {
            return Err(Error::fit(format!(
                "the fit needs {MIN_POSES} training poses, found {}",
                frames.len()
            )));
        }
        let triangles = examples.solid_triangles();
        if triangles.is_empty() {
            return Err(Error::value("no triangle of the rest mesh has an area"));
        }
        let space @ (centre, unit) = (examples.centroid(), examples.diagonal());
        let rest: Vec<_> = examples.rest.iter().map(|x| local(x, space)).collect();
        let mut skeleton = examples.skeleton.clone();
        for rest in &mut skeleton.rest {
            let origin = local(&rest.map(|row| row[3]), space);
            rest.iter_mut().zip(origin).for_each(|(row, x)| row[3] = x);
        }
        let (poses, trajectories) = seen_from(examples, frames, space);
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

    /// Chooses the strength of the pull to prior weights and fits LBS again.
    #[must_use]
    pub fn pulled(self) -> Self {
        let (rest, trajectories, poses) = (&self.rest, &self.trajectories, &self.poses);
        let lbs = Lbs::new(rest, trajectories, (poses, self.folds()), self.lbs.prior.clone());
        Self { lbs, ..self }
    }

    /// Fits LBS with only the weakest pull to prior weights.
    pub fn free_lbs(&self) -> Lbs {
        let pull = (self.lbs.prior.clone(), FREE);
        Lbs::pulled(&self.rest, &self.trajectories, &self.poses, pull)
    }

    /// Returns some of the vertices in some of the poses, with LBS fitted again.
    #[must_use]
    pub fn part(&self, vertices: &[usize], poses: &[usize]) -> Self {
        let rest: Vec<_> = vertices.iter().map(|&v| self.rest[v]).collect();
        let trajectories = self.trajectories_of(vertices, poses);
        let poses = self.poses.only(poses);
        let prior = columns::some(&self.lbs.prior, vertices);
        let lbs = Lbs::pulled(&rest, &trajectories, &poses, (prior, self.lbs.strength));
        let mut place = vec![None; self.rest.len()];
        vertices.iter().enumerate().for_each(|(k, &v)| place[v] = Some(k));
        let renumbered = |corners: &[usize; 3]| {
            let [a, b, c] = corners.map(|v| place[v]);
            Some([a?, b?, c?])
        };
        Self {
            triangles: self.triangles.iter().filter_map(renumbered).collect(),
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

    /// Returns the trajectories of some vertices in some of the poses: 3 rows a pose, a column a vertex.
    pub fn trajectories_of(&self, vertices: &[usize], poses: &[usize]) -> Mat<f64> {
        in_poses(&columns::some(&self.trajectories, vertices), poses)
    }

    /// Converts other frames to these units: poses, and trajectories 3n x V.
    pub fn view(&self, examples: &Examples, frames: &[usize]) -> (Poses, Mat<f64>) {
        seen_from(examples, frames, (self.centre, self.unit))
    }

    /// Returns the training meshes with weights on a palette.
    pub fn targets<'t>(&'t self, weights: &'t Weights) -> Targets<'t> {
        Targets {
            rest: &self.rest,
            weights,
            trajectories: &self.trajectories,
            importance: self.importance(),
        }
    }

    /// Computes the residuals of LBS, 3n x V, and the dominant joint of each vertex, V.
    pub fn lbs_residuals(&self) -> (Mat<f64>, Vec<usize>) {
        let weights = &self.lbs.weights;
        let dominant = (0..self.rest.len()).map(|v| weights.strongest(v).unwrap_or(0)).collect();
        (self.targets(weights).residuals(&self.poses.stacked()), dominant)
    }

    /// Returns the RMS error of LBS, in diagonals.
    pub fn lbs_rms(&self) -> f64 {
        let count = self.rest.len() * self.poses.len();
        (self.lbs.errors.iter().sum::<f64>() / count.max(1) as f64).sqrt()
    }

    /// Shares the squared errors of LBS among a span of palette transforms, in proportion to the weights of each
    /// vertex. Errors are weighted by importance.
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

    /// Lists the curves with their trained ranges, C.
    pub fn curves(&self) -> Vec<Curve> {
        let names = self.examples.curve_names.iter().zip(self.poses.curve_ranges());
        names.map(|(name, range)| Curve { name: name.clone(), range: *range }).collect()
    }

    /// Returns the importance of the vertices.
    pub fn importance(&self) -> Importance<'_> {
        Importance::by(self.importance.as_deref())
    }

    /// Returns the folds of the poses, computed on first use.
    pub fn folds(&self) -> &Folds {
        self.folds.get_or_init(|| Folds::new(&self.poses))
    }

    /// Returns a short basis of the trajectories, computed on first use.
    pub fn basis(&self) -> &Basis {
        self.basis.get_or_init(|| basis(&self.trajectories))
    }
}

/// Residuals of LBS on the training frames.
#[derive(Clone, Copy)]
pub struct Residuals<'a> {
    /// The training frames.
    pub training: &'a Training<'a>,
    /// Residuals, 3n x V, in diagonals.
    pub residuals: &'a Mat<f64>,
    /// Dominant joint of each vertex, V.
    pub dominant: &'a [usize],
}

impl Residuals<'_> {
    /// Lists the vertices that each joint dominates, J lists.
    pub fn skins(&self) -> Vec<Vec<usize>> {
        let mut skins = vec![Vec::new(); self.training.poses.joint_len()];
        for (vertex, &joint) in self.dominant.iter().enumerate() {
            skins[joint].push(vertex);
        }
        skins
    }

    /// Computes the inner products of the residuals of some poses, in the joint's frame and weighted by importance.
    /// Returns a row and a column for each pose.
    ///
    /// - `skin`: vertices of the joint.
    pub fn gram(&self, joint: usize, skin: &[usize], poses: &[usize]) -> Mat<f64> {
        let mut weighted = Mat::zeros(3 * skin.len(), poses.len());
        for (i, &pose) in poses.iter().enumerate() {
            let turn = linear(self.training.poses.map(pose, joint)).transpose();
            for (k, &vertex) in skin.iter().enumerate() {
                let weight = self.training.importance().of(vertex).sqrt();
                let column = self.residuals.col_as_slice(vertex);
                let own = turn * Vector3::from_column_slice(&column[3 * pose..3 * pose + 3]);
                (0..3).for_each(|axis| weighted[(3 * k + axis, i)] = weight * own[axis]);
            }
        }
        weighted.transpose() * &weighted
    }
}
