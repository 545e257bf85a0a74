//! Warnings about data that a reader changes or leaves out.

use std::fmt;

/// Data of a file that the reader changes or leaves out, and that the user should know about.
#[derive(Clone, Debug, PartialEq)]
pub enum FormatWarning {
    /// Authored normals had no direction; computed normals replace them.
    NormalsRepaired {
        /// Number of corners or vertices.
        count: usize,
    },
    /// Meshes without a skin are left out, because other meshes have a skin.
    UnskinnedMeshes {
        /// The meshes.
        meshes: Vec<String>,
    },
    /// Meshes without shapes are left out, because other meshes have shapes.
    UnshapedMeshes {
        /// The meshes.
        meshes: Vec<String>,
    },
    /// Channels have in-between shapes; only the last shape of each is read.
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
        /// The clips with untargeted channels.
        clips: Vec<String>,
    },
    /// Points and lines of meshes are left out.
    PointsAndLines {
        /// The meshes.
        meshes: Vec<String>,
    },
    /// Joints had equal names and were renamed.
    EqualNames {
        /// The new names.
        joints: Vec<String>,
    },
    /// Some vertices have no joint weights.
    Unweighted {
        /// Number of vertices.
        count: usize,
        /// What these vertices follow, in words.
        follow: &'static str,
    },
    /// A joint that Blender's exporter adds for vertices without joint weights.
    NeutralBone {
        /// The joint.
        joint: String,
        /// Number of vertices that follow the joint.
        count: usize,
    },
    /// Point caches outside the scene deform some meshes; they are not read with the scene.
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
                    "in-between shapes are left out, the last shape of each channel is kept: {}",
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
                    "joint {joint} is not part of the rig: Blender adds it for vertices without a joint's weight, which \
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
