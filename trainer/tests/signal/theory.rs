//! The identities of METHOD §4.

use super::common::*;
use super::reference::least;
use faer::Mat;
use sinew_trainer::signal::covariance::Covariance;
use sinew_trainer::signal::functional::Functional;
use sinew_trainer::signal::grid::{Grid, GridFilter, Sample};
use sinew_trainer::signal::kriging::Mean;
use sinew_trainer::signal::kriging::{Kriging, Process, gram};

#[test]
fn matrices_of_every_covariance_are_definite() {
    for covariance in families() {
        let name = covariance.name();
        let mut numbers = Numbers::new(4);
        let places: Vec<f64> = (0..60).map(|_| 6.0 * numbers.normal()).collect();
        let mut functionals = values(&places);
        for (k, at) in places.iter().enumerate().step_by(3) {
            functionals.push(Functional::Average { from: *at, to: at + 0.1 + k as f64 / 20.0 });
            if covariance.is_smooth() {
                functionals.push(Functional::Derivative { at: *at });
            }
        }
        let least = least(&gram(&process(covariance, Mean::Zero), &functionals));
        assert!(least >= -1e-12, "{name}: {least}");
        println!("{name}: {least:.1e}");
    }
    // Control: a gaussian of the angle on a circle is not positive definite.
    let angles = Mat::from_fn(24, 24, |i, k| {
        let d = 2.0 * f64::from((i.abs_diff(k)).min(24 - i.abs_diff(k)) as u32) / 24.0;
        (-0.5 * (d / 0.9) * (d / 0.9)).exp()
    });
    assert!(least(&angles) < -1e-4);
}

#[test]
fn variance_grows_by_the_cost_of_an_unknown_mean() {
    // METHOD's formula, by plain elimination.
    let places: Vec<f64> = vec![0.0, 1.0, 2.5, 4.0, 4.2];
    let process = Process {
        covariance: Covariance::Matern32 { length: 2.0 },
        mean: Mean::Constant,
        noise: 0.05,
    };
    let fit = Kriging::new(&process, &values(&places), &[1.0, 2.0, 0.0, -1.0, 0.5]).unwrap();
    let k = gram(&process, &values(&places));
    let inverse = |y: &Mat<f64>| {
        use faer::linalg::solvers::Solve;
        k.partial_piv_lu().solve(y)
    };
    let ones = Mat::from_fn(5, 1, |_, _| 1.0);
    let y = Mat::from_fn(5, 1, |i, _| [1.0, 2.0, 0.0, -1.0, 0.5][i]);
    let dot = |a: &Mat<f64>, b: &Mat<f64>| (a.transpose() * b)[(0, 0)];
    let all = dot(&ones, &inverse(&ones));
    let m = dot(&ones, &inverse(&y)) / all;
    for at in [-1.0, 1.4, 3.3, 9.0] {
        let r = Mat::from_fn(5, 1, |i, _| process.covariance.value(at - places[i]));
        let value = m + dot(&r, &inverse(&(&y - &ones * faer::Scale(m))));
        let own = 1.0 - dot(&r, &inverse(&r));
        let gained = (1.0 - dot(&ones, &inverse(&r))).powi(2) / all;
        let found = fit.predict(&Functional::Value { at });
        assert!((found.value - value).abs() < 1e-12);
        assert!((found.variance - own - gained).abs() < 1e-12, "{at}");
        assert!(gained > 1e-7 && own > 0.0, "{gained} {own}");
    }
}

#[test]
fn lines_and_constants_go_through_filters_unchanged() {
    for (mean, slope) in [(Mean::Constant, 0.0), (Mean::Linear, 0.4)] {
        for sample in [Sample::Value, Sample::Average] {
            for covariance in families() {
                let grid = Grid { factor: 3, taps: 5, sample };
                let filter = GridFilter::new(&process(covariance, mean), grid).unwrap();
                let samples: Vec<f64> = (0..9).map(|i| 100.0 + slope * f64::from(i)).collect();
                let shape = sinew_trainer::signal::grid::Shape { samples: 9, lanes: 1 };
                for (at, found) in filter.apply(&samples, shape).unwrap().iter().enumerate() {
                    let middle = if sample == Sample::Average { 0.5 } else { 0.0 };
                    let place = (at as f64 + middle) / 3.0 - middle;
                    assert!((found - 100.0 - slope * place).abs() < 1e-9, "{at} {found}");
                }
            }
        }
    }
}
