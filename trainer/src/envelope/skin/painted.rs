//! Joint weights as an artist painted them (METHOD §1.2): what they tell of which joints are near, and where they
//! mislead.

use super::blend::Weights;
use crate::constants::{PAINTED, UNPAINTED};
use crate::examples::Examples;
use faer::Mat;

/// Share of a vertex's largest weight below which another is a rest of smoothing and normalising.
const TRACE: f64 = 1e-3;
/// How many times what it errs without them, RMS, the skin that follows a joint most may err near to painted weights:
/// what errs more was painted for another mesh or other joints, or not at all.
const MISLEADS: f64 = 2.0;
/// The same of the skin of all such joints together, among which chance evens out.
const ALL_MISLEAD: f64 = 1.25;

/// The painted weights of V vertices.
pub struct Painted<'a> {
    joint_len: usize,
    /// V x J.
    rows: Vec<&'a [f64]>,
}

impl<'a> Painted<'a> {
    /// Gives those that come with examples, where any do.
    pub fn of(examples: &'a Examples) -> Option<Self> {
        let (joint_len, weights) = (examples.joint_len(), examples.joint_weights.as_ref()?);
        Some(Self { joint_len, rows: weights.chunks_exact(joint_len).collect() })
    }

    /// How many times farther each joint is from each vertex than the nearest, J x V, where `by_bones` it is so much
    /// farther: the farther the less it weighs, and far where it weighs nothing. A vertex without weights goes by bones.
    pub fn farther(&self, by_bones: &Mat<f64>) -> Mat<f64> {
        let mut farther = by_bones.clone();
        for (vertex, row) in self.rows.iter().enumerate() {
            let Some(strongest) = self.strongest(vertex) else { continue };
            for (joint, farther) in farther.col_as_slice_mut(vertex).iter_mut().enumerate() {
                let share = row[joint] / row[strongest];
                let painted = 1.0 + PAINTED.get() * (1.0 - share);
                let unpainted = UNPAINTED.get() * *farther;
                *farther = if share > TRACE { painted } else { unpainted.max(painted) };
            }
        }
        farther
    }

    /// Lists the joints on whose skin the weights mislead: all, where they do on what is left of it together.
    ///
    /// - `near`, `free`: squared errors of the V vertices near to the weights and without them.
    /// - `unseen`: a squared error of a vertex that does not count.
    pub fn misleading(&self, near: &[f64], free: &[f64], unseen: f64) -> Vec<usize> {
        // Of each joint's skin, in this order.
        let mut sums = vec![[0.0; 3]; self.joint_len];
        for vertex in 0..self.rows.len() {
            let Some(joint) = self.strongest(vertex) else { continue };
            let own = [near[vertex], free[vertex], unseen];
            sums[joint] = std::array::from_fn(|k| sums[joint][k] + own[k]);
        }
        let mislead =
            |[near, free, unseen]: [f64; 3], most: f64| near > most.powi(2) * free.max(unseen);
        let (mut misleading, others): (Vec<usize>, Vec<usize>) = (0..self.joint_len)
            .filter(|&joint| sums[joint] != [0.0; 3])
            .partition(|&joint| mislead(sums[joint], MISLEADS));
        let left = std::array::from_fn(|k| others.iter().map(|&joint| sums[joint][k]).sum());
        if mislead(left, ALL_MISLEAD) {
            misleading.extend(others);
            misleading.sort_unstable();
        }
        misleading
    }

    /// Whether a vertex follows one of some joints most.
    pub fn follows(&self, vertex: usize, joints: &[usize]) -> bool {
        self.strongest(vertex).is_some_and(|joint| joints.contains(&joint))
    }

    /// Gives the weights as they blend; a vertex without any follows nothing.
    pub fn weights(&self) -> Weights {
        let list = |row: &&[f64]| {
            let sum: f64 = row.iter().sum();
            let some = row.iter().enumerate().filter(|(_, weight)| **weight > 0.0);
            let mut list: Vec<_> = some.map(|(joint, weight)| (joint, weight / sum)).collect();
            list.sort_by(|a, b| b.1.total_cmp(&a.1));
            list
        };
        let lists: Vec<_> = self.rows.iter().map(list).collect();
        let most = lists.iter().map(Vec::len).max().unwrap_or(0).max(1);
        Weights::from_lists(most, lists.into_iter())
    }

    /// The joint of the largest weight, the first of several.
    fn strongest(&self, vertex: usize) -> Option<usize> {
        let row = self.rows[vertex];
        let most = row.iter().copied().fold(0.0, f64::max);
        row.iter().position(|&weight| most > 0.0 && weight == most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::examples::testing::triangle;

    #[test]
    fn what_weighs_less_is_farther_and_what_weighs_nothing_far() {
        let mut examples = triangle(1);
        // The second vertex has none.
        examples.joint_weights = Some(vec![3.0, 1.0, 0.0, 0.0, 0.0, 0.5]);
        let by_bones = Mat::from_fn(2, 3, |joint, _| [2.0, 1.0][joint]);
        let found = Painted::of(&examples).unwrap().farther(&by_bones);
        let (painted, unpainted) = (PAINTED.get(), UNPAINTED.get());
        let expected = [[1.0, 1.0 + painted * 2.0 / 3.0], [2.0, 1.0], [2.0 * unpainted, 1.0]];
        for (vertex, expected) in expected.iter().enumerate() {
            for (joint, expected) in expected.iter().enumerate() {
                assert!((found[(joint, vertex)] - expected).abs() < 1e-12, "{joint} {vertex}");
            }
        }
        assert!(Painted::of(&triangle(1)).is_none());
    }

    #[test]
    fn they_mislead_where_the_skin_of_a_joint_errs_twice_as_much() {
        let mut examples = triangle(1);
        examples.joint_weights = Some(vec![1.0, 0.0, 1.0, 0.0, 0.2, 0.8]);
        let painted = Painted::of(&examples).unwrap();
        let misleading = |near: [f64; 3], unseen| painted.misleading(&near, &[1.0; 3], unseen);
        let none: [usize; 0] = [];
        // One vertex may err more where the others make up for it.
        assert_eq!(misleading([2.5, 0.5, 1.5], 0.0), none);
        assert_eq!(misleading([1.0, 1.0, 4.1], 0.0), [1]);
        assert_eq!(misleading([0.5, 0.5, 4.1], 1.1), none, "of errors that do not count");
        assert_eq!(misleading([2.5, 1.5, 1.5], 0.0), [0, 1], "all together");
        assert_eq!(misleading([1.0, 3.0, 4.1], 0.0), [0, 1], "what is left");
        assert!(painted.follows(2, &[1]) && !painted.follows(0, &[1]));
    }
}
