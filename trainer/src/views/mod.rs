//! Memory-based 2-D graphics (S1, METHOD §6): from a few drawings or photographs with matched points to every
//! view between them.
//!
//! A [`set`] of views, as a person writes it, is [`fit`]ted: parameters into points, depths, visibility and a
//! score of each key view. [`inverse`] goes back from points to parameters, [`deformation`] lends one
//! object's motion to another, and [`naive`] is the network over pixels that S1 warns of.

pub mod deformation;
pub mod demo;
pub mod fit;
pub mod inverse;
pub mod motion;
pub mod naive;
pub mod set;
