//! Why a model cannot be put into an artist's file.

use crate::formats::FileError;

/// A file that a model cannot be put into.
#[derive(Debug, thiserror::Error)]
pub enum IntoError {
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// None of its vertices is one of the model's.
    #[error(
        "no mesh has its vertices where the model's are, within 1e-4 of the diagonal, in any axes and \
         unit: give the character that the model was trained on, in its rest pose"
    )]
    NoMesh,
    /// None of its nodes has the name of a joint, but would with other names.
    #[error("has none of the model's joints, by name: {}; {mismatch}", joints.join(", "))]
    OtherJoints {
        /// The model's.
        joints: Vec<String>,
        /// What keeps the names from matching, and the option that mends it.
        mismatch: String,
    },
    /// Some vertices of a mesh are the model's, and others are not.
    #[error(
        "mesh {mesh}: vertex {vertex} at {at:?} is none of the model's, {found} of {len} are: train on \
         the mesh as it is, or part what was added to it into a mesh of its own"
    )]
    Partly {
        /// The mesh.
        mesh: String,
        /// Its first vertex that was not found.
        vertex: usize,
        /// Where that is in the file.
        at: [f64; 3],
        /// Vertices that were found.
        found: usize,
        /// Its vertices.
        len: usize,
    },
    /// A joint cannot be placed by a move, a turn and an even scale.
    #[error(
        "joint {joint} hangs under nodes that scale unevenly: apply the scale of the armature before \
         exporting"
    )]
    Uneven {
        /// The joint.
        joint: String,
    },
}
