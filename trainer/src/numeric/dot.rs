//! Inner products of slices.

/// Returns a·b, summed in order.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Returns a·b, in four sums that a processor can add at once.
pub(crate) fn dot_by_lanes(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; 4];
    let (x, x_rest) = a.as_chunks::<4>();
    let (y, y_rest) = b.as_chunks::<4>();
    for (p, q) in x.iter().zip(y) {
        for k in 0..4 {
            lanes[k] += p[k] * q[k];
        }
    }
    let tail: f64 = x_rest.iter().zip(y_rest).map(|(p, q)| p * q).sum();
    lanes.iter().sum::<f64>() + tail
}
