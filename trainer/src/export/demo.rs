//! The demo character as an artist would hand it over: a skeleton, LBS weights, and animations.

use super::error::ExportError;
use super::mesh::SkinnedMesh;
use super::skeleton::JointNodes;
use super::times::key_times;
use crate::envelope::lbs::weights;
use crate::examples::{Clip, Examples, Split};
use crate::formats::gltf::write::{Document, Placed};

/// What the file says of itself.
const NOTE: &str = "A procedural arm: what a rig exports of its skeleton, with the weights of \
    linear blend skinning. The meshes that its flesh really takes are in the point cache beside it.";

/// Orders frames by use, so that each use is one clip: training frames, held-out, extreme ones.
pub fn by_use(mut examples: Examples) -> (Examples, Vec<Clip>) {
    let (mut frames, mut clips) = (Vec::new(), Vec::new());
    for split in [Split::Train, Split::HeldOut, Split::Extreme] {
        let (name, own) = (split.name(), examples.frames_of(split));
        if !own.is_empty() {
            clips.push(Clip::regular(name.to_owned(), frames.len(), own.len()));
            frames.extend(own);
        }
    }
    let mut vertices = Vec::with_capacity(examples.vertices.len());
    frames.iter().for_each(|&frame| vertices.extend_from_slice(examples.frame(frame)));
    let transforms = frames.iter().flat_map(|&frame| examples.pose(frame)).copied().collect();
    let split = frames.iter().map(|&frame| examples.split[frame]).collect();
    let clip_starts = clips.iter().map(|clip| clip.first).collect();
    examples = Examples { vertices, transforms, split, clip_starts, ..examples };
    (examples, clips)
}

/// Writes examples as a rigged character: its skeleton, its rest mesh with four LBS weights a vertex,
/// fitted to the training frames, and an animation a clip. The rest pose is the bind pose.
///
/// # Errors
/// [`ExportError::Glb`].
pub fn demo_glb(examples: &Examples, clips: &[Clip]) -> Result<Vec<u8>, ExportError> {
    let weights = weights::baseline(examples);
    let influences: Vec<_> = (0..weights.len()).map(|v| weights.of(v).collect()).collect();

    let mut document = Document::new(NOTE);
    let armature = document.node("armature".to_owned(), None, &Placed::AT_PARENT);
    let joints = JointNodes::new(&mut document, armature, &examples.skeleton);
    let skin = document.skin(armature, &joints.nodes, &joints.inverse_binds);
    let mesh = SkinnedMesh {
        name: "skin",
        positions: &examples.rest,
        normals: &examples.surface().normals(),
        uv: examples.surface().uv(),
        influences: &influences,
        primitives: &[(None, examples.triangles.clone())],
    };
    document.mesh(&mesh, skin);
    for clip in clips {
        let frames = clip.first..clip.first + clip.times.len();
        let poses: Vec<_> = frames.map(|frame| examples.pose(frame).to_vec()).collect();
        let times = key_times(clip)?;
        document.animation(&clip.name, &times, joints.tracks(&poses, &times).0);
    }
    Ok(document.finish()?)
}
