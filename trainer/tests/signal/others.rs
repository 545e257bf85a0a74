//! Comparison with others: scikit-learn, the kernel library, and direct manipulation.

use super::common::*;
use faer::Mat;
use faer::linalg::solvers::Solve;
use sinew_runtime::kernel::Kernel;
use sinew_trainer::scattered::solver::fit::Fit;
use sinew_trainer::scattered::solver::options::Options;
use sinew_trainer::scattered::solver::samples::{Conflicts, Samples};
use sinew_trainer::scattered::solver::scaling::Block;
use sinew_trainer::signal::covariance::Covariance;
use sinew_trainer::signal::functional::Functional;
use sinew_trainer::signal::kriging::Mean;
use sinew_trainer::signal::kriging::{Kriging, Process};
use sinew_trainer::signal::solved::Solved;

/// Sites of scikit-learn's samples; their values are sin(1.3 x) + 0.2 x.
const X: [f64; 10] = [0.0, 0.4, 1.1, 1.9, 2.2, 3.7, 5.0, 5.1, 7.3, 8.0];
/// Queries of scikit-learn.
const Q: [f64; 7] = [-0.5, 0.2, 1.5, 3.0, 4.4, 6.2, 8.8];

fn curve() -> Vec<f64> {
    X.iter().map(|x| (1.3 * x).sin() + 0.2 * x).collect()
}

/// scikit-learn 1.9.1, numpy 2.4.6: `GaussianProcessRegressor(K(1.2), alpha=1e-3,
/// optimizer=None).fit(x, y) .predict(q, return_std=True)`, K `RBF`, `Matern(nu=0.5)`,
/// `Matern(nu=1.5)`, `Matern(nu=2.5)`: mean, then squared deviation.
const SCIKIT: [[[f64; 7]; 2]; 4] = [
    [
        [
            -0.6028688001279638,
            0.2914625184800734,
            1.2284943627720313,
            -0.08758500859598373,
            0.3783868170926041,
            2.0080497642220654,
            0.22050599602339085,
        ],
        [
            0.02519834301906465,
            0.0006291400934919088,
            0.001138400112663418,
            0.00942119306376199,
            0.01150350805329736,
            0.08295225808547146,
            0.18195190730458777,
        ],
    ],
    [
        [
            0.0005584273251643189,
            0.28466861009284317,
            1.0466497645991655,
            0.1626805980337422,
            0.4718630536054318,
            0.9487561999866028,
            0.3964512128239119,
        ],
        [
            0.5658354993056753,
            0.16562638443295763,
            0.3219603115573837,
            0.5527791694981826,
            0.4919721321268424,
            0.7245534640684204,
            0.7366660769465302,
        ],
    ],
    [
        [
            -0.27158865382900704,
            0.2739685689284299,
            1.206289937993248,
            -0.009515055783378887,
            0.3675222812221121,
            1.4499654060086282,
            0.30263499752587186,
        ],
        [
            0.24071364174444063,
            0.010761580507612887,
            0.05082467028522953,
            0.23127828078443058,
            0.15693579146262215,
            0.4545167998030001,
            0.5010026382209575,
        ],
    ],
    [
        [
            -0.3986985909238543,
            0.2808263598656781,
            1.219954814688769,
            -0.049763792902985965,
            0.34297758696902025,
            1.685036926119599,
            0.2553204761119535,
        ],
        [
            0.12996723589405698,
            0.002410966423906036,
            0.01287267500360123,
            0.11665663774844924,
            0.07026436648444223,
            0.3104095918913777,
            0.3917543537577666,
        ],
    ],
];

#[test]
fn scikit_learns_gaussian_processes_predict_the_same() {
    let length = 1.2;
    let families = [
        Covariance::SquaredExponential { length },
        Covariance::OrnsteinUhlenbeck { length },
        Covariance::Matern32 { length },
        Covariance::Matern52 { length },
    ];
    for (covariance, [means, variances]) in families.into_iter().zip(SCIKIT) {
        let process = Process { covariance, mean: Mean::Zero, noise: 1e-3 };
        let fit = Kriging::new(&process, &values(&X), &curve()).unwrap();
        for ((at, mean), variance) in Q.into_iter().zip(means).zip(variances) {
            let found = fit.predict(&Functional::Value { at });
            assert!((found.value - mean).abs() < 1e-9, "{process:?} {at}: {}", found.value);
            assert!(
                (found.variance - variance).abs() < 1e-9,
                "{process:?} {at}: {}",
                found.variance
            );
        }
    }
}

#[test]
fn of_values_it_is_the_kernel_library() {
    let (y, n) = (curve(), X.len());
    let column = |of: &[f64]| Mat::from_fn(n, 1, |i, _| of[i]);
    let blocks = [Block { len: 1, weight: 1.0 }];
    let samples = Samples::new(&column(&X), &column(&y), &blocks, Conflicts::Refuse).unwrap();
    for (kernel, degree, mean) in [
        (Kernel::Gaussian, None, Mean::Zero),
        (Kernel::Gaussian, Some(0), Mean::Constant),
        (Kernel::Matern12, Some(0), Mean::Constant),
        (Kernel::Matern32, Some(1), Mean::Linear),
        (Kernel::Matern52, Some(1), Mean::Linear),
    ] {
        let options = Options { epsilon: 2.0, smoothing: 1e-3, degree, ..Options::new(kernel) };
        let whole = Fit::new(&samples, &options).unwrap();
        let length = 1.0 / whole.sum.scale[0];
        let covariance = match kernel {
            Kernel::Gaussian => Covariance::SquaredExponential { length: length * 0.5f64.sqrt() },
            Kernel::Matern12 => Covariance::OrnsteinUhlenbeck { length },
            Kernel::Matern32 => Covariance::Matern32 { length },
            _ => Covariance::Matern52 { length },
        };
        let process = Process { covariance, mean, noise: 1e-3 };
        let fit = Kriging::new(&process, &values(&X), &y).unwrap();
        for at in Q {
            let expected = whole.sum.evaluate(&[at])[0];
            let found = fit.predict(&Functional::Value { at }).value;
            assert!((found - expected).abs() < 1e-10, "{kernel:?}: {found} {expected}");
        }
    }
}

#[test]
fn on_a_finite_set_it_is_direct_manipulation() {
    // METHOD §5.1, in weights: Δw = Σ B̄ᵀ(B̄ Σ B̄ᵀ + βI)⁻¹ Δm, and the face moves by B Δw.
    let (n, r, pins) = (30, 7, [3, 11, 12, 28]);
    let mut numbers = Numbers::new(6);
    let b = Mat::from_fn(n, r, |_, _| numbers.normal());
    let half = Mat::from_fn(r, 2 * r, |_, _| numbers.normal());
    let covariance = &half * half.transpose();
    let moved = [0.5, -1.0, 0.25, 2.0];
    for beta in [1e-2, 1.0] {
        let picked = Mat::from_fn(pins.len(), r, |i, c| b[(pins[i], c)]);
        let inner = &picked * &covariance * picked.transpose()
            + Mat::<f64>::identity(pins.len(), pins.len()) * faer::Scale(beta);
        let right = Mat::from_fn(pins.len(), 1, |i, _| moved[i]);
        let weights = &covariance * picked.transpose() * inner.partial_piv_lu().solve(right);
        let expected = &b * weights;
        // The same solution by the covariance of the face's coordinates, the only input here.
        let a = &b * &covariance * b.transpose();
        let at_pins =
            Mat::from_fn(4, 4, |i, k| a[(pins[i], pins[k])] + if i == k { beta } else { 0.0 });
        let solved = Solved::new(at_pins, &Mat::zeros(4, 0), &moved).unwrap();
        for place in 0..n {
            let row: Vec<f64> = pins.iter().map(|pin| a[(place, *pin)]).collect();
            let found = solved.value(&row, &[]);
            assert!((found - expected[(place, 0)]).abs() < 1e-10, "{beta} {place}");
        }
    }
}
