//! Faces: a skin with shapes, and a prior over their weights that says how the rest of a face follows a few pins
//! (S0 §3, METHOD §5).
//!
//! | file | what it does |
//! |---|---|
//! | [`basis`] | the neutral mesh, its shapes and identities, read from any of the formats |
//! | [`names`] | which shapes a column of a take drives |
//! | [`prior`] | what a take teaches of the weights of all shapes |
//! | [`take`], [`track`] | an animation of weights; points that are followed |

pub mod basis;
mod error;
mod meshes;
pub mod names;
mod npz;
pub mod prior;
pub mod take;
pub mod track;

pub use error::FaceError;
