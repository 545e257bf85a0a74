//! SciPy's own results, computed by SciPy 1.17.1.

use crate::common::{apart, json, matrix, rows};
use faer::Mat;
use sinew_trainer::scattered::compat::scipy::{RbfInterpolator, ScipyOptions};

/// Of the range of the expected values (METHOD §2.7).
const TOLERANCE: f64 = 1e-9;

#[test]
fn every_case_is_scipys_to_a_billionth_of_its_range() {
    let Some(file) = json("rbf-scipy/rbf_reference.json") else { return };
    let cases = file["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 23);
    for case in cases {
        let options: ScipyOptions = serde_json::from_value(case["options"].clone()).unwrap();
        let [sites, values, queries, expected] =
            ["sites", "values", "queries", "expected"].map(|name| matrix(&case[name]));
        let found = RbfInterpolator::new(&sites, &values, &options).unwrap();
        let found = evaluate(&found, &queries);
        let all = || rows(&expected).concat().into_iter();
        let range = all().fold(f64::MIN, f64::max) - all().fold(f64::MAX, f64::min);
        let share = apart(&found, &expected) / range;
        println!("{}: {share:.1e}", case["name"]);
        assert!(share <= TOLERANCE, "{}: {share:.1e}", case["name"]);
    }
}

/// What a function gives at queries, q x m.
fn evaluate(function: &RbfInterpolator, queries: &Mat<f64>) -> Mat<f64> {
    let all: Vec<Vec<f64>> = rows(queries).iter().map(|x| function.evaluate(x).unwrap()).collect();
    Mat::from_fn(all.len(), all[0].len(), |i, o| all[i][o])
}

#[test]
fn the_posts_table_is_scipys() {
    let Some(file) = json("../reference/seed002_reference.json") else { return };
    let [sites, values, grid] = ["samples", "outputs", "grid_points"].map(|n| matrix(&file[n]));
    let cases = file["scipy_rbfinterpolator"].as_array().unwrap();
    assert_eq!(cases.len(), 16);
    for case in cases {
        let options = ScipyOptions {
            kernel: case["kernel"].as_str().unwrap().into(),
            epsilon: case["epsilon"].as_f64(),
            smoothing: serde_json::from_value(case["smoothing"].clone()).unwrap(),
            ..ScipyOptions::default()
        };
        let found = RbfInterpolator::new(&sites, &values, &options).unwrap();
        let kernels = case["coeffs"].as_array().unwrap()[..5].to_vec();
        let own = &found.whole().unwrap().0.coefficients.subcols(0, 5).transpose().to_owned();
        assert!(apart(own, &matrix(&kernels.into())) < 1e-11, "{options:?}");
        assert!(apart(&evaluate(&found, &sites), &matrix(&case["at_samples"])) < 1e-11);
        assert!(apart(&evaluate(&found, &grid), &matrix(&case["grid"])) < 1e-11, "{options:?}");
    }
    let quintic = ScipyOptions { kernel: "quintic".into(), ..ScipyOptions::default() };
    let refused = RbfInterpolator::new(&sites, &values, &quintic).unwrap_err().to_string();
    assert_eq!(refused, "degree 2 in 2 inputs needs 6 samples, found 5");
}
