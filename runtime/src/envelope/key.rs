//! A key predictor, read in place (METHOD §1.4, §1.5).

use super::counts::{KEY_WORDS, NO_JOINT};
use crate::linear::{Le, floats, rows};

/// A key predictor: `D = Q_p exp(twist . theta_b) [exp(residual . theta_c)] (I + sym(H [theta_b; theta_p]))`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key {
    /// The joint b that it follows; p is its parent.
    pub joint: usize,
    /// A = u W, rows (METHOD §1.4).
    pub twist: [[f32; 3]; 3],
    /// The residual joint c and its A', rows.
    pub residual: Option<(usize, [[f32; 3]; 3])>,
    /// H: a row for each of S - I's xx, xy, xz, yy, yz, zz; columns theta_b, then theta_p.
    pub shear: [[f32; 6]; 6],
}

/// A key where it lies in the file.
pub(crate) struct KeyRow<'a> {
    pub(crate) joint: usize,
    pub(crate) twist: &'a [Le; 9],
    pub(crate) residual: Option<(usize, &'a [Le; 9])>,
    pub(crate) shear: &'a [Le],
}

impl<'a> KeyRow<'a> {
    pub(crate) fn new(words: &'a [Le; KEY_WORDS]) -> Option<Self> {
        let [[b0, b1, c0, c1], matrices @ ..] = words;
        let (twist, rest) = matrices.split_first_chunk()?;
        let (residual, shear) = rest.split_first_chunk()?;
        let joint = u16::from_le_bytes([*b0, *b1]).into();
        let residual = joint_index(&[*c0, *c1]).map(|joint| (joint, residual));
        Some(Self { joint, twist, residual, shear })
    }

    pub(crate) fn to_key(&self) -> Option<Key> {
        let residual = self.residual.map(|(joint, twist)| (joint, rows(&floats(twist))));
        let shear = rows(&floats(self.shear.first_chunk::<36>()?));
        Some(Key { joint: self.joint, twist: rows(&floats(self.twist)), residual, shear })
    }
}

/// Reads the index of a joint; `None` if it stands for none.
pub(crate) fn joint_index(le: &[u8; 2]) -> Option<usize> {
    let index = u16::from_le_bytes(*le);
    (index != NO_JOINT).then_some(usize::from(index))
}
