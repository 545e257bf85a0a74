//! Blendshape channels, whose weights are curves.

use super::meshes::{channels, shown};
use crate::formats::scene::{CurveTrack, Sampling};
use ufbx::Scene;

/// A blendshape channel of a mesh.
pub(super) struct NamedChannel {
    /// Name of the node that shows the mesh.
    mesh: String,
    name: String,
    /// Index of the channel in the scene.
    pub(super) channel: usize,
}

/// Lists the blendshape channels of all meshes, with a skin or without, if `sampling` asks for curves.
pub(super) fn named_channels(scene: &Scene, sampling: &Sampling<'_>) -> Vec<NamedChannel> {
    let meshes = shown(scene).filter(|_| sampling.curves);
    let all = meshes.flat_map(|(node, mesh)| {
        channels(mesh).map(|channel| NamedChannel {
            mesh: node.element.name.to_string(),
            name: channel.element.name.to_string(),
            channel: channel.element.typed_id as usize,
        })
    });
    all.collect()
}

/// Returns the weights of channels in a posed scene.
pub(super) fn weights(posed: &Scene, shapes: &[NamedChannel]) -> Vec<f64> {
    shapes.iter().map(|shape| posed.blend_channels[shape.channel].weight).collect()
}

/// Makes the track of each channel from the weights frame by frame.
pub(super) fn tracks(shapes: &[NamedChannel], frames: &[Vec<f64>]) -> Vec<CurveTrack> {
    let track = |(place, shape): (usize, &NamedChannel)| CurveTrack {
        name: shape.name.clone(),
        mesh: shape.mesh.clone(),
        weights: frames.iter().map(|frame| frame[place]).collect(),
    };
    shapes.iter().enumerate().map(track).collect()
}
