//! How shapes tilt the surface at the vertices of a skin (METHOD §5).

use super::truth::TrueNormals;
use crate::envelope::model::{SkinModel, Vertex};
use crate::mesh::Surface;
use nalgebra::Vector3;

/// The steepest slope, 83°: a shape that turns a surface further, as one that folds it, is held there, so that the
/// sum with others keeps a direction.
const STEEPEST: f64 = 8.0;

impl SkinModel {
    /// Computes the slopes of its shapes: secants, by which each at a weight of 1 alone gives the shaped surface the
    /// normals that it has.
    ///
    /// - `surface`: what the skin is made of; the vertices of the skin are the engine's, in their order.
    ///
    /// # Panics
    /// If the skin or its shapes have another number of vertices.
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
                    // What no shape comes near keeps its normal to the last digit.
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

/// Tells which vertices have a triangle of which a corner is moved.
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
    /// Finds the slopes a, c by which `n - a g - c h` has the direction of a unit normal; 0 where either has none.
    fn slopes(&self, normal: &Vector3<f64>) -> [f64; 2] {
        // Neither is of length 1 where a rest tangent is not square to its normal.
        let along = self.tilt_frame().map(|axis| {
            let square = axis.norm_squared();
            if square > 0.0 { -axis.dot(normal) / square } else { 0.0 }
        });
        let rise = along[0].hypot(along[1]);
        let up = self.normal.dot(normal).max(rise / STEEPEST);
        if up > 0.0 { along.map(|x| x / up) } else { [0.0; 2] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::affine;

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
    fn slopes_give_the_normal_back() {
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
    fn what_is_turned_over_is_held_at_the_steepest() {
        let vertex = vertex(Vector3::z(), None);
        let turned = Vector3::new(0.6, 0.0, -0.8);
        let [a, c] = vertex.slopes(&turned);
        assert!((a.hypot(c) - STEEPEST).abs() < 1e-12);
        let [g, h] = vertex.tilt_frame();
        assert!((Vector3::z() - a * g - c * h).x > 0.0, "to the side to which it turns");
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
