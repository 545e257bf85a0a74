//! Counts of a sample.

/// Shape of a sample model: joints 0 -> 2 -> 1 (root), then a chain below joint 0.
#[derive(Clone, Copy)]
pub struct Shape {
    /// V.
    pub vertices: usize,
    /// J.
    pub joints: usize,
    /// P.
    pub proxies: usize,
    /// K.
    pub influences: usize,
    /// Whether it has tangents.
    pub tangents: bool,
    /// Whether it has tangent coefficients, and errors of normals.
    pub coefficients: bool,
}

/// As few of everything as a file can be damaged in, bit by bit.
pub const TINY: Shape =
    Shape { vertices: 2, joints: 3, proxies: 2, influences: 2, tangents: true, coefficients: true };

/// A few of everything.
pub const SMALL: Shape =
    Shape { vertices: 7, joints: 4, proxies: 3, influences: 2, tangents: true, coefficients: true };
