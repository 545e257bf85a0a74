//! Findings that a check must and must not report on the sets of `../shared/data`.

use crate::shared::shared;
use sinew_trainer::envelope::check::finding::{Kind, Severity};
use sinew_trainer::envelope::check::{Check, check};
use sinew_trainer::examples::{Loaded, npz};
use sinew_trainer::progress::Silent;

fn checked(set: &str) -> Option<Check> {
    let path = shared(set)?;
    let Loaded { examples, clips, .. } = npz::load(&path).unwrap();
    Some(check(&examples, &clips, &Silent).unwrap())
}

#[test]
fn mpfb_arm_is_good_but_for_vertices_without_faces() {
    let Some(found) = checked("mpfb-arm/mpfb_arm.npz") else { return };
    assert_eq!(found.count(Severity::Warning), 0, "{:?}", found.findings);
    assert_eq!(found.find(Kind::Unreferenced).unwrap().places.len(), 8);
    // METHOD §1.9: the kernel predictor with 40 helpers reaches 0.068 % on held-out frames.
    let predicted = found.predicted.unwrap();
    assert!((0.05..0.12).contains(&predicted.expected_percent), "{}", predicted.expected_percent);
    assert!((0.7..0.9).contains(&found.lbs.rms_percent));
}

#[test]
fn dem_bones_rests_for_a_quarter_of_its_frames() {
    let Some(found) = checked("dem-bones/bone.npz") else { return };
    assert_eq!(found.count(Severity::Warning), 0, "{:?}", found.findings);
    assert_eq!((found.rest.nearest.frame, found.rest.tested), (0, 6));
    assert!(found.find(Kind::Repeated).unwrap().places.len() > 50);
    assert!(found.joints[1..].iter().all(|joint| joint.slide_percent > 5.0), "its joints slide");
}
