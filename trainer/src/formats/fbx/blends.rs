//! Blendshapes of meshes, as the scene has them and as a clip plays them.

use ufbx::{BlendChannel, Mesh, Scene, Vec3};

/// The property of a blendshape channel that weighs it.
pub(super) const WEIGHING: &str = "DeformPercent";

/// Gives the vertices of a mesh at rest: moved by the channels that no clip weighs, which are on in all of them. A channel
/// that a clip weighs is off at rest, for its own weight is that of the frame in which the scene was saved.
pub(super) fn rest_vertices(scene: &Scene, mesh: &Mesh) -> Vec<Vec3> {
    let mut vertices = mesh.vertices.to_vec();
    for channel in channels(mesh).filter(|channel| !is_keyed(scene, channel)) {
        for keyframe in &channel.keyframes {
            let weight = keyframe.effective_weight;
            ufbx::add_blend_shape_vertex_offsets(&keyframe.shape, &mut vertices, weight);
        }
    }
    vertices
}

/// Tells whether channels that a clip weighs move a mesh of a posed scene.
pub(super) fn is_shaped(scene: &Scene, posed: &Mesh) -> bool {
    let mut keyed = channels(posed).filter(|channel| is_keyed(scene, channel));
    keyed.any(|channel| channel.keyframes.iter().any(|key| key.effective_weight != 0.0))
}

/// Lists the channels of a mesh.
pub(super) fn channels(mesh: &Mesh) -> impl Iterator<Item = &BlendChannel> {
    mesh.blend_deformers.iter().flat_map(|blend| blend.channels.iter()).map(|channel| &**channel)
}

fn is_keyed(scene: &Scene, channel: &BlendChannel) -> bool {
    let layers = scene.anim_stacks.iter().flat_map(|stack| stack.layers.iter());
    let mut properties = layers.flat_map(|layer| layer.anim_props.iter());
    properties.any(|property| {
        let own = property.element.element_id == channel.element.element_id;
        let curves = &property.anim_value.curves;
        let has_keys = curves.iter().flatten().any(|curve| !curve.keyframes.is_empty());
        own && *property.prop_name == *WEIGHING && has_keys
    })
}
