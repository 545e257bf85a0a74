//! `sinew kernel train` on everyday samples: offsets, uneven places, repeated measurements, tables
//! of other programs; and its messages about wrong samples.

use super::common::Folder;
use super::kernel::numbers;
use serde_json::{Value, json};
use std::fs;

/// Writes a problem whose training must fail; returns the message.
#[track_caller]
fn refused(folder: &Folder, problem: &Value, arguments: &str) -> String {
    fs::write(folder.path("p.json"), problem.to_string()).unwrap();
    folder.sinew(&format!("kernel train p.json -o m.sinew {arguments}")).failed()
}

/// Evaluates `m.sinew` at queries, one row of inputs each; returns the first outputs.
fn evaluated(folder: &Folder, queries: &Value) -> Vec<f64> {
    fs::write(folder.path("q.json"), queries.to_string()).unwrap();
    let found = folder.sinew("kernel eval m.sinew q.json --json").json();
    let all = found["results"].as_array().unwrap().iter();
    all.map(|one| one["outputs"][0].as_f64().unwrap()).collect()
}

/// Trains a problem and asserts that its samples are reproduced within a thousandth of the values'
/// range; returns its warnings.
#[track_caller]
fn assert_trains(folder: &Folder, sites: &[f64], values: &[f64], options: Value) -> Vec<Value> {
    let problem = json!({ "sites": sites, "values": values, "options": options });
    fs::write(folder.path("p.json"), problem.to_string()).unwrap();
    let run = folder.sinew("kernel train p.json -o m.sinew --json");
    assert_eq!(run.code, Some(0), "{options}: {}", run.err);
    let said: Value = serde_json::from_str(&run.out).unwrap();
    let least = values.iter().copied().fold(f64::MAX, f64::min);
    let range = values.iter().copied().fold(f64::MIN, f64::max) - least;
    let found = evaluated(folder, &json!(sites));
    for ((x, found), expected) in sites.iter().zip(found).zip(values) {
        assert!((found - expected).abs() <= 1e-3 * range, "{x}: {found} {expected}, {options}");
    }
    said["warnings"].as_array().unwrap().clone()
}

#[test]
fn values_with_a_large_offset_are_refused_with_the_remedy() {
    let folder = Folder::new("kernel-offset-values");
    let sites = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
    let squares = sites.map(|x| x * x);
    for (offset, options) in [
        (1e6, json!({})),
        (1e9, json!({})),
        (-1e12, json!({})),
        (1e9, json!({ "kernel": "linear" })),
        (1e9, json!({ "mode": "scipy" })),
    ] {
        let values = squares.map(|y| offset + y);
        let problem = json!({ "sites": sites, "values": values, "options": options });
        let said = refused(&folder, &problem, "");
        assert!(said.contains("take the offset off the values"), "{offset} {options}: {said}");
        assert!(!folder.path("m.sinew").exists());
    }
    // A constant is not an offset, alone or next to another output.
    assert_trains(&folder, &sites, &squares.map(|y| 100.0 + y), json!({}));
    let both: Vec<[f64; 2]> = squares.iter().map(|y| [1e9, *y]).collect();
    fs::write(folder.path("p.json"), json!({ "sites": sites, "values": both }).to_string())
        .unwrap();
    folder.sinew("kernel train p.json -o m.sinew").done();
    assert_eq!(evaluated(&folder, &json!([0.0, 2.5, 5.0])), [1e9; 3]);
}

#[test]
fn inputs_with_an_offset_are_taken_where_f32_holds_them() {
    let folder = Folder::new("kernel-offset-inputs");
    let values = [0.0, 1.0, 2.0, 0.5];
    for (offset, sites) in [
        (1e5, [0.0, 0.5, 1.0, 1.507_812_5]),
        (1e6, [0.0, 0.5, 1.0, 1.562_5]),
        (1e7, [0.0, 1.0, 2.0, 3.0]),
        (-1e7, [0.0, 1.0, 2.0, 4.0]),
    ] {
        for kernel in ["gaussian", "matern 5/2", "thin plate", "cubic", "linear"] {
            for outside in ["free", "fade"] {
                let options = json!({ "kernel": kernel, "outside": outside });
                assert_trains(&folder, &sites.map(|x| offset + x), &values, options);
            }
        }
    }
    // f32 has no numbers between 1e8 and 1e8 + 8.
    let sites = [0.0, 1.0, 2.0, 3.0].map(|x| [0.0, 1e8 + x]);
    let inputs = json!([{ "name": "a" }, { "name": "b" }]);
    let problem = json!({ "inputs": inputs, "sites": sites, "values": values });
    let said = refused(&folder, &problem, "");
    assert!(said.contains("take the offset off the input \"b\""), "{said}");
}

/// Returns a number between 0 and 1, reproducible.
fn random(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 11) as f64 / (1u64 << 53) as f64
}

#[test]
fn uneven_places_are_fitted_at_the_widest_sound_width() {
    let folder = Folder::new("kernel-uneven");
    for (seed, n) in [(1, 10), (2, 20), (3, 40), (4, 80), (5, 150)] {
        let mut state = seed;
        let sites: Vec<f64> = (0..n).map(|_| random(&mut state)).collect();
        let smooth: Vec<f64> = sites.iter().map(|x| (6.0 * x).sin()).collect();
        assert_trains(&folder, &sites, &smooth, json!({}));
        if n != 40 {
            continue;
        }
        // Values that alternate between rows need a narrower width.
        let values: Vec<f64> = (0..n).map(|row| f64::from(row % 2)).collect();
        let warnings = assert_trains(&folder, &sites, &values, json!({}));
        let said = warnings[0].as_str().unwrap();
        assert!(said.starts_with("single precision holds no width that joins"), "{said}");
        let other = said.split('"').nth(1).unwrap();
        assert!(assert_trains(&folder, &sites, &values, json!({ "kernel": other })).is_empty());
    }
}

#[test]
fn samples_that_are_too_near_are_named_with_a_kernel_that_fits() {
    let folder = Folder::new("kernel-near");
    let (sites, values) = ([0.0, 1.0, 1.0001, 2.0, 3.0], [0.0, 1.0, 0.0, 2.0, 3.0]);
    let problem =
        |kernel: &str| json!({ "sites": sites, "values": values, "options": { "kernel": kernel } });
    let said = refused(&folder, &problem("gaussian"), "");
    let expected = "rows 1 and 2 are only 7.1e-5 of the mean distance apart: take one of them away; the kernel \"";
    let (_, other) = said.split_once(expected).unwrap_or_else(|| panic!("{said}"));
    let other = other.strip_suffix("\" fits").unwrap();
    assert_trains(&folder, &sites, &values, json!({ "kernel": other }));
    let rest = |of: [f64; 5]| [of[0], of[1], of[3], of[4]];
    assert_trains(&folder, &rest(sites), &rest(values), json!({}));
    // Sites over many magnitudes: the first two sites differ, and the message must not call them
    // equal.
    let sites = [1e-6, 2.6e-6, 1.0, 1e3, 1e6];
    let problem = json!({ "sites": sites, "values": values });
    let said = refused(&folder, &problem, "");
    assert!(
        said.contains("rows 0 and 1 have sites that are 4.0e-12 of the mean distance"),
        "{said}"
    );
}

#[test]
fn a_degree_that_is_too_high_is_answered_with_one_that_fits() {
    let folder = Folder::new("kernel-degree");
    let sites: Vec<f64> = (0..30).map(|i| f64::from(i) / 29.0).collect();
    let mut seed = 5;
    let noisy = sites.iter().map(|x| (6.0 * x).sin() + 0.3 * random(&mut seed));
    let values: Vec<f64> = noisy.collect();
    let problem = json!({ "sites": sites, "values": values, "options": { "degree": 99 } });
    let said = refused(&folder, &problem, "");
    let (_, degree) = said.rsplit_once("; degree ").unwrap();
    let degree: i32 = degree.strip_suffix(" fits").unwrap().parse().unwrap();
    assert_trains(&folder, &sites, &values, json!({ "degree": degree }));
}

#[test]
fn kernels_without_a_width_get_no_advice_to_narrow_it() {
    let folder = Folder::new("kernel-no-width");
    let mut seed = 3;
    let sites: Vec<[f64; 2]> = (0..30).map(|_| [(); 2].map(|()| random(&mut seed))).collect();
    let values: Vec<f64> = (0..30).map(|_| random(&mut seed)).collect();
    let of =
        |kernel: &str| json!({ "sites": sites, "values": values, "options": { "kernel": kernel } });
    let said = refused(&folder, &of("quintic"), "");
    assert!(!said.contains("epsilon"), "{said}");
    let (_, other) = said.split_once("take the kernel \"").unwrap_or_else(|| panic!("{said}"));
    let (other, _) = other.split_once("\", which fits, or a rougher kernel").unwrap();
    fs::write(folder.path("p.json"), of(other).to_string()).unwrap();
    folder.sinew("kernel train p.json -o m.sinew").done();
}

#[test]
fn repeated_measurements_are_smoothed_as_scipy_does() {
    let folder = Folder::new("kernel-repeated");
    let of = |options: Value| json!({ "sites": [0, 1, 1, 2], "values": [0, 1, 2, 3], "options": options });
    // SciPy 1.17: RBFInterpolator(kernel="linear", degree=0), with our distances: the mean distance
    // is 1.
    for (smoothing, expected) in [
        (json!(0.1), [0.071_428_57, 0.785_714_29, 1.5, 2.214_285_71, 2.928_571_43]),
        (
            json!([0.1, 0.2, 0.3, 0.0]),
            [0.067_348_68, 0.740_835_46, 1.414_322_25, 2.207_161_13, 3.000_000_00],
        ),
    ] {
        let problem = of(json!({ "kernel": "linear", "smoothing": smoothing }));
        fs::write(folder.path("p.json"), problem.to_string()).unwrap();
        folder.sinew("kernel train p.json -o m.sinew").done();
        let found = evaluated(&folder, &json!([0.0, 0.5, 1.0, 1.5, 2.0]));
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-5, "{found} {expected}");
        }
    }
    fs::write(folder.path("p.json"), of(json!({ "smoothing": "auto" })).to_string()).unwrap();
    folder.sinew("kernel train p.json -o m.sinew").done();
    let twice = json!({ "sites": [0, 0, 1, 1, 2, 2], "values": [0, 1, 1, 2, 2, 3], "options": { "smoothing": 0.1 } });
    fs::write(folder.path("p.json"), twice.to_string()).unwrap();
    folder.sinew("kernel train p.json -o m.sinew").done();
    // Without smoothing, the message names the option that takes the mean.
    let said = refused(&folder, &of(json!({})), "");
    let expected = "rows 1 and 2 have the same site and different values: take their mean (\"average\": true or \
                    --average)";
    assert!(said.contains(expected), "{said}");
    fs::write(folder.path("p.csv"), "x,y\n0,0\n1,1\n1,2\n2,3\n").unwrap();
    let said = folder.sinew("kernel train p.csv -o m.sinew").failed();
    assert!(said.starts_with("p.csv: lines 3 and 4 have the same site"), "{said}");
    let run = folder.sinew("kernel train p.csv -o m.sinew --average");
    assert!(run.err.contains("line 4 is averaged with line 3"), "{}", run.err);
    let found = evaluated(&folder, &json!([1.0]));
    assert!((found[0] - 1.5).abs() < 1e-3, "{found:?}");
}

#[test]
fn tables_of_other_programs_are_read() {
    let folder = Folder::new("kernel-tables");
    for (table, query) in [
        ("x;y\n0;1\n0,5;2\n1;1,5\n", "x;b\n0,5;7\n"),
        ("\u{feff}x;y\r\n0;1\r\n0,5;2\r\n1;1,5\r\n", "x;b\n0.5;7\n"),
        ("x\ty\n0\t1\n0.5\t2\n1\t1.5\n", "b\tx\n7\t0,5\n"),
        ("x,y\n0,1\n\"0,5\",2\n1,\"1,5\"\n", "x\n\"0,5\"\n"),
        ("x,y,\n0,1,\n0.5,2,\n1,1.5,\n,,\n", "x,b,\n0.5,7,\n"),
    ] {
        fs::write(folder.path("t.csv"), table).unwrap();
        fs::write(folder.path("q.csv"), query).unwrap();
        folder.sinew("kernel train t.csv -o m.sinew").done();
        let found = folder.sinew("kernel eval m.sinew q.csv --json").json();
        let found = numbers(&found["results"][0]["outputs"]);
        assert!((found[0] - 2.0).abs() < 1e-3, "{table:?}: {found:?}");
    }
    for (table, expected) in [
        (
            "30,0.25\n60,0.5\n90,0.8\n120,1\n",
            "line 1: expected the names of the columns, found numbers (30, 0.25)",
        ),
        (",x,y\n0,0,1\n1,1,2\n", "line 1: column 1 has no name"),
        ("x,y,z\n0,0,0\n1,0.5\n", "line 3: expected 3 columns, found 2"),
        ("x,y\n0,0\n1,\"1,500\"\n", "line 3, column \"y\": expected a number, found \"1,500\""),
    ] {
        fs::write(folder.path("t.csv"), table).unwrap();
        let said = folder.sinew("kernel train t.csv -o m.sinew").failed();
        assert!(said.starts_with(&format!("t.csv: {expected}")), "{said}");
    }
    let queries = folder.sinew("kernel eval t.csv t.csv").failed();
    assert!(queries.contains("t.csv: holds text, expected a model"), "{queries}");
}

#[test]
fn faults_of_a_problem_are_named_by_their_key() {
    let folder = Folder::new("kernel-keys");
    let of = |options: Value| json!({ "sites": [0, 1, 2, 3], "values": [0, 1, 2, 3], "options": options });
    for (options, expected) in [
        (json!({ "epsilon": "1" }), "options.epsilon: expected a number, found \"1\""),
        (
            json!({ "centres": -1 }),
            "options.centres: expected a whole number that is not negative, found -1",
        ),
        (json!({ "degree": 1.5 }), "options.degree: expected a whole number, found 1.5"),
        (
            json!({ "mode": "Scipy" }),
            "options.mode: expected one of sinew, scipy, published, found \"Scipy\"",
        ),
        (
            json!({ "smoothing": "some" }),
            "options.smoothing: expected a number, a list of numbers (one a sample) or auto, found \"some\"",
        ),
    ] {
        let said = refused(&folder, &of(options), "");
        assert_eq!(said, format!("p.json: {expected}"));
    }
    let said = refused(&folder, &json!([[0], [1]]), "");
    assert_eq!(said, "p.json: expected an object with `sites` and `values`, found a list");
    let named = json!({ "inputs": [{ "name": "a" }, { "name": "a" }], "sites": [[0, 1], [1, 3]], "values": [0, 1] });
    assert_eq!(refused(&folder, &named, ""), "p.json: two inputs are named \"a\"");
    let said = refused(&folder, &of(json!({})), "--outputs z");
    assert!(said.starts_with("p.json: --outputs names columns of a CSV"), "{said}");
    fs::write(folder.path("p.json"), format!("\u{feff}{}", of(json!({})))).unwrap();
    folder.sinew("kernel train p.json -o m.sinew").done();
    let text = folder.sinew("inspect m.sinew").done().out;
    let worst = text.lines().find_map(|line| line.split_once("error of f32, bound")).unwrap().1;
    assert!(worst.starts_with(' ') && worst.trim().parse::<f64>().is_ok(), "{text}");
    // Fewer samples than the default number of learned centres.
    folder.sinew("kernel train p.json -o m.sinew --learn").done();
    fs::write(folder.path("s.json"), r#"{"noise": [1], "observations": []}"#).unwrap();
    let said = folder.sinew("signal fit s.json -o s.sinew").failed();
    assert_eq!(said, "s.json: noise: expected a number, found a list");
}
