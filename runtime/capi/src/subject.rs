//! What an error is about.

use core::ffi::{CStr, c_char};
use sinew_runtime::format::SectionKind;
use sinew_runtime::{Argument, Quantity};

/// What an error is about: an argument (below 64), a quantity (from 64), a section of the file
/// (128 and the section's number).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u32)]
pub enum sinew_subject {
    /// Nothing in particular.
    None = 0,
    /// Memory for an object; lengths in bytes.
    Memory = 1,
    /// Bytes of the file.
    File = 2,
    /// Limits.
    Limits = 3,
    /// Handle of a model.
    Model = 4,
    /// Handle of an envelope.
    Envelope = 5,
    /// A name; lengths in bytes.
    Name = 6,
    /// Local transforms of the joints.
    Local = 7,
    /// Skinning matrices of the joints.
    Pose = 8,
    /// Scratch; lengths in floats.
    Workspace = 9,
    /// The palette; lengths in matrices.
    Palette = 10,
    /// A skin job.
    Job = 11,
    /// Output buffer A; lengths in floats.
    OutA = 12,
    /// Output buffer B; lengths in floats.
    OutB = 13,
    /// Positions.
    Positions = 14,
    /// Normals.
    Normals = 15,
    /// Tangents.
    Tangents = 16,
    /// Palette indices of influences.
    Indices = 17,
    /// Weights of influences.
    Weights = 18,
    /// Evaluation order of the joints.
    Order = 19,
    /// Where a result goes.
    Result = 20,
    /// Where a second result goes.
    SecondResult = 21,

    /// Bytes of the file.
    FileBytes = 64,
    /// Vertices.
    Vertices = 65,
    /// Joints.
    Joints = 66,
    /// Proxies.
    Proxies = 67,
    /// Influences of a vertex.
    Influences = 68,
    /// Groups of proxies.
    Groups = 69,

    /// The certificate.
    Certificate = 128,
    /// Section: names.
    SectionNames = 129,
    /// Section: hierarchy.
    SectionHierarchy = 130,
    /// Section: inverse bind matrices.
    SectionInverseBinds = 131,
    /// Section: rest positions.
    SectionRestPositions = 132,
    /// Section: rest normals.
    SectionRestNormals = 133,
    /// Section: rest tangents.
    SectionRestTangents = 134,
    /// Section: palette index of each influence.
    SectionInfluenceIndices = 135,
    /// Section: weight of each influence.
    SectionInfluenceWeights = 136,
    /// Section: key predictors.
    SectionKeys = 137,
    /// Section: gradients to palette.
    SectionC1 = 138,
    /// Section: joints to palette.
    SectionC2 = 139,
    /// Section: rest box of what each map moves.
    SectionRestBoxes = 140,
    /// Section: largest rotation of each joint in training.
    SectionPoseRanges = 141,
    /// Section: origin of each joint in the rest pose.
    SectionOrigins = 142,
    /// Section: groups of proxies that share a kernel map.
    SectionGroups = 143,
    /// Section: numbers of the kernel maps.
    SectionCorrections = 144,
}

impl sinew_subject {
    /// Returns its name.
    pub const fn text(self) -> &'static CStr {
        match self {
            Self::None => c"nothing in particular",
            Self::Memory => c"memory",
            Self::File => c"file",
            Self::Limits => c"limits",
            Self::Model => c"model",
            Self::Envelope => c"envelope",
            Self::Name => c"name",
            Self::Local => c"local transforms",
            Self::Pose => c"pose",
            Self::Workspace => c"workspace",
            Self::Palette => c"palette",
            Self::Job => c"job",
            Self::OutA => c"output a",
            Self::OutB => c"output b",
            Self::Positions => c"positions",
            Self::Normals => c"normals",
            Self::Tangents => c"tangents",
            Self::Indices => c"indices",
            Self::Weights => c"weights",
            Self::Order => c"order",
            Self::Result => c"result",
            Self::SecondResult => c"second result",
            Self::FileBytes => c"file bytes",
            Self::Vertices => c"vertices",
            Self::Joints => c"joints",
            Self::Proxies => c"proxies",
            Self::Influences => c"influences",
            Self::Groups => c"groups",
            Self::Certificate => c"certificate",
            Self::SectionNames => c"section names",
            Self::SectionHierarchy => c"section hierarchy",
            Self::SectionInverseBinds => c"section inverse_binds",
            Self::SectionRestPositions => c"section rest_positions",
            Self::SectionRestNormals => c"section rest_normals",
            Self::SectionRestTangents => c"section rest_tangents",
            Self::SectionInfluenceIndices => c"section influence_indices",
            Self::SectionInfluenceWeights => c"section influence_weights",
            Self::SectionKeys => c"section keys",
            Self::SectionC1 => c"section c1",
            Self::SectionC2 => c"section c2",
            Self::SectionRestBoxes => c"section rest_boxes",
            Self::SectionPoseRanges => c"section pose_ranges",
            Self::SectionOrigins => c"section origins",
            Self::SectionGroups => c"section groups",
            Self::SectionCorrections => c"section corrections",
        }
    }
}

/// Returns the name of a subject, ended by a zero; of any other number, that it is unknown. Never
/// null, valid for ever.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_subject_text(subject: u32) -> *const c_char {
    const ALL: [sinew_subject; 45] = [
        sinew_subject::None,
        sinew_subject::Memory,
        sinew_subject::File,
        sinew_subject::Limits,
        sinew_subject::Model,
        sinew_subject::Envelope,
        sinew_subject::Name,
        sinew_subject::Local,
        sinew_subject::Pose,
        sinew_subject::Workspace,
        sinew_subject::Palette,
        sinew_subject::Job,
        sinew_subject::OutA,
        sinew_subject::OutB,
        sinew_subject::Positions,
        sinew_subject::Normals,
        sinew_subject::Tangents,
        sinew_subject::Indices,
        sinew_subject::Weights,
        sinew_subject::Order,
        sinew_subject::Result,
        sinew_subject::SecondResult,
        sinew_subject::FileBytes,
        sinew_subject::Vertices,
        sinew_subject::Joints,
        sinew_subject::Proxies,
        sinew_subject::Influences,
        sinew_subject::Groups,
        sinew_subject::Certificate,
        sinew_subject::SectionNames,
        sinew_subject::SectionHierarchy,
        sinew_subject::SectionInverseBinds,
        sinew_subject::SectionRestPositions,
        sinew_subject::SectionRestNormals,
        sinew_subject::SectionRestTangents,
        sinew_subject::SectionInfluenceIndices,
        sinew_subject::SectionInfluenceWeights,
        sinew_subject::SectionKeys,
        sinew_subject::SectionC1,
        sinew_subject::SectionC2,
        sinew_subject::SectionRestBoxes,
        sinew_subject::SectionPoseRanges,
        sinew_subject::SectionOrigins,
        sinew_subject::SectionGroups,
        sinew_subject::SectionCorrections,
    ];
    let found = ALL.into_iter().find(|known| *known as u32 == subject);
    found.map_or(c"unknown subject", sinew_subject::text).as_ptr()
}

impl From<Argument> for sinew_subject {
    fn from(argument: Argument) -> Self {
        match argument {
            Argument::Pose => Self::Pose,
            Argument::Palette => Self::Palette,
            Argument::OutA => Self::OutA,
            Argument::OutB => Self::OutB,
            // What single stages are given is cut from the workspace here.
            Argument::Workspace
            | Argument::Relative
            | Argument::Rotations
            | Argument::Gradients
            | Argument::Features
            | Argument::Scratch => Self::Workspace,
        }
    }
}

impl From<Quantity> for sinew_subject {
    fn from(quantity: Quantity) -> Self {
        match quantity {
            Quantity::FileBytes => Self::FileBytes,
            Quantity::Vertices => Self::Vertices,
            Quantity::Joints => Self::Joints,
            Quantity::Proxies => Self::Proxies,
            Quantity::Influences => Self::Influences,
            Quantity::Groups => Self::Groups,
        }
    }
}

impl From<SectionKind> for sinew_subject {
    fn from(section: SectionKind) -> Self {
        match section {
            SectionKind::Names => Self::SectionNames,
            SectionKind::Hierarchy => Self::SectionHierarchy,
            SectionKind::InverseBinds => Self::SectionInverseBinds,
            SectionKind::RestPositions => Self::SectionRestPositions,
            SectionKind::RestNormals => Self::SectionRestNormals,
            SectionKind::RestTangents => Self::SectionRestTangents,
            SectionKind::InfluenceIndices => Self::SectionInfluenceIndices,
            SectionKind::InfluenceWeights => Self::SectionInfluenceWeights,
            SectionKind::Keys => Self::SectionKeys,
            SectionKind::C1 => Self::SectionC1,
            SectionKind::C2 => Self::SectionC2,
            SectionKind::RestBoxes => Self::SectionRestBoxes,
            SectionKind::PoseRanges => Self::SectionPoseRanges,
            SectionKind::Origins => Self::SectionOrigins,
            SectionKind::Groups => Self::SectionGroups,
            SectionKind::Corrections => Self::SectionCorrections,
        }
    }
}
