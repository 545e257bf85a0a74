//! What views between views reach: against held-out views, closed forms and truth that tests make.
#![allow(clippy::unwrap_used, reason = "a test stops where its set-up fails")]

mod baked;
mod common;
mod deformation;
mod demo;
mod export;
mod faults;
mod left_out;
mod painted;
mod pixels;
mod proposed;
#[path = "../shared/mod.rs"]
mod shared;
mod tiger;
mod turning;
