//! The skin (METHOD §1.8).

use crate::envelope::model::Vertex;
use crate::numeric::affine::{cofactors, linear};
use nalgebra::{Matrix3, Matrix3x4, Vector3};

/// A skinned vertex.
pub struct SkinnedVertex {
    /// Position, model space.
    pub position: Vector3<f64>,
    /// Unit normal; the rest normal where the map leaves it no direction.
    pub normal: Vector3<f64>,
    /// Unit tangent likewise, and handedness.
    pub tangent: Option<(Vector3<f64>, f64)>,
}

impl Vertex<'_> {
    /// Skins the vertex by a palette.
    pub fn skinned(&self, palette: &[Matrix3x4<f64>]) -> SkinnedVertex {
        let map = self.blend(palette);
        let towards =
            |m: &Matrix3<f64>, rest: &Vector3<f64>| (m * rest).try_normalize(0.0).unwrap_or(*rest);
        let turn = linear(&map);
        SkinnedVertex {
            position: map * self.position,
            normal: towards(&cofactors(&turn), &self.normal),
            tangent: self.tangent.map(|(rest, hand)| (towards(&turn, &rest), hand)),
        }
    }
}
