//! Faces: a skin with shapes, and a prior over their weights that says how the rest of a face follows a few pins
//! (S0 §3, METHOD §5).
//!
//! | file | what it does |
//! |---|---|
//! | [`basis`] | the neutral mesh, its shapes and identities, read from any of the formats |
//! | [`names`] | which shapes a column of a take drives |
//! | [`take`], [`track`] | an animation of weights; points that are followed |

pub mod baked;
pub mod basis;
mod error;
pub mod evaluate;
pub mod measure;
mod meshes;
pub mod names;
mod npz;
pub mod outline;
mod skin;
pub mod take;
pub mod track;

pub use error::FaceError;
