//! Normals that are right: tangent coefficients, fitted to the surface of the training frames (METHOD §1.8).

mod chosen;
mod fan;
mod fit;
mod lean;
mod tilt;
mod truth;
mod vertex;

pub use chosen::fit_normals;
pub use fan::Fan;
pub use fit::PosedSurface;
pub use truth::TrueNormals;
