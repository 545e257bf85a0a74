//! Shapes of sample models.

use sinew_runtime::envelope::HelperKind;

/// Shape of a sample model. Joints are 0 -> 2 -> 1 (root), then a chain below joint 0. A kernel
/// sample may have curves and no joints.
#[derive(Clone, Copy)]
pub struct Shape {
    /// Number of vertices V.
    pub vertices: usize,
    /// Number of joints J.
    pub joints: usize,
    /// Number of proxies P.
    pub proxies: usize,
    /// Influences per vertex K.
    pub influences: usize,
    /// Whether the skin has tangents.
    pub tangents: bool,
    /// Whether the skin has tangent coefficients and errors of normals.
    pub coefficients: bool,
    /// Whether joints stretch.
    pub stretches: bool,
    /// Number of curves C. A rotational sample has none.
    pub curves: usize,
    /// Kind of the helpers. A rotational sample has affine ones.
    pub kind: HelperKind,
}

/// The smallest shape with every section of a rigid model: small enough to damage every bit.
pub const TINY: Shape = Shape {
    vertices: 2,
    joints: 3,
    proxies: 2,
    influences: 2,
    tangents: true,
    coefficients: true,
    stretches: false,
    curves: 0,
    kind: HelperKind::Affine,
};

/// A small shape with a few of everything that a rigid model has.
pub const SMALL: Shape = Shape { vertices: 7, joints: 4, proxies: 3, ..TINY };

/// A small shape whose joints stretch, with curves.
pub const STRETCHING: Shape = Shape { stretches: true, curves: 3, ..SMALL };

/// A small shape without joints, which follows curves alone; for the kernel predictor.
pub const JOINTLESS: Shape = Shape { joints: 0, curves: 5, ..SMALL };

impl Shape {
    /// Returns the number of features.
    pub const fn feature_len(self) -> usize {
        (if self.stretches { 18 } else { 12 }) * self.joints + self.curves
    }
}
