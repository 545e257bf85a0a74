//! Tests of the runtime.
#![allow(clippy::unwrap_used, reason = "a test stops where its set-up fails")]

mod allocator;
mod common;
mod evaluate;
mod format;
mod no_alloc;
