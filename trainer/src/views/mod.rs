//! Memory-based 2-D graphics (S1, METHOD §6): views between a few drawings or photographs with matched points.
//!
//! [`train`] makes a [`model`] of a [`set`] of views. [`fit`] makes maps from parameters to points, depths, visibility
//! and scores of key views, and a [`mesh`] carries the pictures. A [`player`] draws a file by the runtime, and
//! [`evaluate`] compares a file with views. [`inverse`] finds parameters from points, [`transfer`] lends the motion of
//! one object to another, and [`pin`] drags a few points. [`control`] measures the networks over pixels that S1 warns
//! of. A [`report`] shows all of these on one page, and [`export`] writes files for other tools.

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
