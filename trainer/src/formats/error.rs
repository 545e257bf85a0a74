//! What can be wrong with a file, whatever its format.
//! What a file holds and a reader leaves out.

use super::abc::AlembicError;
use super::csv::CsvError;
use super::layered::LayeredError;
use super::npz::ArrayError;
use super::obj::ObjError;
use super::posed_meshes::{PointCacheError, SequenceError};
use super::scene::SceneError;
use std::fmt;
use std::path::PathBuf;

/// A file that cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[error("{}: {error}", file.display())]
pub struct FileError {
    /// The file at fault.
    pub file: PathBuf,
    /// What is wrong with it.
    pub error: FormatError,
}

/// What is wrong with a file.
#[derive(Debug, thiserror::Error)]
pub enum FormatError {
    /// The file cannot be opened or read.
    #[error("cannot be read: {0}")]
    Read(std::io::Error),
    /// The file cannot be written.
    #[error("cannot be written: {0}")]
    Write(std::io::Error),
    /// The file's name does not end as any format that is read here.
    #[error("expected a file that ends in {expected}, found {found}")]
    UnknownFormat {
        /// The endings that are read.
        expected: &'static str,
        /// The ending found.
        found: String,
    },
    /// The file is of a format that is not read.
    #[error("is {format}, which is not read: {remedy}")]
    Unread {
        /// The format.
        format: &'static str,
        /// What to do.
        remedy: &'static str,
    },
    /// There is nothing in the file.
    #[error("is empty")]
    Empty,
    /// The file is a baked model, where examples are read.
    #[error("is a baked model, expected examples: commands take the model first")]
    Model,
    /// The file holds what another ending stands for.
    #[error("holds what a .{ending} file holds: give it that ending")]
    OtherContent {
        /// The ending of what it holds.
        ending: &'static str,
    },
    /// A scene is damaged, or lacks what a rigged character has.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Arrays are missing, damaged or others than expected.
    #[error(transparent)]
    Array(#[from] ArrayError),
    /// A point cache is damaged or none.
    #[error(transparent)]
    PointCache(#[from] PointCacheError),
    /// An Alembic archive is damaged, or its meshes are not of one mesh.
    #[error(transparent)]
    Alembic(#[from] AlembicError),
    /// Meshes do not follow one another.
    #[error(transparent)]
    Sequence(#[from] SequenceError),
    /// The file is no OBJ, or a folder of them is not a face.
    #[error(transparent)]
    Obj(#[from] ObjError),
    /// The file is no picture in layers, or lacks a layer.
    #[error(transparent)]
    Layered(#[from] LayeredError),
    /// The file is no table of numbers.
    #[error(transparent)]
    Csv(#[from] CsvError),
}

/// Something that a file holds and that is left out, which the user should know.
#[derive(Clone, Debug, PartialEq)]
pub enum FormatWarning {
    /// Authored normals without a direction, in place of which the trainer's own stand.
    NormalsRepaired {
        /// Of how many corners or vertices.
        count: usize,
    },
    /// Meshes without a skin stand beside meshes that have one, and are left out.
    UnskinnedMeshes {
        /// The meshes.
        meshes: Vec<String>,
    },
    /// Meshes without shapes stand beside meshes that have some, and are left out.
    UnshapedMeshes {
        /// The meshes.
        meshes: Vec<String>,
    },
    /// Channels with shapes between, of which only the last is taken.
    ShapesBetween {
        /// The channels.
        channels: Vec<String>,
    },
    /// Clips that move no joint and no shape of the mesh are left out.
    IdleClips {
        /// The clips.
        clips: Vec<String>,
    },
    /// Animation channels that name no node are left out.
    UntargetedChannels {
        /// The clips that have any.
        clips: Vec<String>,
    },
    /// Points and lines of meshes are left out.
    PointsAndLines {
        /// The meshes.
        meshes: Vec<String>,
    },
    /// Joints of equal names, which were told apart.
    EqualNames {
        /// The names that they have now.
        joints: Vec<String>,
    },
    /// Vertices that no joint moves.
    Unweighted {
        /// How many.
        count: usize,
        /// What they follow.
        follow: &'static str,
    },
    /// A joint that Blender's exporter adds for vertices that no joint moves.
    NeutralBone {
        /// The joint.
        joint: String,
        /// How many vertices follow it.
        count: usize,
    },
    /// Meshes that a point cache outside the scene deforms, which is not read with it.
    CacheIgnored {
        /// The meshes.
        meshes: Vec<String>,
    },
}

impl fmt::Display for FormatWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FormatWarning::NormalsRepaired { count } => {
                write!(
                    f,
                    "normals that are absent, zero or not finite become those of the faces around \
                     them: {count}"
                )
            }
            FormatWarning::UnskinnedMeshes { meshes } => {
                write!(f, "meshes without a skin are left out: {}", meshes.join(", "))
            }
            FormatWarning::UnshapedMeshes { meshes } => {
                write!(f, "meshes without shapes are left out: {}", meshes.join(", "))
            }
            FormatWarning::ShapesBetween { channels } => {
                write!(
                    f,
                    "shapes between are left out, the last of each channel is taken: {}",
                    channels.join(", ")
                )
            }
            FormatWarning::IdleClips { clips } => {
                write!(
                    f,
                    "clips that move neither a joint nor a shape of the mesh are left out: {}",
                    clips.join(", ")
                )
            }
            FormatWarning::UntargetedChannels { clips } => {
                write!(
                    f,
                    "animation channels without a node are left out, of the clips: {}",
                    clips.join(", ")
                )
            }
            FormatWarning::PointsAndLines { meshes } => {
                write!(f, "points and lines are left out, of the meshes: {}", meshes.join(", "))
            }
            FormatWarning::EqualNames { joints } => {
                write!(f, "joints with equal names were renamed: {}", joints.join(", "))
            }
            FormatWarning::Unweighted { count, follow } => {
                write!(f, "vertices without a joint's weight, which follow {follow}: {count}")
            }
            FormatWarning::NeutralBone { joint, count } => {
                write!(
                    f,
                    "joint {joint} is none of the rig's: Blender adds it for vertices without a joint's weight, which \
                     stay where they are: {count}; give them weights where the character should take them along"
                )
            }
            FormatWarning::CacheIgnored { meshes } => {
                write!(
                    f,
                    "point caches of meshes are not read with the scene: {}; give them as --targets",
                    meshes.join(", ")
                )
            }
        }
    }
}
