//! How much each key view counts: from a configuration of points to the characteristic views (S1 §2, METHOD §6.3).

/// The most key views that count.
const SOURCES: usize = 8;
/// Count of a view without a positive score; a score of 1 counts 1.
const FAR: f64 = 1e-3;
/// Share of the greatest count at which weights begin.
const LEAST: f64 = 0.2;

/// Returns the weights of N key views by their scores, as the runtime blends an element that all views show
/// (FORMAT.md, "Blend of key views"). Weights are not negative and sum to 1.
///
/// They are 1 for a key view at its own parameters, and change continuously between key views.
pub fn weights(scores: &[f64]) -> Vec<f64> {
    let highest = scores.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let count = |score: &f64| score.max(0.0) + FAR / (1.0 + (highest - score));
    let counts: Vec<f64> = scores.iter().map(count).collect();
    let mut order: Vec<usize> = (0..counts.len()).collect();
    order.sort_by(|&a, &b| counts[b].total_cmp(&counts[a]));
    let mut out = vec![0.0; counts.len()];
    let Some(&first) = order.first() else { return out };
    let ninth = order.get(SOURCES).map_or(0.0, |&view| counts[view]);
    let least = ninth.max(LEAST * counts[first]);
    for &view in order.iter().take(SOURCES) {
        out[view] = (counts[view] - least).max(0.0);
    }
    let whole: f64 = out.iter().sum();
    if whole > 0.0 {
        out.iter_mut().for_each(|weight| *weight /= whole);
    } else {
        out[first] = 1.0;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_view_counts_alone_at_its_own_scores_and_half_between_two() {
        assert_eq!(weights(&[0.0, 1.0, 0.0]), [0.0, 1.0, 0.0]);
        assert_eq!(weights(&[0.5, 0.5, -0.25]), [0.5, 0.5, 0.0]);
        assert_eq!(weights(&[-0.5]), [1.0]);
        assert!(weights(&[]).is_empty());
        // Nine views alike leave room for none: the first counts.
        assert_eq!(weights(&[0.1; 9])[..2], [1.0, 0.0]);
    }

    #[test]
    fn weights_are_those_of_the_formula() {
        // Scores 0.6 and 0.4: counts 0.601 and 0.4 + 0.001 / 1.2, less 0.2 x 0.601.
        let [a, b] = [0.601 - 0.1202, 0.4 + 0.001 / 1.2 - 0.1202];
        let found = weights(&[0.4, 0.6]);
        assert!((found[1] - a / (a + b)).abs() < 1e-15 && (found[0] - b / (a + b)).abs() < 1e-15);
    }
}
