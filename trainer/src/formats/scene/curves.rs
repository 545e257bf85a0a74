//! Curves of a scene: the weights of named shapes, frame by frame.

/// Weights of one shape of one mesh.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CurveTrack {
    /// Name of the shape.
    pub(crate) name: String,
    /// Name of the mesh.
    pub(crate) mesh: String,
    /// Weight in each frame, N; 1 for the whole shape.
    pub(crate) weights: Vec<f64>,
}
