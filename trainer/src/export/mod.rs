//! A model and a clip as binary glTF, which plays in any engine without our runtime.
//!
//! The skeleton's joints become nodes under one armature, and the proxies under them; what is in the
//! palette are the joints of one skin, and every mesh hangs on it. The f32 runtime predicts the
//! palette of each frame, and that is what the animations play.

mod between;
mod character;
mod demo;
mod dress;
mod error;
mod further;
mod into;
mod mesh;
mod played;
mod proxies;
mod skeleton;
mod stretch;
mod times;

pub use character::{Export, Exported, Stand};
pub use demo::{by_use, demo_glb};
pub use error::ExportError;
pub use into::{ExportInto, Grafted, IntoError};
