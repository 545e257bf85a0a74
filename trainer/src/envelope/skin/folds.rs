//! Folds of a cross-validation.

use std::ops::Range;

/// Folds of the training poses, fewer where they would be short.
const FOLDS: usize = 10;
/// Poses of a fold, so that it holds more than neighbours of what is left.
const FOLD_LEN: usize = 2;

/// Splits n poses into contiguous folds of nearly equal length, two at least.
pub fn folds(n: usize) -> Vec<Range<usize>> {
    let count = (n / FOLD_LEN).clamp(2, FOLDS);
    (0..count).map(|f| f * n / count..(f + 1) * n / count).collect()
}
