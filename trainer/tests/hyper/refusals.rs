//! Problems that cannot be learned, and their errors.

use crate::hyper::problem::{Problem, options};
use faer::Mat;
use sinew_runtime::kernel::Kernel;
use sinew_trainer::scattered::hyper::{Entries, Method, Metric, Options, learn};
use sinew_trainer::{Error, ErrorKind};

fn refused(options: &Options) -> Error {
    Problem::franke(1, 20).learn(options).unwrap_err()
}

#[test]
fn options_are_checked() {
    let fine = options(2, 4);
    assert!(Problem::franke(1, 20).learn(&fine).is_ok());
    let hat = Kernel::Hat { power: 3 };
    let hat = refused(&Options { kernel: hat, ..fine.clone() });
    assert_eq!(hat.kind(), ErrorKind::Unsupported);
    assert_eq!(hat.message(), "nothing can be learned with a hat: it is for evaluation alone");
    let none = refused(&Options { centres: 0, ..fine.clone() });
    assert_eq!(none.message(), "the number of centres is 0");
    let none = refused(&Options { seeds: Vec::new(), ..fine.clone() });
    assert_eq!(none.message(), "there is no seed");
    let many = refused(&Options { centres: 15, degree: Some(2), ..fine.clone() });
    assert_eq!(many.kind(), ErrorKind::Fit);
    assert_eq!(
        many.message(),
        "15 centres and a polynomial of 6 terms need as many samples, found 20"
    );
    let number = |options: &Options, name: &str| {
        let error = refused(options);
        let expected = format!("{name} must be finite and not negative, found ");
        assert!(error.message().starts_with(&expected), "{error}");
        assert_eq!(error.kind(), ErrorKind::Value);
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
        let values = problem.values.as_ref();
        learn(sites.as_ref(), values, shift, scale, options).unwrap_err().to_string()
    };
    let length = |name: &str, expected: usize, found: usize| {
        format!("{name}: expected {expected}, found {found}")
    };
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
        "nothing to learn from: 0 samples of 2 inputs and 1 values"
    );
    let mut broken = sites.clone();
    let expected = "the energy is not finite where seed 1 starts: a sample or the metric is not";
    broken[(7, 1)] = f64::NAN;
    assert_eq!(with(&broken, &two, &two, &fine), expected);
    broken[(7, 1)] = f64::INFINITY;
    assert_eq!(with(&broken, &two, &two, &fine), expected);
}
