//! S2's solver as published, against its Python, and the same function as one of our kernels.

use crate::kernel::common::{apart, evaluate, json, matrix, random, rows};
use faer::Mat;
use sinew_trainer::regression::function::Exact;
use sinew_trainer::scattered::compat::published::{Published, PublishedKernel, PublishedOptions};

fn kernel(name: &str) -> PublishedKernel {
    match name {
        "linear" => PublishedKernel::Linear,
        "gaussian" => PublishedKernel::Gaussian,
        "thin_plate" => PublishedKernel::ThinPlate,
        "multi_quadratic_biharmonic" => PublishedKernel::MultiQuadraticBiharmonic,
        "inv_multi_quadratic_biharmonic" => PublishedKernel::InverseMultiQuadraticBiharmonic,
        "beckert_wendland_c2_basis" => PublishedKernel::BeckertWendlandC2,
        name => panic!("{name}"),
    }
}

/// Returns the tolerance relative to the largest output (METHOD §2.7): normal equations square the
/// condition.
fn tolerance(condition: f64) -> f64 {
    if condition <= 100.0 { 1e-9 } else { 1e-6 }
}

#[test]
fn every_case_of_the_post_is_reproduced() {
    let Some(file) = json("../reference/seed002_reference.json") else { return };
    let [features, outputs, grid] = ["samples", "outputs", "grid_points"].map(|n| matrix(&file[n]));
    let cases = file["seed_python"].as_array().unwrap();
    assert_eq!(cases.len(), 68);
    for case in cases {
        let options = PublishedOptions {
            kernel: kernel(case["kernel"].as_str().unwrap()),
            radius: case["radius"].as_f64().unwrap(),
            regularization: case["regularization"].as_f64().unwrap(),
            normalise_features: case["feature_normalise"].as_bool().unwrap(),
            normalise_distances: case["distance_normalise"].as_bool().unwrap(),
        };
        let found = Published::new(&features, &outputs, &options).unwrap();
        let condition = case["cond_M"].as_f64().unwrap();
        assert!(condition <= 3e4 && (found.condition / condition - 1.0).abs() < 1e-9);
        let norm = case["distance_norm"].as_f64().unwrap();
        assert!((found.distance_norm / norm - 1.0).abs() < 1e-14);
        let theta = matrix(&case["theta"]);
        let share = apart(&found.theta.transpose().to_owned(), &theta) / theta.norm_max();
        assert!(share <= tolerance(condition), "{options:?} theta {share:.1e}");
        for (queries, name) in [(&features, "at_samples"), (&grid, "grid")] {
            let expected = matrix(&case[name]);
            let share = apart(&evaluate(&found.sum, queries), &expected) / expected.norm_max();
            assert!(share <= tolerance(condition), "{options:?} {name} {share:.1e}");
        }
    }
}

#[test]
fn the_sum_of_our_kernel_is_the_posts_sum() {
    let (features, outputs) = (random(3, 12, 3), random(4, 12, 2));
    let queries = random(5, 40, 3);
    for kernel in ALL {
        for radius in [0.25, 0.9] {
            let options = PublishedOptions {
                kernel,
                radius,
                regularization: 1e-3,
                normalise_features: true,
                normalise_distances: kernel != PublishedKernel::Linear,
            };
            let found = Published::new(&features, &outputs, &options).unwrap();
            let plain = |query: &[f64]| -> Vec<f64> {
                let mut out = vec![0.0; 2];
                for k in 0..12 {
                    let apart = |c: usize| (query[c] - features[(k, c)]) / found.feature_norms[c];
                    let distance = (0..3).map(|c| apart(c).powi(2)).sum::<f64>().sqrt();
                    let value = kernel.value(distance / found.distance_norm, radius);
                    (0..2).for_each(|o| out[o] += found.theta[(o, k)] * value);
                }
                out
            };
            let expected: Vec<Vec<f64>> = rows(&queries).iter().map(|q| plain(q)).collect();
            let expected = Mat::from_fn(40, 2, |i, o| expected[i][o]);
            let most = 1e-12 * found.theta.norm_max();
            assert!(apart(&evaluate(&found.sum, &queries), &expected) < most, "{kernel:?}");
        }
    }
}

#[test]
fn functions_of_a_distance_are_kernels_of_ours_by_a_scale_and_a_factor() {
    for kernel in ALL {
        for radius in [0.1f64, 0.5, 1.0, 3.0] {
            let found = kernel.canonical(radius);
            for step in 0..60 {
                let d = 0.05 * f64::from(step);
                let ours = found.factor * found.kernel.exact((found.epsilon * d).powi(2));
                let exact = closed_form(kernel, d, radius);
                assert!(
                    (ours - exact).abs() <= 1e-13 * (1.0 + exact.abs()),
                    "{kernel:?} {radius} {d}"
                );
            }
        }
    }
}

#[test]
fn a_radius_that_is_not_positive_is_guarded_where_the_post_guards_it() {
    for radius in [0.0, -1.0] {
        for kernel in [
            PublishedKernel::Gaussian,
            PublishedKernel::ThinPlate,
            PublishedKernel::BeckertWendlandC2,
        ] {
            assert_eq!(kernel.value(3e-4, radius), kernel.value(3e-4, 0.001));
            assert_eq!(kernel.canonical(radius), kernel.canonical(0.001));
        }
    }
    let distance = PublishedKernel::MultiQuadraticBiharmonic.canonical(0.0);
    assert_eq!(distance.factor * distance.kernel.exact(4.0), 2.0);
}

const ALL: [PublishedKernel; 6] = [
    PublishedKernel::Linear,
    PublishedKernel::Gaussian,
    PublishedKernel::ThinPlate,
    PublishedKernel::MultiQuadraticBiharmonic,
    PublishedKernel::InverseMultiQuadraticBiharmonic,
    PublishedKernel::BeckertWendlandC2,
];

/// Evaluates the post's formulas, as written there.
fn closed_form(kernel: PublishedKernel, d: f64, r: f64) -> f64 {
    match kernel {
        PublishedKernel::Linear => d,
        PublishedKernel::Gaussian => (-0.5 * (d / (0.707 * r)).powi(2)).exp(),
        PublishedKernel::ThinPlate if d == 0.0 => 0.0,
        PublishedKernel::ThinPlate => (d / r).powi(2) * (d / r).ln(),
        PublishedKernel::MultiQuadraticBiharmonic => d.hypot(r),
        PublishedKernel::InverseMultiQuadraticBiharmonic => 1.0 / d.hypot(r),
        PublishedKernel::BeckertWendlandC2 => (1.0 - d / r).max(0.0).powi(4) * (4.0 * d / r + 1.0),
    }
}
