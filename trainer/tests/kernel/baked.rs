//! A function in its file: the runtime, compared with the fitted f64 function.

use crate::kernel::common::random;
use sinew_runtime::format::Space;
use sinew_runtime::kernel::{EulerOrder, Normalise, QueryRule};
use sinew_runtime::{KernelMap, Model};
use sinew_trainer::ErrorKind;
use sinew_trainer::bake::bake;
use sinew_trainer::regression::rotations::{Feature, from_euler};
use sinew_trainer::scattered::bake::part;
use sinew_trainer::scattered::model::{
    Input, InputKind, KernelModel, Output, OutputKind, query_numbers,
};
use sinew_trainer::scattered::problem::{Learn, Problem, ProblemOptions};
use sinew_trainer::scattered::train::train;

/// Tolerance relative to the larger of 1 and the value. It covers f32 features, coefficients and
/// sums, for functions whose coefficients are about as large as their values.
const TOLERANCE: f64 = 5e-5;
const SAMPLES: usize = 60;
const AXIS: [f64; 3] = [0.6, 0.0, 0.8];

/// One input of every kind.
fn inputs() -> Vec<Input> {
    let rotation = |feature, order| InputKind::Rotation { feature, order };
    let kinds = [
        InputKind::Scalar,
        InputKind::Vector3,
        rotation(Feature::Matrix, None),
        rotation(Feature::TwoRows, Some(EulerOrder::Zxy)),
        rotation(Feature::Swing(AXIS), None),
        rotation(Feature::Twist(AXIS), Some(EulerOrder::Xyz)),
        rotation(Feature::TwistAngle(AXIS), None),
    ];
    let input =
        |(i, kind)| Input { name: format!("input {i}"), kind, weight: 1.0 + 0.25 * i as f64 };
    kinds.into_iter().enumerate().map(input).collect()
}

/// One output of every kind, scalars with bounds and a sum.
fn outputs() -> Vec<Output> {
    let scalar = OutputKind::Scalar { low: 0.05, high: 0.9, normalised: true, neutral: 0.0 };
    let kinds = [
        scalar,
        scalar,
        OutputKind::Vector3 { neutral: [0.0; 3] },
        OutputKind::Rotation { neutral: [0.0, 0.0, 0.0, 1.0] },
    ];
    let output = |(i, kind)| Output { name: format!("output {i}"), kind };
    kinds.into_iter().enumerate().map(output).collect()
}

/// Draws queries, one per row: numbers between -1 and 1, rotations of up to 115 degrees.
fn queries(seed: u64, reach: f64) -> Vec<Vec<f64>> {
    let quaternion = |of: &[f64]| [of[0], of[1], of[2], 1.0];
    random(seed, SAMPLES, 22)
        .row_iter()
        .map(|row| {
            let x: Vec<f64> = row.iter().map(|x| reach * x).collect();
            let degrees = |of: &[f64]| [60.0 * of[0], 60.0 * of[1], 60.0 * of[2]];
            let parts: [&[f64]; 7] = [
                &x[..4],
                &quaternion(&x[4..7]),
                &degrees(&x[7..10]),
                &quaternion(&x[10..13]),
                &degrees(&x[13..16]),
                &quaternion(&x[16..19]),
                &[],
            ];
            parts.concat()
        })
        .collect()
}

fn problem(options: ProblemOptions) -> Problem {
    let sites = queries(1, 1.0);
    let value = |site: &Vec<f64>| {
        let [a, b] = [site[0], site[5]];
        let rotation = from_euler(EulerOrder::Xyz, [50.0 * a, 30.0 * b, 0.0]);
        let numbers = [0.4 + 0.3 * a, 0.5 - 0.4 * b, a * b, a - b, 0.5 + b];
        [numbers.as_slice(), &rotation].concat()
    };
    let values = sites.iter().map(value).collect();
    let name = "of everything".to_owned();
    Problem {
        name,
        inputs: inputs(),
        outputs: outputs(),
        sites,
        values,
        lines: Vec::new(),
        options,
    }
}

/// Asserts that the file gives the function's values, near its samples and far from them.
fn assert_same(model: &KernelModel, about: &str) {
    let bytes = bake(Space::default(), &[part(model).unwrap()]).unwrap();
    let file = Model::from_bytes(bytes).unwrap();
    let map = file.all::<KernelMap>().next().unwrap();
    let mut scratch = vec![0.0; map.counts().scratch_len()];
    let mut found = vec![0.0; map.result_len()];
    let mut doubted = 0;
    for given in queries(2, 1.0).into_iter().chain(queries(3, 4.0)) {
        let numbers = query_numbers(&model.inputs, &given).unwrap();
        let query: Vec<f32> = numbers.iter().map(|x| *x as f32).collect();
        let confidence = map.evaluate(&query, &mut scratch, &mut found).unwrap();
        let expected = model.evaluate(&given).unwrap();
        doubted += usize::from(expected.confidence < 1.0);
        let pairs = expected.numbers.iter().zip(&found);
        let pairs = pairs.chain([(&expected.confidence, &confidence)]);
        for (number, (expected, found)) in pairs.enumerate() {
            let apart = (expected - f64::from(*found)).abs() / expected.abs().max(1.0);
            assert!(apart <= TOLERANCE, "{about}, number {number}: {expected} became {found}");
        }
    }
    let stays = model.query == QueryRule::Clamp;
    assert!(stays || doubted > SAMPLES / 2, "{about}: {doubted} are far");
}

#[test]
fn the_file_gives_the_fitted_values() {
    for (kernel, degree) in [("gaussian", 0), ("thin plate", 1), ("matern 5/2", -1)] {
        for query in [QueryRule::Free, QueryRule::Clamp, QueryRule::Fade] {
            for normalise in [Normalise::Never, Normalise::Always, Normalise::AboveOne] {
                let options = ProblemOptions {
                    kernel: Some(kernel.to_owned()),
                    degree: Some(degree),
                    epsilon: Some(2.0),
                    outside: Some(query),
                    normalise: Some(normalise),
                    ..ProblemOptions::default()
                };
                let model = train(&problem(options), false).unwrap().model;
                assert_same(&model, &format!("{kernel}, {query:?}, {normalise:?}"));
            }
        }
    }
}

#[test]
fn the_file_gives_the_learned_values() {
    let learn =
        Learn { centres: Some(6), seeds: 1, evaluations: 60, ridge: 1e-6, ..Learn::default() };
    let options = ProblemOptions { learn: Some(learn), ..ProblemOptions::default() };
    let model = train(&problem(options), false).unwrap().model;
    assert!(model.sum.metric.is_some());
    assert_same(&model, "learned");
}

#[test]
fn invalid_queries_are_refused_by_input() {
    let model =
        train(&problem(ProblemOptions { epsilon: Some(2.0), ..ProblemOptions::default() }), false)
            .unwrap()
            .model;
    let mut query = queries(2, 1.0).swap_remove(0);
    query[4..8].fill(0.0);
    let refused = model.evaluate(&query).unwrap_err();
    assert_eq!(refused.kind(), ErrorKind::Value);
    assert_eq!(refused.message(), "input \"input 2\": the quaternion is zero");
    let short = model.evaluate(&query[1..]).unwrap_err();
    assert_eq!(short.kind(), ErrorKind::Mismatch);
    assert_eq!(short.message(), "expected 22 numbers, found 21");
}
