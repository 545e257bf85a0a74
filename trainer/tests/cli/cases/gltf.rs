//! Cases of the folder `gltf`.

use super::with_cases;

#[test]
fn a_plain_linear_skin_is_exact() {
    let Some(folder) = with_cases("plain", &["gltf/plain.glb"]) else { return };
    folder.sinew("-q train plain.glb -o m.sinew");
    let found = folder.sinew("eval m.sinew plain.glb --json").json();
    let error = found["lbs"]["rms_percent"].as_f64().unwrap();
    assert!(error <= 1e-4, "{error}");
}
