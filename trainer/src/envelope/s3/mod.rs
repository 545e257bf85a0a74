//! Enveloping by rotational regression (S3). Regression predicts key gradients, and a reduced Poisson reconstruction
//! turns the gradients into vertices. Its matrices c1 and c2 are then refined on the training meshes. [`fit`] runs
//! these stages in order:
//!
//! | file | stage |
//! |---|---|
//! | [`surface`], [`merge`], [`proxies`] | triangles and their trajectories, merged into P proxies |
//! | [`keys`] | P sequences of gradients, and a predictor for each |
//! | [`rotation`] | the joint and the residual joint that a key follows, and their twists |
//! | [`poisson`], [`reduce`] | the reconstruction: full, and reduced to c1 and c2; the refinement of c1 and c2 |
//! | [`validation`] | chooses near-rigid vertices, anchors and refinement by cross-validation |
//! | [`published`] | S3 to the letter: its setting, its merging, its bias |

mod fit;
pub mod keys;
pub mod merge;
mod options;
pub mod poisson;
pub mod proxies;
pub mod published;
pub mod reduce;
pub mod rotation;
pub mod surface;
pub mod validation;

pub use fit::{Rotational, RotationalReport, fit};
pub use options::{Method, ProxyCount, RotationalOptions};
