//! How much each key view counts: from a configuration of points to the characteristic views (S1 §2, METHOD §6.3).

use sinew_runtime::views::Blend;

/// Returns the weights of N key views by their scores, as the runtime has them: not negative, and they sum to 1.
pub fn weights(scores: &[f64]) -> Vec<f64> {
    let single: Vec<f32> = scores.iter().map(|score| *score as f32).collect();
    let mut out = vec![0.0; scores.len()];
    for (view, share) in Blend::of_scores(&single).views() {
        out[*view] += f64::from(*share);
    }
    out
}
