//! Everything that a file holds.

use super::envelope::EnvelopeModel;
use super::skin::SkinModel;
use crate::face::prior::PriorModel;
use sinew_runtime::format::Space;

/// Envelopes, the skins that follow them, in the examples' order, and priors over the weights of their shapes.
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
}
