//! Fans: the faces around a vertex.

use crate::mesh::{Surface, same_normal};
use nalgebra::{Matrix2, Vector2, Vector3};

/// Minimum ratio of the singular values of the summed maps of a fan at rest. Below it, the faces span no plane.
const FLAT: f64 = 1e-6;

/// Corners of faces, and the coefficients of their edges in the images of a plane's two axes.
pub(super) type Images = Vec<(usize, Vector2<f64>)>;

/// The faces of a vertex. Several vertices can have one position; each of them then has a part of the faces around the
/// position.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fan {
    /// Index of the position of the vertex.
    pub centre: usize,
    /// The two other corners of each face, in winding order.
    pub faces: Vec<[usize; 2]>,
}

impl Fan {
    /// Lists the fans of V vertices; a fan holds all faces around its vertex.
    pub fn all(triangles: &[[usize; 3]], vertex_len: usize) -> Vec<Self> {
        let mut fans: Vec<Self> =
            (0..vertex_len).map(|centre| Self { centre, faces: Vec::new() }).collect();
        for &[a, b, c] in triangles {
            for [centre, next, last] in [[a, b, c], [b, c, a], [c, a, b]] {
                fans[centre].faces.push([next, last]);
            }
        }
        fans
    }

    /// Lists the fans of the engine's vertices, E: all faces around the position. If normals are authored, a fan holds
    /// only the faces whose corner at the position has the vertex's normal.
    pub fn of(surface: &Surface<'_>) -> Vec<Self> {
        let whole = Self::all(surface.triangles, surface.positions.len());
        let Some(normals) = surface.authored_normals() else { return surface.copied(&whole) };
        // Engine vertex of each face's corner at the centre, in the order of the faces of a fan.
        let mut corners: Vec<Vec<usize>> = vec![Vec::new(); whole.len()];
        for &corner in surface.engine_triangles().as_flattened() {
            corners[surface.copy_of(corner)].push(corner);
        }
        let side = |copy: usize| {
            let Self { centre, faces } = &whole[surface.copy_of(copy)];
            let own = |corner: &usize| same_normal(&normals[copy], &normals[*corner]);
            let faces = faces.iter().zip(&corners[*centre]).filter(|(_, corner)| own(corner));
            Self { centre: *centre, faces: faces.map(|(face, _)| *face).collect() }
        };
        (0..surface.engine_len()).map(side).collect()
    }

    /// Lists the two edges of each face that start at the vertex.
    pub fn edges(
        &self,
        at: impl Fn(usize) -> Vector3<f64>,
    ) -> impl Iterator<Item = [Vector3<f64>; 2]> {
        let centre = at(self.centre);
        self.faces.iter().map(move |face| face.map(|corner| at(corner) - centre))
    }

    /// Sums the normals of the faces; the length of a normal is twice the area of its face.
    pub fn normal(&self, at: impl Fn(usize) -> Vector3<f64>) -> Vector3<f64> {
        self.edges(at).map(|[a, b]| a.cross(&b)).sum()
    }

    /// Sums twice the areas of the faces.
    pub(super) fn area(&self, at: impl Fn(usize) -> Vector3<f64>) -> f64 {
        self.edges(at).map(|[a, b]| a.cross(&b).norm()).sum()
    }

    /// Computes coefficients for the images of a plane's two axes. At positions y, the image of axis k is
    /// `Σ c_k (y - y_centre)` over the corners. The map is the mean of the faces' maps, weighted by area at rest. It is
    /// scaled to map the in-plane part of each axis to itself at rest. `None` if the faces at rest span no plane.
    pub fn images(
        &self,
        at_rest: impl Fn(usize) -> Vector3<f64>,
        axes: &[Vector3<f64>; 2],
    ) -> Option<Images> {
        let mut edges: Vec<(usize, Vector2<f64>)> = Vec::new();
        let mut sum = Matrix2::zeros();
        for (corners, [a, b]) in self.faces.iter().zip(self.edges(at_rest)) {
            let Some(normal) = a.cross(&b).try_normalize(0.0) else { continue };
            for (corner, edge, dual) in
                [(corners[0], a, b.cross(&normal)), (corners[1], b, normal.cross(&a))]
            {
                let share = axes.map(|axis| axis.dot(&dual)).into();
                let flat = Vector2::new(axes[0].dot(&edge), axes[1].dot(&edge));
                sum += share * flat.transpose();
                match edges.iter_mut().find(|known| known.0 == corner) {
                    Some(known) => known.1 += share,
                    None => edges.push((corner, share)),
                }
            }
        }
        let spread = sum.singular_values();
        if spread.min() <= FLAT * spread.max() {
            return None;
        }
        let inverse = sum.try_inverse()?;
        Some(edges.into_iter().map(|(corner, share)| (corner, inverse * share)).collect())
    }

    /// Computes the images of a plane's axes at posed positions, without their part along a normal.
    ///
    /// - `images`: coefficients, as [`Fan::images`] returns them.
    pub fn carried(
        &self,
        images: &[(usize, Vector2<f64>)],
        at: impl Fn(usize) -> Vector3<f64>,
        normal: &Vector3<f64>,
    ) -> [Vector3<f64>; 2] {
        let centre = at(self.centre);
        [0, 1].map(|k| {
            let image: Vector3<f64> =
                images.iter().map(|(corner, c)| (at(*corner) - centre) * c[k]).sum();
            image - normal * normal.dot(&image)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::EngineMesh;
    use nalgebra::Matrix3;

    /// A corner of a cube, cut open: three faces around vertex 0 and a border.
    const CORNERS: [[f64; 3]; 5] =
        [[0.2, 0.1, 0.0], [1.0, 0.0, 0.1], [0.6, 0.9, -0.2], [-0.7, 0.8, 0.1], [-0.9, -0.3, 0.0]];
    const TRIANGLES: [[usize; 3]; 3] = [[0, 1, 2], [2, 3, 0], [3, 4, 0]];

    fn corner(vertex: usize) -> Vector3<f64> {
        CORNERS[vertex].into()
    }

    #[test]
    fn every_face_is_in_the_fans_of_its_corners() {
        let fans = Fan::all(&TRIANGLES, 6);
        assert_eq!(fans[0].faces, [[1, 2], [2, 3], [3, 4]]);
        assert_eq!(fans[2], Fan { centre: 2, faces: vec![[0, 1], [3, 0]] });
        assert_eq!(fans[5], Fan { centre: 5, faces: Vec::new() });
        let expected: Vector3<f64> = TRIANGLES
            .map(|[a, b, c]| (corner(b) - corner(a)).cross(&(corner(c) - corner(a))))
            .iter()
            .sum();
        assert!((fans[0].normal(corner) - expected).norm() < 1e-12);
    }

    #[test]
    fn hard_edges_split_the_faces_of_a_vertex_and_seams_do_not() {
        let positions = CORNERS;
        let mut engine = EngineMesh {
            copy_of: vec![0, 0, 0, 1, 2, 3, 3, 4],
            triangles: vec![[0, 3, 4], [4, 5, 1], [6, 7, 2]],
            normals: None,
            tangents: None,
            uv: None,
        };
        let fans = |engine: &EngineMesh| {
            let triangles = &TRIANGLES;
            Fan::of(&Surface { positions: &positions, triangles, engine: Some(engine) })
        };
        let whole = fans(&engine);
        assert!(whole[..3].iter().all(|fan| fan.faces == [[1, 2], [2, 3], [3, 4]]));
        // A hard edge separates the third face of vertex 0 from the others.
        let (up, back) = ([0.0, 0.0, 1.0], [0.0, 1.0, 0.0]);
        engine.normals = Some(vec![up, up, back, up, up, up, back, back]);
        let sides = fans(&engine);
        for copy in [0, 1] {
            assert_eq!(sides[copy], Fan { centre: 0, faces: vec![[1, 2], [2, 3]] });
        }
        assert_eq!(sides[2].faces, [[3, 4]]);
        assert_eq!([&sides[5].faces, &sides[6].faces], [&vec![[0, 2]], &vec![[4, 0]]]);
    }

    fn image(images: &Images, at: &dyn Fn(usize) -> Vector3<f64>, k: usize) -> Vector3<f64> {
        images.iter().map(|(corner, c)| (at(*corner) - at(0)) * c[k]).sum()
    }

    #[test]
    fn the_images_of_the_axes_are_those_of_a_linear_map() {
        let fan = &Fan::all(&TRIANGLES, 5)[0];
        let axes = [Vector3::new(1.0, 0.0, 0.1).normalize(), Vector3::y()];
        let images = fan.images(corner, &axes).unwrap();
        let bend = Matrix3::new(0.5, -0.2, 0.0, 0.3, 1.4, 0.0, 0.2, -0.1, 0.0);
        let posed = |v: usize| {
            let [x, y] = [0, 1].map(|axis| axes[axis].dot(&corner(v)));
            bend * Vector3::new(x, y, 0.0)
        };
        for k in 0..2 {
            assert!((image(&images, &posed, k) - bend.column(k)).norm() < 1e-12);
        }
    }

    #[test]
    fn the_images_of_a_flat_fan_are_the_area_weighted_mean_of_its_faces_maps() {
        let fan = &Fan::all(&TRIANGLES, 5)[0];
        let flat = |v: usize| Vector3::new(corner(v).x, corner(v).y, 0.0);
        let posed = |v: usize| flat(v).map(|x| x * x - 0.3 * x) + Vector3::z() * v as f64;
        let images = fan.images(flat, &[Vector3::x(), Vector3::y()]).unwrap();
        let (mut sum, mut areas) = (nalgebra::Matrix3x2::zeros(), 0.0);
        for &[a, b] in &fan.faces {
            let plane = [a, b].map(|v| (flat(v) - flat(0)).xy());
            let plane = Matrix2::from_columns(&plane);
            let space = nalgebra::Matrix3x2::from_columns(&[a, b].map(|v| posed(v) - posed(0)));
            sum += space * plane.try_inverse().unwrap() * plane.determinant();
            areas += plane.determinant();
        }
        for k in 0..2 {
            let expected = sum.column(k) / areas;
            assert!((image(&images, &posed, k) - expected).norm() < 1e-12);
        }
    }

    #[test]
    fn the_map_of_long_thin_faces_is_not_turned_over() {
        // A strip of width 0.2 and length 10. Both ends move to the same side by 0.5.
        let ring = |y: f64| [-0.1, 0.0, 0.1].map(|x| Vector3::new(x, y, 0.0));
        let at = [ring(0.0), ring(5.0), ring(-5.0)].concat();
        let faces = [[6, 7, 1], [6, 1, 0], [7, 2, 1], [0, 1, 3], [1, 4, 3], [1, 2, 4]];
        let fan = &Fan::all(&faces, 9)[1];
        let images = fan.images(|v| at[v], &[Vector3::x(), Vector3::y()]).unwrap();
        let swung = |v: usize| at[v] + Vector3::x() * if v > 2 { 0.5 } else { 0.0 };
        let of = |k: usize| {
            let end = |(v, c): &(usize, Vector2<f64>)| (swung(*v) - swung(1)) * c[k];
            images.iter().map(end).sum::<Vector3<f64>>()
        };
        assert!(of(0).cross(&of(1)).z > 0.5, "{} {}", of(0), of(1));
    }

    #[test]
    fn edges_that_span_no_plane_have_no_images() {
        let axes = [Vector3::x(), Vector3::y()];
        let along_x = |vertex: usize| Vector3::x() * (vertex as f64);
        let fans = Fan::all(&TRIANGLES, 6);
        assert!(fans[0].images(along_x, &axes).is_none());
        assert!(fans[5].images(along_x, &axes).is_none());
        // A single face spans a plane.
        assert!(fans[1].images(corner, &axes).is_some());
    }
}
