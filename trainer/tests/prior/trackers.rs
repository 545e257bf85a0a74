//! Terms for trackers: the previous frame, symmetry, cancelling pairs.

use super::common::*;
use faer::Mat;
use sinew_runtime::prior::{Anchor, Pin, Temporal};

#[test]
fn the_frame_before_is_a_prior_combined_once() {
    let face = Face::new(12, 11);
    let n = face.shape_len();
    let pins = sorted(three());
    let (now, last) = (weights(n, 6), weights(n, 7));
    let stiffness = 40.0;
    let narrow: Vec<f32> = last.iter().map(|w| *w as f32).collect();
    let (found, _) = face
        .solve(&pins, &now, |job| {
            job.anchor = Anchor::Mean;
            // The weights must outlive the job.
            let weights = Vec::leak(narrow.clone());
            job.temporal = Some(Temporal { weights, stiffness: stiffness as f32 });
        })
        .unwrap();
    // (Σ⁻¹ + s I)⁻¹, and its mean.
    let precision = inverse(&face.prior.covariance);
    let combined = inverse(&(&precision + Mat::<f64>::identity(n, n) * faer::Scale(stiffness)));
    let right = |i: usize| {
        (0..n).map(|j| precision[(i, j)] * face.prior.mean[j]).sum::<f64>() + stiffness * last[i]
    };
    let right: Vec<f64> = (0..n).map(right).collect();
    let mean: Vec<f64> =
        (0..n).map(|i| (0..n).map(|j| combined[(i, j)] * right[j]).sum()).collect();
    let (b, rest) = face.rows(&pins);
    let missing: Vec<f64> = targets(&pins).iter().zip(&rest).map(|(t, r)| t - r).collect();
    let noise = noise(&pins, f64::from(face.prior.fit.beta));
    let expected = dual(&combined, &b, &noise, &missing, &mean);
    assert!(apart(&found, &expected) < 1e-4, "{}", apart(&found, &expected));
    let without = dual(&face.prior.covariance, &b, &noise, &missing, &face.prior.mean);
    assert!(apart(&found, &without) > 1e-2);
}

#[test]
fn symmetry_is_rows_of_observations() {
    let face = Face::new(12, 12);
    let n = face.shape_len();
    let pins = sorted(three());
    let now = weights(n, 8);
    let ([first, second], stiffness) = face.prior.symmetry[0];
    for by in [1.0, 30.0] {
        let (found, _) = face.solve(&pins, &now, |job| job.symmetry = by as f32).unwrap();
        // One more row: w_a - w_b has the target 0.
        let (b, rest) = face.rows(&pins);
        let k = b.nrows();
        let rows = Mat::from_fn(k + 1, n, |i, j| match i < k {
            true => b[(i, j)],
            false => f64::from(j == first) - f64::from(j == second),
        });
        let mut missing: Vec<f64> = targets(&pins).iter().zip(&rest).map(|(t, r)| t - r).collect();
        missing.push(0.0);
        let mut noise = noise(&pins, f64::from(face.prior.fit.beta));
        noise.push(1.0 / (by * stiffness));
        let expected = dual(&face.prior.covariance, &rows, &noise, &missing, &now);
        assert!(apart(&found, &expected) < 1e-4);
        let (plain, _) = face.solve(&pins, &now, |_| ()).unwrap();
        let difference = |w: &[f64]| (w[first] - w[second]).abs();
        assert!(difference(&found) < difference(&plain));
    }
}

#[test]
fn of_a_pair_that_cancels_the_smaller_is_held_at_0() {
    let mut both = 0;
    for seed in 0..10 {
        let face = Face::new(12, 20 + seed);
        let [a, b] = face.prior.cancel[0];
        let pins: Vec<Pin> =
            (0..4).map(|i| Pin::new(4 + 27 * i, [0.5, -0.4 + 0.3 * i as f32, 0.2])).collect();
        let now = weights(12, 30 + seed);
        for is_bounded in [false, true] {
            let (free, _) = face.solve(&pins, &now, |job| job.is_bounded = is_bounded).unwrap();
            let (found, edit) = face
                .solve(&pins, &now, |job| (job.is_bounded, job.cancels) = (is_bounded, true))
                .unwrap();
            assert!(edit.is_least);
            if free[a] == 0.0 || free[b] == 0.0 {
                assert_eq!(found, free);
                continue;
            }
            both += 1;
            let smaller = if free[a].abs() < free[b].abs() { a } else { b };
            assert_eq!(found[smaller], 0.0, "{free:?}");
            if !is_bounded {
                // The other weights are as without the shape, which equals bounds of 0.
                let mut prior = face.prior.clone();
                prior.bounds = vec![[-1e6, 1e6]; 12];
                prior.bounds[smaller] = [0.0; 2];
                let other = Face::of(face.skin.clone(), prior);
                let (expected, _) = other.solve(&pins, &now, |job| job.is_bounded = true).unwrap();
                assert!(apart(&found, &expected) < 1e-5);
            }
        }
    }
    assert!(both > 5, "pairs are at work: {both}");
}
