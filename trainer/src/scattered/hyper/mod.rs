//! HyperBF: a sum of few kernels whose centres and metric are learned (S1 appendix 1, METHOD §3).
//!
//! [`learn()`] places centres on samples ([`Start`]), moves them and the metric by one of three methods
//! ([`Method`]), from every seed, and keeps the best. [`Energy`] is what they lower. Random numbers are
//! ChaCha8's, loops are scalar and in one order, and what is neither a sum, a product, a quotient nor
//! a square root is libm's: the same seed gives the same trace, bit for bit, on any CPU.

mod energy;
mod error;
mod flow;
mod learn;
mod least_squares;
mod metropolis;
mod options;
mod projection;
mod quasi_newton;
mod start;
mod trace;

pub use energy::{Energy, Parameters, Point};
pub use error::HyperError;
pub use learn::{Learned, learn};
pub use options::{Entries, Method, Metric, Options, Start};
pub use trace::{Step, Stop, Trace};
