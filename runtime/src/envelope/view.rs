//! An envelope in a loaded file, and accessors to its arrays.

use super::counts::{
    Certificate, EnvelopeCounts, HelperKind, KEY_WORDS, NO_JOINT, Predictor, RULES, place,
};
use super::group::GroupRow;
use super::pose::Pose;
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
#[cfg(feature = "stretch")]
const STRETCH_RANGES: usize = Rule::place(&RULES, SectionKind::StretchRanges);
#[cfg(feature = "stretch")]
const KEY_STRETCHES: usize = Rule::place(&RULES, SectionKind::KeyStretches);
#[cfg(feature = "curves")]
const CURVE_RANGES: usize = Rule::place(&RULES, SectionKind::CurveRanges);
#[cfg(feature = "trs")]
const HELPER_PLACES: usize = Rule::place(&RULES, SectionKind::HelperPlaces);

/// Envelope of J joints and P proxies or helpers, which predicts a palette from a pose; borrowed from a loaded model.
///
/// Accessors by index return `None` beyond their range.
#[derive(Clone, Copy)]
pub struct Envelope<'a>(pub(crate) Part<'a>);

/// Key predictor (METHOD §1.4, §1.5):
/// `D = Q_p exp(twist . theta_b) [exp(residual . theta_c)] (I + sym(H [theta_b; theta_p] + G E_b))`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key {
    /// Joint b that the key follows; p is the parent of b.
    pub joint: usize,
    /// A = u W, rows (METHOD §1.4).
    pub twist: [[f32; 3]; 3],
    /// Residual joint c and its A', rows.
    pub residual: Option<(usize, [[f32; 3]; 3])>,
    /// H: a row for each of xx, xy, xz, yy, yz, zz of S - I; columns theta_b, then theta_p.
    pub shear: [[f32; 6]; 6],
    /// G: rows as of H; columns are the joint's strain xx, xy, xz, yy, yz, zz. `None` if no joint stretches.
    pub stretch: Option<[[f32; 6]; 6]>,
}

/// Key predictor, read in place.
pub(crate) struct KeyRow<'a> {
    pub(crate) joint: usize,
    pub(crate) twist: &'a [Le; 9],
    pub(crate) residual: Option<(usize, &'a [Le; 9])>,
    pub(crate) shear: &'a [Le],
    pub(crate) stretch: Option<&'a [Le; 36]>,
}

part::view! { Envelope, Envelope, |words| -> EnvelopeCounts { EnvelopeCounts::read(words) } }

impl<'a> Envelope<'a> {
    /// Returns J, the number of joints.
    pub const fn joint_len(&self) -> usize {
        self.0.layout.counts[place::JOINTS] as usize
    }

    /// Returns P, the number of helpers, or of proxies of a rotational envelope. They are the last P transforms of the
    /// palette.
    pub const fn proxy_len(&self) -> usize {
        self.0.layout.counts[place::PROXIES] as usize
    }

    /// Returns the number of transforms in the palette: P, or J + P for the kernel predictor.
    pub const fn palette_len(&self) -> usize {
        self.counts().palette_len()
    }

    /// Returns the predictor of the palette.
    pub const fn predictor(&self) -> Predictor {
        self.counts().predictor
    }

    /// Returns the transforms that the helpers may have.
    pub const fn helper_kind(&self) -> HelperKind {
        self.counts().helper_kind
    }

    /// Returns G, the number of groups of helpers that share a kernel map.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) const fn group_len(&self) -> usize {
        self.0.layout.counts[place::GROUPS] as usize
    }

    /// Whether a joint stretches: its linear part may be any matrix that does not mirror, not only a rotation.
    pub const fn stretches(&self) -> bool {
        self.counts().stretches
    }

    /// Returns C, the number of curves.
    pub const fn curve_len(&self) -> usize {
        self.counts().curve_len as usize
    }

    /// Returns the reference root: the joint without a parent; 0 if there is no joint.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) const fn root(&self) -> usize {
        self.0.layout.counts[place::ROOT] as usize
    }

    /// Returns the measured errors of the fit.
    pub fn certificate(&self) -> Certificate {
        let figures = self.0.array(CERTIFICATE).first().map(floats);
        Certificate::from_figures(figures.unwrap_or_default())
    }

    /// Returns a joint's name.
    pub fn joint_name(&self, joint: usize) -> Option<&'a str> {
        (joint < self.joint_len()).then(|| self.names().get(joint + 1))?
    }

    /// Returns a curve's name.
    pub fn curve_name(&self, curve: usize) -> Option<&'a str> {
        self.names().get((self.joint_len() + 1).checked_add(curve)?)
    }

    /// Returns a joint's parent; `None` for the root.
    pub fn parent(&self, joint: usize) -> Option<usize> {
        self.parents().get(joint).and_then(joint_index)
    }

    /// Lists the J joints so that each comes after its parent.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) fn evaluation_order(&self) -> impl ExactSizeIterator<Item = usize> + use<'a> {
        self.thirds()[1].iter().map(|le| usize::from(u16::from_le_bytes(*le)))
    }

    /// Returns a joint's inverse bind matrix: model space to the joint's rest frame.
    pub fn inverse_bind(&self, joint: usize) -> Option<Matrix3x4> {
        self.0.entry::<12>(INVERSE_BINDS, self.joint_len(), joint).map(|m| rows(&floats(m)))
    }

    /// Returns a joint's origin in the rest pose, in model space; `None` for a rotational envelope.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) fn origin(&self, joint: usize) -> Option<[f32; 3]> {
        self.0.entry(ORIGINS, self.joint_len(), joint).map(floats)
    }

    /// Returns the largest |theta| of a joint in training, in radians.
    pub fn pose_range(&self, joint: usize) -> Option<f32> {
        self.0.entry(POSE_RANGES, self.joint_len(), joint).map(|[le]| f32::from_le_bytes(*le))
    }

    /// Returns the largest gap of a joint in training: the distance from the joint's origin to where its parent
    /// carries that origin. 0 for the root, and about 0 for a joint that only turns.
    pub fn pose_gap(&self, joint: usize) -> Option<f32> {
        let len = self.joint_len();
        let gap = self.0.entry(POSE_RANGES, 2 * len, joint.checked_add(len)?);
        gap.map(|[le]| f32::from_le_bytes(*le))
    }

    /// Returns the largest norm of a joint's strain in training, `|LᵀL - I| / 2` of its linear part L; 0 if the joint
    /// does not stretch.
    pub fn stretch_range(&self, joint: usize) -> Option<f32> {
        if joint >= self.joint_len() {
            return None;
        }
        let range = self.stretch_ranges().get(joint);
        Some(range.map_or(0.0, |[le]| f32::from_le_bytes(*le)))
    }

    /// Returns the least and the greatest value of a curve in training.
    pub fn curve_range(&self, curve: usize) -> Option<[f32; 2]> {
        self.curve_ranges().get(curve).map(floats)
    }

    /// Returns the key predictor of a proxy; `None` for a kernel envelope.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) fn key(&self, proxy: usize) -> Option<Key> {
        (proxy < self.proxy_len()).then(|| self.keys().nth(proxy))??.to_key()
    }

    /// Returns the centre of a helper, or of a proxy, in the rest pose, in model space: the mean of the vertices that it
    /// moves, by squared weights. The rest frame of a bone of [`Envelope::palette_trs`] is the translation to the centre.
    #[cfg(feature = "trs")]
    pub fn helper_centre(&self, helper: usize) -> Option<[f32; 3]> {
        self.helper_place(helper).map(|(centre, _)| centre)
    }

    /// Returns the spread of the vertices that a helper, or a proxy, moves: their covariance by squared weights, xx, xy,
    /// xz, yy, yz, zz, without a unit. It decides which rotation and scale of a bone are nearest to a palette entry.
    #[cfg(feature = "trs")]
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) fn helper_spread(&self, helper: usize) -> Option<[f32; 6]> {
        self.helper_place(helper).map(|(_, spread)| spread)
    }

    #[cfg(feature = "trs")]
    fn helper_place(&self, helper: usize) -> Option<([f32; 3], [f32; 6])> {
        self.0.entry(HELPER_PLACES, self.proxy_len(), helper).map(place)
    }

    /// Returns a coefficient of c1 (4 P x 3 P).
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) fn c1(&self, row: usize, column: usize) -> Option<f32> {
        let shape = (4 * self.proxy_len(), 3 * self.proxy_len());
        block_entry(self.c1_blocks(), shape, row, column)
    }

    /// Returns a coefficient of c2 (4 P x 4 J).
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) fn c2(&self, row: usize, column: usize) -> Option<f32> {
        let shape = (4 * self.proxy_len(), 4 * self.joint_len());
        block_entry(self.c2_blocks(), shape, row, column)
    }

    /// Returns an error unless the predictor has a stage.
    pub(crate) fn check_stage(&self, is_part: bool) -> Result<(), CallError> {
        if is_part {
            return Ok(());
        }
        let found = self.predictor().number().into();
        Err(CallError::new(CallErrorKind::NoStage, Argument::Call).values(0, found))
    }

    /// Checks that a pose has J finite matrices and C finite curves.
    pub(crate) fn check_finite(&self, pose: Pose<'_>) -> Result<(), CallError> {
        Argument::Pose.check_len(self.joint_len(), pose.joints.len())?;
        Argument::Curves.check_len(self.curve_len(), pose.curves.len())?;
        pose.check_finite()
    }

    /// Checks that a pose has J finite matrices.
    pub(crate) fn check_joints(&self, pose: &[Matrix3x4]) -> Result<(), CallError> {
        Argument::Pose.check_len(self.joint_len(), pose.len())?;
        Pose { joints: pose, curves: &[] }.check_finite()
    }

    pub(crate) fn names(&self) -> Names<'a> {
        // The counts are below 2^16.
        Names::new(self.0.bytes(NAMES), self.joint_len() + self.curve_len() + 1)
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

    /// Returns the J angles, then the J gaps.
    pub(crate) fn pose_ranges(&self) -> &'a [[Le; 1]] {
        self.0.array(POSE_RANGES)
    }

    /// Returns the largest strain of each joint; empty if no joint stretches.
    pub(crate) fn stretch_ranges(&self) -> &'a [[Le; 1]] {
        #[cfg(feature = "stretch")]
        return self.0.array(STRETCH_RANGES);
        #[cfg(not(feature = "stretch"))]
        &[]
    }

    /// Returns the least and the greatest value of each curve.
    pub(crate) fn curve_ranges(&self) -> &'a [[Le; 2]] {
        #[cfg(feature = "curves")]
        return self.0.array(CURVE_RANGES);
        #[cfg(not(feature = "curves"))]
        &[]
    }

    /// Returns the centre and the spread of each proxy.
    #[cfg(feature = "trs")]
    pub(crate) fn helper_places(&self) -> &'a [[Le; 9]] {
        self.0.array(HELPER_PLACES)
    }

    /// Lists the key predictors.
    pub(crate) fn keys(&self) -> impl Iterator<Item = KeyRow<'a>> + use<'a> {
        let (keys, stretches) = (self.0.array::<KEY_WORDS>(KEYS), self.key_stretches());
        let rows = keys.iter().enumerate();
        rows.map_while(move |(at, words)| KeyRow::new(words, stretches.get(at)))
    }

    fn key_stretches(&self) -> &'a [[Le; 36]] {
        #[cfg(feature = "stretch")]
        return self.0.array(KEY_STRETCHES);
        #[cfg(not(feature = "stretch"))]
        &[]
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

    /// Returns the length of section `corrections` in bytes, which may end with a part of a word.
    pub(crate) fn corrections_len(&self) -> usize {
        self.0.bytes(CORRECTIONS).len()
    }

    /// Returns the parents, the evaluation order and the inverse of that order, J entries each.
    fn thirds(&self) -> [&'a [[u8; 2]]; 3] {
        let all = self.0.bytes(HIERARCHY).as_chunks::<2>().0;
        let (parents, rest) = all.split_at_checked(self.joint_len()).unwrap_or_default();
        let (order, ranks) = rest.split_at_checked(self.joint_len()).unwrap_or_default();
        [parents, order, ranks]
    }
}

impl<'a> KeyRow<'a> {
    fn new(words: &'a [Le; KEY_WORDS], stretch: Option<&'a [Le; 36]>) -> Option<Self> {
        let [[b0, b1, c0, c1], matrices @ ..] = words;
        let (twist, rest) = matrices.split_first_chunk()?;
        let (residual, shear) = rest.split_first_chunk()?;
        let joint = u16::from_le_bytes([*b0, *b1]).into();
        let residual = joint_index(&[*c0, *c1]).map(|joint| (joint, residual));
        Some(Self { joint, twist, residual, shear, stretch })
    }

    pub(crate) fn to_key(&self) -> Option<Key> {
        let residual = self.residual.map(|(joint, twist)| (joint, rows(&floats(twist))));
        let shear = rows(&floats(self.shear.first_chunk::<36>()?));
        let stretch = self.stretch.map(|words| rows(&floats(words)));
        Some(Key { joint: self.joint, twist: rows(&floats(self.twist)), residual, shear, stretch })
    }
}

/// Reads the index of a joint; `None` for [`NO_JOINT`].
pub(crate) fn joint_index(le: &[u8; 2]) -> Option<usize> {
    let index = u16::from_le_bytes(*le);
    (index != NO_JOINT).then_some(usize::from(index))
}

/// Reads the centre and the spread of a helper.
#[cfg(feature = "trs")]
pub(crate) fn place(words: &[Le; 9]) -> ([f32; 3], [f32; 6]) {
    let [x, y, z, xx, xy, xz, yy, yz, zz] = floats(words);
    ([x, y, z], [xx, xy, xz, yy, yz, zz])
}
