//! The checks of an envelope, in the order that FORMAT.md lists.
//!
//! The checks of one step read nothing that an earlier step has not checked. All of them together
//! read each byte a bounded number of times and allocate nothing.

use super::counts::{BIND_TOLERANCE, EnvelopeCounts, KEY_WORDS, RULES, TWIST_MAX};
use super::group_row::GroupRow;
use super::view::{Envelope, EnvelopeLayout};
use crate::format::content::{check_count, check_floats, check_index, invalid, outside};
use crate::format::rule::Floats;
use crate::format::{
    CORRECTION_MAX, FileError, FileErrorKind as Kind, Manifest, SectionKind, saturated,
};
use crate::kernel::{Kernel, padded};
use crate::limits::Limits;
use crate::linear::dot;
use crate::numeric::greater;

/// Finds a part's counts and arrays, after checking its counts and its sections' lengths.
pub(crate) fn layout(
    manifest: &Manifest,
    file: &[u8],
    part: u16,
    limits: &Limits,
) -> Result<EnvelopeLayout, FileError> {
    manifest.check_known(file, part, &RULES)?;
    let (section, mut words) = (SectionKind::EnvelopeCounts, [0; 6]);
    manifest.counts(file, part, section, &mut words)?;
    let Some(counts) = EnvelopeCounts::from_words(words) else {
        return Err(FileError::of(Kind::Unsupported, section, 0, [0, words[0]]));
    };
    let predictor = counts.predictor;
    // Indices are u16, and the greatest stands for none.
    let indexed = u32::from(u16::MAX);
    // Each group owns a proxy.
    let groups = if predictor.corrects() { counts.proxy_len } else { 0 };
    let least = u32::from(predictor.reconstructs());
    check_count(section, 1, 1..=limits.joints.min(indexed), counts.joint_len)?;
    check_count(section, 2, least..=limits.proxies.min(indexed), counts.proxy_len)?;
    check_count(section, 4, 0..=groups, counts.group_len)?;
    let mut layout = EnvelopeLayout::new(manifest.id(), part, counts);
    let asked = (counts.bits(), &counts.sizes()[..]);
    manifest.find_all((file, part), &RULES, asked, layout.spans_mut())?;
    Ok(layout)
}

/// Checks the content of an envelope whose sections all have their length.
pub(crate) fn content(envelope: &Envelope<'_>) -> Result<(), FileError> {
    if let Some(index) = envelope.names().unsound() {
        return invalid(SectionKind::Names, index);
    }
    check_hierarchy(envelope)?;
    check_floats(envelope.file_bytes(), &RULES, envelope.spans())?;
    check_matrices(envelope)?;
    check_inverse_binds(envelope)?;
    check_keys(envelope)?;
    check_groups(envelope)?;
    check_corrections(envelope)
}

/// Checks the matrices of the keys, which stand after a word of joints each.
fn check_matrices(envelope: &Envelope<'_>) -> Result<(), FileError> {
    for (key, words) in envelope.keys().iter().enumerate() {
        let matrices = words.split_first().map_or(&[][..], |(_, matrices)| matrices);
        if let Some(at) = outside(matrices, Floats::Signed.range()) {
            let index = key * (KEY_WORDS - 1) + at;
            return Err(FileError::of(Kind::Float, SectionKind::Keys, index, [0; 2]));
        }
    }
    Ok(())
}

/// Checks that the root alone has no parent, and that the evaluation order is a permutation in
/// which parents come first. The stored inverse makes this linear without scratch.
fn check_hierarchy(envelope: &Envelope<'_>) -> Result<(), FileError> {
    let joint_len = envelope.joint_len();
    let ranks = envelope.ranks();
    let rank = |joint: usize| ranks.get(joint).map(|le| usize::from(u16::from_le_bytes(*le)));
    for (position, joint) in envelope.evaluation_order().enumerate() {
        if rank(joint) != Some(position) {
            return invalid(SectionKind::Hierarchy, joint.min(joint_len));
        }
    }
    for joint in 0..joint_len {
        let fits = match envelope.parent(joint) {
            None => joint == envelope.root(),
            Some(parent) => parent < joint_len && rank(parent) < rank(joint),
        };
        if !fits {
            return invalid(SectionKind::Hierarchy, joint);
        }
    }
    Ok(())
}

/// Checks that each inverse bind matrix turns as a rotation does and mirrors nothing.
fn check_inverse_binds(envelope: &Envelope<'_>) -> Result<(), FileError> {
    let near = |found: f32, expected: f32| (found - expected).abs() <= BIND_TOLERANCE;
    for joint in 0..envelope.joint_len() {
        let Some(matrix) = envelope.inverse_bind(joint) else { continue };
        let [x, y, z] = matrix.map(|[a, b, c, _]| [a, b, c]);
        let units = [x, y, z].iter().all(|row| near(dot(*row, *row), 1.0));
        let apart = near(dot(x, y), 0.0) && near(dot(y, z), 0.0) && near(dot(z, x), 0.0);
        let across =
            [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]];
        if !(units && apart && dot(across, z) > 0.0) {
            return invalid(SectionKind::InverseBinds, joint);
        }
    }
    Ok(())
}

fn check_keys(envelope: &Envelope<'_>) -> Result<(), FileError> {
    let below = envelope.joint_len();
    for index in 0..envelope.keys().len() {
        let Some(key) = envelope.key(index) else { continue };
        let residual = key.residual.map_or(0, |(joint, _)| joint);
        let found = if key.joint < below { residual } else { key.joint };
        check_index(SectionKind::Keys, index, below, found)?;
        let norm = |m: &[[f32; 3]; 3]| m.as_flattened().iter().map(|x| x * x).sum::<f32>();
        let residual = key.residual.map_or(0.0, |(_, twist)| norm(&twist));
        if greater(norm(&key.twist), residual) > TWIST_MAX * TWIST_MAX {
            return invalid(SectionKind::Keys, index);
        }
    }
    Ok(())
}

/// Checks the groups' rows, that together they own every proxy, that the corrections have the
/// length which follows from them, and that the scratch stated is what they need.
fn check_groups(envelope: &Envelope<'_>) -> Result<(), FileError> {
    let counts = envelope.counts();
    // Sums of at most 2^16 groups, each below 2^40 words.
    let (mut words, mut proxies, mut scratch) = (0u64, 0u64, 0);
    for (group, row) in envelope.group_rows().enumerate() {
        check_group(envelope, group, &row)?;
        if u64::from(row.offset) != words {
            let values = [saturated(words), row.offset];
            return Err(FileError::of(Kind::Mismatch, SectionKind::Groups, group, values));
        }
        words += row.words();
        proxies += u64::from(row.proxy_len);
        scratch = scratch.max(row.scratch_len());
    }
    let error = |kind, section, index, expected, found| {
        Err(FileError::of(kind, section, index, [expected, found].map(saturated)))
    };
    let section = SectionKind::EnvelopeCounts;
    if counts.predictor.corrects() && proxies != u64::from(counts.proxy_len) {
        return error(Kind::Mismatch, section, 2, proxies, counts.proxy_len.into());
    }
    let found = envelope.corrections_len() as u64;
    if 4 * words != found {
        return error(Kind::Length, SectionKind::Corrections, 0, 4 * words, found);
    }
    if scratch as u64 != u64::from(counts.correction_len) {
        return error(Kind::Mismatch, section, 5, scratch as u64, counts.correction_len.into());
    }
    Ok(())
}

fn check_group(envelope: &Envelope<'_>, group: usize, row: &GroupRow) -> Result<(), FileError> {
    let section = SectionKind::Groups;
    let error = |kind, values| Err(FileError::of(kind, section, group, values));
    check_index(section, group, envelope.joint_len(), row.joint.into())?;
    if Kernel::from_number(row.kernel).is_none() {
        return error(Kind::Unsupported, [0, row.kernel.into()]);
    }
    if row.reserved != 0 {
        return error(Kind::Unsupported, [0, row.reserved.into()]);
    }
    let has_centres = row.centre_len > 0;
    if row.proxy_len == 0 || has_centres && (row.input_len == 0 || row.rank == 0) {
        return error(Kind::Empty, [1, 0]);
    }
    let (start, end) = (row.fade_start, row.fade_end);
    let within = (0.0..=CORRECTION_MAX).contains(&start) && (0.0..=CORRECTION_MAX).contains(&end);
    if !within || has_centres && start >= end {
        return error(Kind::Invalid, [0; 2]);
    }
    Ok(())
}

/// Checks that inputs point to features, and every float of the kernel maps.
fn check_corrections(envelope: &Envelope<'_>) -> Result<(), FileError> {
    let section = SectionKind::Corrections;
    let below = 12 * envelope.joint_len();
    let mut words = envelope.corrections();
    let mut start = 0;
    for row in envelope.group_rows() {
        // The section has the words of all groups, so that each finds its own.
        let own = usize::try_from(row.words()).unwrap_or(words.len()).min(words.len());
        let (group, rest) = words.split_at(own);
        let (features, floats) = group.split_at(padded(row.input_len.into()).min(own));
        for (i, feature) in features.iter().enumerate() {
            check_index(section, start + i, below, u32::from_le_bytes(*feature) as usize)?;
        }
        if let Some(at) = outside(floats, [-CORRECTION_MAX, CORRECTION_MAX]) {
            let index = start + features.len() + at;
            return Err(FileError::of(Kind::Float, section, index, [0; 2]));
        }
        (words, start) = (rest, start + own);
    }
    Ok(())
}
