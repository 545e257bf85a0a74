//! Enveloping as published (S3): key gradients by rotational regression, vertices by a reduced
//! Poisson reconstruction, refined on the training meshes.

mod fit;
pub mod full;
pub mod gradient;
pub mod keys;
pub mod merge;
mod options;
pub mod poisson;
pub mod predictor;
pub mod proxies;
pub mod reduce;
pub mod refine;
pub mod rotation;
pub mod scale_shear;
pub mod settings;
pub mod surface;
pub mod validation;

pub use fit::{KeyChoice, Rotational, RotationalReport, Variant, fit};
pub use options::{ProxyCount, RotationalOptions};
