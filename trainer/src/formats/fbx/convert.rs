//! From the library's types to ours.

use crate::formats::scene::SceneError;
use nalgebra::Matrix4;

pub(super) fn fault(error: ufbx::Error) -> SceneError {
    SceneError::Fbx { reason: error.description.to_lowercase() }
}

pub(super) fn matrix(m: &ufbx::Matrix) -> Matrix4<f64> {
    Matrix4::new(
        m.m00, m.m01, m.m02, m.m03, m.m10, m.m11, m.m12, m.m13, m.m20, m.m21, m.m22, m.m23, 0.0,
        0.0, 0.0, 1.0,
    )
}
