//! Everything that a file holds.

use super::envelope::EnvelopeModel;
use super::prior::PriorModel;
use super::record::RecordModel;
use super::skin::SkinModel;
use sinew_runtime::format::Space;

/// Envelopes, the skins that follow them, in the examples' order, priors over the weights of their shapes, and what
/// is told of their training.
#[derive(Clone, Debug, Default)]
pub struct FileModel {
    /// The space of all their numbers.
    pub space: Space,
    /// What predicts palettes.
    pub envelopes: Vec<EnvelopeModel>,
    /// The meshes that follow them.
    pub skins: Vec<SkinModel>,
    /// What is known of the weights of skins' shapes.
    pub priors: Vec<PriorModel>,
    /// What the envelopes were trained on.
    pub records: Vec<RecordModel>,
}
