//! True normals of posed meshes, authored normals included (METHOD §1.8), and the slopes of shapes, which tilt the
//! normals of a skin (METHOD §5).

use super::fan::Fan;
use crate::envelope::model::{SkinModel, Vertex};
use crate::mesh::{Surface, normals};
use crate::numeric::affine;
use nalgebra::{Matrix3, Vector3};

/// Maximum slope, 83°. A shape that tilts the surface further, for example folds it, gets this slope. Then the sum with
/// other shapes still has a direction.
const MAX_SLOPE: f64 = 8.0;

/// True normals of a posed surface at the engine's vertices: the area-weighted normals of the posed mesh. Authored
/// normals move with the faces around each vertex (METHOD §1.8).
pub struct TrueNormals<'a> {
    surface: Surface<'a>,
    /// Fan and authored normal of each engine vertex, E; `None` if normals are not authored.
    sides: Option<Vec<(Fan, LeaningNormal)>>,
}

impl<'a> TrueNormals<'a> {
    /// Measures the authored normals of a surface against its faces at rest.
    pub fn new(surface: Surface<'a>) -> Self {
        let rest = |vertex: usize| Vector3::from(surface.positions[vertex]);
        let side = |(fan, normal): (Fan, &[f64; 3])| {
            let leaning = LeaningNormal::new(&fan, rest, &Vector3::from(*normal));
            (fan, leaning)
        };
        let sides = surface
            .authored_normals()
            .map(|normals| Fan::of(&surface).into_iter().zip(normals).map(side).collect());
        Self { surface, sides }
    }

    /// Computes the E normals, of length 1; 0 if a vertex has no normal.
    ///
    /// - `posed`: positions of the surface's vertices, V.
    pub fn posed(&self, posed: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let Some(sides) = &self.sides else {
            return self.surface.copied(&normals(posed, self.surface.triangles));
        };
        let at = |vertex: usize| Vector3::from(posed[vertex]);
        sides
            .iter()
            .map(|(fan, leaning)| leaning.posed(fan, at).unwrap_or_default().into())
            .collect()
    }
}

/// An authored normal of a vertex, which moves with the faces around the vertex.
///
/// Each face of area A has a map D, which maps its edges and its unit normal n to the posed edges and the posed unit
/// normal. The posed normal is `Σ A cof(D) (n + δ)`. The offset δ is chosen at rest: the sum is as long as `Σ A n` and
/// parallel to the authored normal. For δ = 0 the sum is the area-weighted normal of the posed faces. No map is
/// inverted, so thin faces are safe (METHOD §1.8).
pub(super) struct LeaningNormal {
    /// δ along the two edges and the normal of each face.
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

    /// Computes the unit normal of posed faces; `None` if the sum is 0.
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

/// Frame t, b = n x t of a vertex, relative to the surface around the vertex at rest.
pub(super) struct Lean {
    /// Axes of the surface's plane.
    pub(super) plane: [Vector3<f64>; 2],
    /// t and b in coordinates of these axes and the surface's normal.
    axes: [Vector3<f64>; 2],
}

impl Lean {
    /// Measures a frame against the faces of a vertex; `None` if the faces have no area at rest.
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

    /// Computes the images of t and b under a map. The cross product of the images is the cofactor image of n.
    ///
    /// - `u`, `v`, `normal`: images of the plane's axes and of the surface's unit normal under the map.
    pub(super) fn images(
        &self,
        [u, v]: [Vector3<f64>; 2],
        normal: Vector3<f64>,
    ) -> [Vector3<f64>; 2] {
        self.axes.map(|axis| u * axis.x + v * axis.y + normal * axis.z)
    }
}

impl SkinModel {
    /// Computes the slopes of the shapes. The slopes are secants: one shape at a weight of 1 gets the true normals of
    /// the shaped surface.
    ///
    /// - `surface`: the surface of the skin. The skin has the engine's vertices, in their order.
    ///
    /// # Panics
    /// If the skin or a shape has another number of vertices than the surface.
    pub fn tilt_shapes(&mut self, surface: &Surface<'_>) {
        let truth = TrueNormals::new(*surface);
        let of_shape = |deltas: &Vec<[f64; 3]>| {
            let own = surface.of_first_copies(deltas);
            let shaped: Vec<[f64; 3]> = surface
                .positions
                .iter()
                .zip(&own)
                .map(|(x, by)| (Vector3::from(*x) + Vector3::from(*by)).into())
                .collect();
            let touched = surface.copied(&touched(&own, surface.triangles));
            let normals = truth.posed(&shaped);
            let slopes =
                normals.iter().zip(touched).enumerate().map(|(index, (normal, touched))| {
                    // Exactly 0, so that a vertex away from the shape keeps its normal bit for bit.
                    if touched {
                        self.vertex(index).slopes(&Vector3::from(*normal))
                    } else {
                        [0.0; 2]
                    }
                });
            slopes.collect()
        };
        self.shapes.slopes = self.shapes.deltas.iter().map(of_shape).collect();
    }
}

/// Marks the vertices of the triangles that have a moved corner, V flags.
fn touched(deltas: &[[f64; 3]], triangles: &[[usize; 3]]) -> Vec<bool> {
    let mut touched = vec![false; deltas.len()];
    for triangle in triangles {
        if triangle.iter().any(|&vertex| deltas[vertex] != [0.0; 3]) {
            triangle.iter().for_each(|&vertex| touched[vertex] = true);
        }
    }
    touched
}

impl Vertex<'_> {
    /// Computes the slopes a, c at which `n - a g - c h` is parallel to a unit normal; 0 if n or the normal is 0.
    fn slopes(&self, normal: &Vector3<f64>) -> [f64; 2] {
        // g and h do not have length 1 if a rest tangent is not orthogonal to its normal.
        let along = self.tilt_frame().map(|axis| {
            let square = axis.norm_squared();
            if square > 0.0 { -axis.dot(normal) / square } else { 0.0 }
        });
        let tilt = along[0].hypot(along[1]);
        let up = self.normal.dot(normal).max(tilt / MAX_SLOPE);
        if up > 0.0 { along.map(|x| x / up) } else { [0.0; 2] }
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
        // This map keeps the surface's normal: it has length 1 and is orthogonal to the mapped plane.
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
    fn an_authored_normal_is_kept_at_rest_and_a_face_normal_follows_the_faces() {
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
    fn faces_without_area_have_no_lean_and_no_normal() {
        let fan = &Fan::all(&[[0, 1, 2]], 3)[0];
        let frame = [Vector3::x(), Vector3::y()];
        let line = |v: usize| Vector3::x() * v as f64;
        assert!(Lean::new(fan, line, &frame).is_none());
        assert!(LeaningNormal::new(fan, line, &Vector3::z()).posed(fan, line).is_none());
    }

    fn vertex(normal: Vector3<f64>, tangent: Option<Vector3<f64>>) -> Vertex<'static> {
        Vertex {
            position: Vector3::zeros().push(1.0),
            normal,
            tangent: tangent.map(|tangent| (tangent, 1.0)),
            influences: &[],
            coefficients: &[],
        }
    }

    #[test]
    fn slopes_reproduce_the_normal() {
        let rest = Vector3::new(0.3, -0.5, 0.8).normalize();
        let leaning = (affine::tangent(&rest) + 0.2 * rest).normalize();
        for tangent in [None, Some(affine::tangent(&rest)), Some(leaning)] {
            let vertex = vertex(rest, tangent);
            let [g, h] = vertex.tilt_frame();
            for turned in [Vector3::new(0.1, -0.7, 0.6), Vector3::new(0.9, 0.1, 0.5), rest] {
                let turned = turned.normalize();
                let [a, c] = vertex.slopes(&turned);
                let found = (rest - a * g - c * h).normalize();
                assert!((found - turned).norm() < 1e-12, "{found} {turned}");
            }
        }
    }

    #[test]
    fn a_normal_turned_over_gets_the_maximum_slope() {
        let vertex = vertex(Vector3::z(), None);
        let turned = Vector3::new(0.6, 0.0, -0.8);
        let [a, c] = vertex.slopes(&turned);
        assert!((a.hypot(c) - MAX_SLOPE).abs() < 1e-12);
        let [g, h] = vertex.tilt_frame();
        assert!(
            (Vector3::z() - a * g - c * h).x > 0.0,
            "the tilt must be towards the turned normal"
        );
        assert_eq!(vertex.slopes(&-Vector3::z()), [0.0; 2]);
        assert_eq!(vertex.slopes(&Vector3::zeros()), [0.0; 2]);
    }

    #[test]
    fn corners_of_moved_triangles_are_touched() {
        let deltas = [[0.0; 3], [0.0; 3], [0.0, 1.0, 0.0], [0.0; 3], [0.0; 3]];
        let found = touched(&deltas, &[[0, 1, 2], [1, 3, 0], [3, 4, 1]]);
        assert_eq!(found, [true, true, true, false, false]);
    }
}
