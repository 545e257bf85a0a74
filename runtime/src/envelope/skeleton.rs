//! Which skeleton it is: a number that an engine can compute of its own.

use super::view::Envelope;
use crate::format::crc;

impl Envelope<'_> {
    /// Returns the hash of the joints' names and parents, [`skeleton_hash_of`] in the file's order: a reload of another
    /// character's file shows itself.
    pub fn skeleton_hash(&self) -> u32 {
        let joints = 0..self.joint_len();
        let names = joints.clone().filter_map(|joint| self.joint_name(joint));
        skeleton_hash_of(names, joints.map(|joint| self.parent(joint)))
    }
}

/// Computes the hash of a skeleton: a CRC-32, from 0 on of joint after joint, each time of the hash so far, the name's
/// bytes, their number, and the parent or 2³² - 1, numbers as little-endian u32.
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
