//! Everything that a file holds.

use super::envelope::EnvelopeModel;
use super::skin::SkinModel;
use sinew_runtime::format::Space;

/// Envelopes and the skins that follow them, in the examples' order.
#[derive(Clone, Debug, Default)]
pub struct FileModel {
    /// The space of all their numbers.
    pub space: Space,
    /// What predicts palettes.
    pub envelopes: Vec<EnvelopeModel>,
    /// The meshes that follow them.
    pub skins: Vec<SkinModel>,
}
