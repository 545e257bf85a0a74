//! `sinew kernel`: from samples to functions in a file, and back.

use super::common::Folder;
use super::shared::shared;
use serde_json::{Value, json};
use std::f64::consts::FRAC_1_SQRT_2;
use std::fs;

/// Writes a problem and trains it.
fn trained(test: &str, problem: &Value, arguments: &str) -> Folder {
    let folder = Folder::new(test);
    fs::write(folder.path("problem.json"), problem.to_string()).unwrap();
    folder.sinew(&format!("kernel train problem.json -o model.sinew {arguments}")).done();
    folder
}

/// Evaluates queries, and returns outputs and confidences.
fn evaluated(folder: &Folder, queries: &Value, arguments: &str) -> Vec<Value> {
    fs::write(folder.path("queries.json"), queries.to_string()).unwrap();
    let found = folder.sinew(&format!("kernel eval model.sinew queries.json --json {arguments}"));
    found.json()["results"].as_array().unwrap().clone()
}

fn numbers(of: &Value) -> Vec<f64> {
    of.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

#[track_caller]
fn near(found: &Value, expected: &[f64], within: f64) {
    let found = numbers(found);
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() <= within, "{found} instead of {expected}");
    }
}

#[test]
fn a_linear_kernel_of_one_number_joins_its_samples_by_lines() {
    let problem = json!({ "sites": [0.0, 1.0, 3.0], "values": [2.0, 4.0, 0.0], "options": { "kernel": "linear" } });
    let folder = trained("kernel-lines", &problem, "");
    let found = evaluated(&folder, &json!([0.0, 0.5, 1.0, 2.5, 3.0]), "");
    for (found, expected) in found.iter().zip([2.0, 3.0, 4.0, 1.0, 0.0]) {
        near(&found["outputs"], &[expected], 1e-5);
    }
}

#[test]
fn five_poses_of_a_wrist_become_weights_that_sum_to_one() {
    let weight = |name| json!({ "name": name, "clamp": [0, 1], "normalise": true });
    let outputs = ["rest", "up", "down", "in", "out"].map(weight);
    let problem = json!({
        "inputs": [{ "name": "wrist", "kind": "euler XYZ" }],
        "outputs": outputs,
        "sites": [[0, 0, 0], [0, 0, 60], [0, 0, -60], [0, 40, 0], [0, -40, 0]],
        "options": { "weights": true, "kernel": "matern 5/2", "epsilon": 0.5 },
    });
    let folder = trained("kernel-weights", &problem, "");
    let half = 30f64.to_radians();
    let turned = |half: f64| json!([0.0, 0.0, half.sin(), half.cos()]);
    let found = evaluated(&folder, &json!([[0, 0, 0], [0, 0, 60], [0, 0, 30], [12, 7, -25]]), "");
    near(&found[0]["outputs"], &[1.0, 0.0, 0.0, 0.0, 0.0], 1e-5);
    near(&found[1]["outputs"], &[0.0, 1.0, 0.0, 0.0, 0.0], 1e-5);
    for found in &found {
        let sum: f64 = numbers(&found["outputs"]).iter().sum();
        assert!((sum - 1.0).abs() < 1e-5, "{sum}");
    }
    let halfway = numbers(&found[2]["outputs"]);
    assert!(halfway[..2].iter().all(|weight| (0.35..0.65).contains(weight)), "{halfway:?}");
    let about = &folder.sinew("inspect model.sinew --json").json()["kernels"][0];
    assert_eq!(about["inputs"][0]["name"], "wrist");
    assert_eq!(about["inputs"][0]["kind"], "rotation");
    assert_eq!(
        about["outputs"][4],
        json!({ "name": "out", "kind": "scalar", "range": [0.0, 1.0], "normalised": true })
    );
    let text = folder.sinew("inspect model.sinew").done().out;
    assert!(
        text.contains("output out") && text.contains("scalar from 0 to 1, a share of a sum"),
        "{text}"
    );
    // As a quaternion the same rotation is the same pose.
    let quaternions = json!({
        "inputs": [{ "name": "wrist", "kind": "quaternion" }],
        "sites": [[0, 0, 0, 1], turned(half), turned(-half)],
        "options": { "weights": true },
    });
    let folder = trained("kernel-quaternions", &quaternions, "");
    let half = 30f64.to_radians();
    let opposite = json!([
        [0.0, 0.0, half.sin(), half.cos()],
        [0.0, 0.0, -2.0 * half.sin(), -2.0 * half.cos()]
    ]);
    let found = evaluated(&folder, &opposite, "");
    near(&found[0]["outputs"], &[0.0, 1.0, 0.0], 1e-5);
    near(&found[1]["outputs"], &[0.0, 1.0, 0.0], 1e-5);
}

#[test]
fn rotations_come_out_as_rotations() {
    let quarter = [0.0, 0.0, FRAC_1_SQRT_2, FRAC_1_SQRT_2];
    let problem = json!({
        "inputs": [{ "name": "t" }],
        "outputs": [{ "name": "turn", "kind": "quaternion" }],
        "sites": [0.0, 1.0],
        "values": [[0.0, 0.0, 0.0, 1.0], quarter],
        "options": { "kernel": "linear" },
    });
    let folder = trained("kernel-rotations", &problem, "");
    let found = evaluated(&folder, &json!([0.0, 1.0, 0.5]), "");
    near(&found[0]["outputs"], &[0.0, 0.0, 0.0, 1.0], 1e-5);
    near(&found[1]["outputs"], &quarter, 1e-5);
    // Between the two it turns about the same axis, by the angle that has half of 4 tan(angle / 4).
    let half = 2.0 * (0.5 * 22.5f64.to_radians().tan()).atan();
    near(&found[2]["outputs"], &[0.0, 0.0, half.sin(), half.cos()], 1e-5);
    let length: f64 = numbers(&found[2]["outputs"]).iter().map(|x| x * x).sum();
    assert!((length - 1.0).abs() < 1e-5);
}

#[test]
fn far_from_the_samples_a_function_fades_stays_or_goes_on() {
    let problem = json!({ "sites": [[0, 0], [1, 0], [0, 1], [1, 1]], "values": [5, 6, 7, 9] });
    let far = json!([[40, 40], [0.5, 0.5]]);
    let of = |test: &str, rule: &str| {
        let folder = trained(test, &problem, &format!("--kernel thin-plate --outside {rule}"));
        evaluated(&folder, &far, "")
    };
    let fade = of("kernel-fade", "fade");
    near(&fade[0]["outputs"], &[5.0], 1e-6);
    assert_eq!((&fade[0]["confidence"], &fade[1]["confidence"]), (&json!(0.0), &json!(1.0)));
    near(&of("kernel-clamp", "clamp")[0]["outputs"], &[9.0], 1e-4);
    assert!(numbers(&of("kernel-free", "free")[0]["outputs"])[0] > 50.0);
}

#[test]
fn tables_and_arrays_are_problems_too() {
    let folder = Folder::new("kernel-csv");
    let table = "a,b,c.x,c.y,c.z\n0,0,1,2,3\n1,0,2,3,4\n0,1,3,4,5\n1,1,4,5,7\n";
    fs::write(folder.path("table.csv"), table).unwrap();
    folder.sinew("kernel train table.csv -o model.sinew --kernel cubic").done();
    fs::write(folder.path("queries.csv"), "b,other,a\n1,9,0\n").unwrap();
    let found = folder.sinew("kernel eval model.sinew queries.csv").done().out;
    let mut lines = found.lines();
    assert_eq!(lines.next(), Some("c.x,c.y,c.z,confidence"));
    let row: Vec<f64> = lines.next().unwrap().split(',').map(|x| x.parse().unwrap()).collect();
    assert!(row.iter().zip([3.0, 4.0, 5.0, 1.0]).all(|(a, b)| (a - b).abs() < 1e-4), "{row:?}");
    let chosen =
        folder.sinew("kernel train table.csv -o model.sinew --outputs a,b --kernel linear");
    chosen.done();
    let found = evaluated(&folder, &json!([[2, 3, 4]]), "");
    near(&found[0]["outputs"], &[1.0, 0.0], 1e-4);
}

#[test]
fn variance_is_nothing_at_samples_and_derivatives_are_differences() {
    let sites: Vec<[f64; 2]> =
        (0..12).map(|i| [(f64::from(i) * 0.37).sin(), (f64::from(i) * 0.61).cos()]).collect();
    let values: Vec<f64> = sites.iter().map(|[x, y]| x * y + x).collect();
    let problem = json!({ "sites": sites, "values": values, "options": { "epsilon": 1.0 } });
    let folder = trained("kernel-variance", &problem, "--kernel matern-5/2 --variance");
    let queries = json!([sites[3], [0.3, 0.2], [0.301, 0.2], [0.3, 0.201], [3.0, 3.0]]);
    let found = evaluated(&folder, &queries, "--variance --jacobian");
    let variance = |at: usize| numbers(&found[at]["variance"])[0];
    assert!(variance(0) < 1e-3 * variance(1) && variance(1) < variance(4));
    let value = |at: usize| numbers(&found[at]["outputs"])[0];
    let slopes = numbers(&found[1]["jacobian"][0]);
    for (slope, at) in slopes.iter().zip([2, 3]) {
        assert!((slope - (value(at) - value(1)) / 1e-3).abs() < 5e-3, "{slopes:?}");
    }
    let folder = trained("kernel-no-variance", &problem, "");
    fs::write(folder.path("q.json"), "[[0, 0]]").unwrap();
    let said = folder.sinew("kernel eval model.sinew q.json --variance").failed();
    assert!(said.contains("train it with --variance"), "{said}");
}

#[test]
fn scipys_cases_are_held_and_a_false_one_is_found() {
    let Some(file) = shared("rbf-scipy/rbf_reference.json") else { return };
    let folder = Folder::new("kernel-check");
    let mut cases: Value = serde_json::from_slice(&fs::read(file).unwrap()).unwrap();
    fs::write(folder.path("cases.json"), cases.to_string()).unwrap();
    let found = folder.sinew("kernel check cases.json --json").json();
    assert_eq!((&found["failed"], &found["skipped"]), (&json!(0), &json!(0)));
    assert_eq!(found["cases"].as_array().unwrap().len(), 23);
    let value = cases["cases"][0]["expected"][0].as_f64().unwrap();
    cases["cases"][0]["expected"][0] = json!(value + 1e-7);
    cases["cases"][1]["options"]["kernel"] = json!("none");
    fs::write(folder.path("cases.json"), cases.to_string()).unwrap();
    let run = folder.sinew("kernel check cases.json");
    assert_eq!(run.code, Some(1));
    assert!(run.out.contains("<- too far") && run.out.contains("skipped: \"none\" is no kernel"));
    assert!(run.err.contains("cases.json: 1 of"), "{}", run.err);
}

#[test]
fn functions_of_one_or_two_numbers_are_drawn() {
    let problem =
        json!({ "sites": [[0, 0], [1, 0], [0, 1], [1, 1], [0.4, 0.6]], "values": [1, 2, 3, 0, 1] });
    let folder = trained("kernel-plot", &problem, "");
    folder.sinew("kernel plot model.sinew -o one.png").done();
    assert_eq!(&folder.read("one.png")[..4], b"\x89PNG");
    folder.sinew("kernel plot model.sinew --all -o all.SVG").done();
    let svg = String::from_utf8(folder.read("all.SVG")).unwrap();
    for name in ["thin plate", "multiquadric", "gaussian", "Wendland"] {
        assert!(svg.contains(&format!(">{name}</text>")), "{name}");
    }
    let said = folder.sinew("kernel plot model.sinew -o all.gif").failed();
    assert!(said.ends_with("expected a file that ends in .png or .svg"), "{said}");
}

#[test]
fn bad_problems_are_refused_by_place_and_nothing_is_written() {
    let folder = Folder::new("kernel-refused");
    let refused = |problem: &str, expected: &str| {
        fs::write(folder.path("problem.json"), problem).unwrap();
        let before = folder.list();
        let said = folder.sinew("kernel train problem.json -o model.sinew").failed();
        assert!(said.starts_with("problem.json: ") && said.contains(expected), "{said}");
        assert_eq!(folder.list(), before);
    };
    for (problem, expected) in [
        (r#"{"sites": [], "values": []}"#, "there are no samples"),
        (
            r#"{"sites": [1, 2], "values": [1]}"#,
            "expected a row of values for each of 2 sites, found 1",
        ),
        (
            r#"{"sites": [[1, 2], [3]], "values": [1, 2]}"#,
            "row 1 of sites: expected 2 numbers, found 1",
        ),
        (
            r#"{"sites": [1, 1, 2], "values": [1, 5, 2]}"#,
            "rows 0 and 1 have the same site and different values",
        ),
        (
            r#"{"sites": [1, 2], "values": [1, 2], "options": {"kernel": "bell"}}"#,
            "\"bell\" is no kernel",
        ),
        (
            r#"{"sites": [1, 2], "values": [1, 2], "options": {"kernell": "linear"}}"#,
            "unknown field `kernell`",
        ),
        (r#"{"sites": [1, 2], "values": [1, 2], "options": {"neighbors": 1}}"#, "cannot be baked"),
        (r#"{"sites": [1, 2], "values": [1, 2], "options": {"epsilon": 0}}"#, "epsilon is 0"),
        (
            r#"{"inputs": [{"name": "q", "kind": "quaternion"}], "sites": [[0, 0, 0, 1], [0, 0, 0, 0]], "values": [1, 2]}"#,
            "row 1 of sites: input \"q\": the quaternion is zero",
        ),
        (
            r#"{"inputs": [{"name": "q", "kind": "twist"}], "sites": [[0, 0, 0, 1]], "values": [1]}"#,
            "its axis is missing",
        ),
        (
            r#"{"inputs": [{"name": "q", "kind": "euler XXZ"}], "sites": [[0, 0, 0]], "values": [1]}"#,
            "found \"euler XXZ\"",
        ),
        (
            r#"{"outputs": [{"name": "y", "clamp": [1, 0]}], "sites": [0], "values": [1]}"#,
            "output \"y\": its bounds are the wrong way round",
        ),
    ] {
        refused(problem, expected);
    }
    // A gaussian so wide that rounding decides.
    let sites: Vec<f64> = (0..30).map(|i| f64::from(i) / 30.0).collect();
    let wide = json!({ "sites": sites, "values": sites, "options": { "epsilon": 0.01 } });
    refused(&wide.to_string(), "smooth more, take a narrower kernel or fewer centres");
    fs::write(folder.path("table.csv"), "x,y\n1,2\n3,nan\n").unwrap();
    let said = folder.sinew("kernel train table.csv -o model.sinew").failed();
    assert_eq!(said, "table.csv: line 3: column \"y\": expected a number, found \"nan\"");
}

#[test]
fn what_a_fit_merged_or_took_otherwise_is_told() {
    let folder = Folder::new("kernel-warned");
    let problem = json!({
        "inputs": [{ "name": "a", "kind": "euler XYZ" }, { "name": "b", "kind": "euler ZYX" }],
        "sites": [[0, 0, 0, 0, 0, 0], [30, 0, 0, 0, 0, 20], [30, 0, 0, 0, 0, 20], [0, 50, 0, 10, 0, 0]],
        "values": [0, 1, 1, 2],
    });
    fs::write(folder.path("problem.json"), problem.to_string()).unwrap();
    let run = folder.sinew("kernel train problem.json -o model.sinew");
    assert_eq!(run.code, Some(0));
    assert!(run.err.contains("row 2 is the same sample as row 1"), "{}", run.err);
    assert!(run.err.contains("2 inputs are Euler angles (a, b): they are taken as rotations"));
}

#[test]
fn learned_centres_leave_out_what_does_not_matter() {
    let sites: Vec<[f64; 2]> = (0..60)
        .map(|i| [(f64::from(i) * 0.754_877_666).fract(), (f64::from(i) * 0.569_840_291).fract()])
        .collect();
    let values: Vec<f64> = sites.iter().map(|[x, _]| (6.0 * x).sin()).collect();
    let problem = json!({
        "sites": sites, "values": values,
        "options": { "learn": { "centres": 6, "seeds": 2, "evaluations": 400 } },
    });
    let folder = Folder::new("kernel-learned");
    fs::write(folder.path("problem.json"), problem.to_string()).unwrap();
    let found = folder.sinew("kernel train problem.json -o model.sinew --json").json();
    let learned = &found["report"]["learned"];
    assert!(learned["residual_rms"].as_f64().unwrap() < 1e-3, "{learned}");
    let weights = numbers(&learned["relevance"]);
    assert!(weights[1].abs() < 0.05 * weights[0].abs(), "{weights:?}");
}
