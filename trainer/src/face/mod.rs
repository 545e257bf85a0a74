//! Faces: a skin with shapes, and a prior over their weights that says how the rest of a face follows a few pins
//! (S0 §3, METHOD §5.1).
//!
//! | file | what it does |
//! |---|---|
//! | [`basis`], [`source`] | the neutral mesh, its shapes and identities, read from any of the formats |
//! | [`names`] | which shapes a column of a take drives |
//! | [`take`], [`track`] | an animation of weights; points that are followed |
//! | [`prior`] | what a take says of the weights of all shapes, and how a file holds it |
//! | [`train`] | from all these to a file, and the mesh beside it: [`outline`] |
//! | [`baked`] | a face as its file holds it, solved and shaped by the runtime |
//! | [`measure`], [`evaluate`] | how far faces are apart; what a few handles reach |
//! | [`scene`], [`picture`], [`report`] | a face as binary glTF, as pixels, as a page |

pub mod baked;
pub mod basis;
mod error;
pub mod evaluate;
pub mod measure;
mod meshes;
pub mod names;
mod npz;
pub mod outline;
pub mod picture;
pub mod prior;
pub mod report;
pub mod scene;
mod skin;
pub mod source;
pub mod take;
#[cfg(test)]
mod tests;
pub mod track;
pub mod train;

pub use error::{FaceError, listed};
