//! The stages: their shaders and their bindings.

use super::resource::Resource;

/// Threads of a workgroup.
pub const WORKGROUP: u32 = 64;

/// A stage of the evaluation, with its name in the runtime. Every instance has its own workgroups.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stage {
    /// Poses to the rotations and the strains of joints that stretch: one thread a joint.
    Polar,
    /// Poses to relative transforms, rotations and gradients: one workgroup.
    Gradients,
    /// Gradients and relative transforms to palettes: one thread a transform.
    Palette,
    /// Poses to the palettes of the kernel predictor: one thread a transform.
    Joints,
    /// Poses, rotations and curves to features: one thread a joint and a curve.
    Features,
    /// Features to the corrections of palettes by the kernel maps: one workgroup a group of
    /// helpers.
    Correction,
    /// Weights of shapes to the rest mesh of a skin: one workgroup a block of vertices.
    Shapes,
    /// Palettes to positions, normals and tangents: one thread a vertex.
    Skin,
    /// Rotations, or features and the confidences of the groups, to one number: one workgroup.
    Confidence,
    /// Queries of a kernel to outputs and the confidence in them: one workgroup.
    Kernel,
    /// Samples of signals to finer ones: one thread a number.
    Filter,
}

/// One binding of a stage, in group (set) 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Binding {
    /// Resource to bind; its index in [`Stage::bindings`] is the binding's number.
    pub resource: Resource,
    /// Whether the stage writes to it.
    pub writable: bool,
}

impl Binding {
    const fn read(resource: Resource) -> Self {
        Self { resource, writable: false }
    }

    const fn write(resource: Resource) -> Self {
        Self { resource, writable: true }
    }
}

macro_rules! wgsl {
    ($($stem:literal),*) => {
        concat!($(include_str!(concat!("../../shaders/", $stem, ".wgsl"))),*)
    };
}

macro_rules! spirv {
    ($stem:literal) => {
        include_bytes!(concat!("../../shaders/spirv/", $stem, ".spv"))
    };
}

impl Stage {
    /// Every stage, each after the stages that it reads from. No stage reads confidences, so
    /// `confidence` follows `skin`, and `skin` need not wait for it.
    pub const ALL: [Self; 11] = [
        Self::Polar,
        Self::Gradients,
        Self::Palette,
        Self::Joints,
        Self::Features,
        Self::Correction,
        Self::Shapes,
        Self::Skin,
        Self::Confidence,
        Self::Kernel,
        Self::Filter,
    ];

    /// Returns the stage's name: the stem of its shaders and of its module in the runtime.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Polar => "polar",
            Self::Gradients => "gradients",
            Self::Palette => "palette",
            Self::Joints => "joints",
            Self::Features => "features",
            Self::Correction => "correction",
            Self::Confidence => "confidence",
            Self::Shapes => "shapes",
            Self::Skin => "skin",
            Self::Kernel => "kernel",
            Self::Filter => "filter",
        }
    }

    /// Returns the complete WGSL; the entry point is `main`.
    pub const fn wgsl(self) -> &'static str {
        match self {
            Self::Polar => wgsl!("params", "blob", "joint", "nearest", "polar"),
            Self::Gradients => {
                wgsl!("params", "blob", "numeric", "rotation", "joint", "gradients")
            }
            Self::Palette => wgsl!("params", "blob", "palette"),
            Self::Joints => wgsl!("params", "blob", "joints"),
            Self::Features => wgsl!("params", "blob", "rotation", "joint", "features"),
            Self::Correction => {
                wgsl!("params", "blob", "numeric", "joint", "nearest", "correction")
            }
            Self::Confidence => wgsl!("params", "blob", "numeric", "joint", "confidence"),
            Self::Shapes => wgsl!("shapes_params", "blob", "frame", "shapes"),
            Self::Skin => wgsl!("params", "blob", "frame", "skin"),
            Self::Kernel => wgsl!(
                "kernel_params",
                "blob",
                "numeric",
                "kernel_value",
                "kernel_features",
                "kernel_outputs",
                "kernel"
            ),
            Self::Filter => wgsl!("filter_params", "blob", "filter"),
        }
    }

    /// Returns the SPIR-V that glslang makes of the GLSL, in little-endian words; the entry point
    /// is `main`.
    pub const fn spirv(self) -> &'static [u8] {
        match self {
            Self::Polar => spirv!("polar"),
            Self::Gradients => spirv!("gradients"),
            Self::Palette => spirv!("palette"),
            Self::Joints => spirv!("joints"),
            Self::Features => spirv!("features"),
            Self::Correction => spirv!("correction"),
            Self::Confidence => spirv!("confidence"),
            Self::Shapes => spirv!("shapes"),
            Self::Skin => spirv!("skin"),
            Self::Kernel => spirv!("kernel"),
            Self::Filter => spirv!("filter"),
        }
    }

    /// Lists the bindings: number 0 is the uniform [`Resource::Params`], the others are at most
    /// four storage buffers.
    pub const fn bindings(self) -> &'static [Binding] {
        use Resource::{
            Blob, Confidences, Curves, Host, Out, Palettes, Params, Poses, Queries, Samples,
            Scratch, Weights,
        };
        const PARAMS: Binding = Binding::read(Params);
        const BLOB: Binding = Binding::read(Blob);
        const POSES: Binding = Binding::read(Poses);
        const CURVES: Binding = Binding::read(Curves);
        const QUERIES: Binding = Binding::read(Queries);
        const WEIGHTS: Binding = Binding::read(Weights);
        const SAMPLES: Binding = Binding::read(Samples);
        const SCRATCH: Binding = Binding::read(Scratch);
        const PALETTES: Binding = Binding::read(Palettes);
        const HOST: Binding = Binding::read(Host);
        const OUT_SCRATCH: Binding = Binding::write(Scratch);
        const OUT_PALETTES: Binding = Binding::write(Palettes);
        const OUT_CONFIDENCES: Binding = Binding::write(Confidences);
        const OUT: Binding = Binding::write(Out);
        match self {
            Self::Polar | Self::Gradients => &[PARAMS, BLOB, POSES, OUT_SCRATCH],
            Self::Features => &[PARAMS, BLOB, POSES, CURVES, OUT_SCRATCH],
            Self::Palette => &[PARAMS, BLOB, POSES, SCRATCH, OUT_PALETTES],
            Self::Joints => &[PARAMS, BLOB, POSES, OUT_PALETTES],
            Self::Correction => &[PARAMS, BLOB, POSES, OUT_SCRATCH, OUT_PALETTES],
            Self::Shapes => &[PARAMS, BLOB, WEIGHTS, OUT],
            Self::Skin => &[PARAMS, BLOB, PALETTES, HOST, OUT],
            Self::Confidence => &[PARAMS, BLOB, POSES, SCRATCH, OUT_CONFIDENCES],
            Self::Kernel => &[PARAMS, BLOB, QUERIES, OUT_SCRATCH, OUT],
            Self::Filter => &[PARAMS, BLOB, SAMPLES, OUT],
        }
    }
}
