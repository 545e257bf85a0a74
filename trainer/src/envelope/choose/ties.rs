//! Candidates whose errors cannot be told apart.

use crate::settings::{TIED, UNSEEN};

/// Returns the index of the smallest file among the candidates that tie with the best. A candidate is (error, bytes).
pub(super) fn smallest_tied(all: &[(f64, Option<usize>)]) -> Option<usize> {
    let least = all.iter().map(|own| own.0).fold(f64::INFINITY, f64::min);
    let tied = (0..all.len()).filter(|&i| all[i].0 <= TIED * least.max(UNSEEN));
    tied.min_by_key(|&i| all[i].1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_of_tied_files_is_chosen() {
        let chosen = |all: &[(f64, usize)]| {
            smallest_tied(&Vec::from_iter(all.iter().map(|&(error, bytes)| (error, Some(bytes)))))
        };
        assert_eq!(chosen(&[(1e-3, 300), (1.01e-3, 200), (1.03e-3, 100)]), Some(1));
        // Nobody sees either error.
        assert_eq!(chosen(&[(1e-5, 300), (9e-5, 200)]), Some(1));
        assert_eq!(chosen(&[]), None);
    }
}
