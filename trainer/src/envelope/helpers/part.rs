//! The part of a skin that helpers serve.

use crate::constants::PULL;
use crate::envelope::skin::blend::{Items, Maps, Weights, fit_maps};
use crate::envelope::skin::targets::Targets;
use crate::envelope::skin::training::Training;
use crate::examples::Importance;
use faer::Mat;

/// The vertices that may follow helpers: those that LBS errs on. The others stay as they are.
pub(super) struct Part {
    /// Their numbers.
    vertices: Vec<usize>,
    pub(super) rest: Vec<[f64; 3]>,
    pub(super) trajectories: Mat<f64>,
    importance: Vec<f64>,
    /// Their LBS weights.
    pub(super) plain: Weights,
}

impl Part {
    pub(super) fn new(training: &Training, vertices: Vec<usize>) -> Self {
        let Training { rest, trajectories, lbs, .. } = training;
        Self {
            rest: vertices.iter().map(|&v| rest[v]).collect(),
            trajectories: Mat::from_fn(trajectories.nrows(), vertices.len(), |row, k| {
                trajectories[(row, vertices[k])]
            }),
            importance: vertices.iter().map(|&v| training.importance().of(v)).collect(),
            plain: Weights::from_lists(
                lbs.weights.most(),
                vertices.iter().map(|&v| lbs.weights.of(v).collect()),
            ),
            vertices,
        }
    }

    pub(super) fn importance(&self) -> Importance<'_> {
        Importance::by(Some(&self.importance))
    }

    /// The weights of all vertices, given those of these and what the others follow.
    pub(super) fn whole(&self, others: &Weights, own: &Weights) -> Weights {
        let mut lists: Vec<Vec<_>> = (0..others.len()).map(|v| others.of(v).collect()).collect();
        for (k, &vertex) in self.vertices.iter().enumerate() {
            lists[vertex] = own.of(k).collect();
        }
        Weights::from_lists(own.most(), lists.into_iter())
    }

    /// Fits the helpers' maps to weights and trajectories.
    pub(super) fn fit_helpers(
        &self,
        trajectories: &Mat<f64>,
        [joints, bases]: [&Mat<f64>; 2],
        weights: &Weights,
    ) -> Mat<f64> {
        let (on_joints, on_helpers) = split(weights, joints.ncols() / 4);
        let (rest, importance) = (&self.rest, self.importance());
        let left =
            Targets { rest, weights: &on_joints, trajectories, importance }.residuals(joints);
        let items = Items::vertices(rest, &left, importance);
        let bases = Maps { width: 4, columns: bases.clone() };
        fit_maps(&items, &on_helpers, &bases, PULL.get()).columns
    }
}

/// Splits weights on joints and helpers.
fn split(weights: &Weights, joint_len: usize) -> (Weights, Weights) {
    let part = |keep: &dyn Fn(usize) -> Option<usize>| {
        let lists = (0..weights.len())
            .map(|v| weights.of(v).filter_map(|(map, w)| keep(map).map(|map| (map, w))).collect());
        Weights::from_lists(weights.most(), lists)
    };
    (part(&|map| (map < joint_len).then_some(map)), part(&|map| map.checked_sub(joint_len)))
}
