//! Vector registers as a CPU's scalar code wants them.

use faer::Mat;
use std::hint::black_box;

/// Ends what faer's products leave behind: their wide registers stay in use, and on some CPUs all other
/// arithmetic of the same thread then takes ten times as long (*measured*). A norm puts them back.
pub(crate) fn narrow() {
    black_box(black_box(Mat::<f64>::identity(8, 8)).norm_l2());
}
