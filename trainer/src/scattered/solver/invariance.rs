//! Kernels without a width.

use sinew_runtime::kernel::Kernel;

/// Returns true if a factor on all distances leaves the function of all samples as it is, without smoothing.
pub const fn is_scale_invariant(kernel: Kernel) -> bool {
    matches!(kernel, Kernel::Linear | Kernel::ThinPlate | Kernel::Cubic | Kernel::Quintic)
}
