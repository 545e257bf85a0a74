//! Signals as processes: functions that are likeliest, given what was observed of them, and signals and pictures made
//! finer (S0 §1 and §4, METHOD §4).
//!
//! | file | what it does |
//! |---|---|
//! | [`covariance`], [`table`], [`mean`] | what a function is thought to be: families, or estimated |
//! | [`functional`] | what is observed: a value, a derivative, a box average |
//! | [`solved`], [`kriging`], [`neighbours`] | the likeliest function, of all observations or of the nearest |
//! | [`regularised`] | fits in a span, under any norm |
//! | [`grid`] | the same on a grid: a window of taps by phase |
//! | [`image`] | pictures, by columns and rows |
//! | [`sum`], [`deviation`] | a function of observations as a sum of kernels; how far its file is off |
//! | [`observations`], [`function`] | observations as a person writes them, and their function as a part kernel |
//! | `repeated` | observations that earlier ones determine, whatever the covariance |
//! | [`reading`], [`model`] | signals of files; a filter for one, and what it reaches |
//! | [`bake`], [`plot`] | a part filter; a picture |
//! | [`choose`] | the covariance that predicts a signal best |

pub mod bake;
pub mod choose;
pub mod covariance;
pub mod deviation;
pub mod error;
pub mod function;
pub mod functional;
pub mod grid;
pub mod image;
pub mod kriging;
pub mod mean;
pub mod model;
pub mod neighbours;
pub mod observations;
pub mod plot;
pub mod reading;
pub mod regularised;
mod repeated;
pub mod solved;
pub mod sum;
pub mod table;
