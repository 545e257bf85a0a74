//! Nearest point of a surface, by a tree of boxes.

use nalgebra::Vector3;

/// Vertex indices of a triangle.
pub(super) type Triangle = [usize; 3];

/// Maximum number of triangles in a leaf.
const LEAF: usize = 4;

/// Nearest point of a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Foot {
    /// Triangle of the point.
    pub(super) triangle: usize,
    /// Barycentric coordinates in the triangle: none negative, sum 1.
    pub(super) shares: [f64; 3],
    /// Distance from the query point.
    pub(super) distance: f64,
}

/// Tree of boxes over the triangles of a surface. Every triangle has a positive area.
pub(super) struct Tree<'a> {
    positions: &'a [[f64; 3]],
    triangles: &'a [Triangle],
    /// Triangle indices; every box holds a range of this list.
    order: Vec<usize>,
    root: Boxed,
}

/// A box around triangles, and its content.
struct Boxed {
    low: Vector3<f64>,
    high: Vector3<f64>,
    content: Content,
}

enum Content {
    Leaf { from: usize, to: usize },
    Halves(Box<[Boxed; 2]>),
}

impl<'a> Tree<'a> {
    /// Builds the tree of a mesh.
    pub(super) fn new(positions: &'a [[f64; 3]], triangles: &'a [Triangle]) -> Self {
        let mut order: Vec<usize> = (0..triangles.len()).collect();
        let corners = |triangle: usize| triangles[triangle].map(|v| Vector3::from(positions[v]));
        let root = Boxed::new(&mut order, 0, &corners);
        Self { positions, triangles, order, root }
    }

    /// Returns the corners of a triangle in the rest pose.
    pub(super) fn corners(&self, triangle: usize) -> [Vector3<f64>; 3] {
        self.triangles[triangle].map(|vertex| Vector3::from(self.positions[vertex]))
    }

    /// Finds the nearest point of the surface; `None` if there is no triangle.
    pub(super) fn nearest(&self, point: &Vector3<f64>) -> Option<Foot> {
        let mut best = None;
        self.search(&self.root, point, &mut best);
        best
    }

    fn search(&self, boxed: &Boxed, point: &Vector3<f64>, best: &mut Option<Foot>) {
        if best.is_some_and(|best| boxed.distance(point) >= best.distance) {
            return;
        }
        match &boxed.content {
            Content::Leaf { from, to } => {
                for &triangle in &self.order[*from..*to] {
                    let corners = self.corners(triangle);
                    let shares = shares(point, &corners);
                    let foot: Vector3<f64> = corners.iter().zip(shares).map(|(c, s)| c * s).sum();
                    let distance = (foot - point).norm();
                    if best.is_none_or(|best| distance < best.distance) {
                        *best = Some(Foot { triangle, shares, distance });
                    }
                }
            }
            Content::Halves(halves) => {
                let [a, b] = halves.as_ref();
                let (near, far) =
                    if a.distance(point) <= b.distance(point) { (a, b) } else { (b, a) };
                self.search(near, point, best);
                self.search(far, point, best);
            }
        }
    }
}

impl Boxed {
    fn new(
        order: &mut [usize],
        from: usize,
        corners: &impl Fn(usize) -> [Vector3<f64>; 3],
    ) -> Self {
        let all = || order.iter().flat_map(|&triangle| corners(triangle));
        let low = all().fold(Vector3::repeat(f64::INFINITY), |a, b| a.inf(&b));
        let high = all().fold(Vector3::repeat(f64::NEG_INFINITY), |a, b| a.sup(&b));
        if order.len() <= LEAF {
            return Self { low, high, content: Content::Leaf { from, to: from + order.len() } };
        }
        let axis = (high - low).imax();
        let middle = |triangle: usize| corners(triangle).iter().map(|c| c[axis]).sum::<f64>();
        order.sort_by(|&a, &b| middle(a).total_cmp(&middle(b)).then(a.cmp(&b)));
        let half = order.len() / 2;
        let (first, second) = order.split_at_mut(half);
        let halves = [Self::new(first, from, corners), Self::new(second, from + half, corners)];
        Self { low, high, content: Content::Halves(Box::new(halves)) }
    }

    fn distance(&self, point: &Vector3<f64>) -> f64 {
        (point - point.sup(&self.low).inf(&self.high)).norm()
    }
}

/// Finds the point of a triangle nearest to a point, in barycentric coordinates (C. Ericson, *Real-Time Collision
/// Detection*, 5.1.5).
fn shares(point: &Vector3<f64>, [a, b, c]: &[Vector3<f64>; 3]) -> [f64; 3] {
    let (ab, ac) = (b - a, c - a);
    let toward = |from: &Vector3<f64>| {
        let to = point - from;
        (ab.dot(&to), ac.dot(&to))
    };
    let ((ab_a, ac_a), (ab_b, ac_b), (ab_c, ac_c)) = (toward(a), toward(b), toward(c));
    if ab_a <= 0.0 && ac_a <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    if ab_b >= 0.0 && ac_b <= ab_b {
        return [0.0, 1.0, 0.0];
    }
    if ac_c >= 0.0 && ab_c <= ac_c {
        return [0.0, 0.0, 1.0];
    }
    let area_c = ab_a * ac_b - ab_b * ac_a;
    if area_c <= 0.0 && ab_a >= 0.0 && ab_b <= 0.0 {
        let along = ab_a / (ab_a - ab_b);
        return [1.0 - along, along, 0.0];
    }
    let area_b = ab_c * ac_a - ab_a * ac_c;
    if area_b <= 0.0 && ac_a >= 0.0 && ac_c <= 0.0 {
        let along = ac_a / (ac_a - ac_c);
        return [1.0 - along, 0.0, along];
    }
    let area_a = ab_b * ac_c - ab_c * ac_b;
    if area_a <= 0.0 && ac_b >= ab_b && ab_c >= ac_c {
        let along = (ac_b - ab_b) / ((ac_b - ab_b) + (ab_c - ac_c));
        return [0.0, 1.0 - along, along];
    }
    let sum = area_a + area_b + area_c;
    [area_a / sum, area_b / sum, area_c / sum]
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    /// Computes the distance from the plane if the point lies above the triangle, else from the nearest side.
    fn distance(point: &Vector3<f64>, corners: &[Vector3<f64>; 3]) -> f64 {
        let [a, b, c] = corners;
        let normal = (b - a).cross(&(c - a)).normalize();
        let sides = [(a, b), (b, c), (c, a)];
        let inside = |&(from, to): &(&Vector3<f64>, &Vector3<f64>)| {
            normal.dot(&(to - from).cross(&(point - from))) >= 0.0
        };
        if sides.iter().all(inside) {
            return normal.dot(&(point - a)).abs();
        }
        let from_side = |(from, to): (&Vector3<f64>, &Vector3<f64>)| {
            let side = to - from;
            let along = (side.dot(&(point - from)) / side.norm_squared()).clamp(0.0, 1.0);
            (from + side * along - point).norm()
        };
        sides.map(from_side).into_iter().fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn the_nearest_point_has_the_least_distance_of_all_triangles() {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(11);
        let mut point = || -> [f64; 3] { std::array::from_fn(|_| random.random_range(-1.0..1.0)) };
        let positions: Vec<[f64; 3]> = (0..30).map(|_| point()).collect();
        let triangles: Vec<Triangle> = (0..10).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        let tree = Tree::new(&positions, &triangles);
        for _ in 0..100 {
            let point = Vector3::from(point()) * 1.5;
            let foot = tree.nearest(&point).unwrap();
            let all = (0..10).map(|k| distance(&point, &tree.corners(k)));
            let least = all.fold(f64::INFINITY, f64::min);
            assert!((foot.distance - least).abs() < 1e-12, "{} {least}", foot.distance);
            let sum: f64 = foot.shares.iter().sum();
            assert!((sum - 1.0).abs() < 1e-12 && foot.shares.iter().all(|&s| s >= 0.0));
        }
    }
}
