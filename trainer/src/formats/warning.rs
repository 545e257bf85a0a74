//! Warnings about data that a reader changes or leaves out.

use std::fmt;

/// Data of a file that the reader changes or leaves out, and that the user should know about.
#[derive(Clone, Debug, PartialEq)]
pub enum FormatWarning {
    /// Authored normals of this many corners or vertices had no direction; computed normals replace them.
    NormalsRepaired(usize),
    /// These meshes without a skin are left out, because other meshes have a skin.
    UnskinnedMeshes(Vec<String>),
    /// These meshes without shapes are left out, because other meshes have shapes.
    UnshapedMeshes(Vec<String>),
    /// These channels have in-between shapes; only the last shape of each is read.
    ShapesBetween(Vec<String>),
    /// These clips that move no joint and no shape of the mesh are left out.
    IdleClips(Vec<String>),
    /// Animation channels of these clips that name no node are left out.
    UntargetedChannels(Vec<String>),
    /// Points and lines of these meshes are left out.
    PointsAndLines(Vec<String>),
    /// Joints had equal names and were renamed to these.
    EqualNames(Vec<String>),
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
    /// Point caches outside the scene deform these meshes; they are not read with the scene.
    CacheIgnored(Vec<String>),
}

impl FormatWarning {
    /// Makes a warning of repaired normals; `None` if none was repaired.
    pub(crate) fn repaired(count: usize) -> Option<Self> {
        (count > 0).then_some(Self::NormalsRepaired(count))
    }

    /// Makes a warning that lists names; `None` without names.
    pub(super) fn listed(warning: fn(Vec<String>) -> Self, names: Vec<String>) -> Option<Self> {
        (!names.is_empty()).then(|| warning(names))
    }
}

impl fmt::Display for FormatWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (what, names) = match self {
            Self::NormalsRepaired(count) => {
                return write!(
                    f,
                    "normals that are absent, zero or not finite become those of the faces around \
                     them: {count}"
                );
            }
            Self::UnskinnedMeshes(meshes) => ("meshes without a skin are left out", meshes),
            Self::UnshapedMeshes(meshes) => ("meshes without shapes are left out", meshes),
            Self::ShapesBetween(channels) => {
                let what = "in-between shapes are left out, the last shape of each channel is kept";
                (what, channels)
            }
            Self::IdleClips(clips) => {
                ("clips that move neither a joint nor a shape of the mesh are left out", clips)
            }
            Self::UntargetedChannels(clips) => {
                ("animation channels without a node are left out, of the clips", clips)
            }
            Self::PointsAndLines(meshes) => {
                ("points and lines are left out, of the meshes", meshes)
            }
            Self::EqualNames(joints) => ("joints with equal names were renamed", joints),
            Self::Unweighted { count, follow } => {
                return write!(
                    f,
                    "vertices without a joint's weight, which follow {follow}: {count}"
                );
            }
            Self::NeutralBone { joint, count } => {
                return write!(
                    f,
                    "joint {joint} is not part of the rig: Blender adds it for vertices without a joint's weight, which \
                     stay where they are: {count}; give them weights where the character should take them along"
                );
            }
            Self::CacheIgnored(meshes) => {
                return write!(
                    f,
                    "point caches of meshes are not read with the scene: {}; give them as --targets",
                    meshes.join(", ")
                );
            }
        };
        write!(f, "{what}: {}", names.join(", "))
    }
}
