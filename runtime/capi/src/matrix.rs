//! Matrices, laid out as the runtime's.

use core::mem::{align_of, offset_of, size_of};
use sinew_runtime::{LocalTransform, Matrix3x4};

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

/// A joint's frame in its parent's.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_local_transform {
    /// Quaternion x, y, z, w; it is normalised by the call.
    pub rotation: [f32; 4],
    /// Origin in the parent's frame, in the units of the model.
    pub translation: [f32; 3],
}

const _: () = {
    assert!(size_of::<sinew_local_transform>() == size_of::<LocalTransform>());
    assert!(align_of::<sinew_local_transform>() == align_of::<LocalTransform>());
    assert!(
        offset_of!(sinew_local_transform, translation) == offset_of!(LocalTransform, translation)
            && offset_of!(LocalTransform, rotation) == 0
    );
};
