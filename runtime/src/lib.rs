//! Evaluates baked Sinew models: no standard library, no allocation, and the same bits on every CPU.
//!
//! ```
//! use sinew_runtime::{CallError, Envelope, LocalTransform, Matrix3x4, Model, Skin};
//! use sinew_runtime::{matrix, model_space_pose};
//!
//! /// Skins a mesh from a file and an animation's rotations. An engine keeps the arrays.
//! fn frame(
//!     model: &Model<Vec<u8>>,
//!     rotations: &[(usize, [f32; 4])],
//! ) -> Result<Vec<[f32; 3]>, CallError> {
//!     let parts = (model.first::<Envelope>(), model.first::<Skin>());
//!     let (Some(envelope), Some(skin)) = parts else { return Ok(Vec::new()) };
//!     // Start at the rest pose, then apply the animation.
//!     let mut local: Vec<LocalTransform> = envelope.rest_locals().collect();
//!     for (joint, rotation) in rotations {
//!         local[*joint].rotation = *rotation;
//!     }
//!     let mut pose = vec![matrix::IDENTITY; envelope.joint_len()];
//!     model_space_pose(&envelope, &local, &mut pose)?;
//!     let curves = vec![0.0; envelope.curve_len()];
//!     debug_assert_eq!(envelope.check_pose(&pose, &curves), Ok(()));
//!     let mut palette: Vec<Matrix3x4> = vec![matrix::IDENTITY; envelope.palette_len()];
//!     let mut scratch = vec![0.0; envelope.scratch_len()];
//!     envelope.palette(&pose, &curves, &mut scratch, &mut palette)?;
//!     let mut positions = vec![[0.0; 3]; skin.vertex_len()];
//!     skin.skin_positions(&palette, &mut positions)?;
//!     Ok(positions)
//! }
//! ```
//!
//! An engine with the matrices of its own skeleton gathers the pose with [`gather_pose`].
//!
//! [`Model::from_bytes`] checks a file once. Later evaluations read the file in place and fail only
//! for the caller's own arguments. `FORMAT.md` describes the file.
//!
//! "METHOD" in these pages is the trainer's `METHOD.md`: the mathematics, with its sources.
//!
//! Arithmetic is plain IEEE single precision: no fused multiply-add and one fixed order of
//! summation. Each transcendental function is one polynomial (METHOD §7).
#![no_std]
#![forbid(unsafe_code)]
// Without `internals`, items that serve only the trainer and other evaluators are unused.
#![cfg_attr(not(feature = "internals"), allow(dead_code, unreachable_pub, unused_imports))]

pub mod envelope;
mod error;
#[cfg(feature = "filter")]
pub mod filter;
pub mod format;
#[cfg(feature = "kernel")]
pub mod kernel;

mod lanes;
mod limits;
mod linear;
pub mod matrix;
mod model;
mod named;
mod names;
mod numeric;
#[cfg(feature = "prior")]
pub mod prior;
#[cfg(feature = "record")]
pub mod record;
pub mod skin;
#[cfg(feature = "internals")]
pub mod stages;
#[cfg_attr(
    all(
        not(target_os = "none"),
        any(
            target_feature = "sse2",
            target_feature = "simd128",
            all(target_arch = "aarch64", target_feature = "neon")
        )
    ),
    path = "vector_unit.rs"
)]
mod unit;
#[cfg(not(target_os = "none"))]
mod vectors;
#[cfg(feature = "views")]
pub mod views;

pub use envelope::{
    Envelope, LocalTransform, gather_pose, model_space_pose, model_space_pose_under,
    skeleton_hash_of,
};
pub use error::{Argument, CallError, CallErrorKind};
#[cfg(feature = "filter")]
pub use filter::Filter;
pub use format::part::{ModelPart, PartLayout};
pub use format::{FileError, FileErrorKind};
#[cfg(feature = "kernel")]
pub use kernel::KernelMap;
pub use limits::Limits;
pub use linear::Matrix3x4;
pub use matrix::{scale_palette, take_scale};
pub use model::Model;
#[cfg(feature = "internals")]
pub use model::Section;
#[cfg(feature = "prior")]
pub use prior::{Pin, PinJob, Pins, Prior};
#[cfg(feature = "record")]
pub use record::Record;
#[cfg(feature = "shapes")]
pub use skin::ShapesJob;
pub use skin::{Skin, SkinJob, mesh_hash_of};
#[cfg(feature = "raster")]
pub use views::RenderJob;
#[cfg(feature = "views")]
pub use views::{Frame, FrameJob, Views};

/// Compiles the example of `README.md`.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
