//! Solver of scattered data (METHOD §2): fits a [`KernelSum`](crate::scattered::sum::KernelSum) to samples anywhere.
//!
//! | file | content |
//! |---|---|
//! | [`samples`], [`scaling`] | sites and values, checked and merged; scales of distances |
//! | [`options`], `refusal` | options of a fit; reasons why there is none |
//! | [`matrix`], [`polynomial`] | kernels between points, greedy centres; a basis of polynomials at samples |
//! | [`system`] | the saddle system in a definite form, its solution and its condition |
//! | [`fit`] | every sample a centre, or fewer centres by least squares |
//! | [`leave_one_out`] | samples left out in closed form; the variance between samples |
//! | [`choose`] | width and smoothing with the least left-out error |
//! | [`report`] | quality of a fit |

pub mod choose;
pub mod fit;
pub mod leave_one_out;
pub mod matrix;
pub mod options;
pub mod polynomial;
pub(crate) mod refusal;
pub mod report;
pub mod samples;
pub mod scaling;
pub mod system;
