use crate::full::Full;
use sinew_trainer::examples::demo::{DemoOptions, demo};

#[test]
fn an_arm_is_reconstructed_in_full_from_poses_that_were_not_seen() {
    let examples = demo(&DemoOptions { vertices: 300, poses: 60, held_out: 20, seed: 1 });
    let full = Full::fit(&examples, 0.25).unwrap();
    let [found, lbs] = [full.rms(Full::reconstruct), full.rms(Full::skinned)];
    assert!(found < 0.5 * lbs, "{found} against {lbs} of LBS");
}
