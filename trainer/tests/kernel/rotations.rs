//! Rotations as inputs and outputs of functions.

use crate::kernel::common::{json, random, rows};
use faer::{Mat, Side};
use sinew_runtime::kernel::EulerOrder;
use sinew_runtime::kernel::Kernel;
use sinew_trainer::regression::function::Exact;
use sinew_trainer::regression::rotations::{Feature, Xyzw, from_euler, from_values, to_values};
use sinew_trainer::scattered::solver::fit::Fit;
use sinew_trainer::scattered::solver::matrix::matrix as kernels;
use sinew_trainer::scattered::solver::options::Options;
use sinew_trainer::scattered::solver::samples::{Conflicts, Samples};
use sinew_trainer::scattered::solver::scaling::Block;

/// Returns the smallest eigenvalue of a symmetric matrix.
fn least(of: &Mat<f64>) -> f64 {
    of.self_adjoint_eigenvalues(Side::Lower).unwrap()[0]
}

fn quaternions(count: usize) -> Vec<Xyzw> {
    rows(&random(8, count, 4)).iter().map(|q| [q[0], q[1], q[2], q[3]]).collect()
}

/// Computes a feature of each rotation, one per row.
fn features(feature: Feature, rotations: &[Xyzw]) -> Mat<f64> {
    let all: Vec<Vec<f64>> = rotations.iter().map(|q| feature.of(*q).unwrap()).collect();
    Mat::from_fn(all.len(), feature.number_len(), |i, c| all[i][c])
}

#[test]
fn a_gaussian_of_features_is_definite_where_one_of_angles_is_not() {
    let Some(file) = json("../reference/edge_cases.json") else { return };
    let of = |name: &str| {
        let all = file["rotation_kernel_min_eigenvalue_400_random"].as_array().unwrap();
        all.iter().map(|of| of[name].as_f64().unwrap()).fold(f64::MAX, f64::min)
    };
    assert!(of("geodesic_gaussian_exp_minus_d2") < -0.5 && of("unreal_quintic") < -5.0);
    assert!(of("chordal_gaussian_on_rotation_matrix") > 0.0);
    let points = features(Feature::Matrix, &quaternions(100));
    assert!(least(&kernels(Kernel::Gaussian, &points, &points)) > 1e-9);
    let hats = kernels(
        Kernel::Hat { power: 5 },
        &(&points * faer::Scale(0.3)),
        &(points * faer::Scale(0.3)),
    );
    assert!(least(&hats) < -0.1);
}

#[test]
fn twists_about_one_axis_have_the_references_eigenvalues() {
    let Some(file) = json("../reference/edge_cases.json") else { return };
    let turn = |i: usize| from_euler(EulerOrder::Xyz, [0.0, 3.0 * i as f64, 0.0]);
    let turns: Vec<Xyzw> = (0..120).map(turn).collect();
    let axis = [0.0, 1.0, 0.0];
    let angles = features(Feature::TwistAngle(axis), &turns);
    for (sigma, expected) in file["twist_circle_min_eigenvalue"].as_object().unwrap() {
        let epsilon = 1.0 / sigma.parse::<f64>().unwrap().to_radians();
        let of = |kernel: Kernel| {
            let geodesic = Mat::from_fn(120, 120, |i, k| {
                let apart = (angles[(i, 0)] - angles[(k, 0)]).abs();
                kernel.exact((epsilon * apart.min(std::f64::consts::TAU - apart)).powi(2))
            });
            least(&geodesic)
        };
        let close =
            |name: &str, found: f64| (found - expected[name].as_f64().unwrap()).abs() < 1e-12;
        assert!(close("geodesic_gaussian", of(Kernel::Gaussian)), "{sigma}");
        assert!(close("laplacian", of(Kernel::Matern12)), "{sigma}");
        let chords = features(Feature::Twist(axis), &turns) * faer::Scale(epsilon);
        assert!(close("chord_gaussian", least(&kernels(Kernel::Gaussian, &chords, &chords))));
    }
}

#[test]
fn a_rotation_drives_another_whatever_its_quaternions_sign() {
    // The output rotates half as far about the same axis, from a separate neutral rotation.
    let neutral = from_euler(EulerOrder::Zyx, [20.0, -35.0, 50.0]);
    let pose = |x: f64, y: f64| from_euler(EulerOrder::Xyz, [x, y, 0.0]);
    let driven = |q: Xyzw| {
        let [x, y, z] = to_values([0.0, 0.0, 0.0, 1.0], q).unwrap();
        from_values(neutral, [0.5 * x, 0.5 * y, 0.5 * z]).unwrap()
    };
    let poses: Vec<Xyzw> =
        (0..25).map(|i| pose(30.0 * (i % 5) as f64 - 60.0, 30.0 * (i / 5) as f64 - 60.0)).collect();
    let sites = features(Feature::Matrix, &poses);
    let values: Vec<[f64; 3]> =
        poses.iter().map(|q| to_values(neutral, driven(*q)).unwrap()).collect();
    let values = Mat::from_fn(25, 3, |i, c| values[i][c]);
    let blocks = [Block { len: 9, weight: 1.0 }];
    let samples = Samples::new(&sites, &values, &blocks, Conflicts::Refuse).unwrap();
    let fit = Fit::new(&samples, &Options::new(Kernel::ThinPlate)).unwrap();
    for (x, y) in [(0.0, 0.0), (-60.0, 30.0), (17.0, -41.0)] {
        let q = pose(x, y);
        let at = |q: Xyzw| {
            let found = fit.sum.evaluate(&Feature::Matrix.of(q).unwrap());
            from_values(neutral, [found[0], found[1], found[2]]).unwrap()
        };
        assert_eq!(at(q), at(q.map(|x| -x)));
        let angle = |a: Xyzw, b: Xyzw| {
            let dot: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
            2.0 * dot.abs().min(1.0).acos().to_degrees()
        };
        let most = if x == 17.0 { 1.0 } else { 1e-4 };
        assert!(angle(at(q), driven(q)) < most, "{x} {y}: {}", angle(at(q), driven(q)));
    }
}

#[test]
fn rotations_count_by_their_weights() {
    let all = quaternions(40);
    let (a, b) = (
        features(Feature::Matrix, &all[..20]),
        features(Feature::Swing([1.0, 0.0, 0.0]), &all[20..]),
    );
    let sites = faer::concat![[&a, &b]];
    let values = Mat::from_fn(20, 1, |i, _| i as f64);
    let spread = |weight: f64| {
        let blocks = [Block { len: 9, weight: 1.0 }, Block { len: 3, weight }];
        let samples = Samples::new(&sites, &values, &blocks, Conflicts::Refuse).unwrap();
        let points = samples.scaling.apply(&sites);
        points.subcols(9, 3).norm_l2() / points.subcols(0, 9).norm_l2()
    };
    assert!((spread(1.0) - 1.0).abs() < 1e-12 && (spread(3.0) - 3.0).abs() < 1e-12);
}
