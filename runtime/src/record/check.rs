//! The checks of a record, in the order that FORMAT.md lists.

use super::counts::{RULES, RecordCounts, place};
use super::view::Record;
use crate::format::SectionKind;
use crate::format::content::{check_counts, check_floats, check_index, check_names};
use crate::format::part::{Asked, COUNTS, first_counts};
use crate::format::refusal::{Checked, Loading};

/// Checks a record's counts, and returns what they ask of its sections.
pub(crate) fn counts(words: &[u32; COUNTS], loading: &Loading<'_>) -> Checked<Asked> {
    let most = u32::from(u16::MAX);
    let ranges = [
        (place::VERTICES, 0, loading.limits.vertices),
        (place::INFLUENCES, 0, loading.limits.influences.min(most)),
        (place::JOINTS, 1, loading.limits.joints.min(most)),
    ];
    check_counts(loading, SectionKind::RecordCounts, words, &ranges)?;
    Ok(RecordCounts::from_words(first_counts(words)).asked())
}

/// Checks the content of a record whose sections all have their length.
pub(crate) fn content(record: &Record<'_>, loading: &Loading<'_>) -> Checked {
    check_names(loading, record.names())?;
    check_floats(loading, &record.0, &RULES)?;
    let below = record.counts().joint_len;
    for (index, joint) in record.lbs_joints().iter().enumerate() {
        let found = u16::from_le_bytes(*joint).into();
        check_index(loading, SectionKind::LbsJoints, index, below, found)?;
    }
    Ok(())
}
