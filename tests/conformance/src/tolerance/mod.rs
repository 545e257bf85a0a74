//! Every tolerance of the conformance tests, with its derivation; one file for each stage, with the
//! stage's name.
//!
//! Each operation rounds once: `fl(a op b) = (a op b)(1 + δ)`, |δ| ≤ u = 2⁻²⁴. After n roundings in
//! a row, the error of a value is at most γₙ = n u / (1 - n u) times the value with all its terms
//! taken as positive (Higham, Accuracy and Stability, §3.1). So the error of a sum of n products is
//! at most γₙ Σ|a||b|, in any order, fused or not. [`U`] is u and [`gamma`] is γₙ; the trainer
//! bounds its kernel maps with them.
//!
//! A stage's function takes values with bounds of their errors. The function returns the oracle's
//! value with the resulting bound. For a stage alone, on given f32 inputs, the bounds of the inputs
//! are zero; from pose to skin the bounds are chained. Every product of bounds is kept, so only the
//! oracle's own rounding is neglected, a billionth of f32 rounding.
//!
//! GPUs may divide and take roots less precisely: [`Arithmetic`] has the number of roundings of
//! each. GPUs may also fuse a product and a sum, which omits a rounding. They may flush subnormal
//! numbers; [`UNDERFLOW`] allows for that. The bounds of the transcendental functions hold on GPUs
//! as well: all but one or two of their roundings are of terms far below the result. Of these
//! functions only the arc tangent divides, and its division is counted.

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
mod polar;
mod shapes;
mod skin;
mod whole;

pub use confidence::confidence;
pub use correction::correction;
pub use directions::Direction;
pub use features::features;
pub use filter::filter;
pub use gradients::{gradients, relative, rotations, same_branch, turning};
pub use inexact::{
    BOUNDS_AT_REST, BOUNDS_POSED, EXACT, Inexact, PSEUDO_SOLVED, SOLVED, Transform, UNDERFLOW,
};
pub use joints::joints;
pub use kernel::kernel;
pub use palette::palette;
pub use polar::polar;
pub use shapes::shapes;
pub use sinew_trainer::regression::arithmetic::{Arithmetic, U, gamma};
pub use skin::{Skinned, rest, skin};
pub use whole::whole;
