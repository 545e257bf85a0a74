//! An envelope in a loaded file: what loading found of it, and what it holds.

use super::counts::{Certificate, EnvelopeCounts, KEY_WORDS, Predictor, RULES, place};
use super::group_row::GroupRow;
use super::key::{Key, KeyRow, joint_index};
use crate::error::{Argument, CallError, CallErrorKind};
use crate::format::SectionKind;
use crate::format::part::{self, Part};
use crate::format::rule::Rule;
use crate::linear::{Le, Matrix3x4, block_entry, floats, rows};
use crate::names::Names;

const CERTIFICATE: usize = Rule::place(&RULES, SectionKind::Certificate);
const NAMES: usize = Rule::place(&RULES, SectionKind::Names);
const HIERARCHY: usize = Rule::place(&RULES, SectionKind::Hierarchy);
const INVERSE_BINDS: usize = Rule::place(&RULES, SectionKind::InverseBinds);
const KEYS: usize = Rule::place(&RULES, SectionKind::Keys);
const C1: usize = Rule::place(&RULES, SectionKind::C1);
const C2: usize = Rule::place(&RULES, SectionKind::C2);
const POSE_RANGES: usize = Rule::place(&RULES, SectionKind::PoseRanges);
const ORIGINS: usize = Rule::place(&RULES, SectionKind::Origins);
const GROUPS: usize = Rule::place(&RULES, SectionKind::Groups);
const CORRECTIONS: usize = Rule::place(&RULES, SectionKind::Corrections);

/// Predicts a palette from a pose of J joints, by P proxies or helpers; borrowed from a loaded model.
///
/// Accessors by number return `None` beyond their range.
#[derive(Clone, Copy)]
pub struct Envelope<'a>(pub(crate) Part<'a>);

part::view! { Envelope, EnvelopeLayout, |words| -> EnvelopeCounts { EnvelopeCounts::read(words) } }

impl<'a> Envelope<'a> {
    /// Returns J, the number of joints.
    pub const fn joint_len(&self) -> usize {
        self.0.layout.counts[place::JOINTS] as usize
    }

    /// Returns P, the number of proxies: for the kernel predictor, of helpers beside the joints.
    pub const fn proxy_len(&self) -> usize {
        self.0.layout.counts[place::PROXIES] as usize
    }

    /// Returns the number of transforms in the palette: P, or J + P for the kernel predictor.
    pub const fn palette_len(&self) -> usize {
        self.counts().palette_len()
    }

    /// Returns how the palette is predicted.
    pub const fn predictor(&self) -> Predictor {
        self.counts().predictor
    }

    /// Returns G, the number of groups of proxies that share a kernel map.
    pub const fn group_len(&self) -> usize {
        self.0.layout.counts[place::GROUPS] as usize
    }

    /// Returns the reference root: the joint without a parent.
    pub const fn root(&self) -> usize {
        self.0.layout.counts[place::ROOT] as usize
    }

    /// Returns what the fit was measured to reach.
    pub fn certificate(&self) -> Certificate {
        let figures = self.0.array(CERTIFICATE).first().map(floats);
        Certificate::from_figures(figures.unwrap_or_default())
    }

    /// Returns a joint's name.
    pub fn joint_name(&self, joint: usize) -> Option<&'a str> {
        self.names().get(joint.checked_add(1)?)
    }

    /// Returns a joint's parent; `None` for the root.
    pub fn parent(&self, joint: usize) -> Option<usize> {
        self.parents().get(joint).and_then(joint_index)
    }

    /// Lists the J joints so that each comes after its parent.
    pub fn evaluation_order(&self) -> impl ExactSizeIterator<Item = usize> + use<'a> {
        self.thirds()[1].iter().map(|le| usize::from(u16::from_le_bytes(*le)))
    }

    /// Returns a joint's inverse bind matrix: model space to the joint's rest frame.
    pub fn inverse_bind(&self, joint: usize) -> Option<Matrix3x4> {
        self.0.entry::<12>(INVERSE_BINDS, self.joint_len(), joint).map(|m| rows(&floats(m)))
    }

    /// Returns a joint's origin in the rest pose, in model space; a rotational envelope holds none.
    pub fn origin(&self, joint: usize) -> Option<[f32; 3]> {
        self.0.entry(ORIGINS, self.joint_len(), joint).map(floats)
    }

    /// Returns the largest |theta| of a joint in training, in radians.
    pub fn pose_range(&self, joint: usize) -> Option<f32> {
        self.0.entry(POSE_RANGES, self.joint_len(), joint).map(|[le]| f32::from_le_bytes(*le))
    }

    /// Returns how far a joint's origin came in training from where its parent carries it, at the most; 0 for
    /// the root, and about 0 for a joint that only turns.
    pub fn pose_gap(&self, joint: usize) -> Option<f32> {
        let len = self.joint_len();
        let gap = self.0.entry(POSE_RANGES, 2 * len, joint.checked_add(len)?);
        gap.map(|[le]| f32::from_le_bytes(*le))
    }

    /// Returns the key predictor of a proxy; a kernel envelope has none.
    pub fn key(&self, proxy: usize) -> Option<Key> {
        KeyRow::new(self.0.entry(KEYS, self.proxy_len(), proxy)?)?.to_key()
    }

    /// Returns a coefficient of c1 (4 P x 3 P).
    pub fn c1(&self, row: usize, column: usize) -> Option<f32> {
        let shape = (4 * self.proxy_len(), 3 * self.proxy_len());
        block_entry(self.c1_blocks(), shape, row, column)
    }

    /// Returns a coefficient of c2 (4 P x 4 J).
    pub fn c2(&self, row: usize, column: usize) -> Option<f32> {
        let shape = (4 * self.proxy_len(), 4 * self.joint_len());
        block_entry(self.c2_blocks(), shape, row, column)
    }

    /// Checks that a stage is part of the predictor.
    pub(crate) fn check_stage(&self, is_part: bool) -> Result<(), CallError> {
        if is_part {
            return Ok(());
        }
        let found = self.predictor().number().into();
        Err(CallError::new(CallErrorKind::NoStage, Argument::Call).values(0, found))
    }

    /// Checks that a pose has J matrices, all of them finite.
    pub(crate) fn check_finite(&self, pose: &[Matrix3x4]) -> Result<(), CallError> {
        Argument::Pose.check_len(self.joint_len(), pose.len())?;
        let unsound = pose.iter().position(|m| !m.as_flattened().iter().all(|x| x.is_finite()));
        unsound.map_or(Ok(()), |joint| {
            Err(CallError::new(CallErrorKind::NonFinite, Argument::Pose).at(joint))
        })
    }

    pub(crate) fn names(&self) -> Names<'a> {
        Names::new(self.0.bytes(NAMES), self.joint_len() + 1)
    }

    pub(crate) fn parents(&self) -> &'a [[u8; 2]] {
        self.thirds()[0]
    }

    pub(crate) fn ranks(&self) -> &'a [[u8; 2]] {
        self.thirds()[2]
    }

    pub(crate) fn bind_words(&self) -> &'a [[Le; 12]] {
        self.0.array(INVERSE_BINDS)
    }

    pub(crate) fn origins(&self) -> &'a [[Le; 3]] {
        self.0.array(ORIGINS)
    }

    /// Returns the J angles, and behind them the J gaps.
    pub(crate) fn pose_ranges(&self) -> &'a [[Le; 1]] {
        self.0.array(POSE_RANGES)
    }

    pub(crate) fn keys(&self) -> &'a [[Le; KEY_WORDS]] {
        self.0.array(KEYS)
    }

    pub(crate) fn c1_blocks(&self) -> &'a [[Le; 8]] {
        self.0.array(C1)
    }

    pub(crate) fn c2_blocks(&self) -> &'a [[Le; 8]] {
        self.0.array(C2)
    }

    pub(crate) fn group_rows(&self) -> impl ExactSizeIterator<Item = GroupRow> + use<'a> {
        self.0.bytes(GROUPS).as_chunks().0.iter().map(GroupRow::from_bytes)
    }

    pub(crate) fn corrections(&self) -> &'a [Le] {
        self.0.bytes(CORRECTIONS).as_chunks().0
    }

    /// Returns the bytes of the corrections, of which a whole number of words is read.
    pub(crate) fn corrections_len(&self) -> usize {
        self.0.bytes(CORRECTIONS).len()
    }

    /// Returns the parents, the evaluation order and its inverse.
    fn thirds(&self) -> [&'a [[u8; 2]]; 3] {
        let all = self.0.bytes(HIERARCHY).as_chunks::<2>().0;
        let (parents, rest) = all.split_at_checked(self.joint_len()).unwrap_or_default();
        let (order, ranks) = rest.split_at_checked(self.joint_len()).unwrap_or_default();
        [parents, order, ranks]
    }
}
