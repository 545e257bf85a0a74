//! Errors of scenes that several readers report.

use crate::Error;

/// The default scene has no node.
pub(crate) fn empty() -> Error {
    Error::missing(
        "is empty: its scene shows no node; export the character's mesh and armature, in the scene \
         that the file shows",
    )
}

/// The file has no mesh of triangles.
pub(crate) fn no_mesh() -> Error {
    Error::missing("holds no mesh: export the character's mesh together with its armature")
}

/// No mesh has shapes.
pub(crate) fn no_shapes() -> Error {
    Error::missing("has no blendshape: export the face with its shape keys (morph targets)")
}

/// The bind matrix of a joint has no inverse.
pub(crate) fn singular_bind(joint: &str) -> Error {
    Error::value(format!(
        "the bind matrix of joint {joint} cannot be inverted: bind the mesh again"
    ))
}

/// Two meshes bind a joint at different places.
pub(crate) fn other_bind(mesh: &str, joint: &str) -> Error {
    Error::mismatch(format!(
        "mesh {mesh} binds joint {joint} elsewhere than the other meshes do: export all meshes in one \
         rest pose (apply the armature's pose as rest pose)"
    ))
}

/// No clip moves a joint or a shape of the mesh.
///
/// - `clips`: the clips of the file.
pub(crate) fn nothing_moves(clips: &[String]) -> Error {
    Error::missing(format!(
        "no animation targets a joint or a shape of the mesh (clips: {}): export the armature's \
         animation, sampled at every frame",
        clips.join(", ")
    ))
}

/// A requested clip does not exist.
///
/// - `known`: the clips of the file.
pub(crate) fn unknown_clip(name: &str, known: &[String]) -> Error {
    Error::missing(format!("has no clip {name}, there are: {}", known.join(", ")))
}

/// Key times are not finite, not in order, or too far apart to sample.
pub(crate) fn key_times(clip: &str) -> Error {
    Error::value(format!(
        "clip {clip}: its key times are not finite, not ascending, or span more frames than can be \
         sampled"
    ))
}
