//! Every finding of a check, on a made character that has exactly this fault; one without has none.
#![allow(clippy::unwrap_used, reason = "a test stops where its set-up fails")]

mod frames;
mod made;
mod mesh;
mod poses;
mod real;
mod skeleton;
mod space;

use made::{arm, check, kinds};
use sinew_trainer::check::finding::Severity;

#[test]
fn a_good_character_has_no_warning() {
    for examples in [arm(), made::chain(&made::bends())] {
        let checked = check(&examples);
        assert_eq!(checked.count(Severity::Warning), 0, "{:?}", checked.findings);
        assert_eq!(kinds(&checked), [], "{:?}", checked.findings);
    }
}
