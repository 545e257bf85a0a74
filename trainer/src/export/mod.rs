//! Exports a model and its clips as binary glTF, which plays in any engine without our runtime.
//!
//! The skeleton's joints become nodes under one armature, and the proxies become nodes under the joints. The palette
//! becomes the joints of one skin, and every mesh uses this skin. The f32 runtime predicts the palette of each frame
//! for the animations. A USD file is made from the finished GLB, so that both hold the same nodes, keys and weights.

mod between;
mod chains;
mod into;
mod mesh;
mod play;
mod played;
mod scene;
mod skeleton;
mod stretch;

pub use into::{ExportInto, Grafted};
pub use play::Playback;
pub use scene::{Export, Exported, Placement, by_use, demo_glb};
pub use skeleton::check_clips;
