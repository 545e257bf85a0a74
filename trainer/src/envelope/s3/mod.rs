//! Enveloping by rotational regression (S3): key gradients by rotational regression, vertices by a reduced
//! Poisson reconstruction, refined on the training meshes. [`fit`] goes from top to bottom:
//!
//! | file | what it does |
//! |---|---|
//! | [`surface`], [`merge`], [`proxies`] | triangles with trajectories, merged into P proxies |
//! | [`keys`], [`gradient`] | P sequences of gradients |
//! | [`rotation`] | the joint that each follows, its residual joint, and their twists |
//! | [`scale_shear`], [`predictor`] | its scale and shear, and both as one key |
//! | [`poisson`], [`reduce`] | the reconstruction, in full and reduced to c1 and c2 |
//! | [`settings`], [`validation`] | near-rigid vertices and anchors, by folds |
//! | [`refine`], [`refinement`] | c1 and c2 refined on the training meshes, by folds |
//! | [`published`], [`merging`], [`bias`] | S3 to the letter, in place of some of this: its setting, its merging, its bias |

pub mod bias;
mod fit;
pub mod gradient;
pub mod keys;
pub mod merge;
pub mod merging;
mod options;
pub mod poisson;
pub mod predictor;
pub mod proxies;
pub mod published;
pub mod reduce;
pub mod refine;
pub mod refinement;
pub mod rotation;
pub mod scale_shear;
pub mod settings;
pub mod surface;
pub mod validation;

pub use fit::{KeyChoice, Rotational, RotationalReport, fit};
pub use options::{Method, ProxyCount, RotationalOptions};
