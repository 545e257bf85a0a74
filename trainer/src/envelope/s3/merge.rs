//! Greedy merging of triangles into patches; a patch follows one affine map (METHOD §1.7.1, S3 §3.1).
//!
//! Every triangle starts as a group with its exact map. Each step merges a group A into a neighbour B and refits B's
//! map. The pair is the cheapest by `E_{A→B} = Σ_{a∈A} |y_a - T_B x̂_a|²`. A group stores sums of outer products of its
//! points, and a merge adds these sums.

use super::surface::Surface;
use crate::numeric::affine::homogeneous;
use crate::numeric::columns::dot_by_lanes;
use nalgebra::Matrix4;
use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};

/// Number of coordinates used for the merging. The strongest coordinates come first and hold most of the motion.
const MERGE_RANK: usize = 40;

/// The merges in order; the first `T - P` merges leave P groups.
pub struct MergeTree {
    triangles: usize,
    merges: Vec<(u32, u32)>,
}

impl MergeTree {
    /// Merges all triangles of a surface. Calls `advance` after every merge.
    pub fn build(surface: &Surface<'_>, mut advance: impl FnMut()) -> Self {
        let count = surface.triangles.len();
        let mut groups = Patches::new(surface);
        let mut queue = BinaryHeap::new();
        for a in 0..count as u32 {
            groups.queue_moves_of(a, &mut queue);
        }
        let mut merges = Vec::with_capacity(count);
        while merges.len() + 1 < count {
            let Some(best) = queue.pop() else {
                // The remaining groups share no edge: make near groups neighbours.
                groups.join_components();
                for a in groups.alive() {
                    groups.queue_moves_of(a, &mut queue);
                }
                continue;
            };
            if !groups.0[best.from as usize].neighbours.contains(&best.into) {
                continue;
            }
            let error = groups.move_error(best.from, best.into);
            // B's map has changed since the move was queued: queue the move again with its current error.
            if error > best.error * 1.01 && queue.peek().is_some_and(|next| error > next.error) {
                queue.push(Move { error, ..best });
                continue;
            }
            for neighbour in groups.merge(best.from, best.into) {
                for (from, into) in [(neighbour, best.into), (best.into, neighbour)] {
                    queue.push(Move { error: groups.move_error(from, into), from, into });
                }
            }
            merges.push((best.from, best.into));
            advance();
        }
        Self { triangles: count, merges }
    }

    /// Returns the group of each triangle after merging down to `count` groups, numbered from 0.
    pub fn cut(&self, count: usize) -> Vec<usize> {
        let mut into: Vec<u32> = (0..self.triangles as u32).collect();
        for &(a, b) in &self.merges[..self.triangles.saturating_sub(count).min(self.merges.len())] {
            into[a as usize] = b;
        }
        let mut number = BTreeMap::new();
        (0..self.triangles)
            .map(|triangle| {
                let mut group = triangle as u32;
                while into[group as usize] != group {
                    group = into[group as usize];
                }
                let next = number.len();
                *number.entry(group).or_insert(next)
            })
            .collect()
    }
}

/// A possible merge of group `from` into group `into`.
#[derive(Clone, Copy)]
struct Move {
    error: f64,
    from: u32,
    into: u32,
}

impl Ord for Move {
    fn cmp(&self, other: &Self) -> Ordering {
        // The heap returns its greatest element first: the least error, then the lowest numbers.
        let key = |m: &Self| (m.from, m.into);
        other.error.total_cmp(&self.error).then_with(|| key(other).cmp(&key(self)))
    }
}
impl PartialOrd for Move {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl PartialEq for Move {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Move {}

/// Groups of triangles; a merged group is empty.
struct Patches(Vec<Patch>);

/// A group of triangles.
#[derive(Default)]
struct Patch {
    /// Σ h hᵀ.
    points: Matrix4<f64>,
    /// Σ h yᵀ: four rows.
    targets: Vec<f64>,
    /// Σ |y|².
    energy: f64,
    /// Fitted map, as `targets`; empty after the group is merged into another.
    map: Vec<f64>,
    neighbours: BTreeSet<u32>,
    centre: [f64; 3],
}

impl Patch {
    fn add_point(&mut self, x: &[f64; 3], y: &[f64], counts: f64) {
        let h = homogeneous(x);
        self.points += h * h.transpose() * counts;
        for (row, target) in self.targets.chunks_exact_mut(y.len()).enumerate() {
            for (sum, value) in target.iter_mut().zip(y) {
                *sum += counts * h[row] * value;
            }
        }
        self.energy += counts * y.iter().map(|v| v * v).sum::<f64>();
    }

    fn refit(&mut self) {
        let inverse = regular_inverse(&self.points);
        let rank = self.targets.len() / 4;
        self.map = vec![0.0; 4 * rank];
        for row in 0..4 {
            let out = &mut self.map[row * rank..(row + 1) * rank];
            for column in 0..4 {
                let factor = inverse[(row, column)];
                for (o, t) in out.iter_mut().zip(&self.targets[column * rank..]) {
                    *o += factor * t;
                }
            }
        }
    }
}

impl Patches {
    fn new(surface: &Surface<'_>) -> Self {
        let rank = surface.vertices.nrows().min(MERGE_RANK);
        let patch = |(triangle, neighbours): (usize, BTreeSet<u32>)| {
            let corners = surface.triangles[triangle];
            let (centre, targets) = (surface.rest[corners[0]], vec![0.0; 4 * rank]);
            let mut patch = Patch { targets, neighbours, centre, ..Patch::default() };
            let counts = surface.triangle_importance(triangle);
            for corner in corners {
                let y = &surface.vertices.col_as_slice(corner)[..rank];
                patch.add_point(&surface.rest[corner], y, counts);
            }
            // A fourth point outside the plane makes the map of a flat group unique.
            let normal = surface.rest_normals[triangle];
            let tip = std::array::from_fn(|axis| centre[axis] + normal[axis]);
            let moved: Vec<f64> = (0..rank)
                .map(|k| surface.vertices[(k, corners[0])] + surface.normals[(k, triangle)])
                .collect();
            patch.add_point(&tip, &moved, counts);
            patch.refit();
            patch
        };
        Self(surface.neighbours().into_iter().enumerate().map(patch).collect())
    }

    /// Returns Σ |y - T_B x|² over the points of A.
    fn move_error(&self, a: u32, b: u32) -> f64 {
        let (a, map) = (&self.0[a as usize], &self.0[b as usize].map);
        let rank = map.len() / 4;
        let row = |r: usize| r * rank..(r + 1) * rank;
        let mut error = a.energy;
        for r in 0..4 {
            let own = &map[row(r)];
            error -= 2.0 * dot_by_lanes(own, &a.targets[row(r)]);
            for c in 0..=r {
                let twice = if c == r { 1.0 } else { 2.0 };
                error += twice * a.points[(r, c)] * dot_by_lanes(own, &map[row(c)]);
            }
        }
        error.max(0.0)
    }

    fn queue_moves_of(&self, a: u32, queue: &mut BinaryHeap<Move>) {
        for &b in &self.0[a as usize].neighbours {
            queue.push(Move { error: self.move_error(a, b), from: a, into: b });
        }
    }

    /// Merges A into B; returns the neighbours that are new for B.
    fn merge(&mut self, a: u32, b: u32) -> Vec<u32> {
        let from = std::mem::take(&mut self.0[a as usize]);
        let into = &mut self.0[b as usize];
        into.points += from.points;
        for (sum, value) in into.targets.iter_mut().zip(&from.targets) {
            *sum += value;
        }
        into.energy += from.energy;
        into.refit();
        let mut fresh = Vec::new();
        for neighbour in from.neighbours {
            self.0[neighbour as usize].neighbours.remove(&a);
            if neighbour != b && self.0[b as usize].neighbours.insert(neighbour) {
                self.0[neighbour as usize].neighbours.insert(b);
                fresh.push(neighbour);
            }
        }
        fresh
    }

    /// Lists the groups that are not merged into another.
    fn alive(&self) -> Vec<u32> {
        (0..self.0.len() as u32).filter(|&g| !self.0[g as usize].map.is_empty()).collect()
    }

    /// Makes each remaining group a neighbour of the groups nearest to it.
    fn join_components(&mut self) {
        const NEAREST: usize = 8;
        let alive = self.alive();
        for &a in &alive {
            let distance = |b: u32| -> f64 {
                let [p, q] = [a, b].map(|group| self.0[group as usize].centre);
                (0..3).map(|k| (p[k] - q[k]).powi(2)).sum()
            };
            let mut others: Vec<(f64, u32)> =
                alive.iter().filter(|&&b| b != a).map(|&b| (distance(b), b)).collect();
            others.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
            for &(_, b) in others.iter().take(NEAREST) {
                self.0[a as usize].neighbours.insert(b);
                self.0[b as usize].neighbours.insert(a);
            }
        }
    }
}

/// Inverts Σ h hᵀ of a group, with a ridge as small as rounding errors.
pub(super) fn regular_inverse(gram: &Matrix4<f64>) -> Matrix4<f64> {
    let ridge = 1e-12 * gram.trace() + f64::MIN_POSITIVE;
    (gram + Matrix4::identity() * ridge).try_inverse().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::examples::Importance;
    use crate::numeric::basis::basis;
    use faer::Mat;

    /// Returns a strip of quads along x over a few frames. Its right half rotates about the middle.
    fn strip() -> (Vec<[f64; 3]>, Vec<[usize; 3]>, Mat<f64>) {
        let rest: Vec<[f64; 3]> = (0..18)
            .map(|i| [f64::from(i / 2), f64::from(i % 2), 0.05 * f64::from(i % 3)])
            .collect();
        let triangles = (0..8)
            .flat_map(|k| [[2 * k, 2 * k + 2, 2 * k + 1], [2 * k + 1, 2 * k + 2, 2 * k + 3]])
            .collect();
        let moved = Mat::from_fn(3 * 5, rest.len(), |row, vertex| {
            let [x, y, z] = rest[vertex];
            let angle = 0.3 * (row / 3) as f64;
            let beyond = (x - 4.0).max(0.0);
            [x - beyond + beyond * angle.cos(), y, z + beyond * angle.sin()][row % 3]
        });
        (rest, triangles, moved)
    }

    #[test]
    fn two_halves_that_rotate_against_each_other_become_two_groups() {
        let (rest, triangles, moved) = strip();
        let basis = basis(&moved);
        let surface = Surface::new(&rest, triangles.clone(), &moved, &basis, Importance::UNIFORM);
        let groups = MergeTree::build(&surface, || ()).cut(2);
        let left = groups[0];
        for (triangle, group) in groups.iter().enumerate() {
            assert_eq!(*group == left, triangle < 8, "triangle {triangle} of {groups:?}");
        }
    }

    #[test]
    fn a_cut_leaves_as_many_groups_as_asked_for() {
        let (rest, triangles, moved) = strip();
        let basis = basis(&moved);
        let surface = Surface::new(&rest, triangles.clone(), &moved, &basis, Importance::UNIFORM);
        let tree = MergeTree::build(&surface, || ());
        for count in 1..=triangles.len() {
            let groups: BTreeSet<usize> = tree.cut(count).into_iter().collect();
            assert_eq!(groups, (0..count).collect());
        }
    }

    #[test]
    fn parts_without_a_common_edge_are_merged() {
        let (rest, triangles, moved) = strip();
        let apart = [triangles[0], triangles[5], triangles[10], triangles[15]];
        let basis = basis(&moved);
        let surface = Surface::new(&rest, apart.to_vec(), &moved, &basis, Importance::UNIFORM);
        let groups = MergeTree::build(&surface, || ()).cut(1);
        assert_eq!(groups, vec![0; 4]);
    }
}
