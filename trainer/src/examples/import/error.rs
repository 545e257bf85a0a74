//! Errors in scenes and their posed meshes, with advice on exporting.

use sinew_runtime::format::MAGNITUDE_MAX;

/// A scene and posed meshes that do not match, or are incomplete.
#[derive(Debug, thiserror::Error)]
pub enum ImportError {
    /// An option for scenes was given with complete examples.
    #[error(
        "{option} goes with a scene (.glb, .gltf, .fbx); an .npz holds its own poses and meshes"
    )]
    NotAScene {
        /// Name of the option.
        option: &'static str,
    },
    /// A file of posed meshes was given as a scene.
    #[error(
        "holds posed meshes, but no joints to learn from: give the scene with the joints (.fbx, .glb, .gltf), and \
         this file as --targets"
    )]
    MeshesAlone,
    /// The posed meshes have a constant rate, but the clip's keys are unevenly spaced.
    #[error(
        "clip {clip} has non-uniform key times: a step of {step:.4} s at {at:.4} s, elsewhere \
         {usual:.4} s; bake a key at every frame when exporting, or give the frames a second that \
         the meshes were exported at as --fps"
    )]
    UnevenKeys {
        /// Name of the clip.
        clip: String,
        /// Start of the uneven step, in seconds.
        at: f64,
        /// Length of the uneven step, in seconds.
        step: f64,
        /// Length of the other steps, in seconds.
        usual: f64,
    },
    /// The scene has poses but no posed meshes.
    #[error(
        "holds poses but neither a skin nor shapes: give the posed meshes as --targets (.abc, .pc2, .mdd, \
         .npz, or a numbered sequence of .obj)"
    )]
    NoShapes,
    /// The posed meshes have a wrong number of vertices.
    #[error(
        "holds meshes of {found} vertices, the scene's mesh has {}: export both from one mesh \
         without modifiers that change its vertices; glTF splits vertices along seams of texture and \
         normals, FBX does not",
        counts(*expected, *engine)
    )]
    TargetVertices {
        /// Vertices in the scene's mesh.
        expected: usize,
        /// Engine vertices in the scene.
        engine: usize,
        /// Vertices in the file.
        found: usize,
    },
    /// A posed position is not finite or exceeds the range of a model.
    #[error(
        "its vertices {} {at}, at vertex {vertex}: export the meshes again",
        if *is_finite {
            format!("exceed {MAGNITUDE_MAX:e}, the most a model can hold,")
        } else {
            "are not finite".to_owned()
        }
    )]
    TargetNumber {
        /// Whether the position is finite, and so too large.
        is_finite: bool,
        /// Name of the frame in its file or clip, or the rest pose.
        at: String,
        /// The vertex.
        vertex: usize,
    },
    /// Copies of a vertex separate in the posed meshes.
    #[error(
        "its vertices {first} and {second} are copies of one vertex of the scene's mesh, split along a seam, but lie \
         {percent:.4} % of the diagonal apart in frame {frame}, expected 0.001 % at most; export both from \
         one mesh"
    )]
    CopiesApart {
        /// First copy.
        first: usize,
        /// Second copy.
        second: usize,
        /// First frame with a separation.
        frame: usize,
        /// Distance in % of the diagonal.
        percent: f64,
    },
    /// The numbers of posed meshes and poses differ.
    #[error(
        "holds {found} meshes, the scene's clips have {expected} frames ({clips}): {}",
        remedy(missing)
    )]
    TargetFrames {
        /// Frames in the clips.
        expected: usize,
        /// Meshes in the file.
        found: usize,
        /// Names of the clips with their numbers of frames.
        clips: String,
        /// Files missing from a numbered sequence.
        missing: Vec<String>,
    },
    /// The posed meshes fit several orders of the clips, but not the given order.
    #[error(
        "its meshes do not follow the scene's clips in their order, {}, but may in several others, as {}: export \
         the meshes over the clips in the scene's order",
        given.join(", "),
        other.join(", ")
    )]
    ClipOrder {
        /// Names of the scene's clips.
        given: Vec<String>,
        /// Names of the clips in the best order.
        other: Vec<String>,
    },
    /// The posed meshes have the vertices in another order.
    #[error(
        "its vertices are those of the scene's mesh, but in another order: export both from one mesh, neither as \
         glTF, which sorts vertices anew; or give an .npz with the `rest` positions of its vertices"
    )]
    VertexOrder,
    /// The rest mesh differs from the model's.
    #[error(
        "its rest mesh is not that of the model in any axes and unit: off by {percent:.1} % of the \
         diagonal at best{}",
        if *is_shuffled {
            ", the same vertices in another order; give a file of the kind that training had"
        } else {
            ""
        }
    )]
    OtherMesh {
        /// RMS distance in % of the diagonal.
        percent: f64,
        /// Whether both meshes have the same positions in another order.
        is_shuffled: bool,
    },
    /// The joints' names differ from the model's, but renaming would match them.
    #[error("its joints have other names than the model's: {mismatch}")]
    OtherNames {
        /// Reason why names do not match, with the option that fixes it.
        mismatch: String,
    },
    /// An animation lacks the character's root joint.
    #[error(
        "has no joint {joint}, the root of the character's: {}",
        mismatch.as_deref().unwrap_or("export the whole skeleton")
    )]
    NoRoot {
        /// Name of the root.
        joint: String,
        /// Reason why names do not match, with the option that fixes it.
        mismatch: Option<String>,
    },
    /// The animation's rest pose differs from the character's.
    #[error(
        "its joints at rest are not the character's: off by {percent:.1} % of the diagonal; export the skeleton \
         in its rest pose, with the animation, or give --mesh a file that says its axes"
    )]
    OtherSkeleton {
        /// RMS distance of joint origins in % of the diagonal.
        percent: f64,
    },
    /// The scene has no mesh, but a mesh is needed.
    #[error(
        "holds joints and no mesh: give a file that has the character's mesh as well, with --mesh or --into{}",
        mismatch.as_ref().map_or(String::new(), |mismatch| format!("; {mismatch}"))
    )]
    JointsAlone {
        /// Reason why names do not match the model's, with the option that fixes it.
        mismatch: Option<String>,
    },
    /// The file's mesh or skeleton differs from the first file's.
    #[error(
        "has {found} {what}, {first} has {expected}: examples in several files are of one character"
    )]
    OtherCounts {
        /// The counted items: vertices or joints.
        what: &'static str,
        /// Number in the first file.
        expected: usize,
        /// Number in this file.
        found: usize,
        /// The first file.
        first: String,
    },
    /// A joint's name or parent differs from the first file's.
    #[error("joint {joint} is {found}, in {first} it is {expected}")]
    OtherJoint {
        /// Number of the joint.
        joint: usize,
        /// Joint and parent in the first file.
        expected: String,
        /// Joint and parent in this file.
        found: String,
        /// The first file.
        first: String,
    },
    /// The rest mesh differs from the first file's.
    #[error(
        "its rest mesh is not that of {first}: off by {percent:.2} % of the diagonal, {}",
        if *is_shuffled {
            "the same vertices in another order; export both with the same settings"
        } else {
            "expected 0.01 % at most; export both in one rest pose, axes and unit"
        }
    )]
    OtherRest {
        /// RMS distance in % of the diagonal.
        percent: f64,
        /// Whether both meshes have the same positions in another order.
        is_shuffled: bool,
        /// The first file.
        first: String,
    },
    /// The rest origins of joints differ from the first file's.
    #[error(
        "its joints at rest are not where {first} has them: off by {percent:.2} % of the diagonal; export \
         both in one rest pose"
    )]
    OtherRestPose {
        /// RMS distance in % of the diagonal.
        percent: f64,
        /// The first file.
        first: String,
    },
    /// The faces differ from the first file's.
    #[error("its faces are not those of {first}; export both from one mesh")]
    OtherFaces {
        /// The first file.
        first: String,
    },
    /// The posed meshes are not near the joints.
    #[error(
        "its meshes do not lie on the scene's joints in any axes and unit: off by {percent:.0} % of \
         the diagonal at best; export them in world space, and over the same frames as the clip"
    )]
    TargetsApart {
        /// RMS distance from one-joint skinning, in % of the diagonal.
        percent: f64,
    },
}

impl ImportError {
    /// Returns whether the posed meshes cause the error, not the scene.
    pub(super) fn is_about_targets(&self) -> bool {
        matches!(
            self,
            Self::TargetVertices { .. }
                | Self::TargetNumber { .. }
                | Self::CopiesApart { .. }
                | Self::TargetFrames { .. }
                | Self::ClipOrder { .. }
                | Self::VertexOrder
                | Self::TargetsApart { .. }
        )
    }
}

/// Returns the advice for a wrong number of meshes.
fn remedy(missing: &[String]) -> String {
    match missing {
        [] => "export both over the same frames, choose the clip with --clip, or sample it at the meshes' rate with \
               --fps"
            .to_owned(),
        [one] => format!("{one} is missing"),
        [one, two] => format!("{one} and {two} are missing"),
        [one, others @ ..] => format!("{one} and {} others are missing", others.len()),
    }
}

/// Formats the allowed numbers of vertices.
fn counts(vertices: usize, engine: usize) -> String {
    if vertices == engine {
        vertices.to_string()
    } else {
        format!("{vertices}, for engines {engine}")
    }
}
