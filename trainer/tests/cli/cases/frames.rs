//! Cases of the folder `frames`.

use super::with_cases;

#[test]
fn an_exact_linear_skin_that_rarely_moves_keeps_all_frames() {
    let Some(folder) = with_cases("punch", &["frames/punch.glb"]) else { return };
    let found = folder.sinew("check punch.glb --json");
    let found: serde_json::Value = serde_json::from_str(&found.out).unwrap();
    let kinds: Vec<_> = found["findings"].as_array().unwrap().iter().map(|f| &f["kind"]).collect();
    assert!(kinds.iter().all(|kind| *kind != "broken"), "{kinds:?}");
    folder.sinew("-q train punch.glb -o m.sinew --json");
    let found = folder.sinew("-q eval m.sinew punch.glb --json").json();
    let error = found["lbs"]["rms_percent"].as_f64().unwrap();
    assert!(error <= 1e-4 && found["frames"] == 21, "{found}");
}
