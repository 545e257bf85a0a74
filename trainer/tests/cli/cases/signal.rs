//! Cases of the folder `signal`.

use super::with_cases;
use crate::common::Folder;
use serde_json::{Value, json};
use std::fs;

/// Measures by how much `m.sinew` misses the values and averages of observations at most.
fn missed(folder: &Folder, observations: &Value) -> f64 {
    let all = observations["observations"].as_array().unwrap();
    let number = |of: &Value, key: &str| of[key].as_f64();
    // A value is one place, an average 400.
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
fn a_function_whose_file_misses_it_is_refused_with_what_was_measured() {
    let Some(folder) = with_cases("case-fit-f32", &["signal/s-fit-f32-22.json"]) else { return };
    let said = folder.sinew("signal fit s-fit-f32-22.json -o m.sinew").failed();
    let expected = "s-fit-f32-22.json: in single precision the function is off by ";
    assert!(said.starts_with(expected) && said.ends_with("or allow it by --f32-error"), "{said}");
    assert!(!folder.path("m.sinew").exists());
    // What is allowed is what is measured; the issue found 0.088.
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
