//! Tests of joining scenes and posed meshes.

mod meshes;
mod real;
mod scene;
