//! Cases of the folders `frames` and `normals`. `normals` holds a tube of three rings, whose long
//! thin faces bend at the middle ring.

use super::with_cases;
use serde_json::Value;

fn at_most(found: &Value, key: &str, most: f64) {
    let value = found[key].as_f64().unwrap();
    assert!(value <= most, "{key}: {value}, at most {most}");
}

#[test]
fn every_predictor_learns_the_middle_ring_and_its_normals() {
    let Some(folder) = with_cases("ring", &["normals/h_none.glb", "normals/h_none.npz"]) else {
        return;
    };
    let shape = "h_none.glb --targets h_none.npz";
    for (options, percent) in [
        ("", 0.02),
        ("--predictor kernel", 0.02),
        ("--predictor kernel --proxies 1", 0.02),
        ("--predictor kernel --proxies 4", 0.02),
        ("--predictor rotational", 0.06),
        ("--predictor rotational --proxies 20", 0.06),
    ] {
        folder.sinew(&format!("train {shape} -o m.sinew {options}")).done();
        let found = folder.sinew(&format!("eval m.sinew {shape} --json")).json();
        at_most(&found, "rms_percent", percent);
        at_most(&found, "normal_rms_degrees", 2.0);
        at_most(&found, "normal_p99_degrees", 10.0);
    }
}

#[test]
fn authored_normals_of_an_exact_linear_skin_are_near_the_truth() {
    let Some(folder) = with_cases("own", &["normals/own.glb"]) else { return };
    folder.sinew("-q train own.glb -o m.sinew");
    let found = folder.sinew("-q eval m.sinew own.glb --json").json();
    at_most(&found, "normal_rms_degrees", 2.0);
    at_most(&found["lbs"], "normal_rms_degrees", 2.0);
}

#[test]
fn an_exact_linear_skin_that_rarely_moves_keeps_all_frames() {
    let Some(folder) = with_cases("punch", &["frames/punch.glb"]) else { return };
    let found = folder.sinew("check punch.glb --json");
    let found: Value = serde_json::from_str(&found.out).unwrap();
    let kinds: Vec<_> = found["findings"].as_array().unwrap().iter().map(|f| &f["kind"]).collect();
    assert!(kinds.iter().all(|kind| *kind != "broken"), "{kinds:?}");
    folder.sinew("-q train punch.glb -o m.sinew --json");
    let found = folder.sinew("-q eval m.sinew punch.glb --json").json();
    let error = found["lbs"]["rms_percent"].as_f64().unwrap();
    assert!(error <= 1e-4 && found["frames"] == 21, "{found}");
}
