//! Authored normals that are not those of the faces.

use super::fan::Fan;
use crate::numeric::affine;
use nalgebra::{Matrix3, Vector3};

/// An authored normal of a vertex, carried by the faces around it.
///
/// Each face k of area A has a map D: it takes the edges to the posed edges, and the unit normal n to the posed one. The posed
/// normal is `Σ A cof(D) (n + δ)`, where δ makes the sum at rest as long as `Σ A n` and parallel to the authored normal. At δ = 0
/// this is the sum of the posed faces' normals by area. No face is inverted, so thin faces are safe (METHOD §1.8).
pub(super) struct LeaningNormal {
    /// δ along the edges and the normal of each face.
    faces: Vec<[f64; 3]>,
}

impl LeaningNormal {
    /// Measures an authored unit normal against the faces of a vertex.
    pub(super) fn new(
        fan: &Fan,
        at_rest: impl Fn(usize) -> Vector3<f64>,
        authored: &Vector3<f64>,
    ) -> Self {
        let faces: Vec<_> = fan.edges(at_rest).map(|[a, b]| [a, b, a.cross(&b)]).collect();
        let sum: Vector3<f64> = faces.iter().map(|face| face[2]).sum();
        let areas: f64 = faces.iter().map(|face| face[2].norm()).sum();
        let lean = (authored * sum.norm() - sum).unscale(areas.max(f64::MIN_POSITIVE));
        let along = |[a, b, normal]: &[Vector3<f64>; 3]| {
            let normal = normal.try_normalize(0.0).unwrap_or_default();
            [a, b, &normal].map(|axis| axis.dot(&lean))
        };
        Self { faces: faces.iter().map(along).collect() }
    }

    /// Computes the unit normal of posed faces; `None` where it vanishes.
    pub(super) fn posed(
        &self,
        fan: &Fan,
        at: impl Fn(usize) -> Vector3<f64>,
    ) -> Option<Vector3<f64>> {
        let carried = |([a, b], [along_a, along_b, up]): ([Vector3<f64>; 2], &[f64; 3])| {
            let area = a.cross(&b);
            let normal = area.try_normalize(0.0).unwrap_or_default();
            area * (1.0 + up) + b.cross(&normal) * *along_a + normal.cross(&a) * *along_b
        };
        let sum: Vector3<f64> = fan.edges(at).zip(&self.faces).map(carried).sum();
        sum.try_normalize(0.0)
    }
}

/// How a frame t, b = n x t of a vertex leans against the surface around it at rest.
pub(super) struct Lean {
    /// Axes of the surface's plane.
    pub(super) plane: [Vector3<f64>; 2],
    /// t and b along these and along the surface's normal.
    axes: [Vector3<f64>; 2],
}

impl Lean {
    /// Measures a frame against the faces of a vertex; `None` where they have no area at rest.
    pub(super) fn new(
        fan: &Fan,
        at_rest: impl Fn(usize) -> Vector3<f64>,
        frame: &[Vector3<f64>; 2],
    ) -> Option<Self> {
        let normal = fan.normal(at_rest).try_normalize(0.0)?;
        let along = affine::tangent(&normal);
        let plane = [along, normal.cross(&along)];
        let surface = Matrix3::from_columns(&[plane[0], plane[1], normal]).transpose();
        Some(Self { plane, axes: frame.map(|axis| surface * axis) })
    }

    /// Gives the images of t and b under the map that takes the plane's axes and the surface's unit normal to these.
    /// Their cross product is what the map's cofactors make of n.
    pub(super) fn images(
        &self,
        [u, v]: [Vector3<f64>; 2],
        normal: Vector3<f64>,
    ) -> [Vector3<f64>; 2] {
        self.axes.map(|axis| u * axis.x + v * axis.y + normal * axis.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_leaning_normal_moves_by_the_cofactors_of_the_surface_s_map() {
        let corners: [Vector3<f64>; 4] = [
            Vector3::zeros(),
            Vector3::new(1.0, 0.1, 0.0),
            Vector3::new(-0.2, 0.9, 0.0),
            Vector3::new(-0.8, -0.7, 0.0),
        ];
        let fan = &Fan::all(&[[0, 1, 2], [0, 2, 3], [0, 3, 1]], 4)[0];
        let n = Vector3::new(0.5, -0.2, 0.7).normalize();
        let t = affine::tangent(&n);
        let rest = |v: usize| corners[v];
        let lean = Lean::new(fan, rest, &[t, n.cross(&t)]).unwrap();
        // A map that keeps the surface's normal of length 1 and square to what it makes of the plane.
        let turn = nalgebra::Rotation3::from_euler_angles(0.3, -1.1, 2.0).into_inner();
        let map = turn * Matrix3::new(1.3, 0.4, 0.0, -0.2, 0.8, 0.0, 0.0, 0.0, 1.0);
        let posed = |v: usize| map * corners[v];
        let images = fan.images(rest, &lean.plane).unwrap();
        let image = |k: usize| {
            images.iter().map(|(v, c)| (posed(*v) - posed(0)) * c[k]).sum::<Vector3<f64>>()
        };
        let normal = fan.normal(posed).normalize();
        let [along, across] = lean.images([image(0), image(1)], normal);
        assert!((along - map * t).norm() < 1e-12);
        let cofactors = map.try_inverse().unwrap().transpose() * map.determinant();
        assert!((along.cross(&across) - cofactors * n).norm() < 1e-12);
        let leaning = LeaningNormal::new(fan, rest, &n);
        assert!((leaning.posed(fan, posed).unwrap() - (cofactors * n).normalize()).norm() < 1e-12);
    }

    #[test]
    fn an_authored_normal_is_kept_at_rest_and_that_of_the_faces_follows_them() {
        let corners = [[0.2, 0.1, 0.0], [1.0, 0.0, 0.1], [0.6, 0.9, -0.2], [-0.7, 0.8, 0.1]];
        let fan = &Fan::all(&[[0, 1, 2], [0, 2, 3]], 4)[0];
        let rest = |v: usize| Vector3::from(corners[v]);
        let posed = |v: usize| rest(v).map(|x| x * x - 0.3 * x) + Vector3::z() * (0.1 * v as f64);
        let n = Vector3::new(0.5, -0.2, 0.7).normalize();
        let kept = LeaningNormal::new(fan, rest, &n).posed(fan, rest).unwrap();
        assert!((kept - n).norm() < 1e-12);
        let own = LeaningNormal::new(fan, rest, &fan.normal(rest).normalize());
        assert!((own.posed(fan, posed).unwrap() - fan.normal(posed).normalize()).norm() < 1e-12);
    }

    #[test]
    fn without_area_nothing_leans() {
        let fan = &Fan::all(&[[0, 1, 2]], 3)[0];
        let frame = [Vector3::x(), Vector3::y()];
        let line = |v: usize| Vector3::x() * v as f64;
        assert!(Lean::new(fan, line, &frame).is_none());
        assert!(LeaningNormal::new(fan, line, &Vector3::z()).posed(fan, line).is_none());
    }
}
