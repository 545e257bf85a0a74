//! Candidates whose errors cannot be told apart.

/// Errors that differ by less than this factor cannot be told apart.
pub const ALIKE: f64 = 1.02;
/// Error, RMS in diagonals, below which nobody sees a difference: a fifth of a millimetre on a body. Of a walk, which
/// every candidate fits so well, noise would choose.
pub const UNSEEN: f64 = 1e-4;
/// Vertices on which errors are compared or forecast for less time; more tell the same.
pub const FEW_VERTICES: usize = 250;
/// Tangent coefficients give way to a budget where positions else err so many times as much.
pub const COEFFICIENTS_COST: f64 = 1.5;

/// The place of the smallest file of those whose error cannot be told from the least: of each, error and bytes.
pub(super) fn smallest_alike(all: &[(f64, Option<usize>)]) -> Option<usize> {
    let least = all.iter().map(|own| own.0).fold(f64::INFINITY, f64::min);
    let alike = (0..all.len()).filter(|&i| all[i].0 <= ALIKE * least.max(UNSEEN));
    alike.min_by_key(|&i| all[i].1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_errors_that_cannot_be_told_apart_the_smallest_file_is_taken() {
        let taken = |all: &[(f64, usize)]| {
            smallest_alike(&Vec::from_iter(all.iter().map(|&(error, bytes)| (error, Some(bytes)))))
        };
        assert_eq!(taken(&[(1e-3, 300), (1.01e-3, 200), (1.03e-3, 100)]), Some(1));
        // Nobody sees either error.
        assert_eq!(taken(&[(1e-5, 300), (9e-5, 200)]), Some(1));
        assert_eq!(taken(&[]), None);
    }
}
