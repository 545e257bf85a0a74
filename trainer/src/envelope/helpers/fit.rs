//! Fit of helpers to the training frames (METHOD §1.9).

use super::Helpers;
use super::kind::fit_kind;
use crate::envelope::fitted::places;
use crate::envelope::lbs::blend::{Alternation, InTurn, Items, Normal, Pull, Supports, Weights};
use crate::envelope::lbs::projection::gram;
use crate::envelope::lbs::targets::{Targets, bases, set_map, skin};
use crate::envelope::lbs::training::Training;
use crate::examples::Importance;
use crate::numeric::affine::{homogeneous, linear};
use crate::numeric::basis::{Basis, basis_of};
use crate::numeric::columns::{self, cluster};
use faer::Mat;
use nalgebra::{Matrix3x4, Matrix4, Vector3};
use sinew_runtime::envelope::HelperKind;

/// Name of the step.
pub const STEP: &str = "helpers";
/// Number of first rounds. In every third of them a vertex also chooses its transforms.
const CHOICES: usize = 30;
/// Factor of the first rounds for a skeleton of one joint: LBS has no motion there, so its weights are no start.
const FROM_NOTHING: usize = 3;
/// Number of last rounds, in which vertices keep their transforms, and of sweeps over helpers of a kind.
const ROUNDS: usize = 10;

/// Input shared by the fits of any number of helpers.
pub struct HelperFit<'a> {
    training: &'a Training<'a>,
    kind: HelperKind,
    /// Vertices with an LBS error, which get helpers.
    active: Vec<usize>,
    /// LBS error and rest position of the active vertices, a column a vertex.
    features: Mat<f64>,
    /// Joint transforms, 3n x 4J.
    joints: Mat<f64>,
    /// Trajectories by LBS on their own basis, weighted by [`Settings::base`](crate::settings::Settings::base).
    base: Basis,
}

impl<'a> HelperFit<'a> {
    /// Prepares the fits; `None` if no vertex has an LBS error.
    pub fn new(training: &'a Training<'a>, kind: HelperKind) -> Option<Self> {
        let errors = &training.lbs.errors;
        let threshold = training.settings.active.powi(2) * training.poses.len() as f64;
        let is_active = |&v: &usize| training.importance().of(v) * errors[v] > threshold;
        let active: Vec<usize> = (0..errors.len()).filter(is_active).collect();
        if active.is_empty() {
            return None;
        }
        let joints = training.poses.stacked();
        let Training { rest, lbs, .. } = training;
        let mut base = basis_of([joints.nrows(), rest.len()], |v, column| {
            column.copy_from_slice(&skin(&rest[v], &lbs.weights, v, &joints));
        });
        base.coordinates *= faer::Scale(training.settings.base);
        let features = basis_of([joints.nrows() + 3, active.len()], |k, column| {
            features(training, active[k], column);
        });
        Some(Self { features: features.coordinates, training, kind, active, joints, base })
    }

    /// Fits `count` helpers, starting from LBS weights.
    ///
    /// - `influences`: largest number of palette transforms that a vertex follows.
    pub fn run(&self, count: usize, influences: usize) -> Helpers {
        let (training, joints) = (self.training, &self.joints);
        let poses = &training.poses;
        let groups = self.groups(count);
        let dominant: Vec<usize> = groups.iter().map(|group| group.0).collect();
        let mut maps = Mat::zeros(joints.nrows(), 4 * groups.len());
        for (l, (joint, members)) in groups.iter().enumerate() {
            for (i, map) in self.start(members, *joint).into_iter().enumerate() {
                set_map(&mut maps, i, l, &map);
            }
        }
        let bases = bases(joints, &dominant);
        let anchors = self.anchors(&groups, &bases);
        let refit = Refit::new(self, influences, [&bases, &anchors], &dominant);
        let own = refit.run(&maps, influences);
        let weights = refit.replace(&training.lbs.weights, &own);
        let normal = helper_equations(&training.targets(&weights), [joints, &anchors], training);
        let mut maps = normal.solve(&anchors);
        if self.kind != HelperKind::Affine {
            maps = fit_kind(&normal, &maps, self.kind, None, ROUNDS);
        }
        let span = poses.joint_len()..poses.joint_len() + dominant.len();
        let places = places(training, &weights, span.clone());
        let gram = gram(&training.targets(&weights), span.clone());
        let lbs_errors = training.lbs_errors(&weights, span);
        let joint_sets = vec![0; dominant.len()];
        Helpers {
            weights,
            kind: self.kind,
            places,
            dominant,
            joint_sets,
            residual: maps - bases,
            gram,
            lbs_errors,
        }
    }

    /// Computes the targets of the pull on helper transforms, 3n x 4P: the transforms of the dominant joints.
    ///
    /// Some directions are decided only by the pull, for example the normal of a flat group. There the dominant joint
    /// would shear the skin. In these directions the target is a blend of joint transforms by the group's mean LBS
    /// weights.
    fn anchors(&self, groups: &[(usize, Vec<usize>)], bases: &Mat<f64>) -> Mat<f64> {
        let grams: Vec<Matrix4<f64>> = groups.iter().map(|group| self.gram(&group.1)).collect();
        let mean = grams.iter().map(Matrix4::trace).sum::<f64>() / (4 * grams.len()) as f64;
        let pull = Matrix4::from_diagonal_element(self.training.settings.pull * mean);
        let mut out = bases.clone();
        for (l, ((_, members), gram)) in groups.iter().zip(grams).enumerate() {
            let share = 1.0 / members.len() as f64;
            let mut difference = -bases.subcols(4 * l, 4).to_owned();
            for (joint, weight) in members.iter().flat_map(|&v| self.training.lbs.weights.of(v)) {
                difference += faer::Scale(share * weight) * self.joints.subcols(4 * joint, 4);
            }
            let undecided = pull * (gram + pull).try_inverse().unwrap_or_default();
            let mut own = out.subcols_mut(4 * l, 4);
            own += difference * Mat::from_fn(4, 4, |r, c| undecided[(r, c)]);
        }
        out
    }

    /// Fits an affine transform to some vertices in each pose, with a ridge toward the transform of their joint.
    fn start(&self, members: &[usize], joint: usize) -> Vec<Matrix3x4<f64>> {
        const RIDGE: f64 = 1e-2;
        let Training { rest, poses, trajectories, .. } = self.training;
        let gram = self.gram(members);
        // Vertices in a coordinate plane leave a diagonal entry at 0. The floor keeps the matrix regular.
        let floor = f64::EPSILON * gram.trace();
        let ridge = gram.diagonal().map(|d| (RIDGE * d).max(floor));
        let inverse = (gram + Matrix4::from_diagonal(&ridge)).try_inverse().unwrap_or_default();
        (0..poses.len())
            .map(|i| {
                let base = poses.map(i, joint);
                let mut right = Matrix3x4::zeros();
                for &v in members {
                    let h = homogeneous(&rest[v]);
                    let truth = &trajectories.col_as_slice(v)[3 * i..3 * i + 3];
                    right += (Vector3::from_column_slice(truth) - base * h) * h.transpose();
                }
                base + right * inverse
            })
            .collect()
    }

    /// Sums h hᵀ of vertices at rest.
    fn gram(&self, members: &[usize]) -> Matrix4<f64> {
        let h = |v: usize| homogeneous(&self.training.rest[v]);
        members.iter().map(|&v| h(v) * h(v).transpose()).sum()
    }

    /// Clusters the active vertices by LBS error and rest position. Returns the clusters, sorted by their dominant
    /// joint: the joint that dominates most of the vertices.
    fn groups(&self, count: usize) -> Vec<(usize, Vec<usize>)> {
        let joints = &self.training.lbs.weights;
        let group = cluster(&self.features, count);
        let mut members = vec![Vec::new(); group.iter().max().map_or(0, |g| g + 1)];
        for (&v, &g) in self.active.iter().zip(&group) {
            members[g].push(v);
        }
        members.retain(|m| !m.is_empty());
        let with_joint = |members: Vec<usize>| {
            let mut votes = vec![0usize; self.training.poses.joint_len()];
            members.iter().for_each(|&v| votes[joints.strongest(v).unwrap_or(0)] += 1);
            ((0..votes.len()).rev().max_by_key(|&j| votes[j]).unwrap_or(0), members)
        };
        let mut groups: Vec<_> = members.into_iter().map(with_joint).collect();
        groups.sort_by_key(|group| group.0);
        groups
    }
}

/// Vertices that get new weights, and the alternation between their weights and the helper transforms, on a basis of the
/// trajectories. The other vertices keep their LBS weights.
struct Refit<'a> {
    fit: &'a HelperFit<'a>,
    vertices: Vec<usize>,
    rest: Vec<[f64; 3]>,
    importance: Option<Vec<f64>>,
    /// LBS weights.
    lbs: Weights,
    /// LBS weights, J x the vertices. They are the target of the pull on weights.
    prior: Mat<f64>,
    /// Coordinates of the trajectories on their basis.
    trajectories: Mat<f64>,
    /// `trajectories`, and below them the coordinates of the base.
    targets: Mat<f64>,
    /// Joint transforms on the basis.
    joints: Mat<f64>,
    /// Targets of the pull on helper transforms, on the basis.
    anchors: Mat<f64>,
    /// Weighted palette without a correction, on the basis of the base.
    base: Mat<f64>,
    /// Joint of each palette transform. A helper's weight counts for its dominant joint in the pull.
    joints_of: Vec<usize>,
}

impl<'a> Refit<'a> {
    fn new(
        fit: &'a HelperFit<'a>,
        influences: usize,
        [bases, anchors]: [&Mat<f64>; 2],
        dominant: &[usize],
    ) -> Self {
        let HelperFit { training, joints, base, .. } = fit;
        let Training { rest, lbs, poses, settings, .. } = *training;
        let threshold = settings.refit.powi(2) * poses.len() as f64;
        let error = |v: usize| training.importance().of(v).max(1.0) * lbs.errors[v];
        let is_refitted =
            |&v: &usize| error(v) > threshold || lbs.weights.of(v).count() > influences;
        let vertices: Vec<usize> = (0..rest.len()).filter(is_refitted).collect();
        let own = |m: &Mat<f64>| columns::some(m, &vertices);
        let onto = |basis: &Basis, maps: &Mat<f64>| basis.vectors.transpose() * maps;
        let trajectories = own(&training.basis().coordinates);
        let lists = vertices.iter().map(|&v| lbs.weights.of(v).collect());
        let lbs = Weights::from_lists(lbs.weights.most(), lists);
        let palette = onto(base, &faer::concat![[joints, bases]]);
        let joint_len = joints.ncols() / 4;
        Self {
            rest: vertices.iter().map(|&v| rest[v]).collect(),
            importance: training.importance().some(&vertices),
            prior: lbs.dense(joint_len),
            targets: faer::concat![[&trajectories], [&own(&base.coordinates)]],
            joints: onto(training.basis(), joints),
            anchors: onto(training.basis(), anchors),
            base: palette * faer::Scale(settings.base),
            joints_of: (0..joint_len).chain(dominant.iter().copied()).collect(),
            trajectories,
            lbs,
            vertices,
            fit,
        }
    }

    fn importance(&self) -> Importance<'_> {
        Importance::by(self.importance.as_deref())
    }

    /// Fits weights and helper transforms in turn, starting from given transforms. Returns the weights.
    fn run(&self, maps: &Mat<f64>, influences: usize) -> Weights {
        let training = self.fit.training;
        let maps = training.basis().vectors.transpose() * maps;
        let momentum = training.settings.momentum;
        let choices =
            if training.poses.joint_len() == 1 { FROM_NOTHING * CHOICES } else { CHOICES };
        let alternation = Alternation { choices, every: 3, rounds: ROUNDS, momentum };
        alternation.run(self, (&self.lbs, maps), influences, || ()).0
    }

    /// Replaces the weights of these vertices among the weights of all vertices.
    fn replace(&self, all: &Weights, own: &Weights) -> Weights {
        let mut lists: Vec<Vec<_>> = (0..all.len()).map(|v| all.of(v).collect()).collect();
        self.vertices.iter().enumerate().for_each(|(k, &v)| lists[v] = own.of(k).collect());
        Weights::from_lists(own.most(), lists.into_iter())
    }
}

impl InTurn for Refit<'_> {
    fn weights(&self, helpers: &Mat<f64>, supports: Supports<'_>) -> (Weights, f64) {
        let palette = faer::concat![[&self.joints, helpers]];
        let columns = faer::concat![[&palette], [&self.base]];
        let Training { settings, lbs, poses, .. } = self.fit.training;
        let strength = (settings.weight_pull * lbs.strength).min(settings.weight_pull_max)
            * poses.len() as f64;
        let pull = Some(Pull { to: &self.prior, joints: &self.joints_of, strength });
        let vertices = Items::vertices(&self.rest, &self.targets, self.importance());
        Items { pull, ..vertices }.weights(&columns, supports)
    }

    fn maps(&self, weights: &Weights, from: &Mat<f64>) -> Mat<f64> {
        let Self { rest, trajectories, anchors, .. } = self;
        let HelperFit { training, kind, .. } = *self.fit;
        let targets = Targets { rest, weights, trajectories, importance: self.importance() };
        let normal = helper_equations(&targets, [&self.joints, anchors], training);
        match kind {
            HelperKind::Affine => normal.solve(anchors),
            _ => {
                let basis = Some(&training.basis().vectors);
                fit_kind(&normal, from, kind, basis, 1)
            }
        }
    }
}

/// Returns the equations of helper transforms for weights and trajectories.
fn helper_equations(
    targets: &Targets<'_>,
    [joints, anchors]: [&Mat<f64>; 2],
    training: &Training<'_>,
) -> Normal {
    let (on_joints, on_helpers) = split(targets.weights, joints.ncols() / 4);
    let Targets { rest, trajectories, importance, .. } = *targets;
    let fixed = Some((&on_joints, joints));
    let items = Items { fixed, ..Items::vertices(rest, trajectories, importance) };
    Normal::new(&items, &on_helpers, anchors, training.settings.pull)
}

/// Writes the LBS error of a vertex in the frame of its dominant joint, pose by pose, and then its rest position: 3n +
/// 3 numbers.
fn features(training: &Training, vertex: usize, column: &mut [f64]) {
    let (poses, joints) = (&training.poses, &training.lbs.weights);
    let scale = training.settings.residuals / (poses.len() as f64).sqrt();
    let scale = scale * training.importance().of(vertex).sqrt();
    let h = homogeneous(&training.rest[vertex]);
    let truth = training.trajectories.col_as_slice(vertex);
    for i in 0..poses.len() {
        let skinned: Vector3<f64> = joints.of(vertex).map(|(j, w)| poses.map(i, j) * h * w).sum();
        let turn = linear(poses.map(i, joints.strongest(vertex).unwrap_or(0)));
        let truth = Vector3::from_column_slice(&truth[3 * i..3 * i + 3]);
        let residual = turn.transpose() * (truth - skinned) * scale;
        column[3 * i..3 * i + 3].copy_from_slice(residual.as_slice());
    }
    column[3 * poses.len()..].copy_from_slice(&training.rest[vertex]);
}

/// Splits weights into weights on joints and weights on helpers.
fn split(weights: &Weights, joint_len: usize) -> (Weights, Weights) {
    let part = |keep: &dyn Fn(usize) -> Option<usize>| {
        let lists = (0..weights.len())
            .map(|v| weights.of(v).filter_map(|(map, w)| keep(map).map(|map| (map, w))).collect());
        Weights::from_lists(weights.most(), lists)
    };
    (part(&|map| (map < joint_len).then_some(map)), part(&|map| map.checked_sub(joint_len)))
}
