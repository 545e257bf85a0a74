//! `sinew signal fit` on observations that are unevenly spaced, far from 0, redundant or out of
//! range.

use super::common::{Folder, Run};
use serde_json::{Value, json};
use std::fs;

fn value(at: f64, value: f64) -> Value {
    json!({ "at": at, "value": value })
}

fn slope(at: f64, slope: f64) -> Value {
    json!({ "at": at, "derivative": slope })
}

fn average(from: f64, to: f64, average: f64) -> Value {
    json!({ "from": from, "to": to, "average": average })
}

/// Observations of a sine at places shifted by `moved`, plus an offset.
fn sine(places: &[f64], moved: f64, offset: f64) -> Vec<Value> {
    places.iter().map(|at| value(moved + at, offset + at.sin())).collect()
}

fn fit(folder: &Folder, problem: &Value) -> Run {
    fs::write(folder.path("o.json"), problem.to_string()).unwrap();
    folder.sinew("signal fit o.json -o o.sinew --json")
}

/// Fits observations with the default covariance. Checks the file at the values, within a
/// thousandth of their range, and checks that the file's reported error is within the limit.
fn check(folder: &Folder, observations: &[Value]) {
    let found = fit(folder, &json!({ "observations": observations })).json();
    assert!(found["f32_error"].as_f64().unwrap() <= 1e-3, "{found}");
    let values = observations.iter().filter(|of| of["value"].is_number());
    let values: Vec<[f64; 2]> =
        values.map(|of| [&of["at"], &of["value"]].map(|x| x.as_f64().unwrap())).collect();
    let places: Vec<f64> = values.iter().map(|[at, _]| *at).collect();
    fs::write(folder.path("q.json"), json!(places).to_string()).unwrap();
    let found = folder.sinew("kernel eval o.sinew q.json --json").json();
    let most = values.iter().fold(f64::NEG_INFINITY, |most, [_, y]| most.max(*y));
    let least = values.iter().fold(f64::INFINITY, |least, [_, y]| least.min(*y));
    for (i, [at, y]) in values.iter().enumerate() {
        let found = found["results"][i]["outputs"][0].as_f64().unwrap();
        assert!((found - y).abs() <= 1e-3 * (most - least), "{at}: {found} {y}");
    }
}

#[test]
fn observations_in_clusters_far_apart_become_a_function() {
    let folder = Folder::new("observations-apart");
    for gap in [1e3, 1e4, 1e5, 1e6] {
        let values = |last: [Value; 3]| {
            let [a, b, c] = last;
            [value(0.0, 1.0), value(1.0, 2.0), a, value(gap, 5.0), b, c]
        };
        check(&folder, &values([value(2.0, 1.0), value(gap + 1.0, 4.0), value(gap + 2.0, 5.0)]));
        check(&folder, &values([slope(2.0, 1.0), slope(gap + 1.0, 0.0), value(gap + 2.0, 5.0)]));
        check(
            &folder,
            &values([
                average(2.0, 3.0, 1.0),
                average(gap + 1.0, gap + 2.0, 4.0),
                value(gap + 3.0, 5.0),
            ]),
        );
    }
    let mut outlier = sine(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0], 0.0, 0.0);
    outlier.extend([slope(3.5, 3.5f64.cos()), value(10000.0, 0.0)]);
    check(&folder, &outlier);
    let clusters = [0.0, 5.0, 10.0].map(|start| [start, start + 0.01, start + 0.02]).concat();
    let both = clusters.iter().flat_map(|at| [value(*at, at.sin()), slope(*at, at.cos())]);
    check(&folder, &both.collect::<Vec<_>>());
}

#[test]
fn steep_observations_are_no_contradictions() {
    let folder = Folder::new("observations-steep");
    let last = value(3.0, 2.0);
    check(&folder, &[value(0.0, 0.0), value(1e-5, 1.0), last.clone(), slope(2.0, 0.0)]);
    check(&folder, &[value(0.0, 0.0), average(0.0, 1e-4, 5.0), last.clone()]);
    check(&folder, &[value(0.0, 0.0), value(1e-3, 1.0), slope(0.0, -5.0), last]);
    let decades: Vec<Value> =
        (-4..6).map(|power| value(10f64.powi(power), f64::from(power))).collect();
    check(&folder, &decades);
    check(&folder, &[decades, vec![slope(1.0, 0.43)]].concat());
}

#[test]
fn units_of_places_do_not_matter() {
    let folder = Folder::new("observations-units");
    for unit in [1e-9, 1e-6, 1e6, 1e9] {
        let mut all: Vec<Value> =
            (0..8).map(|i| value(unit * f64::from(i), f64::from(i).sin())).collect();
        all.push(slope(3.5 * unit, 3.5f64.cos() / unit));
        check(&folder, &all);
    }
}

#[test]
fn an_offset_of_inputs_is_taken_off_where_single_precision_holds_them() {
    let folder = Folder::new("observations-inputs");
    // Multiples of 1/128, 1/16 and 1: f32 numbers at this magnitude; their midpoints are not.
    for (offset, last) in [(1e5, 1.5078125), (1e6, 1.5625)] {
        check(&folder, &sine(&[0.0, 0.5, 1.0, last], offset, 0.0));
        check(&folder, &sine(&[0.0, 0.5, 1.0, last], -offset, 0.0));
    }
    check(&folder, &sine(&[0.0, 1.0, 2.0, 3.0], 1e7, 0.0));
    for problem in [
        sine(&[0.0, 0.37, 0.74, 1.11, 1.48, 1.85, 2.22, 2.59], 1e5, 0.0),
        sine(&[0.0, 0.3, 0.74, 1.11, 1.4, 1.85, 2.22, 2.59], 1e5, 0.0),
        (0..8)
            .map(|i| value(1.7e9 + 3600.0 * f64::from(i), f64::from(i).sin()))
            .collect::<Vec<_>>(),
    ] {
        let said = fit(&folder, &json!({ "observations": problem })).failed();
        let expected = ": take an offset off the inputs, or allow it by --f32-error";
        assert!(
            said.contains("more than 1.0e-3: inputs near 1") && said.ends_with(expected),
            "{said}"
        );
    }
}

#[test]
fn an_offset_of_values_that_single_precision_does_not_hold_is_refused() {
    let folder = Folder::new("observations-values");
    let places = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
    check(&folder, &sine(&places, 0.0, 1e3));
    for offset in [1e5, 1e6, -1e6, 1e8] {
        let said = fit(&folder, &json!({ "observations": sine(&places, 0.0, offset) })).failed();
        let expected = ": take an offset off the values, or allow it by --f32-error";
        assert!(
            said.contains("more than 1.0e-3: values near 1") && said.ends_with(expected),
            "{said}"
        );
    }
    // The range of a constant is its magnitude.
    let constant = [value(0.0, 3.25e6), value(1.0, 3.25e6), value(2.0, 3.25e6)];
    assert_eq!(fit(&folder, &json!({ "observations": constant })).code, Some(0));
    // A filter contains no values, but it is applied to signals in f32.
    let rows = (0..60).map(|i| format!("{}\n", 1e8 + f64::from(i).sin())).collect::<String>();
    fs::write(folder.path("s.csv"), format!("a\n{rows}")).unwrap();
    let run = folder.sinew("signal train s.csv --column a --factor 2 -o s.sinew");
    let expected = "sinew: warning: s.csv: in single precision values near 100000000 are rounded by 6.0e0: take an \
                    offset off the values\n";
    assert_eq!((run.code, run.err.as_str()), (Some(0), expected));
    let run = folder.sinew("signal superres s.csv --column a --model s.sinew -o fine.csv");
    assert_eq!((run.code, run.err.as_str()), (Some(0), expected));
}

#[test]
fn numbers_out_of_range_are_refused_by_name() {
    let folder = Folder::new("observations-range");
    let two = json!([value(0.0, 1.0), value(1.0, 2.0)]);
    let said = |key: &str, number: f64| {
        let mut problem = json!({ "observations": two });
        problem[key] = json!(number);
        fit(&folder, &problem).failed()
    };
    for (key, what) in [("variance", "variance"), ("f32_error", "f32 error")] {
        for number in [-1.0, 0.0] {
            let expected =
                format!("o.json: {what}: expected a finite number above 0, found {number}");
            assert_eq!(said(key, number), expected);
        }
    }
    assert_eq!(said("noise", -1.0), "o.json: noise: expected a finite number above 0, found -1");
    let refused =
        |observations: Value| fit(&folder, &json!({ "observations": observations })).failed();
    let expected = "o.json: observation 1: expected numbers from -3.4e38 to 3.4e38, as single precision holds them";
    assert_eq!(refused(json!([value(0.0, 1.0), value(1e39, 2.0)])), expected);
    assert_eq!(refused(json!([value(0.0, 1.0), value(1.0, -1e300)])), expected);
    assert_eq!(refused(json!([value(0.0, 1.0), average(0.0, 1e39, 1.0)])), expected);
    let small = refused(json!([value(0.0, 1e-300), value(1.0, -1e-300)]));
    assert!(
        small.contains(": give inputs and values in units in which they are near 1, or"),
        "{small}"
    );
    for (length, expected) in [
        (
            "1e-300",
            "o.json: length: expected a number from 1e-37 to 1e37, as single precision holds it, found 1e-300",
        ),
        (
            "1e-6",
            "o.json: no part kernel holds averages that take 12000000 centres: it can hold 1,000,000: take a longer length",
        ),
    ] {
        let covariance = format!("squared exponential:{length}");
        let all = [value(0.0, 1.0), average(0.0, 2.0, 1.0)];
        let said = fit(&folder, &json!({ "covariance": covariance, "observations": all })).failed();
        assert!(said.starts_with(expected), "{said}");
    }
    // The filter command gives the same message.
    let train = |rows: &str, arguments: &str| {
        fs::write(folder.path("s.csv"), format!("a\n{rows}")).unwrap();
        folder
            .sinew(&format!("signal train s.csv --column a --factor 2 -o s.sinew {arguments}"))
            .failed()
    };
    let expected = "s.csv: give inputs and values in units in which they are near 1";
    assert_eq!(train(&"1e300\n-1e300\n".repeat(20), ""), expected);
    let expected =
        "s.csv: weights, taps x taps x factor: expected at most 67,108,864, found 19999600002";
    assert_eq!(train(&"1\n2\n".repeat(20), "--taps 99999"), expected);
}

#[test]
fn averages_that_follow_from_others_are_left_out() {
    let folder = Folder::new("observations-averages");
    for (order, left_out) in [([0, 1, 2], 1), ([2, 0, 1], 1), ([1, 2, 0], 1)] {
        let all = [average(0.0, 1.0, 1.0), average(1.0, 2.0, 3.0), average(0.0, 2.0, 2.0)];
        let problem = json!({ "observations": order.map(|at| all[at].clone()) });
        let run = fit(&folder, &problem);
        let expected = format!(
            "sinew: warning: o.json: observations that repeat earlier ones, or follow from them, and are left out: \
             {left_out}\n"
        );
        assert_eq!((run.code, run.err.as_str()), (Some(0), expected.as_str()));
    }
    // Contradictory observations are listed, and both remedies work.
    let all = [average(0.0, 1.0, 1.0), average(1.0, 2.0, 3.0), average(0.0, 2.0, 5.0)];
    let said = fit(&folder, &json!({ "observations": all })).failed();
    let expected = "o.json: observation 2 contradicts observations 0, 1: they give 2 and it says 5; leave one out, or \
                    give a noise";
    assert_eq!(said, expected);
    fit(&folder, &json!({ "observations": all, "noise": 0.1 })).done();
    fit(&folder, &json!({ "observations": all[..2] })).done();
}

#[test]
fn ill_conditioned_or_inexact_fits_name_their_remedies() {
    let folder = Folder::new("observations-remedies");
    let mut problem =
        json!({ "observations": sine(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0], 0.0, 0.0) });
    problem["covariance"] = json!("matern 5/2:100");
    let said = fit(&folder, &problem).failed();
    let remedy =
        ": take a shorter length, a rougher covariance or a noise, or leave `covariance` out";
    assert!(said.contains("ill-conditioned") && said.ends_with(remedy), "{said}");
    let change = |key: &str, to: Value| {
        let mut other = problem.clone();
        other[key] = to;
        fit(&folder, &other).done();
    };
    change("covariance", json!("matern 5/2:2"));
    change("covariance", json!("ornstein-uhlenbeck:100"));
    change("covariance", json!("auto"));
    change("noise", json!(0.01));
    // Slopes need a smooth covariance, and a function of observations cannot have fewer centres.
    let all =
        [value(0.0, 1.0), value(1.0, 2.0), slope(2.0, 1.0), value(1000.0, 5.0), slope(1001.0, 4.0)];
    let all = [all.to_vec(), vec![value(1002.0, 5.0)]].concat();
    let said = fit(&folder, &json!({ "observations": all, "covariance": "squared exponential:2" }))
        .failed();
    let remedy =
        ": take a shorter length or a noise, or leave `covariance` out, or allow it by --f32-error";
    assert!(said.contains("in single precision") && said.ends_with(remedy), "{said}");
}
