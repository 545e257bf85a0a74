//! The stage of shapes (METHOD §5).

use crate::envelope::model::{SkinModel, Vertex};
use nalgebra::{Vector2, Vector3};

/// A vertex of the shaped rest mesh.
pub struct ShapedVertex {
    /// Position, model space.
    pub position: Vector3<f64>,
    /// Unit normal; the rest normal if the shaped normal is 0.
    pub normal: Vector3<f64>,
    /// Unit tangent and handedness; the rest tangent if the shaped tangent is 0.
    pub tangent: Option<(Vector3<f64>, f64)>,
}

impl SkinModel {
    /// Applies the shapes to every vertex at rest.
    ///
    /// - `weights`: of the shapes, S.
    pub fn shaped(&self, weights: &[f64]) -> Vec<ShapedVertex> {
        let shaped = |(index, vertex): (usize, Vertex<'_>)| {
            let (mut delta, mut tilt) = (Vector3::zeros(), Vector2::zeros());
            let shapes = self.shapes.deltas.iter().zip(&self.shapes.slopes);
            for (weight, (deltas, slopes)) in weights.iter().zip(shapes) {
                delta += *weight * Vector3::from(deltas[index]);
                tilt += *weight * Vector2::from(slopes[index]);
            }
            vertex.shaped(delta, tilt)
        };
        self.vertices().enumerate().map(shaped).collect()
    }
}

impl Vertex<'_> {
    /// Moves the vertex, and tilts its normal and tangent by slopes.
    fn shaped(&self, delta: Vector3<f64>, tilt: Vector2<f64>) -> ShapedVertex {
        let (normal, [g, h]) = (self.normal, self.tilt_frame());
        let direction = |v: Vector3<f64>, rest| v.try_normalize(0.0).unwrap_or(rest);
        let lifted = |(rest, hand)| (direction(rest + tilt.x * normal, rest), hand);
        ShapedVertex {
            position: self.position.xyz() + delta,
            normal: direction(normal - tilt.x * g - tilt.y * h, normal),
            tangent: self.tangent.map(lifted),
        }
    }
}
