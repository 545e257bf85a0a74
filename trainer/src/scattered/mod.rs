//! Scattered data: functions of a few numbers, learned from samples (S2, S1, METHOD §2).
//!
//! [`problem`] reads the samples and options that a person writes. [`train`] fits a [`model`] to a problem, and
//! [`bake`] writes the model as the part `kernel` of a file. [`plot`] draws functions.
//!
//! [`solver`] fits a [`sum`] of kernels and polynomials. [`compat`] solves by other libraries' rules and compares
//! values with theirs. [`hyper`] learns centres and a metric. [`bound`] bounds the rounding error of f32, and
//! [`deviation`] measures the error of a baked file.
//!
//! **To add a kernel** of METHOD §2.1, positive definite and 1 at its centre:
//! 1. `runtime/src/envelope/group/kernel.rs`: a variant of `GroupKernel` with METHOD's number, its name, its f32 values
//!    and its place in `ALL` (`from_number` expects consecutive numbers).
//! 2. [`crate::regression::function`]: value and slope in f64, and a place in `SMOOTHEST_FIRST`; every training then
//!    tries the kernel. [`crate::regression::map`]: rounding of its value, and whether the bound there covers its
//!    slope.
//! 3. `shaders/kernel_value.glsl` and `.wgsl`, or `numeric` for kernels of envelope groups, then `cargo xtask shaders`.
//!    No compiler reports a missing case there: a number without a case is a Matérn 5/2. `gpu/tests/common/kernels.rs`
//!    compares each number that a file may name.
//! 4. The tables in `runtime/FORMAT.md` and `trainer/METHOD.md`, and the closed forms that tests compare with, in
//!    `runtime/tests/evaluate/correction/reference.rs` and beside `GroupKernel`.

pub mod bake;
pub mod bound;
pub mod compat;
pub mod deviation;
pub mod hyper;
pub mod model;
pub mod plot;
pub mod problem;
pub mod solver;
pub mod sum;
pub mod train;

use faer::Mat;

/// Makes a matrix of rows of equal length.
fn matrix(rows: &[Vec<f64>]) -> Mat<f64> {
    Mat::from_fn(rows.len(), rows.first().map_or(0, Vec::len), |i, c| rows[i][c])
}
