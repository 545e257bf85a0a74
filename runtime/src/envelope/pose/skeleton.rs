//! The caller's skeleton: its joints by name, poses gathered from its frames, and a hash of the file's skeleton.

use super::arrays::is_finite;
use super::local::check_root;
use crate::envelope::view::{Envelope, joint_index};
use crate::error::{Argument, CallError, CallErrorKind};
use crate::format::crc;
use crate::linear::{Matrix3x4, compose, floats, rows};

/// Entry of a joint map for a joint that the caller's skeleton lacks: the joint moves as its parent does.
pub const FOLDED: u32 = u32::MAX;

/// Result of [`Envelope::bind_joints`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use = "joints that were not found are stiff: compare `found_len` with `joint_len`"]
#[cfg_attr(not(feature = "internals"), non_exhaustive)]
pub struct BoundJoints {
    /// Number of joints that the skeleton has, at least the root.
    pub found_len: usize,
    /// First joint that the skeleton lacks although the skeleton has a child of the joint: the child turns, and the
    /// joint between does not.
    pub missing_parent: Option<usize>,
}

impl Envelope<'_> {
    /// Finds the file's joints in a skeleton of the caller by name, for [`super::gather_pose`].
    ///
    /// Names must be equal. A joint that the skeleton lacks follows its parent: compare
    /// [`BoundJoints::found_len`] with [`Envelope::joint_len`].
    ///
    /// - `names`: UTF-8 names of the skeleton's joints, in the skeleton's order. The first of equal names counts.
    /// - `out_map`: receives for each of the J joints the index of the skeleton's joint, or [`FOLDED`].
    ///
    /// # Errors
    /// - [`CallErrorKind::Length`]: `out_map` does not hold J elements.
    /// - [`CallErrorKind::OtherName`]: the skeleton names a joint with another prefix (`mixamorig:Hips` for `Hips`),
    ///   another case or other separators. [`Envelope::joint_name`] of `index` is the file's name. `found` is the
    ///   index of the skeleton's name.
    /// - [`CallErrorKind::NoRoot`]: the skeleton lacks the root, which can follow no other joint.
    /// - [`CallErrorKind::NoJoints`]: the skeleton has only the root of several joints. The character would be stiff.
    pub fn bind_joints<S: AsRef<[u8]>>(
        &self,
        names: impl IntoIterator<Item = S, IntoIter: Clone>,
        out_map: &mut [u32],
    ) -> Result<BoundJoints, CallError> {
        Argument::Joints.check_len(self.joint_len(), out_map.len())?;
        let names = names.into_iter().zip(0..FOLDED);
        let find = |matches: &dyn Fn(&[u8]) -> bool| {
            let mut names = names.clone();
            names.find(|(name, _)| matches(name.as_ref())).map(|(_, index)| index)
        };
        let file_name = |joint: usize| self.joint_name(joint).unwrap_or_default().as_bytes();
        let index_of = |joint: usize| find(&|name| name == file_name(joint));
        let is_in_file = |name: &[u8]| (0..self.joint_len()).any(|joint| name == file_name(joint));
        let mut bound = BoundJoints { found_len: 0, missing_parent: None };
        for joint in 0..self.joint_len() {
            if index_of(joint).is_some() {
                bound.found_len += 1;
                let parent = self.parent(joint).filter(|parent| index_of(*parent).is_none());
                bound.missing_parent = bound.missing_parent.or(parent);
            } else if let Some(other) =
                find(&|name| is_same_joint(name, file_name(joint)) && !is_in_file(name))
            {
                let error = CallError::new(CallErrorKind::OtherName, Argument::Names);
                return Err(error.at(joint).values(0, other as usize));
            }
        }
        let (root, len) = (self.root(), self.joint_len());
        if len > 0 && index_of(root).is_none() {
            return Err(CallError::new(CallErrorKind::NoRoot, Argument::Names).at(root));
        }
        if bound.found_len == 1 && len > 1 {
            return Err(CallError::new(CallErrorKind::NoJoints, Argument::Names).values(len, 1));
        }
        for (joint, out) in out_map.iter_mut().enumerate() {
            *out = index_of(joint).unwrap_or(FOLDED);
        }
        Ok(bound)
    }

    /// Finds the file's curves among the caller's by name. Names must be equal.
    ///
    /// - `names`: UTF-8 names of the caller's curves, in the caller's order. The first of equal names counts.
    /// - `out_map`: receives for each of the C curves the index of the caller's curve. The curves of a pose are
    ///   `curves[c] = values[out_map[c]]`.
    ///
    /// # Errors
    /// - [`CallErrorKind::Length`]: `out_map` does not hold C elements.
    /// - [`CallErrorKind::NoCurve`]: no name is that of curve `index`, [`Envelope::curve_name`].
    pub fn bind_curves<S: AsRef<[u8]>>(
        &self,
        names: impl IntoIterator<Item = S, IntoIter: Clone>,
        out_map: &mut [u32],
    ) -> Result<(), CallError> {
        Argument::Curves.check_len(self.curve_len(), out_map.len())?;
        let names = names.into_iter().zip(0..FOLDED);
        let index_of = |curve: usize| {
            let own = self.curve_name(curve).unwrap_or_default().as_bytes();
            names.clone().find(|(name, _)| name.as_ref() == own).map(|(_, index)| index)
        };
        if let Some(curve) = (0..self.curve_len()).find(|curve| index_of(*curve).is_none()) {
            return Err(CallError::new(CallErrorKind::NoCurve, Argument::Names).at(curve));
        }
        for (curve, out) in out_map.iter_mut().enumerate() {
            *out = index_of(curve).unwrap_or_default();
        }
        Ok(())
    }

    /// Returns the hash of the joints' names and parents: [`skeleton_hash_of`] in the file's order.
    ///
    /// Compare the hash after a reload, to detect the file of another character.
    pub fn skeleton_hash(&self) -> u32 {
        let joints = 0..self.joint_len();
        let names = joints.clone().filter_map(|joint| self.joint_name(joint));
        skeleton_hash_of(names, joints.map(|joint| self.parent(joint)))
    }
}

/// Gathers the J skinning matrices of a pose from the frames of the caller's skeleton.
///
/// `out_pose[j] = root world[map[j]] inverse_bind_j`. A folded joint gets the skinning matrix of its parent.
///
/// - `map`: J indices into `world`, as [`Envelope::bind_joints`] writes them.
/// - `world`: the frames of the skeleton's joints after the hierarchy pass, all in one space and in the unit of the
///   model.
/// - `root`: carries the space of `world` to the space of the palette; `None` if both are one space. Model space is
///   best for bounds, and for accuracy far from the origin: if `world` is world space, pass the inverse of the
///   actor's matrix.
/// - `out_pose`: J skinning matrices.
///
/// # Errors
/// - [`CallErrorKind::Length`]: `map` or `out_pose` does not hold J elements.
/// - [`CallErrorKind::TooShort`]: `world` lacks a frame that `map` names; `index` is the joint.
/// - [`CallErrorKind::NoRoot`]: the root is folded.
/// - [`CallErrorKind::NonFinite`]: `root` or a gathered frame is not finite. `index` is the frame's index in `world`.
pub fn gather_pose(
    envelope: &Envelope<'_>,
    map: &[u32],
    world: &[Matrix3x4],
    root: Option<&Matrix3x4>,
    out_pose: &mut [Matrix3x4],
) -> Result<(), CallError> {
    let joint_len = envelope.joint_len();
    Argument::Joints.check_len(joint_len, map.len())?;
    Argument::Pose.check_len(joint_len, out_pose.len())?;
    root.map_or(Ok(()), check_root)?;
    for (joint, index) in map.iter().enumerate() {
        check_frame(envelope, joint, *index, world)?;
    }
    for joint in envelope.evaluation_order() {
        let frame = map.get(joint).and_then(|index| world.get(*index as usize));
        let parent = || joint_index(envelope.parents().get(joint)?);
        let matrix = match (frame, envelope.bind_words().get(joint)) {
            (Some(frame), Some(bind)) => {
                let frame = root.map_or(*frame, |root| compose(root, frame));
                Some(compose(&frame, &rows(&floats(bind))))
            }
            _ => parent().and_then(|parent| out_pose.get(parent)).copied(),
        };
        if let (Some(out), Some(matrix)) = (out_pose.get_mut(joint), matrix) {
            *out = matrix;
        }
    }
    Ok(())
}

/// Computes the hash of a skeleton: a chained CRC-32 over the joints, starting at 0.
///
/// The bytes of a joint are the hash so far, the name, the length of the name, and the parent or 2³² - 1. Numbers are
/// little-endian u32.
///
/// - `names`, `parents`: of the joints, in the file's order.
///
/// ```
/// use sinew_runtime::skeleton_hash_of;
///
/// let hash = skeleton_hash_of(["hip", "knee"], [None, Some(0)]);
/// assert_ne!(hash, skeleton_hash_of(["hip", "elbow"], [None, Some(0)]));
/// ```
pub fn skeleton_hash_of<S: AsRef<[u8]>>(
    names: impl IntoIterator<Item = S>,
    parents: impl IntoIterator<Item = Option<usize>>,
) -> u32 {
    let number = |value: usize| u32::try_from(value).unwrap_or(u32::MAX).to_le_bytes();
    let joint = |hash: u32, (name, parent): (S, Option<usize>)| {
        let (name, parent) = (name.as_ref(), number(parent.unwrap_or(usize::MAX)));
        crc::of(&[&hash.to_le_bytes(), name, &number(name.len()), &parent])
    };
    names.into_iter().zip(parents).fold(0, joint)
}

/// Checks that the frame of a joint is present and finite, or that the joint is folded and is not the root.
fn check_frame(
    envelope: &Envelope<'_>,
    joint: usize,
    index: u32,
    world: &[Matrix3x4],
) -> Result<(), CallError> {
    if index == FOLDED {
        if joint != envelope.root() {
            return Ok(());
        }
        return Err(CallError::new(CallErrorKind::NoRoot, Argument::Joints).at(joint));
    }
    let Some(frame) = world.get(index as usize) else {
        let error = CallError::new(CallErrorKind::TooShort, Argument::World);
        return Err(error.at(joint).values((index as usize).saturating_add(1), world.len()));
    };
    if is_finite(frame) {
        return Ok(());
    }
    Err(CallError::new(CallErrorKind::NonFinite, Argument::World).at(index as usize))
}

/// Whether two names differ only by prefix, case or separators: `mixamorig:Hand_L` and `hand.L`.
fn is_same_joint(a: &[u8], b: &[u8]) -> bool {
    bare_name(a).next().is_some() && bare_name(a).eq(bare_name(b))
}

/// Lists the letters and digits of a name without its prefix, in lower case.
fn bare_name(name: &[u8]) -> impl Iterator<Item = u8> {
    let own = name.rsplit(|byte| matches!(byte, b':' | b'|' | b'/')).next().unwrap_or_default();
    own.iter()
        .filter(|byte| byte.is_ascii_alphanumeric() || !byte.is_ascii())
        .map(u8::to_ascii_lowercase)
}

#[cfg(test)]
mod tests {
    use super::is_same_joint;

    #[test]
    fn prefix_case_and_separators_do_not_distinguish_joints() {
        let hand = ["Hand_L", "hand.L", "mixamorig:Hand_L", "Armature|rig:HAND-l", "Rig/Hand L"];
        for (a, b) in hand.iter().flat_map(|a| hand.map(|b| (a, b))) {
            assert!(is_same_joint(a.as_bytes(), b.as_bytes()), "{a} {b}");
        }
        for (a, b) in
            [("Hand_L", "Hand_R"), ("Arm", "ForeArm"), ("_", "."), ("\u{624b}", "\u{8db3}")]
        {
            assert!(!is_same_joint(a.as_bytes(), b.as_bytes()), "{a} {b}");
        }
    }
}
