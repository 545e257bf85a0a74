//! Faces with any number of corners.

use nalgebra::Vector3;

/// Largest number of corners of a polygon that is clipped. Clipping takes the square of that number, and a larger
/// polygon is usually the cap of a tube, which a fan splits well.
const CLIPPED_MAX: usize = 1024;

/// Share of a polygon's area below which a corner counts as straight.
const FLAT: f64 = 1e-9;

/// Polygons, as vertex indices of their corners.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(in crate::formats) struct Polygons {
    corners: Vec<usize>,
    /// End of each polygon in `corners`.
    ends: Vec<usize>,
}

impl Polygons {
    /// Adds a polygon.
    pub(in crate::formats) fn push(&mut self, corners: impl IntoIterator<Item = usize>) {
        self.corners.extend(corners);
        self.ends.push(self.corners.len());
    }

    /// Returns the corners of each polygon, in order.
    pub(in crate::formats) fn iter(&self) -> impl Iterator<Item = &[usize]> {
        let begins = std::iter::once(0).chain(self.ends.iter().copied());
        begins.zip(&self.ends).map(|(begin, &end)| &self.corners[begin..end])
    }

    /// Splits the polygons into triangles.
    ///
    /// A quad becomes corners 0 1 2 and 0 2 3. A larger polygon is split by clipping its ears, seen along its normal,
    /// so that concave polygons keep their outline. A polygon without area, or one that crosses itself, becomes a fan.
    /// A polygon of fewer than three corners disappears.
    ///
    /// # Panics
    /// If a vertex index is not below the length of `positions`.
    pub(in crate::formats) fn triangles(&self, positions: &[[f64; 3]]) -> Vec<[usize; 3]> {
        let corners = self.corner_triangles(positions);
        corners.into_iter().map(|triangle| triangle.map(|corner| self.corners[corner])).collect()
    }

    /// Splits the polygons as [`Polygons::triangles`] does, into corner indices instead of vertex indices.
    ///
    /// # Panics
    /// If a vertex index is not below the length of `positions`.
    pub(in crate::formats) fn corner_triangles(&self, positions: &[[f64; 3]]) -> Vec<[usize; 3]> {
        let mut triangles = Vec::new();
        let mut first = 0;
        for corners in self.iter() {
            let begin = triangles.len();
            match corners.len() {
                5..=CLIPPED_MAX => clip(corners, positions, &mut triangles),
                len => fan(&(0..len).collect::<Vec<_>>(), &mut triangles),
            }
            triangles[begin..].as_flattened_mut().iter_mut().for_each(|place| *place += first);
            first += corners.len();
        }
        triangles
    }

    /// Returns the vertex of every corner, in order.
    pub(in crate::formats) fn corners(&self) -> &[usize] {
        &self.corners
    }
}

/// Splits a polygon into the triangles between its first corner and every further edge.
fn fan(corners: &[usize], triangles: &mut Vec<[usize; 3]>) {
    for pair in corners.windows(2).skip(1) {
        triangles.push([corners[0], pair[0], pair[1]]);
    }
}

/// Splits a polygon by clipping its ears one after the other; the rest becomes a fan once no ear is left.
///
/// - `corners`: vertex of each corner.
fn clip(corners: &[usize], positions: &[[f64; 3]], triangles: &mut Vec<[usize; 3]>) {
    let (flat, twice_area) = flatten(corners, positions);
    let slack = FLAT * twice_area;
    // The remaining corners, as places in the polygon.
    let mut ring: Vec<usize> = (0..corners.len()).collect();
    let mut at = 0;
    while ring.len() > 3 {
        let len = ring.len();
        let ear = (at..at + len).map(|at| at % len).find(|&at| is_ear(&flat, &ring, at, slack));
        let Some(ear) = ear else { break };
        triangles.push(around(&ring, ear));
        ring.remove(ear);
        at = ear;
    }
    fan(&ring, triangles);
}

/// Projects a polygon along the axis nearest to its normal, so that it turns left; also returns twice its projected
/// area.
fn flatten(corners: &[usize], positions: &[[f64; 3]]) -> (Vec<[f64; 2]>, f64) {
    let relative =
        |vertex: usize| Vector3::from(positions[vertex]) - Vector3::from(positions[corners[0]]);
    let mut normal = Vector3::zeros();
    for (place, &corner) in corners.iter().enumerate() {
        normal += relative(corner).cross(&relative(corners[(place + 1) % corners.len()]));
    }
    let axis = normal.iamax();
    let (mut u, mut v) = ((axis + 1) % 3, (axis + 2) % 3);
    if normal[axis] < 0.0 {
        (u, v) = (v, u);
    }
    let project = |&corner: &usize| [relative(corner)[u], relative(corner)[v]];
    (corners.iter().map(project).collect(), normal[axis].abs())
}

/// Returns whether a corner is an ear: the corner turns left, and its triangle contains no corner that turns right.
fn is_ear(flat: &[[f64; 2]], ring: &[usize], at: usize, slack: f64) -> bool {
    let turn = |at: usize| {
        let [a, b, c] = around(ring, at).map(|place| flat[place]);
        cross(a, b, c)
    };
    let [a, b, c] = around(ring, at).map(|place| flat[place]);
    let inside = |p| [(a, b), (b, c), (c, a)].iter().all(|&(a, b)| cross(a, b, p) >= -slack);
    turn(at) > slack
        && (0..ring.len()).all(|other| {
            let p = flat[ring[other]];
            [a, b, c].contains(&p) || turn(other) > slack || !inside(p)
        })
}

/// Returns a corner of the ring between its two neighbours.
fn around(ring: &[usize], at: usize) -> [usize; 3] {
    let len = ring.len();
    [ring[(at + len - 1) % len], ring[at], ring[(at + 1) % len]]
}

/// Returns twice the area of a triangle, positive if it turns left.
fn cross(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

#[cfg(test)]
mod tests {
    use nalgebra::Rotation3;

    use super::*;

    fn triangles(outline: &[[f64; 3]]) -> Vec<[usize; 3]> {
        let mut polygons = Polygons::default();
        polygons.push(0..outline.len());
        polygons.triangles(outline)
    }

    /// Returns the signed areas of the triangles, seen along a direction.
    fn areas(triangles: &[[usize; 3]], positions: &[[f64; 3]], along: [f64; 3]) -> Vec<f64> {
        let area = |&triangle: &[usize; 3]| {
            let [a, b, c] = triangle.map(|vertex| Vector3::from(positions[vertex]));
            (b - a).cross(&(c - a)).dot(&Vector3::from(along)) / 2.0
        };
        triangles.iter().map(area).collect()
    }

    /// Rotates points of the plane z = 0 by arbitrary angles; also returns the rotated normal.
    fn turned(points: &[[f64; 2]]) -> (Vec<[f64; 3]>, [f64; 3]) {
        let turn = Rotation3::from_euler_angles(0.7, -1.9, 2.3);
        let at = |&[x, y]: &[f64; 2]| (turn * Vector3::new(x, y, 0.0)).into();
        (points.iter().map(at).collect(), (turn * Vector3::z()).into())
    }

    #[test]
    fn triangles_and_quads_are_split_as_everywhere() {
        let mut polygons = Polygons::default();
        for corners in [&[3, 1, 2][..], &[0, 1, 2, 3], &[], &[1], &[1, 2]] {
            polygons.push(corners.iter().copied());
        }
        // The quad is concave at its corner 3. It is still split along its first diagonal.
        let positions = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [1.0, 1.0, 0.0]];
        assert_eq!(polygons.triangles(&positions), [[3, 1, 2], [0, 1, 2], [0, 2, 3]]);
        assert_eq!(polygons.iter().map(<[usize]>::len).collect::<Vec<_>>(), [3, 4, 0, 1, 2]);
    }

    #[test]
    fn concave_polygons_keep_their_outline_in_any_plane() {
        let spiral = |corner: usize, len: usize| {
            let (turn, out) = match corner < len / 2 {
                true => (corner, 1.0),
                false => (len - 1 - corner, 0.8),
            };
            let (angle, radius) = (turn as f64 * 0.4, 1.0 + turn as f64);
            [out * radius * angle.cos(), out * radius * angle.sin()]
        };
        let star = |corner: usize| {
            let (angle, radius) = (corner as f64 * std::f64::consts::PI / 7.0, (corner % 2) as f64);
            [(1.0 + 4.0 * radius) * angle.cos(), (1.0 + 4.0 * radius) * angle.sin()]
        };
        let outlines = [
            vec![[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [2.0, 1.0], [0.0, 3.0]],
            vec![[0., 0.], [3., 0.], [3., 3.], [2., 3.], [2., 1.], [1., 1.], [1., 3.], [0., 3.]],
            (0..14).map(star).collect(),
            (0..40).map(|corner| spiral(corner, 40)).collect(),
        ];
        for outline in outlines {
            // The shoelace formula needs no triangles.
            let next = outline.iter().cycle().skip(1);
            let twice: f64 = outline.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum();
            for reversed in [false, true] {
                let mut outline = outline.clone();
                if reversed {
                    outline.reverse();
                }
                let (positions, normal) = turned(&outline);
                let found = triangles(&positions);
                assert_eq!(found.len(), outline.len() - 2);
                let areas = areas(&found, &positions, normal);
                let sign = if reversed { -1.0 } else { 1.0 } * twice.signum();
                assert!(areas.iter().all(|area| area * sign > 1e-6), "{areas:?}");
                let sum: f64 = areas.iter().map(|area| area.abs()).sum();
                assert!((sum - twice.abs() / 2.0).abs() < 1e-9 * sum, "{sum}, {twice}");
            }
        }
    }

    #[test]
    fn a_corner_on_an_edge_makes_no_triangle_without_area() {
        let square = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
        for side in 0..4 {
            let mut outline = square.to_vec();
            let (a, b) = (square[side], square[(side + 1) % 4]);
            outline.insert(side + 1, [(a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0]);
            let (positions, normal) = turned(&outline);
            let areas = areas(&triangles(&positions), &positions, normal);
            assert!(areas.len() == 3 && areas.iter().all(|&area| area > 0.5), "{areas:?}");
        }
    }

    #[test]
    fn polygons_without_area_or_with_crossings_become_as_many_triangles() {
        let star = |corner: usize| {
            let angle = corner as f64 * 0.8 * std::f64::consts::PI;
            [angle.cos(), angle.sin(), 0.0]
        };
        let fanned = [[0, 1, 2], [0, 2, 3], [0, 3, 4]];
        assert_eq!(triangles(&[[1.0, 2.0, 3.0]; 5]), fanned);
        assert_eq!(triangles(&[[f64::NAN; 3]; 5]), fanned);
        assert_eq!(triangles(&[[1e300, -1e300, 0.0]; 5]), fanned);
        let line: Vec<[f64; 3]> = (0..5).map(|corner| [corner as f64, 0.0, 0.0]).collect();
        assert_eq!(triangles(&line), fanned);
        assert_eq!(triangles(&(0..5).map(star).collect::<Vec<_>>()).len(), 3);
        assert_eq!(triangles(&vec![[0.0; 3]; CLIPPED_MAX + 1]).len(), CLIPPED_MAX - 1);
    }
}
