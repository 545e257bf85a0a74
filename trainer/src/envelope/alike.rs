//! Candidates whose errors cannot be told apart.

/// The smallest file is taken whose error is within this of the least.
pub const SMALLER: f64 = 1.02;
/// Error, RMS in diagonals, below which nobody sees a difference: a fifth of a millimetre on a body. Of a walk, which
/// every candidate fits so well, noise would choose.
pub const UNSEEN: f64 = 1e-4;
/// Tangent coefficients give way to a budget where positions else err so many times as much.
pub const COEFFICIENTS_COST: f64 = 1.5;

/// What decides between candidates.
pub(super) struct Rated {
    pub(super) error: f64,
    /// Whether its maps know how far a pose is from those of training.
    pub(super) knows_poses: bool,
    /// Whether it extrapolates as a reconstruction does that nothing taught of poses unlike those of training.
    pub(super) untaught: bool,
    pub(super) bytes: Option<usize>,
}

/// The place of the smallest of those whose errors cannot be told from the least, after what does well in poses unlike
/// those of training.
pub(super) fn smallest_alike(all: &[Rated]) -> Option<usize> {
    let least = all.iter().map(|rated| rated.error).fold(f64::INFINITY, f64::min);
    let alike = (0..all.len()).filter(|&i| all[i].error <= SMALLER * least.max(UNSEEN));
    alike.min_by_key(|&i| (!all[i].knows_poses, all[i].untaught, all[i].bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_errors_that_cannot_be_told_apart_the_smallest_file_is_taken() {
        let rated = |&(error, knows_poses, bytes): &(f64, bool, usize)| Rated {
            error,
            knows_poses,
            untaught: false,
            bytes: Some(bytes),
        };
        let taken =
            |all: &[(f64, bool, usize)]| smallest_alike(&all.iter().map(rated).collect::<Vec<_>>());
        assert_eq!(
            taken(&[(1e-3, true, 300), (1.01e-3, true, 200), (1.03e-3, true, 100)]),
            Some(1)
        );
        // Nobody sees either error.
        assert_eq!(taken(&[(1e-5, true, 300), (9e-5, true, 200)]), Some(1));
        // What knows nothing of poses is taken where it alone is good enough.
        assert_eq!(taken(&[(1e-3, false, 100), (1e-3, true, 200)]), Some(1));
        assert_eq!(taken(&[(1e-3, false, 200), (1.1e-3, true, 100)]), Some(0));
        assert_eq!(taken(&[]), None);
        // Nor is one that no lesson taught, small as it may be.
        let untaught = Rated { untaught: true, ..rated(&(1e-3, true, 100)) };
        assert_eq!(smallest_alike(&[untaught, rated(&(1e-3, true, 300))]), Some(1));
    }
}
