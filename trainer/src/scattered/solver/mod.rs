//! Scattered data into functions (METHOD §2): from samples anywhere to a [`KernelSum`](crate::scattered::sum::KernelSum).
//!
//! | file | what it does |
//! |---|---|
//! | [`samples`], [`scaling`] | sites and values, checked and merged; how distances are measured |
//! | [`options`] | what a fit is asked for |
//! | [`matrix`], [`polynomial`] | kernels between points; a basis of polynomials at samples |
//! | [`system`], [`condition`] | the saddle system, in a form that is definite; its condition |
//! | [`solve`], [`fit`] | every sample a centre |
//! | [`power`], [`fewer`] | fewer centres, by least squares |
//! | [`any`] | either, as options ask |
//! | [`leave_one_out`], [`choose`] | samples left out in closed form; width and smoothing by that |
//! | [`variance`] | how unsure a function is between its samples |
//! | [`report`] | what a fit says of itself |

pub mod choose;
pub mod error;
pub mod fit;
pub mod leave_one_out;
pub mod matrix;
pub mod options;
pub mod polynomial;
pub mod report;
pub mod samples;
pub mod scaling;
pub mod system;
