//! Rows of the two tables, and the sections of an envelope with their sizes.

use super::GroupRow;
use crate::error::FormatError;

/// Stands for no joint: the parent of the root, the residual joint of a key that has none.
pub const NO_JOINT: u16 = u16::MAX;
/// 4-byte words of a key: two joints (u16), twist 9, residual twist 9, shear 36.
pub const KEY_WORDS: usize = 1 + 9 + 9 + 36;

/// The four kinds of part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum PartKind {
    /// Pose to skin (METHOD §1).
    Envelope = 1,
    /// Any map learnt from samples (METHOD §2).
    Kernel = 2,
    /// Blendshapes and pins (METHOD §5).
    Face = 3,
    /// Memory-based 2-D graphics (METHOD §6).
    Views = 4,
}

impl PartKind {
    /// Every kind.
    pub const ALL: [Self; 4] = [Self::Envelope, Self::Kernel, Self::Face, Self::Views];

    /// Returns its number in the file.
    pub const fn number(self) -> u8 {
        self as u8
    }

    /// Returns its name, the same as on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Envelope => "envelope",
            Self::Kernel => "kernel",
            Self::Face => "face",
            Self::Views => "views",
        }
    }

    /// Returns the kind of this number.
    pub fn from_number(number: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.number() == number)
    }
}

/// How an envelope predicts its palette (METHOD §1.9).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Predictor {
    /// Rotational regression and reconstruction (S3): the palette is the P proxies alone.
    Rotational = 1,
    /// The J joints, and P helpers that a kernel map moves against their dominant joints.
    Kernel = 2,
    /// The P proxies of the reconstruction, and a kernel map for what it leaves over.
    Hybrid = 3,
}

impl Predictor {
    /// Every predictor.
    pub const ALL: [Self; 3] = [Self::Rotational, Self::Kernel, Self::Hybrid];

    /// Returns its number in the file.
    pub const fn number(self) -> u8 {
        self as u8
    }

    /// Returns its name, the same as on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Rotational => "rotational",
            Self::Kernel => "kernel",
            Self::Hybrid => "hybrid",
        }
    }

    /// Returns the predictor of this number.
    pub fn from_number(number: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|predictor| predictor.number() == number)
    }

    /// Whether the proxies' base is the reconstruction `c1 d + c2 q`.
    pub const fn reconstructs(self) -> bool {
        matches!(self, Self::Rotational | Self::Hybrid)
    }

    /// Whether kernel maps correct the proxies.
    pub const fn corrects(self) -> bool {
        matches!(self, Self::Kernel | Self::Hybrid)
    }
}

/// What the fit was measured to reach, in the units of the input.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Certificate {
    /// Diagonal of the rest pose's box.
    pub diagonal: f32,
    /// RMS error over vertices and training frames.
    pub training_rms: f32,
    /// The same, each frame predicted by a fit that had not seen its fold.
    pub cross_validated_rms: f32,
    /// The same, of linear blend skinning.
    pub lbs_training_rms: f32,
    /// The farthest that single precision may move a vertex through the correction; 0 without one.
    pub correction_error: f32,
}

/// Counts of an envelope, from which every section's length follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EnvelopeCounts {
    /// Vertices, V.
    pub vertex_len: u32,
    /// Joints, J.
    pub joint_len: u32,
    /// Proxies, P.
    pub proxy_len: u32,
    /// Influences of a vertex, K.
    pub influence_len: u32,
    /// The reference root joint.
    pub root: u32,
    /// Groups, G.
    pub group_len: u32,
    /// Floats of scratch that the correction needs beside the features.
    pub scratch_len: u32,
}

impl EnvelopeCounts {
    /// Returns the number of maps in the palette: P, or J + P for the kernel predictor.
    pub const fn palette_len(&self, predictor: Predictor) -> usize {
        let joints = if predictor.reconstructs() { 0 } else { self.joint_len as usize };
        joints.saturating_add(self.proxy_len as usize)
    }
}

/// A row of the part table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartRow {
    /// Number of a [`PartKind`].
    pub kind: u8,
    /// Number of a [`Predictor`], for an envelope.
    pub predictor: u8,
    /// Bit 0: a reader that does not know the kind must refuse the file.
    pub flags: u16,
    /// Counts: V, J, P, K, root, G, scratch of an envelope.
    pub counts: [u32; 7],
    /// Figures: the certificate of an envelope.
    pub figures: [f32; 5],
}

impl PartRow {
    /// Bytes of a row.
    pub const BYTES: usize = 52;

    /// Makes the row of an envelope.
    pub fn envelope(
        predictor: Predictor,
        counts: EnvelopeCounts,
        certificate: Certificate,
    ) -> Self {
        let (n, c) = (counts, certificate);
        Self {
            kind: PartKind::Envelope.number(),
            predictor: predictor.number(),
            flags: REQUIRED,
            counts: [
                n.vertex_len,
                n.joint_len,
                n.proxy_len,
                n.influence_len,
                n.root,
                n.group_len,
                n.scratch_len,
            ],
            figures: [
                c.diagonal,
                c.training_rms,
                c.cross_validated_rms,
                c.lbs_training_rms,
                c.correction_error,
            ],
        }
    }

    /// Reads the counts of an envelope.
    pub fn envelope_counts(&self) -> EnvelopeCounts {
        let [vertex_len, joint_len, proxy_len, influence_len, root, group_len, scratch_len] =
            self.counts;
        EnvelopeCounts {
            vertex_len,
            joint_len,
            proxy_len,
            influence_len,
            root,
            group_len,
            scratch_len,
        }
    }

    /// Reads the certificate of an envelope.
    pub fn certificate(&self) -> Certificate {
        let [diagonal, training_rms, cross_validated_rms, lbs_training_rms, correction_error] =
            self.figures;
        Certificate {
            diagonal,
            training_rms,
            cross_validated_rms,
            lbs_training_rms,
            correction_error,
        }
    }

    /// Whether a reader that does not know this part must refuse the file.
    pub fn required(&self) -> bool {
        self.flags & REQUIRED != 0
    }

    /// Writes the row: kind, predictor, flags, counts, figures, little-endian.
    pub fn to_bytes(&self) -> [u8; Self::BYTES] {
        let mut words = [[0; 4]; Self::BYTES / 4];
        let [low, high] = self.flags.to_le_bytes();
        let counts = self.counts.map(u32::to_le_bytes);
        let figures = self.figures.map(f32::to_le_bytes);
        let content = [[self.kind, self.predictor, low, high]].into_iter().chain(counts);
        for (word, value) in words.iter_mut().zip(content.chain(figures)) {
            *word = value;
        }
        let mut out = [0; Self::BYTES];
        out.copy_from_slice(words.as_flattened());
        out
    }

    /// Reads a row.
    pub fn from_bytes(bytes: &[u8; Self::BYTES]) -> Self {
        let mut words = bytes.as_chunks::<4>().0.iter().copied();
        let mut word = || words.next().unwrap_or_default();
        let [kind, predictor, low, high] = word();
        Self {
            kind,
            predictor,
            flags: u16::from_le_bytes([low, high]),
            counts: [(); 7].map(|()| u32::from_le_bytes(word())),
            figures: [(); 5].map(|()| f32::from_le_bytes(word())),
        }
    }
}

/// A row of the section table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SectionRow {
    /// Number of a [`SectionKind`].
    pub kind: u16,
    /// Row of the part table that it belongs to.
    pub part: u8,
    /// Bit 0: a reader that does not know the kind must refuse the file.
    pub flags: u8,
    /// Where it starts, in bytes from the blob's start.
    pub offset: u32,
    /// Its length in bytes.
    pub bytes: u32,
}

impl SectionRow {
    /// Bytes of a row.
    pub const BYTES: usize = 12;

    /// Whether a reader that does not know this section must refuse the file.
    pub fn required(&self) -> bool {
        u16::from(self.flags) & REQUIRED != 0
    }

    /// Writes the row, little-endian.
    pub fn to_bytes(&self) -> [u8; Self::BYTES] {
        let [k0, k1] = self.kind.to_le_bytes();
        let [o0, o1, o2, o3] = self.offset.to_le_bytes();
        let [b0, b1, b2, b3] = self.bytes.to_le_bytes();
        [k0, k1, self.part, self.flags, o0, o1, o2, o3, b0, b1, b2, b3]
    }

    /// Reads a row.
    pub fn from_bytes(bytes: &[u8; Self::BYTES]) -> Self {
        let [k0, k1, part, flags, o0, o1, o2, o3, b0, b1, b2, b3] = *bytes;
        Self {
            kind: u16::from_le_bytes([k0, k1]),
            part,
            flags,
            offset: u32::from_le_bytes([o0, o1, o2, o3]),
            bytes: u32::from_le_bytes([b0, b1, b2, b3]),
        }
    }
}

/// Flag bit of a row that must be understood.
pub(crate) const REQUIRED: u16 = 1;

/// The sections of an envelope. A number never changes meaning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
pub enum SectionKind {
    /// Name of the part and of its joints.
    Names = 1,
    /// Parent of each joint, evaluation order, and rank of each joint in it.
    Hierarchy = 2,
    /// Inverse bind matrices.
    InverseBinds = 3,
    /// Rest positions.
    RestPositions = 4,
    /// Rest normals.
    RestNormals = 5,
    /// Rest tangents with handedness.
    RestTangents = 6,
    /// Palette index of each influence.
    InfluenceIndices = 7,
    /// Weight of each influence.
    InfluenceWeights = 8,
    /// Key predictors.
    Keys = 9,
    /// Gradients to palette.
    C1 = 10,
    /// Joints to palette.
    C2 = 11,
    /// Rest box of what each map of the palette moves.
    RestBoxes = 12,
    /// Largest rotation of each joint in training.
    PoseRanges = 13,
    /// Origin of each joint in the rest pose.
    Origins = 14,
    /// Groups of proxies that share a kernel map.
    Groups = 15,
    /// Numbers of the kernel maps, group by group.
    Corrections = 16,
}

/// Whether an envelope of some predictor has a section.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Presence {
    /// It must.
    Required,
    /// It may.
    Optional,
    /// It must not.
    Absent,
}

impl SectionKind {
    /// Every kind, in the order in which the trainer writes them.
    pub const ALL: [Self; 16] = [
        Self::Names,
        Self::Hierarchy,
        Self::InverseBinds,
        Self::RestPositions,
        Self::RestNormals,
        Self::RestTangents,
        Self::InfluenceIndices,
        Self::InfluenceWeights,
        Self::Keys,
        Self::C1,
        Self::C2,
        Self::RestBoxes,
        Self::PoseRanges,
        Self::Origins,
        Self::Groups,
        Self::Corrections,
    ];

    /// Returns its number in the file.
    pub const fn number(self) -> u16 {
        self as u16
    }

    /// Returns the kind of this number.
    pub fn from_number(number: u16) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.number() == number)
    }

    /// Returns its name, as FORMAT.md has it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Names => "names",
            Self::Hierarchy => "hierarchy",
            Self::InverseBinds => "inverse_binds",
            Self::RestPositions => "rest_positions",
            Self::RestNormals => "rest_normals",
            Self::RestTangents => "rest_tangents",
            Self::InfluenceIndices => "influence_indices",
            Self::InfluenceWeights => "influence_weights",
            Self::Keys => "keys",
            Self::C1 => "c1",
            Self::C2 => "c2",
            Self::RestBoxes => "rest_boxes",
            Self::PoseRanges => "pose_ranges",
            Self::Origins => "origins",
            Self::Groups => "groups",
            Self::Corrections => "corrections",
        }
    }

    /// Tells whether an envelope of a predictor has it.
    pub const fn presence(self, predictor: Predictor) -> Presence {
        let has = match self {
            Self::RestTangents => return Presence::Optional,
            Self::Keys | Self::C1 | Self::C2 => predictor.reconstructs(),
            Self::Origins | Self::Groups | Self::Corrections => predictor.corrects(),
            _ => true,
        };
        if has { Presence::Required } else { Presence::Absent }
    }

    /// Computes its length in bytes; `None` if the product overflows. The least length, where the
    /// content states its own: of names by their table, of corrections by the groups.
    pub fn bytes(self, predictor: Predictor, counts: &EnvelopeCounts) -> Option<u64> {
        let EnvelopeCounts {
            vertex_len: v,
            joint_len: j,
            proxy_len: p,
            influence_len: k,
            group_len: g,
            ..
        } = *counts;
        let blocks = p.div_ceil(2);
        let maps = u32::try_from(counts.palette_len(predictor)).ok()?;
        let (each, rows, columns) = match self {
            Self::Names => (4, j.checked_add(1)?, 1),
            Self::Hierarchy => (6, j, 1),
            Self::InverseBinds => (48, j, 1),
            Self::RestPositions | Self::RestNormals => (12, v, 1),
            Self::RestTangents => (16, v, 1),
            Self::InfluenceIndices => (2, v, k),
            Self::InfluenceWeights => (4, v, k),
            Self::Keys => (4 * KEY_WORDS as u64, p, 1),
            Self::C1 => (32 * 3, blocks, p),
            Self::C2 => (32 * 4, blocks, j),
            Self::RestBoxes => (24, maps, 1),
            Self::PoseRanges => (4, j, 1),
            Self::Origins => (12, j, 1),
            Self::Groups => (GroupRow::BYTES as u64, g, 1),
            Self::Corrections => (0, 1, 1),
        };
        (u64::from(rows) * u64::from(columns)).checked_mul(each)
    }

    /// Checks a length against the counts.
    pub(crate) fn check_len(
        self,
        predictor: Predictor,
        counts: &EnvelopeCounts,
        found: usize,
    ) -> Result<(), FormatError> {
        let expected = self.bytes(predictor, counts).unwrap_or(u64::MAX);
        let fits = match self {
            Self::Names | Self::Corrections => found as u64 >= expected,
            _ => found as u64 == expected,
        };
        if fits {
            Ok(())
        } else {
            let expected = u32::try_from(expected).unwrap_or(u32::MAX);
            Err(FormatError::SectionLength { section: self, expected, found })
        }
    }
}
