//! Shaders against their sources, the layout and a browser.
#![allow(clippy::unwrap_used, reason = "a test stops where its set-up fails")]

mod browser;
mod sources;
