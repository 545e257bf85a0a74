//! Problems that cannot be learned, and their errors.

use crate::hyper::problem::{Problem, options};
use faer::Mat;
use sinew_runtime::kernel::Kernel;
use sinew_trainer::scattered::hyper::{Entries, HyperError, Method, Metric, Options, learn};

fn refused(options: &Options) -> HyperError {
    Problem::franke(1, 20).learn(options).unwrap_err()
}

#[test]
fn options_are_checked() {
    let fine = options(2, 4);
    assert!(Problem::franke(1, 20).learn(&fine).is_ok());
    let hat = Kernel::Hat { power: 3 };
    assert_eq!(refused(&Options { kernel: hat, ..fine.clone() }), HyperError::Hat);
    assert_eq!(refused(&Options { centres: 0, ..fine.clone() }), HyperError::NoCentres);
    assert_eq!(refused(&Options { seeds: Vec::new(), ..fine.clone() }), HyperError::NoSeeds);
    assert_eq!(
        refused(&Options { centres: 15, degree: Some(2), ..fine.clone() }),
        HyperError::TooFewSamples { centres: 15, terms: 6, samples: 20 }
    );
    let number = |options: &Options, name: &str| {
        let HyperError::Number { name: found, .. } = refused(options) else { panic!("{name}") };
        assert_eq!(found, name);
    };
    number(&Options { ridge: -1.0, ..fine.clone() }, "the ridge");
    let of = |method| Options { method, ..fine.clone() };
    number(&of(Method::GradientFlow { step: f64::NAN }), "ω");
    let walk = |reach, temperatures| of(Method::Metropolis { reach, temperatures });
    number(&walk(f64::INFINITY, [0.0; 2]), "the reach");
    number(&walk(0.1, [-1.0, 0.0]), "the first T");
    number(&walk(0.1, [0.0, -1.0]), "the last T");
}

#[test]
fn samples_and_their_attributes_are_checked() {
    let problem = Problem::franke(1, 20);
    let fine = options(2, 4);
    let with = |sites: &Mat<f64>, shift: &[f64], scale: &[f64], options: &Options| {
        learn(sites.as_ref(), problem.values.as_ref(), shift, scale, options).unwrap_err()
    };
    let length = |name, expected, found| HyperError::Length { name, expected, found };
    let (sites, two) = (&problem.sites, [1.0; 2]);
    assert_eq!(with(sites, &[0.0], &two, &fine), length("inputs' shifts", 2, 1));
    assert_eq!(with(sites, &two, &[1.0; 3], &fine), length("inputs' scales", 2, 3));
    assert_eq!(
        with(&sites.subrows(0, 19).to_owned(), &two, &two, &fine),
        length("samples' values", 19, 20)
    );
    let wide = Options { metric: Metric::scaled(3, 3, 1.0, Entries::All), ..fine.clone() };
    assert_eq!(with(sites, &two, &two, &wide), length("columns of the metric", 2, 3));
    let mut flat = fine.clone();
    flat.metric.start = Mat::zeros(0, 2);
    assert_eq!(with(sites, &two, &two, &flat), length("rows of the metric", 1, 0));
    assert_eq!(
        with(&Mat::zeros(0, 2), &two, &two, &fine),
        HyperError::Empty { samples: 0, inputs: 2, values: 1 }
    );
    let mut broken = sites.clone();
    broken[(7, 1)] = f64::NAN;
    assert_eq!(with(&broken, &two, &two, &fine), HyperError::NotFinite { seed: 1 });
    broken[(7, 1)] = f64::INFINITY;
    assert_eq!(with(&broken, &two, &two, &fine), HyperError::NotFinite { seed: 1 });
}
