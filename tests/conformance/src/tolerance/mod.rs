//! Every tolerance of the conformance tests, with its derivation.
//!
//! Each operation rounds once, `fl(a op b) = (a op b)(1 + δ)`, |δ| ≤ u = 2⁻²⁴. A value behind n of
//! them in a row is off by at most γₙ = n u / (1 - n u) of what it would be if all its terms had one
//! sign (Higham, Accuracy and Stability, §3.1); so a sum of n products is off by γₙ Σ|a||b| in any
//! order, fused or not. A stage takes values with bounds of their own errors and gives the oracle's
//! value with the bound that follows: with zeros for a stage alone on given f32 inputs, chained from
//! pose to skin. Every product of bounds is kept, so that nothing is neglected but the oracle's own
//! rounding, a billionth of ours. U is u, [`gamma`] γₙ: the trainer bounds its kernel maps by them.
//!
//! GPUs may divide and take roots less exactly: [`Arithmetic`] says how many roundings each counts.
//! They may also fuse a product and a sum, which leaves out a rounding, and flush numbers below the
//! least normal one, for which there is [`UNDERFLOW`]. The bounds of the transcendental functions
//! hold as well: all but one or two of the roundings in them are of terms far below the result, and
//! none of them divides but the arc tangent, whose quotient is counted.

mod correction;
mod reconstruction;
mod whole;

pub use correction::{confidence, correction, features, joints};
pub use reconstruction::{
    BOUNDS_AT_REST, BOUNDS_POSED, EXACT, Inexact, PSEUDO_SOLVED, SOLVED, SkinBounds, Transform,
    UNDERFLOW, gradients, palette, relative, rest, rotations, same_branch, skin,
};
pub use sinew_trainer::kernel::arithmetic::{Arithmetic, U, gamma};
pub use whole::whole;
