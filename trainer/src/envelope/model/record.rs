//! What an envelope was trained on.

use crate::envelope::lbs::blend::Weights;
use crate::examples::{Examples, Mark};

/// Marks of the training frames, and linear blend skinning fitted to them.
#[derive(Clone, Debug)]
pub struct RecordModel {
    /// The envelope's name.
    pub envelope: String,
    /// J.
    pub joint_len: usize,
    /// Marks of the training frames.
    pub marks: Vec<Mark>,
    /// Joint weights of the examples' vertices, V.
    pub lbs: Option<Weights>,
}

impl RecordModel {
    /// Records the training of an envelope on some frames of the examples.
    pub fn new(envelope: &str, examples: &Examples, frames: &[usize], lbs: &Weights) -> Self {
        Self {
            envelope: envelope.to_owned(),
            joint_len: examples.joint_len(),
            marks: frames.iter().map(|&frame| examples.mark(frame)).collect(),
            lbs: Some(lbs.clone()),
        }
    }
}
