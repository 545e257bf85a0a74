//! A model and a clip as binary glTF, which plays in any engine without our runtime.
//!
//! The skeleton's joints become nodes under one armature, and the proxies under them; what is in the
//! palette are the joints of one skin, and every mesh hangs on it. The f32 runtime predicts the
//! palette of each frame, and that is what the animations play.

mod between;
mod error;
mod into;
mod mesh;
mod played;
mod proxies;
mod scene;
mod skeleton;
mod stretch;

pub use error::{ExportError, IntoError};
pub use into::{ExportInto, Grafted};
pub use scene::{Export, Exported, Stand, by_use, demo_glb};
