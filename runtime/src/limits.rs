//! What a caller is willing to load.

/// The most of everything that a file may hold; a file beyond it is refused before it costs anything.
///
/// All work, in loading and in evaluating, grows with these counts and with nothing else: each
/// byte of a kernel map costs one multiplication.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of the file.
    pub file_bytes: u32,
    /// Vertices of a part.
    pub vertices: u32,
    /// Joints of a part; the format itself holds at most 65,535.
    pub joints: u32,
    /// Proxies of a part; the format itself holds at most 65,535.
    pub proxies: u32,
    /// Influences of a vertex.
    pub influences: u32,
}

impl Limits {
    /// Generous for any character: a film mesh, a full face rig, and c1 below 40 MB.
    pub const DEFAULT: Self = Self {
        file_bytes: 1 << 30,
        vertices: 1 << 22,
        joints: 4096,
        proxies: 1024,
        influences: 32,
    };
}

impl Default for Limits {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// What a [`Limits`] or the format bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Bytes of the file.
    FileBytes,
    /// Vertices of a part.
    Vertices,
    /// Joints of a part.
    Joints,
    /// Proxies of a part.
    Proxies,
    /// Influences of a vertex.
    Influences,
    /// Groups of a part: each owns a proxy, so that their number needs no limit of its own.
    Groups,
}

impl Quantity {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::FileBytes => "file bytes",
            Self::Vertices => "vertices",
            Self::Joints => "joints",
            Self::Proxies => "proxies",
            Self::Influences => "influences",
            Self::Groups => "groups",
        }
    }
}
