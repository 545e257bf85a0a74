//! Joints and helpers (METHOD §1.9): helpers are added where LBS has an error, and kernel maps drive them from the
//! pose.

pub mod fit;
mod kind;

use super::correction::features::Features;
use super::correction::joint_sets::{self, JointSets};
use super::correction::target::{CERTAINTY, CorrectionTarget};
use super::fitted::{Fitted, corrected};
use super::lbs::blend::Weights;
use super::lbs::poses::Poses;
use super::lbs::targets::bases;
use super::lbs::training::Training;
use super::model::Group;
use crate::numeric::columns;
use crate::numeric::trs::Place;
use faer::Mat;
use sinew_runtime::envelope::HelperKind;

/// Joints and helpers fitted to the training frames.
pub struct Helpers {
    /// Weights on the palette. Joint j has index j, helper l has index J + l.
    pub weights: Weights,
    /// Kind of the helpers.
    pub kind: HelperKind,
    /// Place of each helper's vertices at rest, P.
    pub places: Vec<Place>,
    /// Dominant joint of each helper, P, ascending.
    pub dominant: Vec<usize>,
    /// Index of the joint set that each helper uses, P, ascending within a joint. All 0 before
    /// [`Helpers::with_joint_sets`].
    pub joint_sets: Vec<usize>,
    /// True transforms of the helpers in the training poses minus those of their dominant joints, 3n x 4P.
    pub residual: Mat<f64>,
    /// Σ φ φᵀ of the helpers over the vertices, 4P x 4P.
    pub gram: Mat<f64>,
    /// Squared error of LBS that each helper has to reduce, P, summed over the poses.
    lbs_errors: Vec<f64>,
}

impl Helpers {
    /// Assigns the best joint set to each helper, and sorts helpers by dominant joint and joint set.
    pub fn with_joint_sets(self, training: &Training, joint_sets: &JointSets) -> Self {
        let assigned = joint_sets::assign(&self.target(training), joint_sets);
        let mut order: Vec<usize> = (0..assigned.len()).collect();
        order.sort_by_key(|&l| (self.dominant[l], assigned[l]));
        let mut rank = vec![0; order.len()];
        order.iter().enumerate().for_each(|(k, &l)| rank[l] = k);
        let joint_len = training.poses.joint_len();
        let place = |map: usize| map.checked_sub(joint_len).map_or(map, |l| joint_len + rank[l]);
        let from = columns::of_maps(&order);
        Self {
            weights: self.weights.renumbered(place),
            kind: self.kind,
            places: order.iter().map(|&l| self.places[l]).collect(),
            dominant: order.iter().map(|&l| self.dominant[l]).collect(),
            joint_sets: order.iter().map(|&l| assigned[l]).collect(),
            residual: columns::some(&self.residual, &from),
            gram: Mat::from_fn(from.len(), from.len(), |r, c| self.gram[(from[r], from[c])]),
            lbs_errors: order.iter().map(|&l| self.lbs_errors[l]).collect(),
        }
    }

    /// Creates the envelope with a correction, given as groups of the helpers.
    pub fn fitted(&self, training: &Training, groups: Vec<Group>) -> Fitted {
        let fitted = Fitted::new(training, self.weights.clone(), None).with(groups);
        fitted.with_helpers(self.kind, self.places.clone())
    }

    /// Computes the palette of poses without a correction, 3n x 4(J + P).
    pub fn base(&self, poses: &Poses) -> Mat<f64> {
        let joints = poses.stacked();
        let helpers = bases(&joints, &self.dominant);
        faer::concat![[joints, helpers]]
    }

    /// Returns the target of a correction.
    pub fn target<'a>(&'a self, training: &'a Training<'a>) -> CorrectionTarget<'a> {
        CorrectionTarget {
            poses: &training.poses,
            folds: training.folds(),
            features: Features::of(training),
            dominant: &self.dominant,
            joint_sets: &self.joint_sets,
            residual: &self.residual,
            gram: &self.gram,
            lbs_errors: &self.lbs_errors,
            certainty: CERTAINTY,
            vertices: training.rest.len(),
        }
    }

    /// Computes the palette of the training poses with the true transforms of the helpers, 3n x 4(J + P).
    pub fn true_palette(&self, poses: &Poses) -> Mat<f64> {
        corrected(self.base(poses), &self.residual)
    }
}

#[cfg(test)]
mod tests {
    use super::fit::HelperFit;
    use super::*;
    use crate::examples::Examples;
    use crate::examples::demo::{DemoOptions, demo};
    use crate::progress::Silent;
    use std::sync::LazyLock;

    fn arm() -> Training<'static> {
        static ARM: LazyLock<Examples> =
            LazyLock::new(|| demo(&DemoOptions { vertices: 300, poses: 40, held_out: 0, seed: 1 }));
        Training::new(&ARM, &Silent).unwrap()
    }

    #[test]
    fn helpers_reduce_the_error_of_lbs() {
        let training = arm();
        let (rest, poses) = (&training.rest, &training.poses);
        let found = HelperFit::new(&training, HelperKind::Affine).unwrap().run(20, 4);
        let of = |weights| training.targets(weights);
        let with = of(&found.weights).rms(&found.true_palette(poses));
        let without = of(&training.lbs.weights).rms(&poses.stacked());
        assert!(with < 0.1 * without, "{with} against {without}");
        assert!((0..rest.len()).all(|v| found.weights.of(v).count() <= 4));
        assert!(found.residual.norm_max() < 1.0, "a helper stays near its joint");
        assert!(found.dominant.is_sorted(), "helpers of a joint are adjacent");
    }

    #[test]
    fn helpers_of_a_joint_set_are_adjacent_and_the_skin_stays() {
        let training = arm();
        let found = HelperFit::new(&training, HelperKind::Affine).unwrap().run(40, 4);
        let skin = |helpers: &Helpers| {
            let palette = helpers.true_palette(&training.poses);
            let trace: f64 = (0..helpers.gram.nrows()).map(|i| helpers.gram[(i, i)]).sum();
            (training.targets(&helpers.weights).rms(&palette), trace)
        };
        let (rms, trace) = skin(&found);
        let joint_sets = joint_sets::choose(&found.target(&training), &Silent);
        assert!(
            joint_sets.values().any(|sets| sets.len() > 1),
            "some joint has several joint sets"
        );
        let sum: f64 = found.lbs_errors.iter().sum();
        let found = found.with_joint_sets(&training, &joint_sets);
        let keys: Vec<_> = (0..40).map(|l| found.target(&training).group_key(l)).collect();
        assert!(keys.is_sorted() && keys.iter().any(|key| key.1 > 0), "{keys:?}");
        let (sorted_rms, sorted_trace) = skin(&found);
        assert!((sorted_rms / rms - 1.0).abs() < 1e-9);
        assert!((sorted_trace / trace - 1.0).abs() < 1e-12);
        assert!((found.lbs_errors.iter().sum::<f64>() / sum - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_helper_without_a_residual_gets_a_joint_set() {
        let training = arm();
        let mut found = HelperFit::new(&training, HelperKind::Affine).unwrap().run(40, 4);
        let joint_sets = joint_sets::choose(&found.target(&training), &Silent);
        let has_several = |l: &usize| joint_sets[&found.dominant[*l]].len() > 1;
        let last = (0..40).rev().find(has_several).unwrap();
        found.residual.subcols_mut(4 * last, 4).fill(0.0);
        assert_eq!(joint_sets::assign(&found.target(&training), &joint_sets).len(), 40);
    }

    #[test]
    fn exact_vertices_keep_lbs_weights_within_the_influences() {
        let mut training = arm();
        (0..100).for_each(|v| training.lbs.errors[v] = 0.0);
        let few = 0;
        let weights = &training.lbs.weights;
        let list = |v: usize| weights.of(v).take(if v == few { 1 } else { 4 });
        let lists = (0..weights.len())
            .map(|v| list(v).map(|(j, w)| (j, if v == few { 1.0 } else { w })).collect());
        training.lbs.weights = Weights::from_lists(4, lists);
        let is_kept = |influences: usize, v: usize| {
            let found = HelperFit::new(&training, HelperKind::Affine).unwrap().run(20, influences);
            found.weights.of(v).eq(training.lbs.weights.of(v))
        };
        let several = (1..100).find(|&v| training.lbs.weights.of(v).count() > 1).unwrap();
        assert!(is_kept(4, few) && is_kept(4, several) && is_kept(1, few));
        assert!(!is_kept(1, several));
        assert!((100..300).any(|v| !is_kept(4, v)));
    }

    #[test]
    fn a_skin_that_is_lbs_needs_no_helper() {
        let mut training = arm();
        training.lbs.errors.fill(0.0);
        assert!(HelperFit::new(&training, HelperKind::Affine).is_none());
    }
}
