//! Matrices, laid out as the runtime's.

use core::mem::{align_of, size_of};
use sinew_runtime::Matrix3x4;

/// A rigid or affine transform, as three rows of four: `y[r] = rows[r][0..2] . x + rows[r][3]`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_matrix {
    /// The rows.
    pub rows: [[f32; 4]; 3],
}

const _: () = {
    assert!(size_of::<sinew_matrix>() == size_of::<Matrix3x4>());
    assert!(align_of::<sinew_matrix>() == align_of::<Matrix3x4>());
};
