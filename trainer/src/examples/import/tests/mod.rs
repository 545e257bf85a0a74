//! Scenes and posed meshes, joined.

mod matched;
mod scene;
mod targets;
