//! Limits for an untrusted file.

/// Largest counts that a file may have. A file above a limit is refused before it costs anything.
///
/// The work of loading and evaluating grows only with these counts. Each byte of a kernel map costs
/// one multiplication, and one per feature in a kernel's Jacobian.
// The C ABI reads and writes this structure as `sinew_limits`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
#[cfg_attr(not(feature = "internals"), non_exhaustive)]
pub struct Limits {
    /// Bytes of the file.
    pub file_bytes: u32,
    /// Parts of the file.
    pub parts: u16,
    /// Sections of the file. Loading compares every pair.
    pub sections: u16,
    /// Vertices of a skin.
    pub vertices: u32,
    /// Joints of an envelope; the format's own limit is 65,535.
    pub joints: u32,
    /// Proxies of an envelope; the format's own limit is 65,535.
    pub proxies: u32,
    /// Influences of a vertex.
    pub influences: u32,
    /// Shapes of a skin; the format's own limit is 65,535.
    pub shapes: u32,
    /// Curves of an envelope; the format's own limit is 65,535.
    pub curves: u32,
}

impl Limits {
    /// Generous limits for any character: a film mesh, a full face rig, and c1 below 40 MB.
    pub const DEFAULT: Self = Self {
        file_bytes: 1 << 30,
        parts: 64,
        sections: 512,
        vertices: 1 << 22,
        joints: 4096,
        proxies: 1024,
        influences: 32,
        shapes: 4096,
        curves: 4096,
    };

    /// Limits of the format itself.
    pub(crate) const FORMAT: Self = Self {
        file_bytes: u32::MAX,
        parts: u16::MAX,
        sections: u16::MAX,
        vertices: u32::MAX,
        joints: u32::MAX,
        proxies: u32::MAX,
        influences: u32::MAX,
        shapes: u32::MAX,
        curves: u32::MAX,
    };
}

impl Default for Limits {
    fn default() -> Self {
        Self::DEFAULT
    }
}
