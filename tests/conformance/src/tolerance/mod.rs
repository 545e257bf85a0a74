//! Every tolerance of the conformance tests, with its derivation; a file a stage, by its name.
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

mod confidence;
mod correction;
mod directions;
mod features;
mod filter;
mod gradients;
mod inexact;
mod joints;
mod kernel;
mod palette;
mod shapes;
mod skin;
mod whole;

pub use confidence::confidence;
pub use correction::correction;
pub use directions::Direction;
pub use features::features;
pub use filter::filter;
pub use gradients::{gradients, relative, rotations, same_branch};
pub use inexact::{
    BOUNDS_AT_REST, BOUNDS_POSED, EXACT, Inexact, PSEUDO_SOLVED, SOLVED, Transform, UNDERFLOW,
};
pub use joints::joints;
pub use kernel::kernel;
pub use palette::palette;
pub use shapes::shapes;
pub use sinew_trainer::regression::arithmetic::{Arithmetic, U, gamma};
pub use skin::{Skinned, rest, skin};
pub use whole::whole;
