//! Scenes and posed meshes, joined.

mod scene;
mod targets;
