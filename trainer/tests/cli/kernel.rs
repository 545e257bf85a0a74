//! `sinew kernel`: from samples to functions in a file, and evaluation.

use super::common::Folder;
use models::shared;
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

/// Evaluates queries; returns outputs and confidences.
fn evaluated(folder: &Folder, queries: &Value, arguments: &str) -> Vec<Value> {
    fs::write(folder.path("queries.json"), queries.to_string()).unwrap();
    let found = folder.sinew(&format!("kernel eval model.sinew queries.json --json {arguments}"));
    found.json()["results"].as_array().unwrap().clone()
}

/// Reads a list of numbers.
pub(crate) fn numbers(of: &Value) -> Vec<f64> {
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
    let row = text.lines().find(|line| line.trim_start().starts_with("out ")).unwrap();
    let cells: Vec<&str> = row.split_whitespace().collect();
    assert_eq!(cells, ["out", "scalar", "0", "to", "1", "yes"], "{text}");
    // As quaternions, both signs of a rotation are the same pose.
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
    // Between the two samples, the output rotates about the same axis, by the angle that halves 4
    // tan(angle / 4).
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

/// Returns a number between -1 and 1, reproducible.
fn random(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

#[test]
fn at_every_sample_the_confidence_is_one_and_the_output_the_samples() {
    let mut seed = 11;
    for (joints, inputs) in [(1, 3), (2, 6), (0, 3), (0, 6)] {
        for (kernel, rule) in [
            ("gaussian", "fade"),
            ("matern 5/2", "fade"),
            ("thin plate", "fade"),
            ("gaussian", "free"),
            ("matern 5/2", "clamp"),
        ] {
            let n = 6 + (20.0 * random(&mut seed).abs()) as usize;
            let most = if joints > 0 { 60.0 } else { 1.0 };
            let mut row = |len: usize, most: f64| -> Vec<f64> {
                (0..len).map(|_| most * random(&mut seed)).collect()
            };
            let sites: Vec<Vec<f64>> = (0..n).map(|_| row(inputs, most)).collect();
            let values: Vec<Vec<f64>> = (0..n).map(|_| row(2, 5.0)).collect();
            let named = |kind: &'static str| {
                let len = if joints > 0 { joints } else { inputs };
                (0..len)
                    .map(|i| json!({ "name": format!("x{i}"), "kind": kind }))
                    .collect::<Vec<_>>()
            };
            let inputs = named(if joints > 0 { "euler XYZ" } else { "scalar" });
            let problem = json!({
                "inputs": inputs, "sites": sites, "values": values,
                "options": { "kernel": kernel, "outside": rule },
            });
            let about = format!("{joints} {kernel} {rule}");
            let folder = Folder::new("kernel-confidence");
            fs::write(folder.path("problem.json"), problem.to_string()).unwrap();
            let run = folder.sinew("kernel train problem.json -o model.sinew");
            assert_eq!(run.code, Some(0), "{about}: {}", run.err);
            for (found, expected) in evaluated(&folder, &json!(sites), "").iter().zip(&values) {
                assert_eq!(found["confidence"], json!(1.0), "{about}");
                near(&found["outputs"], expected, 1e-2);
            }
        }
    }
}

#[test]
fn few_samples_and_few_centres_have_a_fade_too() {
    let of = |test: &str, problem: &Value, queries: Value| {
        let folder = Folder::new(test);
        fs::write(folder.path("problem.json"), problem.to_string()).unwrap();
        let run = folder.sinew("kernel train problem.json -o model.sinew");
        assert_eq!(run.code, Some(0), "{}", run.err);
        evaluated(&folder, &queries, "")
    };
    // One sample gives a constant, for every query.
    let one = json!({ "sites": [3.0], "values": [7.0], "options": { "outside": "fade" } });
    for found in of("kernel-fade-one", &one, json!([3.0, -50.0])) {
        near(&found["outputs"], &[7.0], 1e-6);
        assert_eq!(found["confidence"], json!(1.0));
    }
    // Learned centres and fewer centres are not samples.
    let sites: Vec<f64> = (0..30).map(f64::from).collect();
    let values: Vec<f64> = sites.iter().map(|x| (0.3 * x).sin()).collect();
    for (test, options) in [
        ("kernel-fade-fewer", json!({ "outside": "fade", "centres": 4 })),
        (
            "kernel-fade-learned",
            json!({ "outside": "fade", "learn": { "centres": 5, "seeds": 1 } }),
        ),
    ] {
        let problem = json!({ "sites": sites, "values": values, "options": options });
        for found in of(test, &problem, json!(sites)) {
            assert_eq!(found["confidence"], json!(1.0), "{test}");
        }
        assert_eq!(of(test, &problem, json!([1e4]))[0]["confidence"], json!(0.0), "{test}");
    }
    // Without centres, there is no distance from the data.
    let none = |rule: &str| json!({ "sites": [0, 1, 2], "values": [1, 2, 4], "options": { "centres": 0, "outside": rule } });
    assert_eq!(of("kernel-no-centres", &none("clamp"), json!([1.0]))[0]["confidence"], json!(1.0));
    let folder = Folder::new("kernel-no-fade");
    fs::write(folder.path("problem.json"), none("fade").to_string()).unwrap();
    let said = folder.sinew("kernel train problem.json -o model.sinew").failed();
    assert!(said.contains("without a centre nothing fades"), "{said}");
}

#[test]
fn inexact_files_are_refused_unless_permitted() {
    let folder = Folder::new("kernel-f32");
    // Random values at pairs of near samples: coefficients are large and cancel.
    let mut seed = 3;
    let sites: Vec<f64> = (0..24).map(|i| f64::from(i / 2) + 1e-3 * f64::from(i % 2)).collect();
    let values: Vec<f64> = (0..24).map(|_| random(&mut seed)).collect();
    let write = |options: Value| {
        let problem = json!({ "sites": sites, "values": values, "options": options });
        fs::write(folder.path("problem.json"), problem.to_string()).unwrap();
    };
    for options in [
        json!({ "epsilon": 8.0 }),
        json!({ "mode": "scipy", "kernel": "gaussian", "epsilon": 2.0 }),
        json!({ "mode": "published", "kernel": "gaussian" }),
    ] {
        write(options.clone());
        let run = folder.sinew("kernel train problem.json -o model.sinew");
        assert_eq!(run.code, Some(1), "{options}");
        let expected = "problem.json: in single precision the function is off by ";
        assert!(run.err.contains(expected) && run.err.ends_with("--f32-error\n"), "{}", run.err);
        assert!(!folder.path("model.sinew").exists());
    }
    write(json!({ "epsilon": 8.0 }));
    let run = folder.sinew("kernel train problem.json -o model.sinew --f32-error 100 --json");
    let allowed = run.json()["f32_error"].as_f64().unwrap();
    assert!(allowed > 1e-3, "{allowed}");
    let found = evaluated(&folder, &json!(sites), "");
    let range = 2.0;
    for (found, expected) in found.iter().zip(&values) {
        near(&found["outputs"], &[*expected], range * allowed);
    }
    write(json!({ "epsilon": 8.0, "f32_error": 100.0 }));
    folder.sinew("kernel train problem.json -o model.sinew").done();
    let said = folder.sinew("kernel train problem.json -o model.sinew --f32-error 0").failed();
    assert!(said.contains("the f32 error is 0, expected a finite number above 0"), "{said}");
}

#[test]
fn a_smoothing_for_each_sample_is_scipys() {
    let sites = json!([0.0, 1.0, 2.5, 4.0, 5.0, 7.0]);
    let values = json!([0.0, 1.0, 3.0, 2.0, 2.5, -1.0]);
    let smoothing = json!([0.0, 0.1, 0.0, 0.02, 0.5, 0.0]);
    let queries = json!([0.0, 0.6, 1.0, 2.5, 4.0, 4.4, 5.0, 6.1, 7.0]);
    // SciPy 1.17: RBFInterpolator of the sites, divided by their mean distance 97/30, or unscaled.
    for (options, expected) in [
        (
            json!({ "kernel": "gaussian", "epsilon": 1.2, "degree": 0, "smoothing": smoothing }),
            [
                0.0,
                0.728_266_8,
                1.327_405_21,
                3.0,
                2.105_652_46,
                1.584_963_71,
                0.785_359_21,
                -0.430_584_22,
                -1.0,
            ],
        ),
        (
            json!({ "kernel": "thin plate", "smoothing": smoothing }),
            [
                0.0,
                0.636_247_68,
                1.143_536_7,
                3.0,
                2.054_161_67,
                1.835_118_04,
                1.478_772_72,
                0.161_289_89,
                -1.0,
            ],
        ),
        (
            json!({ "mode": "scipy", "smoothing": smoothing }),
            [
                0.0,
                0.548_724_82,
                1.021_075_2,
                3.0,
                2.011_982_97,
                2.109_174_57,
                2.225_498_17,
                0.656_551_64,
                -1.0,
            ],
        ),
    ] {
        let problem = json!({ "sites": sites, "values": values, "options": options });
        let folder = trained("kernel-smoothings", &problem, "");
        for (found, expected) in evaluated(&folder, &queries, "").iter().zip(expected) {
            near(&found["outputs"], &[expected], 1e-5);
        }
    }
    let folder = Folder::new("kernel-smoothing-lists");
    let refused = |smoothing: Value, more: Value, arguments: &str| {
        let mut options = more;
        options["smoothing"] = smoothing;
        let problem = json!({ "sites": sites, "values": values, "options": options });
        fs::write(folder.path("problem.json"), problem.to_string()).unwrap();
        folder.sinew(&format!("kernel train problem.json -o model.sinew {arguments}")).failed()
    };
    let none = || json!({});
    let short = refused(json!([0.0, 0.1]), none(), "");
    assert_eq!(short, "problem.json: expected a smoothing for each of 6 samples, found 2");
    let below = refused(json!([0, 0, -1, 0, 0, 0]), none(), "");
    assert!(below.contains("the smoothing of row 2 is -1, expected"), "{below}");
    let words = refused(json!("some"), none(), "");
    assert!(
        words.contains("smoothing: expected a number, a list of numbers (one a sample) or auto"),
        "{words}"
    );
    assert!(!words.contains("untagged"), "{words}");
    let fewer = refused(smoothing.clone(), json!({ "centres": 3 }), "");
    assert!(fewer.contains("leave out `centres`"), "{fewer}");
    let published = refused(smoothing.clone(), json!({ "mode": "published" }), "");
    assert!(published.contains("one smoothing for all samples"), "{published}");
    let given = refused(json!(0.1), none(), "--smoothing 0,0.1,0");
    assert!(given.contains("a smoothing for each of 6 samples, found 3"), "{given}");
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
fn learned_centres_ignore_irrelevant_inputs() {
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
