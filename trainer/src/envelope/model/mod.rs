//! A fitted model in f64: baked into a file, evaluated by the oracle, and loaded back from a file.

mod envelope;
mod feature;
mod key;
mod prior;
mod skin;

pub use envelope::{Curve, EnvelopeModel, Group, Input, Reconstruction};
pub use feature::{Feature, FeatureOrder};
pub use key::{Factors, Key, Movement, Shear, movement, stretch, symmetric};
pub use prior::PriorModel;
pub use skin::{ShapeNumbers, Shapes, SkinModel, Vertex};

use crate::envelope::lbs::blend::Weights;
use crate::examples::{Examples, Mark};
use sinew_runtime::format::Space;

/// Content of a file. Skins are in the examples' order.
#[derive(Clone, Debug, Default)]
pub struct FileModel {
    /// Space of all numbers.
    pub space: Space,
    /// Envelopes, which predict palettes.
    pub envelopes: Vec<EnvelopeModel>,
    /// Meshes that follow the palettes.
    pub skins: Vec<SkinModel>,
    /// Priors over the weights of the skins' shapes.
    pub priors: Vec<PriorModel>,
    /// Records of the training of the envelopes.
    pub records: Vec<RecordModel>,
}

/// Record of a training: marks of the training frames, and the fitted LBS weights.
#[derive(Clone, Debug)]
pub struct RecordModel {
    /// Name of the envelope.
    pub envelope: String,
    /// Number of joints, J.
    pub joint_len: usize,
    /// Marks of the training frames.
    pub marks: Vec<Mark>,
    /// LBS weights of the examples' vertices, V.
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
