//! Kernel maps: any function of a few numbers, learned from samples (S2, METHOD §2).
//!
//! [`function`] has every kernel, [`sum`] what they make up, [`bound`] the error bound of f32, [`deviation`] the
//! measured error of a file, [`rotations`] the features of a rotation. [`scattered`] solves for one, [`compat`] as other
//! solvers do, [`hyper`] learns its centres and metric.
//!
//! With its names it is the part kernel of a file: a [`problem`] as a person writes it is [`train`]ed into a
//! [`model`], which [`bake`] writes; [`check`] holds cases of another solver, [`plot`] draws.
//!
//! The rest is the envelope's regression of functions that vanish at rest. From samples to a map:
//! [`inputs`] measures their distances, [`centres`] chooses centres, [`design`] decomposes what depends on
//! the inputs alone, [`ridge`] fits [`outputs`] to it, [`map`] evaluates. Where outputs are very many and
//! only the errors are asked for, [`gram`] takes their inner products instead. Both forms are validated by
//! [`left_out`].
//!
//! **To add a kernel** of METHOD §2.1, positive definite and 1 at its centre:
//! 1. `runtime/src/envelope/group/kernel.rs`: a variant of `GroupKernel` with METHOD's number, its name, its
//!    values in f32, its place in `ALL` (`from_number` takes numbers for consecutive).
//! 2. [`function`]: value and steepness in f64, and its place in `SMOOTHEST_FIRST`; from then on every
//!    training tries it. [`map`]: the roundings of its value, and whether the bound there covers its
//!    slope.
//! 3. `shaders/kernel_value.glsl` and `.wgsl`, or, of the kernels that an envelope's groups have, `numeric`,
//!    then `cargo xtask shaders`: no compiler misses a kernel there, any number without a case is a Matérn
//!    5/2. `gpu/tests/common/kernels.rs` compares each number that a file may name.
//! 4. The tables in `runtime/FORMAT.md` and `trainer/METHOD.md`, and the closed forms that tests
//!    compare with, in `runtime/tests/evaluate/correction.rs` and beside `GroupKernel`.

pub mod arithmetic;
pub mod bake;
pub mod bound;
pub mod centres;
pub mod certainty;
pub mod check;
pub mod compare;
pub mod compat;
pub mod design;
pub mod deviation;
pub mod fade;
pub mod function;
pub mod gram;
pub mod hyper;
pub mod inputs;
pub mod left_out;
pub mod map;
pub mod model;
pub mod outputs;
pub mod plot;
pub mod problem;
pub mod ridge;
pub mod rotations;
pub mod scattered;
pub mod sum;
pub mod train;
