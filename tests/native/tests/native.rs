//! The C ABI as C and C++ see it.
#![allow(clippy::unwrap_used, reason = "a test stops where its set-up fails")]

mod compiled;
mod header;
