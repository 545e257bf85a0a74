//! The file's joints in a skeleton of the caller's, found by their names.

use super::view::Envelope;
use crate::error::{Argument, CallError, CallErrorKind};

/// Stands in a joint map for a joint that the skeleton lacks: it moves as its parent does.
pub const FOLDED: u32 = u32::MAX;

/// What [`Envelope::bind_joints`] found of a file's joints in a skeleton.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use = "joints that were not found are stiff: compare `found_len` with `joint_len`"]
pub struct BoundJoints {
    /// Number of joints that the skeleton has, at least the root.
    pub found_len: usize,
    /// First joint that the skeleton lacks although it has the joint's child: the child turns, and this joint does not.
    pub missing_parent: Option<usize>,
}

impl Envelope<'_> {
    /// Finds the file's joints in a skeleton of the caller's, for [`super::gather_pose`].
    ///
    /// Names must be equal. A joint that the skeleton lacks follows its parent: compare
    /// [`BoundJoints::found_len`] with [`Envelope::joint_len`].
    ///
    /// - `names`: UTF-8 names of the skeleton's joints, in its order. The first of equal names counts.
    /// - `out_map`: receives for each of the J joints the number of the skeleton's, or [`FOLDED`].
    ///
    /// # Errors
    /// - [`CallErrorKind::Length`]: `out_map` does not hold J elements.
    /// - [`CallErrorKind::OtherName`]: a joint has another prefix (`mixamorig:Hips` for `Hips`), another case or other
    ///   separators in the skeleton. [`Envelope::joint_name`] of the index is the file's name, and `found` is the place
    ///   of the skeleton's.
    /// - [`CallErrorKind::NoRoot`]: the skeleton lacks the root, which can follow no other joint.
    /// - [`CallErrorKind::NoJoints`]: the skeleton has the root alone of several joints, so the character would be stiff.
    pub fn bind_joints<S: AsRef<[u8]>>(
        &self,
        names: impl IntoIterator<Item = S, IntoIter: Clone>,
        out_map: &mut [u32],
    ) -> Result<BoundJoints, CallError> {
        Argument::Joints.check_len(self.joint_len(), out_map.len())?;
        let names = names.into_iter().zip(0..FOLDED);
        let find = |is_it: &dyn Fn(&[u8]) -> bool| {
            let mut names = names.clone();
            names.find(|(name, _)| is_it(name.as_ref())).map(|(_, place)| place)
        };
        let own = |joint: usize| self.joint_name(joint).unwrap_or_default().as_bytes();
        let place = |joint: usize| find(&|name| name == own(joint));
        let is_own = |name: &[u8]| (0..self.joint_len()).any(|joint| name == own(joint));
        let mut bound = BoundJoints { found_len: 0, missing_parent: None };
        for joint in 0..self.joint_len() {
            if place(joint).is_some() {
                bound.found_len += 1;
                let parent = self.parent(joint).filter(|parent| place(*parent).is_none());
                bound.missing_parent = bound.missing_parent.or(parent);
            } else if let Some(other) = find(&|name| is_alike(name, own(joint)) && !is_own(name)) {
                let error = CallError::new(CallErrorKind::OtherName, Argument::Names);
                return Err(error.at(joint).values(0, other as usize));
            }
        }
        let (root, len) = (self.root(), self.joint_len());
        if place(root).is_none() {
            return Err(CallError::new(CallErrorKind::NoRoot, Argument::Names).at(root));
        }
        if bound.found_len == 1 && len > 1 {
            return Err(CallError::new(CallErrorKind::NoJoints, Argument::Names).values(len, 1));
        }
        for (joint, out) in out_map.iter_mut().enumerate() {
            *out = place(joint).unwrap_or(FOLDED);
        }
        Ok(bound)
    }
}

/// Whether two names differ by a prefix, by case or by separators alone: `mixamorig:Hand_L` and `hand.L`.
fn is_alike(a: &[u8], b: &[u8]) -> bool {
    bare(a).next().is_some() && bare(a).eq(bare(b))
}

/// Lists the letters and digits of a name without its prefix, in lower case.
fn bare(name: &[u8]) -> impl Iterator<Item = u8> {
    let own = name.rsplit(|byte| matches!(byte, b':' | b'|' | b'/')).next().unwrap_or_default();
    own.iter()
        .filter(|byte| byte.is_ascii_alphanumeric() || !byte.is_ascii())
        .map(u8::to_ascii_lowercase)
}

#[cfg(test)]
mod tests {
    use super::is_alike;

    #[test]
    fn prefixes_cases_and_separators_do_not_tell_joints_apart() {
        let hand = ["Hand_L", "hand.L", "mixamorig:Hand_L", "Armature|rig:HAND-l", "Rig/Hand L"];
        for (a, b) in hand.iter().flat_map(|a| hand.map(|b| (a, b))) {
            assert!(is_alike(a.as_bytes(), b.as_bytes()), "{a} {b}");
        }
        for (a, b) in
            [("Hand_L", "Hand_R"), ("Arm", "ForeArm"), ("_", "."), ("\u{624b}", "\u{8db3}")]
        {
            assert!(!is_alike(a.as_bytes(), b.as_bytes()), "{a} {b}");
        }
    }
}
