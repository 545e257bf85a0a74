//! The stages as every backend offers them.

use crate::compare::poisoned;
use sinew_runtime::envelope::{
    Envelope, SkinJob, confidence, correction, gradients, joints, palette,
};
use sinew_runtime::pose::features;
use sinew_runtime::{EvalError, Matrix3x4};

/// An implementation of the stages; each writes all of its outputs, which come poisoned. Where it
/// has no stage of its own, it is the runtime.
pub trait Backend {
    /// Evaluates the joints' relative maps, their rotations and the keys' gradients.
    ///
    /// # Errors
    /// What the backend refuses.
    fn gradients(
        &self,
        envelope: &Envelope<'_>,
        pose: &[Matrix3x4],
        out: &mut Gradients,
    ) -> Result<(), EvalError> {
        let Gradients { relative, rotations, gradients } = out;
        gradients::evaluate(envelope, pose, relative, rotations, gradients)
    }

    /// Evaluates `t = c1 d + c2 q`, moved by the root's map.
    ///
    /// # Errors
    /// What the backend refuses.
    fn palette(
        &self,
        envelope: &Envelope<'_>,
        root: &Matrix3x4,
        input: &Gradients,
        out_palette: &mut [Matrix3x4],
    ) -> Result<(), EvalError> {
        palette::evaluate(envelope, root, &input.relative, &input.gradients, out_palette)
    }

    /// Copies the joints, and gives each helper the map of its dominant joint.
    ///
    /// # Errors
    /// What the backend refuses.
    fn joints(
        &self,
        envelope: &Envelope<'_>,
        pose: &[Matrix3x4],
        out_palette: &mut [Matrix3x4],
    ) -> Result<(), EvalError> {
        joints::evaluate(envelope, pose, out_palette)
    }

    /// Evaluates the joints' features.
    ///
    /// # Errors
    /// What the backend refuses.
    fn features(
        &self,
        envelope: &Envelope<'_>,
        pose: &[Matrix3x4],
        out_features: &mut [Matrix3x4],
    ) -> Result<(), EvalError> {
        features::evaluate(envelope, pose, out_features)
    }

    /// Adds what the kernel maps give to the base of the palette; returns the confidence.
    ///
    /// # Errors
    /// What the backend refuses.
    fn correction(
        &self,
        envelope: &Envelope<'_>,
        pose: &[Matrix3x4],
        features: &[Matrix3x4],
        out_palette: &mut [Matrix3x4],
    ) -> Result<f32, EvalError> {
        let mut scratch = vec![f32::NAN; envelope.scratch_len()];
        correction::evaluate(envelope, pose, features, &mut scratch, out_palette)
    }

    /// Returns the confidence of a rotational model.
    ///
    /// # Errors
    /// What the backend refuses.
    fn confidence(
        &self,
        envelope: &Envelope<'_>,
        rotations: &[[f32; 3]],
    ) -> Result<f32, EvalError> {
        confidence::evaluate(envelope, rotations)
    }

    /// Skins a range of vertices.
    ///
    /// # Errors
    /// What the backend refuses.
    fn skin(&self, job: SkinJob<'_>) -> Result<(), EvalError> {
        job.run()
    }

    /// Evaluates the palette of a pose in one call; returns the confidence.
    ///
    /// # Errors
    /// What the backend refuses.
    fn whole_palette(
        &self,
        envelope: &Envelope<'_>,
        pose: &[Matrix3x4],
        out_palette: &mut [Matrix3x4],
    ) -> Result<f32, EvalError> {
        let mut workspace = vec![f32::NAN; envelope.workspace_len()];
        envelope.palette(pose, &mut workspace, out_palette)
    }
}

/// The runtime itself.
pub struct Cpu;

impl Backend for Cpu {}

/// What the first stage writes and the second reads.
#[derive(Clone, Debug)]
pub struct Gradients {
    /// The stack q, 4J columns.
    pub relative: Vec<[f32; 3]>,
    /// θ, J.
    pub rotations: Vec<[f32; 3]>,
    /// The stack d, 3P columns.
    pub gradients: Vec<[f32; 3]>,
}

impl Gradients {
    /// Makes outputs of the right length that hold NaN.
    pub fn poisoned(envelope: &Envelope<'_>) -> Self {
        Self {
            relative: poisoned(4 * envelope.joint_len()),
            rotations: poisoned(envelope.joint_len()),
            gradients: poisoned(3 * envelope.proxy_len()),
        }
    }
}

/// Makes a palette of the right length that holds NaN.
pub fn poisoned_palette(envelope: &Envelope<'_>) -> Vec<Matrix3x4> {
    vec![[[f32::NAN; 4]; 3]; envelope.palette_len()]
}

/// Makes features of the right length that hold NaN.
pub fn poisoned_features(envelope: &Envelope<'_>) -> Vec<Matrix3x4> {
    vec![[[f32::NAN; 4]; 3]; envelope.joint_len()]
}
