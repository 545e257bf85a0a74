//! The stages of the shapes (METHOD §5) and the skin (METHOD §1.8).

use crate::envelope::model::{SkinModel, Vertex};
use crate::numeric::affine::{cofactors, linear};
use nalgebra::{Matrix3, Matrix3x4, Vector2, Vector3};

/// A vertex of a shaped or skinned mesh.
pub struct MovedVertex {
    /// Position, model space.
    pub position: Vector3<f64>,
    /// Unit normal, or 0.
    pub normal: Vector3<f64>,
    /// Unit tangent and handedness; the rest tangent if the moved tangent is 0.
    pub tangent: Option<(Vector3<f64>, f64)>,
}

impl SkinModel {
    /// Applies the shapes to every vertex at rest. A vertex whose shaped normal is 0 has the rest normal.
    ///
    /// - `weights`: of the shapes, S.
    pub fn shaped(&self, weights: &[f64]) -> Vec<MovedVertex> {
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
    fn shaped(&self, delta: Vector3<f64>, tilt: Vector2<f64>) -> MovedVertex {
        let (normal, [g, h]) = (self.normal, self.tilt_frame());
        let lifted =
            |(rest, hand): (Vector3<f64>, f64)| (direction(rest + tilt.x * normal, rest), hand);
        MovedVertex {
            position: self.position.xyz() + delta,
            normal: direction(normal - tilt.x * g - tilt.y * h, normal),
            tangent: self.tangent.map(lifted),
        }
    }

    /// Skins the vertex with a palette. If the skinned normal is 0, the normal is the rest normal rotated by the
    /// transform of the strongest influence. If that is 0 too, or normals come from cofactors, it is the rest normal.
    pub fn skinned(&self, palette: &[Matrix3x4<f64>]) -> MovedVertex {
        let map = self.blend(palette);
        let turn = linear(&map);
        // A mirrored pose inverts cross products.
        let mirrored = palette.first().is_some_and(|first| linear(first).determinant() < 0.0);
        let sign = if mirrored { -1.0 } else { 1.0 };
        let (along, normal, fallback) = if self.coefficients.is_empty() {
            let along = self.tangent.map(|(rest, _)| turn * rest);
            (along, cofactors(&turn) * self.normal, self.normal)
        } else {
            let [along, across] = self.carried_frame(palette, &turn);
            (Some(along), along.cross(&across), self.turned_by_strongest(palette))
        };
        let along = along.unwrap_or_default();
        MovedVertex {
            position: map * self.position,
            normal: direction(sign * normal, fallback),
            tangent: self.tangent.map(|(rest, hand)| (direction(along, rest), hand)),
        }
    }

    /// Transforms t, b by the gradient of the skin: `A t + Σ g_l T_l x̂`, with A the blended 3 x 3 matrix.
    fn carried_frame(&self, palette: &[Matrix3x4<f64>], turn: &Matrix3<f64>) -> [Vector3<f64>; 2] {
        let mut carried = self.frame().map(|axis| turn * axis);
        for (&(l, _), coefficients) in self.influences.iter().zip(self.coefficients) {
            let at = palette[l] * self.position;
            carried.iter_mut().zip(coefficients).for_each(|(axis, c)| *axis += at * *c);
        }
        carried
    }

    /// Rotates the rest normal by the transform of the strongest influence; ties go to the first influence.
    fn turned_by_strongest(&self, palette: &[Matrix3x4<f64>]) -> Vector3<f64> {
        let stronger =
            |best: (usize, f64), next: &(usize, f64)| if next.1 > best.1 { *next } else { best };
        let (strongest, _) = self.influences.iter().fold((0, f64::NEG_INFINITY), stronger);
        direction(linear(&palette[strongest]) * self.normal, self.normal)
    }
}

/// Returns the direction of a vector, or `rest` if the vector is 0.
fn direction(v: Vector3<f64>, rest: Vector3<f64>) -> Vector3<f64> {
    v.try_normalize(0.0).unwrap_or(rest)
}
