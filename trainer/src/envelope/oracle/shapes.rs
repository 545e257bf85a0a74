//! Shapes (METHOD §5).

use crate::envelope::model::{SkinModel, Vertex};
use nalgebra::{Vector2, Vector3};

/// A vertex of the shaped rest mesh.
pub struct ShapedVertex {
    /// Position, model space.
    pub position: Vector3<f64>,
    /// Unit normal; that at rest where the shapes leave it no direction.
    pub normal: Vector3<f64>,
    /// Unit tangent, that at rest where the shapes leave it no direction; and handedness.
    pub tangent: Option<(Vector3<f64>, f64)>,
}

impl SkinModel {
    /// Shapes every vertex at rest.
    ///
    /// - `weights`: S.
    pub fn shaped(&self, weights: &[f64]) -> Vec<ShapedVertex> {
        let shaped = |(index, vertex): (usize, Vertex<'_>)| {
            let (mut moved, mut tilt) = (Vector3::zeros(), Vector2::zeros());
            let shapes = self.shapes.deltas.iter().zip(&self.shapes.slopes);
            for (weight, (deltas, slopes)) in weights.iter().zip(shapes) {
                moved += *weight * Vector3::from(deltas[index]);
                tilt += *weight * Vector2::from(slopes[index]);
            }
            vertex.moved(moved, tilt)
        };
        self.vertices().enumerate().map(shaped).collect()
    }
}

impl Vertex<'_> {
    /// Moves the vertex, and tilts its surface.
    fn moved(&self, by: Vector3<f64>, tilt: Vector2<f64>) -> ShapedVertex {
        let (normal, [g, h]) = (self.normal, self.tilt_frame());
        let direction = |v: Vector3<f64>, rest| v.try_normalize(0.0).unwrap_or(rest);
        let lifted = |(rest, hand)| (direction(rest + tilt.x * normal, rest), hand);
        ShapedVertex {
            position: self.position.xyz() + by,
            normal: direction(normal - tilt.x * g - tilt.y * h, normal),
            tangent: self.tangent.map(lifted),
        }
    }
}
