//! Counts of an envelope, its predictor and its certificate.

use super::group::GroupRow;
use crate::format::SectionKind;
use crate::format::part::{Asked, COUNTS, SECTIONS, first_counts};
use crate::format::rule::{ALWAYS, Rule};
use crate::named::named;
use crate::numeric::HALF_TURNS_MAX;

/// Sentinel for "no joint": the parent of the root, the residual joint of a key without one, or the joint of a group if
/// the envelope has no joint.
pub const NO_JOINT: u16 = u16::MAX;
/// Words of a key, 4 bytes each: two joints (u16), twist 9, residual twist 9, shear 36.
pub const KEY_WORDS: usize = 1 + 9 + 9 + 36;
/// Numbers of a joint's strain, (LᵀL - I) / 2 of its linear part L: xx, xy, xz, yy, yz, zz.
pub const STRAIN_LEN: usize = 6;
/// Allowed difference between the products of an inverse bind matrix's rows and the products of a rotation's rows.
///
/// Training accepts singular values within 1e-2 of 1, which make a difference of 0.02. The tolerance is half as much
/// again. With other matrices a pose is not rigid, and its logarithm is NaN.
pub const BIND_TOLERANCE: f32 = 0.03;
/// Largest Frobenius norm of a twist matrix; at this norm angles are still accurate to 4e-4.
pub const TWIST_MAX: f32 = HALF_TURNS_MAX;

named! {
    /// Predictor of an envelope's palette (METHOD §1.9).
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    #[repr(u8)]
    #[cfg_attr(not(feature = "internals"), non_exhaustive)]
    pub enum Predictor {
        /// Rotational regression and reconstruction (S3): the palette is the P proxies.
        Rotational = 1, "rotational";
        /// The palette is the J joints and P helpers. Kernel maps move the helpers in the frames of their dominant joints.
        Kernel = 2, "kernel";
    }
    /// Every predictor.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) ALL;
    /// Returns the predictor's name on the command line.
    pub name;
}

impl Predictor {
    /// Returns the predictor's number in the file, if its helpers are affine.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) const fn number(self) -> u8 {
        self as u8
    }

    /// Whether the base of the proxies is the reconstruction `c1 d + c2 q`.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) const fn reconstructs(self) -> bool {
        matches!(self, Self::Rotational)
    }

    /// Whether kernel maps correct the helpers.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) const fn corrects(self) -> bool {
        matches!(self, Self::Kernel)
    }
}

named! {
    /// Transforms that the helpers of an envelope may have (METHOD §1.13).
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    #[repr(u8)]
    pub enum HelperKind {
        /// Any affine transform.
        #[default]
        Affine = 0, "affine";
        /// Translation, rotation and scale along the model's axes at rest, as bones of engines hold them.
        Trs = 1, "trs";
        /// Translation and rotation.
        Rigid = 2, "rigid";
    }
    /// Every kind.
    pub ALL;
    /// Returns the kind's name on the command line.
    pub name;
}

impl HelperKind {
    /// Returns the kind's number in [`HelperKind::ALL`].
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) const fn number(self) -> u8 {
        self as u8
    }
}

/// Sentinel for "no forecast" in the file.
const NO_FORECAST: f32 = -1.0;

/// Measured errors of the fit, in the units of the file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(not(feature = "internals"), non_exhaustive)]
pub struct Certificate {
    /// Diagonal of the box around the rest pose.
    pub diagonal: f32,
    /// RMS error over vertices and training frames.
    pub training_rms: f32,
    /// Forecast of the RMS error on more frames of the training clips, from fits that left frames out.
    pub same_clips_rms: f32,
    /// RMS error of linear blend skinning over vertices and training frames.
    pub lbs_training_rms: f32,
    /// Largest error of a vertex that single precision may cause in the correction; 0 without a correction.
    pub correction_error: f32,
    /// RMS error over vertices and training frames of [`crate::Envelope::base_palette`].
    pub base_training_rms: f32,
    /// Forecast of the RMS error on another clip, from fits that left clips out. `None` if training had one clip.
    pub other_clip_rms: Option<f32>,
    /// Largest distance over vertices and training frames between the skin of [`super::Envelope::palette`] and the skin
    /// of [`super::Envelope::palette_trs`].
    pub trs_error: f32,
}

impl Certificate {
    /// Bytes of section `certificate`.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) const BYTES: usize = 32;

    /// Lists the figures in the order of the file.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) const fn figures(&self) -> [f32; 8] {
        [
            self.diagonal,
            self.training_rms,
            self.same_clips_rms,
            self.lbs_training_rms,
            self.correction_error,
            self.base_training_rms,
            match self.other_clip_rms {
                Some(rms) => rms,
                None => NO_FORECAST,
            },
            self.trs_error,
        ]
    }

    /// Makes a certificate from figures in the order of the file.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) const fn from_figures(figures: [f32; 8]) -> Self {
        let [diagonal, training_rms, same_clips_rms, lbs_training_rms, ..] = figures;
        let [.., correction_error, base_training_rms, other_clip, trs_error] = figures;
        Self {
            diagonal,
            training_rms,
            same_clips_rms,
            lbs_training_rms,
            correction_error,
            base_training_rms,
            other_clip_rms: if other_clip == NO_FORECAST { None } else { Some(other_clip) },
            trs_error,
        }
    }
}

/// Counts of an envelope. The length of every section follows from them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EnvelopeCounts {
    /// Predictor of the palette.
    pub predictor: Predictor,
    /// Joints, J.
    pub joint_len: u32,
    /// Proxies, P.
    pub proxy_len: u32,
    /// The reference root joint.
    pub root: u32,
    /// Groups, G.
    pub group_len: u32,
    /// Floats of scratch for the correction, without the features.
    pub correction_len: u32,
    /// Whether a joint stretches.
    pub stretches: bool,
    /// Curves, C; 0 for a rotational envelope.
    pub curve_len: u32,
    /// Transforms that the helpers may have; affine for a rotational envelope.
    pub helper_kind: HelperKind,
}

/// Returns the predictor with a number in the file, and the kind of its helpers; `None` if there is none, or if this build
/// does not evaluate the kind.
const fn predictor(number: u32) -> Option<(Predictor, HelperKind)> {
    match number {
        1 => Some((Predictor::Rotational, HelperKind::Affine)),
        2 => Some((Predictor::Kernel, HelperKind::Affine)),
        3 if cfg!(feature = "trs") => Some((Predictor::Kernel, HelperKind::Trs)),
        4 if cfg!(feature = "trs") => Some((Predictor::Kernel, HelperKind::Rigid)),
        _ => None,
    }
}

impl EnvelopeCounts {
    /// Bytes of section `envelope_counts`.
    pub const BYTES: usize = 32;

    /// Returns the number of transforms in the palette: P, or J + P for the kernel predictor.
    pub const fn palette_len(&self) -> usize {
        let joints = if self.predictor.reconstructs() { 0 } else { self.joint_len as usize };
        joints.saturating_add(self.proxy_len as usize)
    }

    /// Returns the number of features: 12 a joint, 6 more a joint if joints stretch, 1 a curve.
    pub const fn feature_len(&self) -> usize {
        let each = if self.stretches { 12 + STRAIN_LEN as u32 } else { 12 };
        // A file's counts are below 2^16.
        self.joint_len.wrapping_mul(each).wrapping_add(self.curve_len) as usize
    }

    /// Returns the number of joints with room for a rotation and a strain: J if joints stretch, else 0.
    pub(crate) const fn stretching(&self) -> usize {
        if self.stretches { self.joint_len as usize } else { 0 }
    }

    /// Lists the counts in the order of the file.
    pub const fn words(&self) -> [u32; 8] {
        let Self { joint_len, proxy_len, root, group_len, correction_len, .. } = *self;
        let (stretches, curve_len) = (self.stretches as u32, self.curve_len);
        // A kernel envelope's number is 2, 3 or 4, by the kind of its helpers.
        let predictor = self.predictor as u32 + self.helper_kind as u32;
        [predictor, joint_len, proxy_len, root, group_len, correction_len, stretches, curve_len]
    }

    /// Makes counts from words in the order of the file; `None` if the predictor is unknown.
    pub const fn from_words(words: [u32; 8]) -> Option<Self> {
        match predictor(words[place::PREDICTOR]) {
            Some(predictor) => Some(Self::of(predictor, words)),
            None => None,
        }
    }

    /// Makes counts from checked words.
    pub(crate) const fn read(words: &[u32; COUNTS]) -> Self {
        let words = first_counts(words);
        match predictor(words[place::PREDICTOR]) {
            Some(predictor) => Self::of(predictor, words),
            None => Self::of((Predictor::Rotational, HelperKind::Affine), words),
        }
    }

    const fn of((predictor, helper_kind): (Predictor, HelperKind), words: [u32; 8]) -> Self {
        let [_, joint_len, proxy_len, root, group_len, correction_len, stretches, curve_len] =
            words;
        Self {
            predictor,
            joint_len,
            proxy_len,
            root,
            group_len,
            correction_len,
            stretches: cfg!(feature = "stretch") && stretches != 0,
            curve_len: if cfg!(feature = "curves") { curve_len } else { 0 },
            helper_kind,
        }
    }

    /// Whether an envelope with these counts has a section.
    pub fn has(&self, section: SectionKind) -> bool {
        Rule::of(&RULES, section).is_some_and(|rule| self.asked().has & rule.has != 0)
    }

    /// Computes the length of a section in bytes; `None` if the product overflows, or no envelope has the section.
    ///
    /// The result is the least length for names and corrections, whose content gives the length.
    pub fn section_bytes(&self, section: SectionKind) -> Option<u64> {
        Rule::of(&RULES, section)?.bytes(&self.asked().sizes)
    }

    /// Returns the flags and sizes that [`RULES`] refer to.
    pub(crate) const fn asked(&self) -> Asked {
        let reconstructs = if self.predictor.reconstructs() { RECONSTRUCTS } else { 0 };
        let corrects = if self.predictor.corrects() { CORRECTS } else { 0 };
        let stretches = match (self.stretches, self.predictor.reconstructs()) {
            (true, true) => STRETCHES | STRETCHES_KEYS,
            (true, false) => STRETCHES,
            (false, _) => 0,
        };
        let curves = if self.curve_len > 0 { CURVES } else { 0 };
        let Self { joint_len: j, proxy_len: p, group_len: g, curve_len: c, .. } = *self;
        let has = ALWAYS | reconstructs | corrects | stretches | curves;
        Asked::new(has, [1, j, p, p.div_ceil(2), g, c, j.saturating_add(c)])
    }
}

/// Positions of the counts in their section.
pub(crate) mod place {
    pub(crate) const PREDICTOR: usize = 0;
    pub(crate) const JOINTS: usize = 1;
    pub(crate) const PROXIES: usize = 2;
    pub(crate) const ROOT: usize = 3;
    pub(crate) const GROUPS: usize = 4;
    pub(crate) const CORRECTION: usize = 5;
    pub(crate) const STRETCHES: usize = 6;
    pub(crate) const CURVES: usize = 7;
}

/// Flag of an envelope with keys, c1 and c2.
const RECONSTRUCTS: u8 = 4;
/// Flag of an envelope with kernel maps.
const CORRECTS: u8 = 8;
/// Flag of an envelope with joints that stretch.
const STRETCHES: u8 = 16;
/// Flag of an envelope with keys whose joints stretch.
const STRETCHES_KEYS: u8 = 32;
/// Flag of an envelope with curves.
const CURVES: u8 = 64;

/// Sections of an envelope, in the order of the trainer's files.
pub const ENVELOPE_SECTIONS: [SectionKind; RULES.len()] = Rule::sections(&RULES);

const _: () = assert!(RULES.len() <= SECTIONS && EnvelopeCounts::BYTES <= 4 * COUNTS);

/// Rules for the sections of an envelope. Sizes: 1, J, P, blocks of 8 rows in 4 P, G, C, J + C.
pub(crate) const RULES: [Rule;
    12 + 2 * cfg!(feature = "stretch") as usize
        + cfg!(feature = "curves") as usize
        + cfg!(feature = "trs") as usize] = [
    Rule::new(SectionKind::EnvelopeCounts, EnvelopeCounts::BYTES as u8, [0, 0]),
    Rule::floats(SectionKind::Certificate, Certificate::BYTES as u8, [0, 0]),
    Rule::new(SectionKind::Names, 4, [6, 0]).or_more(4),
    Rule::new(SectionKind::Hierarchy, 6, [1, 0]),
    Rule::floats(SectionKind::InverseBinds, 48, [1, 0]),
    Rule::new(SectionKind::Keys, 4 * KEY_WORDS as u8, [2, 0]).with(RECONSTRUCTS).floats_after(1),
    Rule::floats(SectionKind::C1, 32 * 3, [3, 2]).with(RECONSTRUCTS),
    Rule::floats(SectionKind::C2, 32 * 4, [3, 1]).with(RECONSTRUCTS),
    Rule::floats(SectionKind::PoseRanges, 8, [1, 0]).unsigned(),
    Rule::floats(SectionKind::Origins, 12, [1, 0]).with(CORRECTS),
    Rule::new(SectionKind::Groups, GroupRow::BYTES as u8, [4, 0]).with(CORRECTS),
    Rule::new(SectionKind::Corrections, 0, [0, 0]).with(CORRECTS).or_more(0),
    #[cfg(feature = "stretch")]
    Rule::floats(SectionKind::StretchRanges, 4, [1, 0]).unsigned().with(STRETCHES),
    #[cfg(feature = "stretch")]
    Rule::floats(SectionKind::KeyStretches, 4 * 36, [2, 0]).with(STRETCHES_KEYS),
    #[cfg(feature = "curves")]
    Rule::floats(SectionKind::CurveRanges, 8, [5, 0]).with(CURVES),
    #[cfg(feature = "trs")]
    Rule::floats(SectionKind::HelperPlaces, 36, [2, 0]),
];
