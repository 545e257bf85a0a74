//! What the runtime makes of one pose.

use crate::evaluate::{evaluated, stride};
use crate::poses;
use sinew_runtime::envelope::Bounds;
use sinew_runtime::format::Predictor;
use sinew_runtime::{Envelope, LocalTransform, Matrix3x4};

/// A frame of an envelope: the inputs and results of its calls.
#[derive(Default)]
pub(super) struct Frame {
    pub(super) vertex_len: usize,
    pub(super) influence_len: usize,
    pub(super) workspace_len: usize,
    pub(super) has_tangents: bool,
    pub(super) predictor: Option<Predictor>,
    pub(super) name: String,
    pub(super) local: Vec<LocalTransform>,
    pub(super) pose: Vec<Matrix3x4>,
    pub(super) palette: Vec<Matrix3x4>,
    pub(super) bounds: Option<Bounds>,
    /// Position, normal and, where there are any, tangent of each vertex.
    pub(super) skin: Vec<f32>,
}

impl Frame {
    /// Evaluates a pose.
    ///
    /// # Panics
    /// Where a call is refused.
    pub(super) fn new(envelope: &Envelope<'_>, pose_number: usize) -> Self {
        let local = poses::local(envelope, pose_number);
        let pose = poses::from_local(envelope, &local);
        let found = match evaluated(envelope, &pose) {
            Ok(found) => found,
            Err(error) => panic!("the runtime refuses its own file's pose: {error}"),
        };
        Self {
            vertex_len: envelope.vertex_len(),
            influence_len: envelope.influence_len(),
            workspace_len: envelope.workspace_len(),
            has_tangents: envelope.has_tangents(),
            predictor: Some(envelope.predictor()),
            name: envelope.name().to_owned(),
            local,
            pose,
            palette: found.palette,
            bounds: found.bounds,
            skin: found.skin,
        }
    }

    /// Returns the floats of a vertex in the skin.
    pub(super) fn stride(&self) -> usize {
        stride(self.has_tangents)
    }
}
