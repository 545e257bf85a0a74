//! The numbers of a skin.

use crate::format::SectionKind;
use crate::format::part::{Asked, COUNTS, SECTIONS};
use crate::format::rule::{ALWAYS, OPTIONAL, Rule};

/// How far the weights of a vertex may sum from one: rounding of 32 influences is below 4e-6.
pub const WEIGHT_SUM_TOLERANCE: f32 = 1.0e-5;
/// How far the square of a normal's or tangent's length may be from one: rounding of three floats and
/// of their squares is below 5e-7.
pub const LENGTH_TOLERANCE: f32 = 1.0e-5;
/// Stands for no envelope in [`SkinCounts::envelope`].
pub const NO_ENVELOPE: u32 = u32::MAX;

/// Counts of a skin, from which, with its envelope's, every section's length follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SkinCounts {
    /// Vertices, V.
    pub vertex_len: u32,
    /// Influences of a vertex, K; 0 without an envelope.
    pub influence_len: u32,
    /// The part whose palette it follows, or [`NO_ENVELOPE`].
    pub envelope: u32,
    /// Named ranges of vertices, R.
    pub range_len: u32,
}

impl SkinCounts {
    /// Bytes of section `skin_counts`.
    pub const BYTES: usize = 16;

    /// Lists the counts in the order of the file.
    pub const fn words(&self) -> [u32; 4] {
        let Self { vertex_len, influence_len, envelope, range_len } = *self;
        [vertex_len, influence_len, envelope, range_len]
    }

    /// Makes them of their words.
    pub const fn from_words(words: [u32; 4]) -> Self {
        let [vertex_len, influence_len, envelope, range_len] = words;
        Self { vertex_len, influence_len, envelope, range_len }
    }

    /// Returns the part whose palette it follows.
    pub fn envelope(&self) -> Option<u16> {
        u16::try_from(self.envelope).ok()
    }

    /// Whether a skin of these counts must have a section, may have it (`None`), or must not.
    pub fn has(&self, section: SectionKind) -> Option<bool> {
        let Some(rule) = Rule::of(&RULES, section) else { return Some(false) };
        let has = rule.has == OPTIONAL || self.asked(0).has & rule.has != 0;
        if has && rule.has & OPTIONAL != 0 { None } else { Some(has) }
    }

    /// Computes a section's length in bytes, the least of the names; `None` if the product overflows,
    /// or no skin has it.
    ///
    /// - `palette_len`: transforms of the envelope's palette, L.
    pub fn section_bytes(&self, section: SectionKind, palette_len: usize) -> Option<u64> {
        Rule::of(&RULES, section)?.bytes(&self.asked(u32::try_from(palette_len).ok()?).sizes)
    }

    /// Returns what they ask of the sections, as [`RULES`] have it.
    pub(crate) const fn asked(&self, palette_len: u32) -> Asked {
        let Self { vertex_len: v, influence_len: k, range_len: r, envelope } = *self;
        let follows = if envelope == NO_ENVELOPE { 0 } else { FOLLOWS };
        #[cfg(feature = "tangent-coefficients")]
        {
            let blends = if follows != 0 && k > 1 { BLENDS } else { 0 };
            Asked::new(ALWAYS | follows | blends, [1, v, k, palette_len, r, k.saturating_sub(1)])
        }
        #[cfg(not(feature = "tangent-coefficients"))]
        Asked::new(ALWAYS | follows, [1, v, k, palette_len, r])
    }
}

/// How far a skin's normals were from the true ones, over the poses of training: the angle's RMS over the area
/// at rest, in radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalErrors {
    /// Of the model, by tangent coefficients where it has them.
    pub model: f32,
    /// Of linear blend skinning, by cofactors.
    pub lbs: f32,
}

impl NormalErrors {
    /// Bytes of section `normal_errors`.
    pub const BYTES: usize = 8;

    /// Lists the figures in the order of the file.
    pub const fn figures(&self) -> [f32; 2] {
        [self.model, self.lbs]
    }

    /// Makes them of their figures.
    pub const fn from_figures([model, lbs]: [f32; 2]) -> Self {
        Self { model, lbs }
    }
}

/// Where the counts stand in their section, and behind them what follows from the envelope.
pub(crate) mod place {
    pub(crate) const VERTICES: usize = 0;
    pub(crate) const INFLUENCES: usize = 1;
    pub(crate) const ENVELOPE: usize = 2;
    pub(crate) const PALETTE: usize = 4;
}

/// Bit of a skin with an envelope.
const FOLLOWS: u8 = 4;
/// Bit of one of which a vertex has several influences.
#[cfg(feature = "tangent-coefficients")]
const BLENDS: u8 = 8;

/// The sections of a skin, in the order in which the trainer writes them.
pub const SKIN_SECTIONS: [SectionKind; RULES.len()] = Rule::sections(&RULES);

const _: () = assert!(RULES.len() <= SECTIONS && place::PALETTE < COUNTS);

/// What a skin asks of its sections. Sizes: 1, V, K, L, R, K - 1.
pub(crate) const RULES: [Rule; if cfg!(feature = "tangent-coefficients") { 11 } else { 9 }] = [
    Rule::new(SectionKind::SkinCounts, SkinCounts::BYTES as u8, [0, 0]),
    Rule::new(SectionKind::Names, 4, [4, 0]).or_more(4),
    Rule::floats(SectionKind::RestPositions, 12, [1, 0]),
    Rule::floats(SectionKind::RestNormals, 12, [1, 0]),
    Rule::floats(SectionKind::RestTangents, 16, [1, 0]).with(OPTIONAL),
    Rule::new(SectionKind::InfluenceIndices, 2, [1, 2]).with(FOLLOWS),
    Rule::floats(SectionKind::InfluenceWeights, 4, [1, 2]).with(FOLLOWS).unsigned(),
    Rule::floats(SectionKind::RestBoxes, 24, [3, 0]).with(FOLLOWS),
    Rule::new(SectionKind::Ranges, 8, [4, 0]),
    #[cfg(feature = "tangent-coefficients")]
    Rule::new(SectionKind::TangentCoefficients, 4, [1, 5]).with(BLENDS | OPTIONAL),
    #[cfg(feature = "tangent-coefficients")]
    Rule::new(SectionKind::NormalErrors, NormalErrors::BYTES as u8, [0, 0])
        .with(OPTIONAL)
        .unsigned(),
];
