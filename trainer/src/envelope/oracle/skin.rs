//! The stage of the skin (METHOD §1.8).

use crate::envelope::model::Vertex;
use crate::numeric::affine::{cofactors, linear};
use nalgebra::{Matrix3, Matrix3x4, Vector3};

/// A skinned vertex.
pub struct SkinnedVertex {
    /// Position, model space.
    pub position: Vector3<f64>,
    /// Unit normal. If the skinned normal is 0, the rest normal rotated by the transform of the strongest influence. If
    /// that is 0 too, or normals come from cofactors, the rest normal.
    pub normal: Vector3<f64>,
    /// Unit tangent and handedness; the rest tangent if the skinned tangent is 0.
    pub tangent: Option<(Vector3<f64>, f64)>,
}

impl Vertex<'_> {
    /// Skins the vertex with a palette.
    pub fn skinned(&self, palette: &[Matrix3x4<f64>]) -> SkinnedVertex {
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
        let direction = |v: Vector3<f64>, rest| v.try_normalize(0.0).unwrap_or(rest);
        let along = along.unwrap_or_default();
        SkinnedVertex {
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
        let turned = linear(&palette[strongest]) * self.normal;
        turned.try_normalize(0.0).unwrap_or(self.normal)
    }
}
