//! Exported files play elsewhere as in the runtime, and scenes of other tools become examples.
#![allow(clippy::unwrap_used, reason = "a test stops where its set-up fails")]

mod blender;
mod export;
