//! Cases of the folders `kernel` and `signal`.

use super::with_cases;
use crate::cli::common::Folder;
use crate::cli::kernel::numbers;
use serde_json::{Value, json};
use std::fs;

/// Evaluates `m.sinew` at queries; returns the outputs and the confidence of each.
fn evaluated(folder: &Folder, queries: &Value) -> Vec<(Vec<f64>, f64)> {
    fs::write(folder.path("q.json"), queries.to_string()).unwrap();
    let found = folder.sinew("kernel eval m.sinew q.json --json").json();
    let all = found["results"].as_array().unwrap().iter();
    all.map(|one| (numbers(&one["outputs"]), one["confidence"].as_f64().unwrap())).collect()
}

/// Trains a case and asserts that its samples are reproduced within a share of the values' range,
/// at confidence 1.
#[track_caller]
fn assert_samples(folder: &Folder, case: &str, within: f64) {
    folder.sinew(&format!("kernel train {case} -o m.sinew")).done();
    let problem = folder.json(case);
    let values: Vec<Vec<f64>> = problem["values"].as_array().unwrap().iter().map(numbers).collect();
    let (low, high) = values
        .iter()
        .flatten()
        .fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(*x), high.max(*x)));
    for ((found, confidence), expected) in evaluated(folder, &problem["sites"]).iter().zip(&values)
    {
        assert_eq!(*confidence, 1.0, "{case}");
        for (found, expected) in found.iter().zip(expected) {
            assert!(
                (found - expected).abs() <= within * (high - low),
                "{case}: {found} {expected}"
            );
        }
    }
}

#[test]
fn a_fade_does_not_start_before_the_samples() {
    let files = ["kernel/fade-bug.json", "kernel/fade-bug.queries.json"];
    let Some(folder) = with_cases("case-fade", &files) else { return };
    assert_samples(&folder, "fade-bug.json", 1e-4);
    let found = folder.sinew("kernel eval m.sinew fade-bug.queries.json").done().out;
    assert_eq!(found.lines().count(), 7);
    assert!(found.lines().skip(1).all(|line| line.ends_with(",1")), "{found}");
}

#[test]
fn ordinary_samples_train_at_the_width_that_is_chosen() {
    let cases = ["line", "two", "k-sine50", "k-sine200", "k-200-smooth", "k-centres"];
    let files = cases.map(|case| format!("kernel/{case}.json"));
    let Some(folder) = with_cases("case-widths", &files.each_ref().map(String::as_str)) else {
        return;
    };
    for case in cases {
        assert_samples(&folder, &format!("{case}.json"), 1e-3);
    }
}

#[test]
fn a_line_is_a_line_between_its_samples_too() {
    let files = ["kernel/line.json", "kernel/dial.csv"];
    let Some(folder) = with_cases("case-lines", &files) else { return };
    let dial = String::from_utf8(folder.read("dial.csv")).unwrap();
    let ends =
        dial.lines().skip(1).map(|line| line.split(',').map(|x| x.parse().unwrap()).collect());
    let ends: Vec<Vec<f64>> = ends.collect();
    let (first, last) = (ends[0].clone(), ends[ends.len() - 1].clone());
    let slope = (last[1] - first[1]) / (last[0] - first[0]);
    for (case, step, slope) in [("line.json", 0.5, 1.0), ("dial.csv", 15.0, slope)] {
        for (degree, within) in [("", 1e-3), (" --degree 1", 1e-4)] {
            folder.sinew(&format!("kernel train {case} -o m.sinew{degree}")).done();
            let samples = if case == "line.json" { 4 } else { ends.len() };
            let places: Vec<f64> = (0..2 * samples - 1).map(|i| step * i as f64).collect();
            let range = slope * places[places.len() - 1];
            for ((found, _), x) in evaluated(&folder, &json!(places)).iter().zip(&places) {
                let error = (found[0] - slope * x).abs() / range;
                assert!(error <= within, "{case}{degree}: {error} at {x}");
            }
        }
    }
}

#[test]
fn each_sample_may_have_its_own_smoothing() {
    let Some(folder) = with_cases("case-smoothings", &["kernel/k-smoothlist.json"]) else { return };
    folder.sinew("kernel train k-smoothlist.json -o m.sinew").done();
    // SciPy 1.17: RBFInterpolator(kernel="cubic", smoothing=[0, 0.1, 0]).
    let expected = [0.0, 0.422_619_05, 1.023_809_52, 1.922_619_05, 3.0];
    let found = evaluated(&folder, &json!([0.0, 0.5, 1.0, 1.5, 2.0]));
    for ((found, _), expected) in found.iter().zip(expected) {
        assert!((found[0] - expected).abs() < 1e-4, "{} {expected}", found[0]);
    }
}

/// Returns the largest error of `m.sinew` at the values and averages of observations.
fn missed(folder: &Folder, observations: &Value) -> f64 {
    let all = observations["observations"].as_array().unwrap();
    let number = |of: &Value, key: &str| of[key].as_f64();
    // A value takes one place, an average 400.
    let places = |of: &Value| -> Vec<f64> {
        match (number(of, "value"), number(of, "from"), number(of, "to")) {
            (Some(_), ..) => vec![number(of, "at").unwrap()],
            (_, Some(from), Some(to)) => {
                (0..400).map(|i| from + (to - from) * (f64::from(i) + 0.5) / 400.0).collect()
            }
            _ => Vec::new(),
        }
    };
    let queries: Vec<f64> = all.iter().flat_map(&places).collect();
    fs::write(folder.path("q.json"), json!(queries).to_string()).unwrap();
    let found = folder.sinew("kernel eval m.sinew q.json --json").json();
    let mut found =
        found["results"].as_array().unwrap().iter().map(|one| one["outputs"][0].as_f64().unwrap());
    let mut most = 0.0f64;
    for of in all {
        let len = places(of).len();
        let Some(expected) = number(of, "value").or(number(of, "average")) else { continue };
        let mean = found.by_ref().take(len).sum::<f64>() / len as f64;
        most = most.max((mean - expected).abs());
    }
    most
}

#[test]
fn a_function_whose_file_is_inexact_is_refused_with_the_measured_error() {
    let Some(folder) = with_cases("case-fit-f32", &["signal/s-fit-f32-22.json"]) else { return };
    let said = folder.sinew("signal fit s-fit-f32-22.json -o m.sinew").failed();
    let expected = "s-fit-f32-22.json: in single precision the function is off by ";
    assert!(said.starts_with(expected) && said.ends_with("or allow it by --f32-error"), "{said}");
    assert!(!folder.path("m.sinew").exists());
    // The limit is the measured error; the issue reported 0.088.
    let found = folder.sinew("signal fit s-fit-f32-22.json -o m.sinew --f32-error 1 --json").json();
    let missed = missed(&folder, &folder.json("s-fit-f32-22.json"));
    let range = 2.2752;
    let share = found["f32_error"].as_f64().unwrap();
    assert!(missed > 0.01 && missed <= 1.01 * share * range, "{missed} {share}");
}

#[test]
fn a_covariance_is_chosen_whose_function_can_be_had() {
    let case = "signal/s-fit-default-refused.json";
    let Some(folder) = with_cases("case-fit-default", &[case]) else { return };
    let found = folder.sinew("signal fit s-fit-default-refused.json -o m.sinew --json").json();
    assert!(found["f32_error"].as_f64().unwrap() <= 1e-4, "{found}");
    let missed = missed(&folder, &folder.json("s-fit-default-refused.json"));
    assert!(missed <= 1e-3, "{missed}");
}
