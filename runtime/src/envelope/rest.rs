//! The rest pose of a skeleton: where its joints stand in model space, and in each other.

use super::local::LocalTransform;
use super::view::Envelope;
use crate::linear::{
    Matrix3x4, columns, compose, floats, inverse, quaternion, rows, squared_length,
};
use crate::numeric::sqrt;

impl<'a> Envelope<'a> {
    /// Returns a joint's rest frame in its parent's, the root's in model space: what
    /// [`crate::model_space_pose`] makes the rest pose of, and what an animation changes.
    pub fn rest_local(&self, joint: usize) -> Option<LocalTransform> {
        let mut frame = self.rest_frame(joint)?;
        if let Some(bind) = self.parent(joint).and_then(|parent| self.inverse_bind(parent)) {
            frame = compose(&bind, &frame);
        }
        let [x, y, z, translation] = columns(&frame);
        let ([x, y, z], w) = quaternion(&[x, y, z]);
        let length = sqrt(squared_length([x, y, z, w]));
        Some(LocalTransform { rotation: [x, y, z, w].map(|value| value / length), translation })
    }

    /// Lists the J rest frames, each in its parent's.
    pub fn rest_locals(&self) -> impl Iterator<Item = LocalTransform> + use<'a> {
        let envelope = *self;
        (0..self.joint_len()).filter_map(move |joint| envelope.rest_local(joint))
    }

    /// Returns a joint's rest frame in model space: the inverse of its inverse bind matrix.
    pub fn rest_frame(&self, joint: usize) -> Option<Matrix3x4> {
        self.inverse_bind(joint).map(|bind| inverse(&bind))
    }

    /// Lists the J inverse bind matrices.
    pub fn inverse_binds(&self) -> impl ExactSizeIterator<Item = Matrix3x4> + use<'a> {
        self.bind_words().iter().take(self.joint_len()).map(|words| rows(&floats(words)))
    }
}
