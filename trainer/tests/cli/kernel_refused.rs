//! Refusals of `sinew kernel train`, with their places, and its warnings.

use super::common::Folder;
use serde_json::json;
use std::fs;

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
            "options: unknown key \"kernell\"",
        ),
        (r#"{"sites": [1, 2], "values": [1, 2], "options": {"neighbors": 1}}"#, "cannot be baked"),
        (
            r#"{"sites": [[1], 2], "values": [1, 2]}"#,
            "row 1 of sites: expected a list of numbers, found 2",
        ),
        (
            r#"{"sites": [1, "2"], "values": [1, 2]}"#,
            "row 1 of sites: expected a number, as in row 0, found \"2\"",
        ),
        (
            r#"{"sites": [[1], [2]], "values": [[1], [null]]}"#,
            "row 1 of values: expected a list of numbers, found [null]",
        ),
        (
            r#"{"sites": {"x": 1}, "values": [1]}"#,
            "sites: expected rows, as [[0, 1], [2, 3]], or a list of numbers",
        ),
        (
            r#"{"sites": [1, 2], "values": [1, 2], "options": {"learn": true}}"#,
            "expected options of `learn` by name",
        ),
        (
            r#"{"sites": [1, 2], "values": [1, 2], "options": {"groups": [0, 0], "smoothing": "auto"}}"#,
            "no smoothing can be chosen",
        ),
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
    // A gaussian so wide that rounding dominates.
    let sites: Vec<f64> = (0..30).map(|i| f64::from(i) / 30.0).collect();
    let wide = json!({ "sites": sites, "values": sites, "options": { "epsilon": 0.01 } });
    refused(&wide.to_string(), "smooth more, take a narrower kernel or fewer centres");
    let queries = |text: &str| {
        let good = json!({ "sites": [1, 2], "values": [1, 2] });
        fs::write(folder.path("problem.json"), good.to_string()).unwrap();
        folder.sinew("kernel train problem.json -o good.sinew").done();
        fs::write(folder.path("queries.json"), text).unwrap();
        folder.sinew("kernel eval good.sinew queries.json").failed()
    };
    let said = queries(r#"{"queries": [1, [2]]}"#);
    assert_eq!(said, "queries.json: row 1 of queries: expected a number, as in row 0, found [2]");
    let said = queries(r#""none""#);
    assert_eq!(
        said,
        "queries.json: queries: expected rows, as [[0, 1], [2, 3]], or a list of numbers, found \"none\""
    );
    let said = folder.sinew("kernel train problem.json -o model.sinew --smoothing some");
    assert!(
        said.code == Some(2)
            && said.err.contains("expected a number, numbers (one a sample) or auto"),
        "{}",
        said.err
    );
    let said = folder.sinew("kernel train problem.json -o model.sinew --outside away");
    assert!(
        said.code == Some(2) && said.err.contains("possible values: free, clamp, fade"),
        "{}",
        said.err
    );
    fs::write(folder.path("table.csv"), "x,y\n1,2\n3,nan\n").unwrap();
    let said = folder.sinew("kernel train table.csv -o model.sinew").failed();
    assert_eq!(said, "table.csv: line 3, column \"y\": expected a number, found \"nan\"");
}

#[test]
fn merged_samples_and_euler_angles_are_reported() {
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
