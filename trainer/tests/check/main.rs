//! Tests every finding of `check`, on a synthetic character with exactly this fault; a character
//! without faults has no finding.
#![allow(clippy::unwrap_used, reason = "a test stops where its set-up fails")]

mod frames;
mod made;
mod mesh;
mod poses;
mod real;
#[path = "../shared/mod.rs"]
mod shared;
mod skeleton;
mod space;

use made::{arm, check, kinds};
use sinew_trainer::envelope::check::finding::{Kind, Severity};
use sinew_trainer::examples::Split;

#[test]
fn a_good_character_has_no_warning() {
    for examples in [arm(), made::chain(&made::bends())] {
        let checked = check(&examples);
        assert_eq!(checked.count(Severity::Warning), 0, "{:?}", checked.findings);
        assert_eq!(kinds(&checked), [], "{:?}", checked.findings);
    }
}

#[test]
fn a_character_that_never_moves_is_checked_all_the_same() {
    let still = made::chain(&[([0.0, 0.0], Split::Train); 8]);
    let checked = check(&still);
    assert_eq!(kinds(&checked), [Kind::OnePose, Kind::Still, Kind::Repeated]);
    assert!(checked.predicted.is_none() && checked.advice.is_empty());
}
