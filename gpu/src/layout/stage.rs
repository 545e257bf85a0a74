//! The stages: their shaders, what these bind, and how many threads they need.

use super::Resource;
use sinew_runtime::Envelope;

/// Threads of a workgroup.
pub const WORKGROUP: u32 = 64;

/// A stage of the evaluation, by the name it has in the runtime.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stage {
    /// Poses to relative maps, rotations and gradients: one workgroup an instance.
    Gradients,
    /// Gradients and relative maps to palettes: one thread a map.
    Palette,
    /// Poses to the palettes of the kernel predictor: one thread a map.
    Joints,
    /// Poses to features: one thread a joint.
    Features,
    /// Features to what the kernel maps add to palettes: one workgroup a group of proxies.
    Correction,
    /// Rotations, or what the correction has found, to one number: one thread an instance.
    Confidence,
    /// Palettes to positions, normals and tangents: one thread a vertex.
    Skin,
}

/// One binding of a stage, in group (set) 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Binding {
    /// What is bound, at the place that it has in [`Stage::bindings`].
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
        concat!($(include_str!(concat!("../../../shaders/", $stem, ".wgsl"))),*)
    };
}

macro_rules! spirv {
    ($stem:literal) => {
        include_bytes!(concat!("../../../shaders/spirv/", $stem, ".spv"))
    };
}

impl Stage {
    /// Every stage, in an order in which each comes after those that it reads from.
    pub const ALL: [Self; 7] = [
        Self::Gradients,
        Self::Palette,
        Self::Joints,
        Self::Features,
        Self::Correction,
        Self::Confidence,
        Self::Skin,
    ];

    /// Returns its name: the stem of its shaders and of its module in the runtime.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Gradients => "gradients",
            Self::Palette => "palette",
            Self::Joints => "joints",
            Self::Features => "features",
            Self::Correction => "correction",
            Self::Confidence => "confidence",
            Self::Skin => "skin",
        }
    }

    /// Returns its WGSL, whole; the entry point is `main`.
    pub const fn wgsl(self) -> &'static str {
        match self {
            Self::Gradients => wgsl!("params", "numeric", "gradients"),
            Self::Palette => wgsl!("params", "palette"),
            Self::Joints => wgsl!("params", "joints"),
            Self::Features => wgsl!("params", "features"),
            Self::Correction => wgsl!("params", "numeric", "correction"),
            Self::Confidence => wgsl!("params", "numeric", "confidence"),
            Self::Skin => wgsl!("params", "skin"),
        }
    }

    /// Returns the SPIR-V that glslang makes of its GLSL, little-endian words; the entry point is
    /// `main`.
    pub const fn spirv(self) -> &'static [u8] {
        match self {
            Self::Gradients => spirv!("gradients"),
            Self::Palette => spirv!("palette"),
            Self::Joints => spirv!("joints"),
            Self::Features => spirv!("features"),
            Self::Correction => spirv!("correction"),
            Self::Confidence => spirv!("confidence"),
            Self::Skin => spirv!("skin"),
        }
    }

    /// Lists what it binds: number 0 the uniform [`Resource::Params`], the others storage buffers,
    /// four at most.
    pub const fn bindings(self) -> &'static [Binding] {
        use Resource::{Blob, Confidences, OutA, OutB, Palettes, Params, Poses, Work};
        const PARAMS: Binding = Binding::read(Params);
        const BLOB: Binding = Binding::read(Blob);
        const POSES: Binding = Binding::read(Poses);
        const WORK: Binding = Binding::read(Work);
        const PALETTES: Binding = Binding::read(Palettes);
        const OUT_WORK: Binding = Binding::write(Work);
        const OUT_PALETTES: Binding = Binding::write(Palettes);
        const OUT_CONFIDENCES: Binding = Binding::write(Confidences);
        const OUT_A: Binding = Binding::write(OutA);
        const OUT_B: Binding = Binding::write(OutB);
        match self {
            Self::Gradients | Self::Features => &[PARAMS, BLOB, POSES, OUT_WORK],
            Self::Palette => &[PARAMS, BLOB, POSES, WORK, OUT_PALETTES],
            Self::Joints => &[PARAMS, BLOB, POSES, OUT_PALETTES],
            Self::Correction => &[PARAMS, BLOB, POSES, OUT_WORK, OUT_PALETTES],
            Self::Confidence => &[PARAMS, BLOB, WORK, OUT_CONFIDENCES],
            Self::Skin => &[PARAMS, BLOB, PALETTES, OUT_A, OUT_B],
        }
    }

    /// Counts what an instance of a batch is cut into, of `vertex_len` vertices to skin: whole
    /// workgroups, or threads.
    pub(crate) fn work_len(self, envelope: &Envelope<'_>, vertex_len: usize) -> WorkLen {
        match self {
            Self::Gradients => WorkLen::Groups(1),
            Self::Palette => WorkLen::Threads(envelope.proxy_len()),
            Self::Joints => WorkLen::Threads(envelope.palette_len()),
            Self::Features => WorkLen::Threads(envelope.joint_len()),
            Self::Correction => WorkLen::Groups(envelope.group_len()),
            Self::Confidence => WorkLen::Threads(1),
            Self::Skin => WorkLen::Threads(vertex_len),
        }
    }
}

/// What one instance needs of a dispatch.
#[derive(Clone, Copy, Debug)]
pub(crate) enum WorkLen {
    /// So many workgroups; workgroup w does item w mod n of instance w / n.
    Groups(usize),
    /// So many threads, of workgroups that instances share; thread t does item t mod n of instance
    /// t / n.
    Threads(usize),
}

impl WorkLen {
    /// Counts the workgroups of a number of instances.
    pub(crate) fn groups(self, instances: usize) -> u64 {
        match self {
            Self::Groups(n) => n as u64 * instances as u64,
            Self::Threads(n) => (n as u64 * instances as u64).div_ceil(WORKGROUP.into()),
        }
    }
}
