//! What keeps a scene from becoming examples, and what to export instead.

use sinew_runtime::format::MAGNITUDE_MAX;

/// A scene and posed meshes that do not go together, or are not enough.
#[derive(Debug, thiserror::Error)]
pub enum ImportError {
    /// What only goes with a scene was given with examples that are complete.
    #[error(
        "{option} goes with a scene (.glb, .gltf, .fbx); an .npz holds its own poses and meshes"
    )]
    NotAScene {
        /// What was given.
        option: &'static str,
    },
    /// A file of posed meshes was given where a scene is read.
    #[error(
        "holds posed meshes, but no joints to learn from: give the scene with the joints (.fbx, .glb, .gltf), and \
         this file as --targets"
    )]
    MeshesAlone,
    /// Posed meshes follow at one rate, the clip's keys do not.
    #[error(
        "clip {clip} has non-uniform key times: a step of {step:.4} s at {at:.4} s, elsewhere \
         {usual:.4} s; bake a key at every frame when exporting, or give the frames a second that \
         the meshes were exported at as --fps"
    )]
    UnevenKeys {
        /// The clip.
        clip: String,
        /// Where the uneven step begins, in seconds.
        at: f64,
        /// How long it is, in seconds.
        step: f64,
        /// How long the others are, in seconds.
        usual: f64,
    },
    /// There are poses but no meshes to learn.
    #[error(
        "holds poses but neither a skin nor shapes: give the posed meshes as --targets (.abc, .pc2, .mdd, \
         .npz, or a numbered sequence of .obj)"
    )]
    NoShapes,
    /// The posed meshes are of another mesh.
    #[error(
        "holds meshes of {found} vertices, the scene's mesh has {}: export both from one mesh \
         without modifiers that change its vertices; glTF splits vertices along seams of texture and \
         normals, FBX does not",
        counts(*expected, *engine)
    )]
    TargetVertices {
        /// In the scene.
        expected: usize,
        /// In the scene as an engine draws it.
        engine: usize,
        /// In the file.
        found: usize,
    },
    /// A position of the posed meshes is not finite, or too large for a model.
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
        /// In which frame, as its file or the scene's clip calls it, or at rest.
        at: String,
        /// The vertex.
        vertex: usize,
    },
    /// Copies of one vertex of the scene's move apart in the posed meshes.
    #[error(
        "its vertices {first} and {second} are one of the scene's mesh, split along a seam, but lie \
         {percent:.4} % of the diagonal apart in frame {frame}, expected 0.001 % at most; export both from \
         one mesh"
    )]
    CopiesApart {
        /// One of them.
        first: usize,
        /// The other.
        second: usize,
        /// The first frame in which they part.
        frame: usize,
        /// How far, in % of the diagonal.
        percent: f64,
    },
    /// There are not as many posed meshes as poses.
    #[error(
        "holds {found} meshes, the scene's clips have {expected} frames ({clips}): {}",
        remedy(missing)
    )]
    TargetFrames {
        /// Frames of the clips.
        expected: usize,
        /// Meshes in the file.
        found: usize,
        /// The clips and their frames.
        clips: String,
        /// Files that a sequence leaves out.
        missing: Vec<String>,
    },
    /// The posed meshes fit the clips in several orders, but not in that given.
    #[error(
        "its meshes do not follow the scene's clips in their order, {}, but may in several others, as {}: export \
         the meshes over the clips in the scene's order",
        given.join(", "),
        other.join(", ")
    )]
    ClipOrder {
        /// The scene's clips.
        given: Vec<String>,
        /// The clips in the order that fits best.
        other: Vec<String>,
    },
    /// The posed meshes' vertices have another order.
    #[error(
        "its vertices are those of the scene's mesh, but in another order: export both from one mesh, neither as \
         glTF, which sorts vertices anew; or give an .npz with the `rest` positions of its vertices"
    )]
    VertexOrder,
    /// The rest mesh is another one.
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
        /// Whether the places of all vertices are the same.
        is_shuffled: bool,
    },
    /// The joints are not called as the model's, but would be by other names.
    #[error("its joints are not called as the model's: {mismatch}")]
    OtherNames {
        /// What keeps the names from matching, and the option that mends it.
        mismatch: String,
    },
    /// An animation lacks the root of the character's joints.
    #[error(
        "has no joint {joint}, the root of the character's: {}",
        mismatch.as_deref().unwrap_or("export the whole skeleton")
    )]
    NoRoot {
        /// The root.
        joint: String,
        /// What keeps names from matching, and the option that mends it.
        mismatch: Option<String>,
    },
    /// An animation's joints at rest are not the character's.
    #[error(
        "its joints at rest are not the character's: off by {percent:.1} % of the diagonal; export the skeleton \
         in its rest pose, with the animation, or give --mesh a file that says its axes"
    )]
    OtherSkeleton {
        /// RMS distance of their origins in % of the diagonal.
        percent: f64,
    },
    /// A scene without a mesh was given where a mesh is needed.
    #[error(
        "holds joints and no mesh: give a file that has the character's mesh as well, with --mesh or --into{}",
        mismatch.as_ref().map_or(String::new(), |mismatch| format!("; {mismatch}"))
    )]
    JointsAlone {
        /// What keeps its names from those of the model, and the option that mends it.
        mismatch: Option<String>,
    },
    /// A file beside others has another mesh, or another skeleton.
    #[error(
        "has {found} {what}, {first} has {expected}: examples in several files are of one character"
    )]
    OtherCounts {
        /// Vertices or joints.
        what: &'static str,
        /// In the first file.
        expected: usize,
        /// In this one.
        found: usize,
        /// The first file.
        first: String,
    },
    /// A joint has another name, or another parent, than in the first of several files.
    #[error("joint {joint} is {found}, in {first} it is {expected}")]
    OtherJoint {
        /// The joint.
        joint: usize,
        /// In the first file.
        expected: String,
        /// In this one.
        found: String,
        /// The first file.
        first: String,
    },
    /// The rest mesh is another one than in the first of several files.
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
        /// Whether the places of all vertices are the same.
        is_shuffled: bool,
        /// The first file.
        first: String,
    },
    /// Joints at rest are elsewhere than in the first of several files.
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
    /// The faces are others than in the first of several files.
    #[error("its faces are not those of {first}; export both from one mesh")]
    OtherFaces {
        /// The first file.
        first: String,
    },
    /// The posed meshes are not where the joints are.
    #[error(
        "its meshes do not lie on the scene's joints in any axes and unit: off by {percent:.0} % of \
         the diagonal at best; export them in world space, and over the same frames as the clip"
    )]
    TargetsApart {
        /// RMS distance from the nearest rigid skin, in % of the diagonal.
        percent: f64,
    },
}

impl ImportError {
    /// Tells whether the posed meshes are at fault, not the scene.
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

/// Says what to do about a count of meshes.
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

/// Names the counts of vertices that posed meshes may have.
fn counts(vertices: usize, engine: usize) -> String {
    if vertices == engine {
        vertices.to_string()
    } else {
        format!("{vertices}, for engines {engine}")
    }
}
