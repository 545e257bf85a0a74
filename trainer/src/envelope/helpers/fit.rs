//! The fit of helpers to the training frames (METHOD §1.9).

use crate::envelope::correction::features::Features;
use crate::envelope::correction::lists::{self, Known};
use crate::envelope::correction::target::{CERTAINTY, CorrectionTarget};
use crate::envelope::fitted::Fitted;
use crate::envelope::lbs::blend::{
    Alternation, InTurn, Items, Maps, Pull, Supports, Weights, fit_maps,
};
use crate::envelope::lbs::poses::Poses;
use crate::envelope::lbs::projection::gram;
use crate::envelope::lbs::stacked::{bases, set_map};
use crate::envelope::lbs::targets::{Targets, skin};
use crate::envelope::lbs::training::Training;
use crate::envelope::model::Group;
use crate::examples::Importance;
use crate::numeric::affine::homogeneous;
use crate::numeric::basis::{Basis, basis_of};
use crate::numeric::columns;
use crate::numeric::columns::cluster;
use faer::Mat;
use nalgebra::{Matrix3, Matrix3x4, Matrix4, Vector3};

/// Name of the step.
pub const STEP: &str = "helpers";
/// Rounds of weights and maps in which each vertex also chooses what it follows, and those after them.
const CHOICES: usize = 30;
const ROUNDS: usize = 10;

/// Joints and helpers fitted to the training frames.
pub struct Helpers {
    /// Weights on the palette: joint j is j, helper l is J + l.
    pub weights: Weights,
    /// Dominant joint of each helper, P, ascending.
    pub dominant: Vec<usize>,
    /// Which of the lists that maps of its joint listen to each takes, P, ascending for a joint; all the first before
    /// [`Helpers::listening`].
    pub listens: Vec<usize>,
    /// What their true maps on the training frames add to their dominant joints', 3n x 4P.
    pub left_over: Mat<f64>,
    /// Σ φ φᵀ of the helpers over the vertices, 4P x 4P.
    pub gram: Mat<f64>,
    /// Squared error of LBS that each helper is to mend, P, summed over the poses.
    lbs_errors: Vec<f64>,
}

/// What a fit of any number of helpers reads.
pub struct HelperFit<'a> {
    training: &'a Training<'a>,
    /// The vertices on which LBS errs, and how each errs and where it lies, a column a vertex.
    errs: Vec<usize>,
    features: Mat<f64>,
    /// The joints' maps, 3n x 4J.
    joints: Mat<f64>,
    /// LBS as far as it counts, on a basis of its own.
    plain: Basis,
}

impl<'a> HelperFit<'a> {
    /// Takes training frames; none where LBS errs nowhere.
    pub fn new(training: &'a Training<'a>) -> Option<Self> {
        let errors = &training.lbs.errors;
        let threshold = training.settings.active.powi(2) * training.poses.len() as f64;
        let errs = |&v: &usize| training.importance().of(v) * errors[v] > threshold;
        let errs: Vec<usize> = (0..errors.len()).filter(errs).collect();
        if errs.is_empty() {
            return None;
        }
        let joints = training.poses.stacked();
        let Training { rest, lbs, .. } = training;
        let mut plain = basis_of([joints.nrows(), rest.len()], |v, column| {
            column.copy_from_slice(&skin(&rest[v], &lbs.weights, v, &joints));
        });
        plain.coordinates *= faer::Scale(training.settings.base);
        let features = basis_of([joints.nrows() + 3, errs.len()], |k, column| {
            features(training, errs[k], column);
        });
        Some(Self { features: features.coordinates, training, errs, joints, plain })
    }

    /// Fits `count` helpers on top of LBS weights.
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
        let open = Open::new(self, influences);
        let own = OnBasis::new(&open, [&bases, &anchors], &dominant).run(&maps, influences);
        let weights = open.among(&training.lbs.weights, &own);
        let pull = training.settings.pull;
        let maps = fit_helpers(&training.targets(&weights), [joints, &anchors], pull);
        let span = poses.joint_len()..poses.joint_len() + dominant.len();
        let gram = gram(&training.targets(&weights), span.clone());
        let lbs_errors = training.lbs_errors(&weights, span);
        let listens = vec![0; dominant.len()];
        Helpers { weights, dominant, listens, left_over: maps - bases, gram, lbs_errors }
    }

    /// What helpers are pulled to, 3n x 4P: the map of their dominant joint. Where the pull is all that decides, as
    /// along the normal of a flat group, that map would shear the skin. There it gives way to a blend of the joints' maps
    /// by the group's mean LBS weights.
    fn anchors(&self, groups: &[(usize, Vec<usize>)], bases: &Mat<f64>) -> Mat<f64> {
        let grams: Vec<Matrix4<f64>> = groups.iter().map(|group| self.gram(&group.1)).collect();
        let mean = grams.iter().map(Matrix4::trace).sum::<f64>() / (4 * grams.len()) as f64;
        let pull = Matrix4::from_diagonal_element(self.training.settings.pull * mean);
        let mut out = bases.clone();
        for (l, ((_, members), gram)) in groups.iter().zip(grams).enumerate() {
            let share = 1.0 / members.len() as f64;
            let mut apart = -bases.subcols(4 * l, 4).to_owned();
            for (joint, weight) in members.iter().flat_map(|&v| self.training.lbs.weights.of(v)) {
                apart += faer::Scale(share * weight) * self.joints.subcols(4 * joint, 4);
            }
            let open = pull * (gram + pull).try_inverse().unwrap_or_default();
            let mut own = out.subcols_mut(4 * l, 4);
            own += apart * Mat::from_fn(4, 4, |r, c| open[(r, c)]);
        }
        out
    }

    /// Fits the affine map of some vertices in each pose, with a ridge toward their joint's map.
    fn start(&self, members: &[usize], joint: usize) -> Vec<Matrix3x4<f64>> {
        const RIDGE: f64 = 1e-2;
        let Training { rest, poses, trajectories, .. } = self.training;
        let gram = self.gram(members);
        // Members in a coordinate plane leave a diagonal entry at 0: the floor keeps the matrix regular.
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

    /// Σ h hᵀ of vertices at rest.
    fn gram(&self, members: &[usize]) -> Matrix4<f64> {
        let h = |v: usize| homogeneous(&self.training.rest[v]);
        members.iter().map(|&v| h(v) * h(v).transpose()).sum()
    }

    /// Groups the vertices on which LBS errs by how they err and where they lie, each with the joint that most of it
    /// follow; those of one joint stand together.
    fn groups(&self, count: usize) -> Vec<(usize, Vec<usize>)> {
        let joints = &self.training.lbs.weights;
        let group = cluster(&self.features, count);
        let mut members = vec![Vec::new(); group.iter().max().map_or(0, |g| g + 1)];
        for (&v, &g) in self.errs.iter().zip(&group) {
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

/// The vertices that are fitted: all but those that LBS serves.
struct Open<'a> {
    fit: &'a HelperFit<'a>,
    vertices: Vec<usize>,
    rest: Vec<[f64; 3]>,
    importance: Option<Vec<f64>>,
    /// Their weights by LBS.
    lbs: Weights,
    /// Their trajectories on a basis, and under these the same of LBS.
    trajectories: Mat<f64>,
    targets: Mat<f64>,
}

impl<'a> Open<'a> {
    fn new(fit: &'a HelperFit<'a>, influences: usize) -> Self {
        let Training { rest, lbs, poses, settings, .. } = fit.training;
        let served = settings.served.powi(2) * poses.len() as f64;
        let error = |v: usize| fit.training.importance().of(v).max(1.0) * lbs.errors[v];
        let is_open = |&v: &usize| error(v) > served || lbs.weights.of(v).count() > influences;
        let vertices: Vec<usize> = (0..rest.len()).filter(is_open).collect();
        let own = |m: &Mat<f64>| columns::some(m, &vertices);
        let trajectories = own(&fit.training.basis().coordinates);
        let lists = vertices.iter().map(|&v| lbs.weights.of(v).collect());
        Self {
            rest: vertices.iter().map(|&v| rest[v]).collect(),
            importance: fit.training.importance().some(&vertices),
            lbs: Weights::from_lists(lbs.weights.most(), lists),
            targets: faer::concat![[&trajectories], [&own(&fit.plain.coordinates)]],
            trajectories,
            vertices,
            fit,
        }
    }

    fn importance(&self) -> Importance<'_> {
        Importance::by(self.importance.as_deref())
    }

    /// Puts weights of these vertices in the place of others among those of all.
    fn among(&self, all: &Weights, own: &Weights) -> Weights {
        let mut lists: Vec<Vec<_>> = (0..all.len()).map(|v| all.of(v).collect()).collect();
        self.vertices.iter().enumerate().for_each(|(k, &v)| lists[v] = own.of(k).collect());
        Weights::from_lists(own.most(), lists.into_iter())
    }
}

/// What weights and the helpers' maps are fitted in turn to, on a basis of the trajectories.
struct OnBasis<'a> {
    open: &'a Open<'a>,
    /// The joints' maps on the basis, and what helpers are pulled to.
    joints: Mat<f64>,
    anchors: Mat<f64>,
    /// The palette before any correction, as far as it counts, on the basis of LBS.
    plain: Mat<f64>,
    /// Weights of LBS, J x the vertices, and the joint of each map: weights that are folded onto dominant joints are pulled to
    /// those of LBS.
    lbs: Mat<f64>,
    joints_of: Vec<usize>,
}

impl<'a> OnBasis<'a> {
    fn new(open: &'a Open<'_>, [bases, anchors]: [&Mat<f64>; 2], dominant: &[usize]) -> Self {
        let HelperFit { training, joints, plain, .. } = open.fit;
        let onto = |basis: &Basis, maps: &Mat<f64>| basis.vectors.transpose() * maps;
        let trajectories = training.basis();
        let palette = onto(plain, &faer::concat![[joints, bases]]);
        let joint_len = joints.ncols() / 4;
        Self {
            open,
            joints: onto(trajectories, joints),
            anchors: onto(trajectories, anchors),
            plain: palette * faer::Scale(training.settings.base),
            lbs: open.lbs.dense(joint_len),
            joints_of: (0..joint_len).chain(dominant.iter().copied()).collect(),
        }
    }

    /// Fits weights and maps in turn from some maps of the helpers, and returns the weights.
    fn run(&self, maps: &Mat<f64>, influences: usize) -> Weights {
        let training = self.open.fit.training;
        let columns = training.basis().vectors.transpose() * maps;
        let maps = Maps { width: 4, columns };
        let ahead = training.settings.ahead;
        let alternation = Alternation { choices: CHOICES, every: 3, rounds: ROUNDS, ahead };
        alternation.run(self, (&self.open.lbs, maps), influences, || ()).0
    }
}

impl InTurn for OnBasis<'_> {
    fn weights(&self, helpers: &Maps, supports: Supports<'_>) -> (Weights, f64) {
        let palette = faer::concat![[&self.joints, &helpers.columns]];
        let columns = faer::concat![[&palette], [&self.plain]];
        let Open { rest, targets, .. } = self.open;
        let Training { settings, lbs, poses, .. } = self.open.fit.training;
        let strength =
            (settings.folded * lbs.strength).min(settings.folded_most) * poses.len() as f64;
        let pull = Some(Pull { to: &self.lbs, joints: &self.joints_of, strength });
        let items = Items { pull, ..Items::vertices(rest, targets, self.open.importance()) };
        items.weights(&Maps { width: 4, columns }, supports)
    }

    fn maps(&self, weights: &Weights, _: &Maps) -> Maps {
        let Open { rest, trajectories, .. } = self.open;
        let importance = self.open.importance();
        let targets = Targets { rest, weights, trajectories, importance };
        let pull = self.open.fit.training.settings.pull;
        let columns = fit_helpers(&targets, [&self.joints, &self.anchors], pull);
        Maps { width: 4, columns }
    }
}

/// Fits the helpers' maps to weights and trajectories.
fn fit_helpers(targets: &Targets<'_>, [joints, anchors]: [&Mat<f64>; 2], pull: f64) -> Mat<f64> {
    let (on_joints, on_helpers) = split(targets.weights, joints.ncols() / 4);
    let Targets { rest, trajectories, importance, .. } = *targets;
    let others = Some((&on_joints, joints));
    let items = Items { others, ..Items::vertices(rest, trajectories, importance) };
    fit_maps(&items, &on_helpers, &Maps { width: 4, columns: anchors.clone() }, pull).columns
}

/// Writes the error of LBS at a vertex in its joint's frame, a pose after the other, and its rest position: 3n + 3 numbers.
fn features(training: &Training, vertex: usize, column: &mut [f64]) {
    let (poses, joints) = (&training.poses, &training.lbs.weights);
    let scale = training.settings.residuals / (poses.len() as f64).sqrt();
    let scale = scale * training.importance().of(vertex).sqrt();
    let h = homogeneous(&training.rest[vertex]);
    let truth = training.trajectories.col_as_slice(vertex);
    for i in 0..poses.len() {
        let skinned: Vector3<f64> = joints.of(vertex).map(|(j, w)| poses.map(i, j) * h * w).sum();
        let turn: Matrix3<f64> =
            poses.map(i, joints.strongest(vertex).unwrap_or(0)).fixed_columns::<3>(0).into();
        let truth = Vector3::from_column_slice(&truth[3 * i..3 * i + 3]);
        let residual = turn.transpose() * (truth - skinned) * scale;
        column[3 * i..3 * i + 3].copy_from_slice(residual.as_slice());
    }
    column[3 * poses.len()..].copy_from_slice(&training.rest[vertex]);
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

impl Helpers {
    /// The helpers in an order in which those of a joint stand together that take the same of what its maps listen to: each
    /// takes what predicts it best.
    pub fn listening(self, training: &Training, known: &Known) -> Self {
        let listens = lists::assign(&self.target(training), known);
        let mut order: Vec<usize> = (0..listens.len()).collect();
        order.sort_by_key(|&l| (self.dominant[l], listens[l]));
        let mut rank = vec![0; order.len()];
        order.iter().enumerate().for_each(|(k, &l)| rank[l] = k);
        let joint_len = training.poses.joint_len();
        let place = |(map, w): (usize, f64)| {
            (map.checked_sub(joint_len).map_or(map, |l| joint_len + rank[l]), w)
        };
        let lists = (0..self.weights.len()).map(|v| self.weights.of(v).map(place).collect());
        let from = columns::of_maps(&order);
        Self {
            weights: Weights::from_lists(self.weights.most(), lists),
            dominant: order.iter().map(|&l| self.dominant[l]).collect(),
            listens: order.iter().map(|&l| listens[l]).collect(),
            left_over: columns::some(&self.left_over, &from),
            gram: Mat::from_fn(from.len(), from.len(), |r, c| self.gram[(from[r], from[c])]),
            lbs_errors: order.iter().map(|&l| self.lbs_errors[l]).collect(),
        }
    }

    /// The envelope with a correction, whose groups hold the helpers.
    pub fn fitted(&self, training: &Training, groups: Vec<Group>) -> Fitted {
        Fitted::new(training, self.weights.clone(), None).with(groups)
    }

    /// The palette of poses before any correction, 3n x 4(J + P).
    pub fn base(&self, poses: &Poses) -> Mat<f64> {
        let joints = poses.stacked();
        let helpers = bases(&joints, &self.dominant);
        faer::concat![[joints, helpers]]
    }

    /// What the joints leave over for a correction to learn.
    pub fn target<'a>(&'a self, training: &'a Training<'a>) -> CorrectionTarget<'a> {
        CorrectionTarget {
            poses: &training.poses,
            folds: training.folds(),
            features: Features::of(training),
            dominant: &self.dominant,
            listens: &self.listens,
            left_over: &self.left_over,
            gram: &self.gram,
            lbs_errors: &self.lbs_errors,
            certainty: CERTAINTY,
            vertices: training.rest.len(),
        }
    }

    /// The palette of the training poses with the helpers' true maps, 3n x 4(J + P).
    pub fn true_palette(&self, poses: &Poses) -> Mat<f64> {
        let joints = poses.stacked();
        let helpers = bases(&joints, &self.dominant) + &self.left_over;
        faer::concat![[joints, helpers]]
    }
}

#[cfg(test)]
mod tests {
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
    fn helpers_take_up_what_lbs_leaves() {
        let training = arm();
        let (rest, poses) = (&training.rest, &training.poses);
        let found = HelperFit::new(&training).unwrap().run(20, 4);
        let of = |weights| training.targets(weights);
        let with = of(&found.weights).rms(&found.true_palette(poses));
        let without = of(&training.lbs.weights).rms(&poses.stacked());
        assert!(with < 0.1 * without, "{with} against {without}");
        assert!((0..rest.len()).all(|v| found.weights.of(v).count() <= 4));
        assert!(found.left_over.norm_max() < 1.0, "a helper stays near its joint");
        assert!(found.dominant.is_sorted(), "helpers of a joint stand together");
    }

    #[test]
    fn helpers_that_hear_the_same_stand_together_and_the_skin_stays() {
        let training = arm();
        let found = HelperFit::new(&training).unwrap().run(40, 4);
        let skin = |helpers: &Helpers| {
            let palette = helpers.true_palette(&training.poses);
            let trace: f64 = (0..helpers.gram.nrows()).map(|i| helpers.gram[(i, i)]).sum();
            (training.targets(&helpers.weights).rms(&palette), trace)
        };
        let (rms, trace) = skin(&found);
        let known = lists::choose(&found.target(&training), &Silent);
        assert!(known.values().any(|lists| lists.len() > 1), "some joint has several lists");
        let sum: f64 = found.lbs_errors.iter().sum();
        let found = found.listening(&training, &known);
        let places: Vec<_> = (0..40).map(|l| found.target(&training).place(l)).collect();
        assert!(places.is_sorted() && places.iter().any(|place| place.1 > 0), "{places:?}");
        let (moved, moved_trace) = skin(&found);
        assert!((moved / rms - 1.0).abs() < 1e-9 && (moved_trace / trace - 1.0).abs() < 1e-12);
        assert!((found.lbs_errors.iter().sum::<f64>() / sum - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_helper_with_nothing_to_learn_takes_a_list_as_well() {
        let training = arm();
        let mut found = HelperFit::new(&training).unwrap().run(40, 4);
        let known = lists::choose(&found.target(&training), &Silent);
        let has_several = |l: &usize| known[&found.dominant[*l]].len() > 1;
        let last = (0..40).rev().find(has_several).unwrap();
        found.left_over.subcols_mut(4 * last, 4).fill(0.0);
        assert_eq!(lists::assign(&found.target(&training), &known).len(), 40);
    }

    #[test]
    fn vertices_that_lbs_serves_keep_its_weights_as_far_as_there_may_be_so_many() {
        let mut training = arm();
        (0..100).for_each(|v| training.lbs.errors[v] = 0.0);
        let few = 0;
        let weights = &training.lbs.weights;
        let list = |v: usize| weights.of(v).take(if v == few { 1 } else { 4 });
        let lists = (0..weights.len())
            .map(|v| list(v).map(|(j, w)| (j, if v == few { 1.0 } else { w })).collect());
        training.lbs.weights = Weights::from_lists(4, lists);
        let is_kept = |influences: usize, v: usize| {
            let found = HelperFit::new(&training).unwrap().run(20, influences);
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
        assert!(HelperFit::new(&training).is_none());
    }
}
