//! Faces: a skin with shapes, and a prior over the weights of the shapes (S0 §3, METHOD §5.1). The prior predicts the
//! rest of a face from a few pins.
//!
//! | file | contents |
//! |---|---|
//! | [`source`], [`basis`] | reads the neutral mesh, its shapes and identities from any format |
//! | [`names`] | finds the shapes that a column of a take drives |
//! | [`take`], [`track`] | an animation of weights; tracked points |
//! | [`prior`] | learns the mean and covariance of weights from a take |
//! | [`train`], [`outline`] | bakes a face; the mesh beside the file |
//! | [`baked`] | a loaded face: pins to weights, weights to vertices |
//! | [`evaluate`] | measures distances between faces, and the accuracy with a few handles |
//! | [`scene`], [`picture`], [`report`] | a face as binary glTF, as pixels, as a page |

pub mod baked;
pub mod basis;
pub mod evaluate;
pub mod names;
pub mod outline;
pub mod picture;
pub mod prior;
pub mod report;
pub mod scene;
pub mod source;
pub mod take;
#[cfg(test)]
mod tests;
pub mod track;
pub mod train;
