//! Kernels without a width.

use sinew_runtime::kernel::Kernel;

/// Tells whether distances may be multiplied by anything: smoothing apart, the function of all samples
/// stays the same.
pub const fn is_scale_invariant(kernel: Kernel) -> bool {
    matches!(kernel, Kernel::Linear | Kernel::ThinPlate | Kernel::Cubic | Kernel::Quintic)
}
