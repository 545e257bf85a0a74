//! Memory-based 2-D graphics (S1, METHOD §6): from a few drawings or photographs with matched points to every
//! view between them.
//!
//! A [`set`] of views, as a person writes it, is [`train`]ed into a [`model`]: [`fit`] makes maps from parameters to
//! points, depths, visibility and a score of each key view, and a [`mesh`] goes along. [`bake`] writes it, a [`player`] shows a file by the
//! runtime, [`evaluate`] holds it against views. [`inverse`] goes back from points to parameters, [`deformation`] and
//! [`transfer`] lend one object's motion to another, [`pin`] lets a few points be dragged, and [`naive`] is the network
//! over pixels that S1 warns of, which [`control`] measures and a [`report`] shows beside the rest.

pub mod control;
pub mod demo;
pub mod evaluate;
pub mod export;
pub mod fit;
pub mod inverse;
pub mod mesh;
pub mod model;
pub mod object;
pub mod pin;
pub mod player;
pub mod report;
pub mod set;
pub mod train;
pub mod transfer;
