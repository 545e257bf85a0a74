//! Scenes and posed meshes, joined.

mod matched;
mod parts;
mod real;
mod scene;
mod targets;
