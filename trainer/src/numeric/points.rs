//! How far points lie from others, one by one and in any order.

/// Measures how far points lie from others, one by one, RMS.
pub fn apart<const N: usize>(a: &[[f64; N]], b: &[[f64; N]]) -> f64 {
    let squared = |(a, b): (&[f64; N], &[f64; N])| -> f64 {
        a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum()
    };
    (a.iter().zip(b).map(squared).sum::<f64>() / a.len().max(1) as f64).sqrt()
}

/// Measures how far apart, RMS, points lie from as many others whatever the order of either: their coordinates, each
/// axis sorted, and their distances from the origin. It is 0 for the same points.
pub fn apart_unordered(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    apart(&unordered(a), &unordered(b))
}

fn unordered(points: &[[f64; 3]]) -> Vec<[f64; 4]> {
    let mut all = vec![[0.0; 4]; points.len()];
    for k in 0..4 {
        let of =
            |x: &[f64; 3]| if k < 3 { x[k] } else { x.iter().map(|x| x * x).sum::<f64>().sqrt() };
        let mut values: Vec<f64> = points.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        all.iter_mut().zip(values).for_each(|(all, value)| all[k] = value);
    }
    all
}
