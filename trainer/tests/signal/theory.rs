//! The identities of METHOD §4.

use super::common::*;
use super::reference::least;
use faer::Mat;
use sinew_trainer::signal::covariance::Covariance;
use sinew_trainer::signal::functional::Functional;
use sinew_trainer::signal::grid::{Grid, GridFilter, Sample};
use sinew_trainer::signal::kriging::Mean;
use sinew_trainer::signal::kriging::Neighbours;
use sinew_trainer::signal::kriging::{Kriging, Process, gram};
use sinew_trainer::signal::solved::Norm;

fn mixed() -> (Vec<Functional>, Vec<f64>) {
    let functionals = vec![
        Functional::Value { at: 0.0 },
        Functional::Derivative { at: 0.7 },
        Functional::Average { from: 1.0, to: 2.5 },
        Functional::Value { at: 3.1 },
        Functional::Average { from: 2.0, to: 5.0 },
        Functional::Derivative { at: 6.0 },
    ];
    (functionals, vec![1.0, -0.4, 0.2, 1.7, 0.9, 0.3])
}

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
fn a_fit_in_the_span_with_the_observations_own_norm_is_kriging() {
    let (functionals, values) = mixed();
    let covariance = Covariance::Matern52 { length: 1.4 };
    let none = process(covariance.clone(), Mean::Zero);
    let c = gram(&none, &functionals);
    for beta in [1e-3, 0.1] {
        let noisy = Process { noise: beta, ..none.clone() };
        let (expected, ..) = Kriging::new(&noisy, &functionals, &values).unwrap().coefficients();
        let found = Norm::new(c.clone()).unwrap().fit(&c, &values, beta);
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found - expected).abs() < 1e-9, "Eq. 13 of Eq. 15");
        }
    }
}

#[test]
fn any_definite_norm_reproduces_by_its_own_kernel() {
    let (functionals, values) = mixed();
    let covariance = Covariance::Matern52 { length: 1.4 };
    let h = |at: f64| -> Vec<f64> {
        let q = Functional::Value { at };
        functionals.iter().map(|of| of.covariance(&q, &covariance)).collect()
    };
    let c = gram(&process(covariance.clone(), Mean::Zero), &functionals);
    let n = functionals.len();
    let mut numbers = Numbers::new(8);
    let random = Mat::from_fn(n, n, |_, _| numbers.normal());
    let any = &random * random.transpose() + Mat::<f64>::identity(n, n);
    for s in [c.clone(), Mat::identity(n, n), any] {
        let norm = Norm::new(s).unwrap();
        let f = norm.fit(&c, &values, 1e-2);
        for q in [-1.0, 0.4, 2.2, 7.0] {
            let at_q: f64 = f.iter().zip(h(q)).map(|(c, h)| c * h).sum();
            let found = norm.inner(&f, &norm.reproducing(&h(q)));
            assert!((found - at_q).abs() < 1e-12, "⟨f, K(·, q)⟩ = f(q): {found} {at_q}");
        }
        // No other coefficients have a smaller energy.
        let energy = |f: &[f64]| {
            let column = Mat::from_fn(n, 1, |i, _| f[i]);
            let misses = &c * column - Mat::from_fn(n, 1, |i, _| values[i]);
            misses.squared_norm_l2() + 1e-2 * norm.inner(f, f)
        };
        let least = energy(&f);
        for k in 0..n {
            for step in [-1e-3, 1e-3] {
                let mut other = f.clone();
                other[k] += step;
                assert!(energy(&other) > least);
            }
        }
    }
    let indefinite = Mat::from_fn(2, 2, |i, k| if i == k { 1.0 } else { 2.0 });
    let error = Norm::new(indefinite).err().unwrap().to_string();
    assert_eq!(error, "the norm S is not positive definite");
}

#[test]
fn all_neighbours_are_the_whole_and_few_of_ornstein_and_uhlenbeck_are_enough() {
    let places: Vec<f64> = (0..30).map(|i| 1.3 * f64::from(i) + 0.2 * f64::from(i % 3)).collect();
    let mut numbers = Numbers::new(1);
    let found: Vec<f64> = places.iter().map(|_| numbers.normal()).collect();
    let functionals = values(&places);
    let near = |process: &Process, count: usize, at: f64| {
        let all = Neighbours { process, functionals: &functionals, values: &found, count };
        all.predict(&Functional::Value { at }).unwrap()
    };
    for covariance in families() {
        let process = process(covariance, Mean::Constant);
        let whole = Kriging::new(&process, &functionals, &found).unwrap();
        for at in [0.4, 17.7, 38.0] {
            let expected = whole.predict(&Functional::Value { at });
            let own = near(&process, 30, at);
            assert!((own.value - expected.value).abs() < 1e-11);
            assert!((own.variance - expected.variance).abs() < 1e-11);
        }
    }
    let markov = process(Covariance::OrnsteinUhlenbeck { length: 3.0 }, Mean::Zero);
    let whole = Kriging::new(&markov, &functionals, &found).unwrap();
    let at = 0.5 * (places[11] + places[12]);
    let expected = whole.predict(&Functional::Value { at });
    assert!((near(&markov, 2, at).value - expected.value).abs() < 1e-10);
    assert!((near(&markov, 1, at).value - expected.value).abs() > 1e-2, "one is not enough");
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
