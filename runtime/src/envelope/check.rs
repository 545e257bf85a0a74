//! Checks of an envelope, in the order of FORMAT.md.
//!
//! A step reads only data that earlier steps have checked. All steps together read each byte a bounded number of
//! times, and allocate nothing.

use super::counts::{BIND_TOLERANCE, EnvelopeCounts, NO_JOINT, RULES, TWIST_MAX, place};
use super::group::{GroupKernel, GroupRow};
use super::polar::is_hidden;
use super::view::{Envelope, joint_index};
use crate::format::content::{check_counts, check_floats, check_index, check_names, outside};
use crate::format::part::{Asked, COUNTS, first_counts};
use crate::format::refusal::{Checked, Loading};
use crate::format::{CORRECTION_MAX, FileErrorKind as Kind, SectionKind, saturated};
use crate::linear::{IDENTITY, Le, floats, padded, rows, turn_back};

/// Checks the counts of an envelope, and returns the flags and sizes for the rules of its sections.
pub(crate) fn counts(words: &[u32; COUNTS], loading: &Loading<'_>) -> Checked<Asked> {
    let section = SectionKind::EnvelopeCounts;
    let Some(counts) = EnvelopeCounts::from_words(first_counts(words)) else {
        let values = [0, words[place::PREDICTOR]];
        return Err(loading.refuse(Kind::Unsupported, Some(section), place::PREDICTOR, values));
    };
    let predictor = counts.predictor;
    // Indices are u16, and the greatest u16 is the sentinel for "none".
    let indexed = u32::from(u16::MAX);
    let corrects = predictor.corrects();
    // Each group owns at least one helper.
    let groups = if corrects { counts.proxy_len } else { 0 };
    let curves =
        if cfg!(feature = "curves") && corrects { loading.limits.curves.min(indexed) } else { 0 };
    // Curves alone may drive the helpers.
    let alone = cfg!(feature = "curves") && corrects;
    let joints = u32::from(!alone || counts.curve_len == 0);
    let proxies = u32::from(!alone || counts.joint_len == 0);
    let ranges = [
        (place::CURVES, 0, curves),
        (place::JOINTS, joints, loading.limits.joints.min(indexed)),
        (place::PROXIES, proxies, loading.limits.proxies.min(indexed)),
        (place::GROUPS, 0, groups),
        (place::STRETCHES, 0, u32::from(cfg!(feature = "stretch") && counts.joint_len > 0)),
    ];
    check_counts(loading, section, words, &ranges)?;
    Ok(counts.asked())
}

/// Checks the content of an envelope whose sections have the right lengths.
pub(crate) fn content(envelope: &Envelope<'_>, loading: &Loading<'_>) -> Checked {
    CHECKS.iter().try_for_each(|check| check(envelope, loading))
}

/// Checks of the content, in order. Calls through pointers are not inlined, so the checks share stack space.
static CHECKS: [fn(&Envelope<'_>, &Loading<'_>) -> Checked;
    7 + cfg!(feature = "curves") as usize + cfg!(feature = "trs") as usize] = [
    |envelope, loading| check_names(loading, envelope.names()),
    check_hierarchy,
    |envelope, loading| check_floats(loading, &envelope.0, &RULES),
    check_inverse_binds,
    check_keys,
    check_groups,
    check_corrections,
    #[cfg(feature = "curves")]
    check_curves,
    #[cfg(feature = "trs")]
    check_places,
];

/// Checks that only the root has no parent, and that the evaluation order is a permutation with parents first.
///
/// The file stores the inverse of the order, so the check takes linear time without scratch.
fn check_hierarchy(envelope: &Envelope<'_>, loading: &Loading<'_>) -> Checked {
    let joint_len = envelope.joint_len();
    if cfg!(feature = "curves") && joint_len == 0 && envelope.root() != 0 {
        return loading.invalid(SectionKind::EnvelopeCounts, place::ROOT);
    }
    let ranks = envelope.ranks();
    let rank = |joint: usize| ranks.get(joint).map(|le| usize::from(u16::from_le_bytes(*le)));
    for (position, joint) in envelope.evaluation_order().enumerate() {
        if rank(joint) != Some(position) {
            return loading.invalid(SectionKind::Hierarchy, joint.min(joint_len));
        }
    }
    for (joint, parent) in envelope.parents().iter().enumerate() {
        let fits = match joint_index(parent) {
            None => joint == envelope.root(),
            Some(parent) => parent < joint_len && rank(parent) < rank(joint),
        };
        if !fits {
            return loading.invalid(SectionKind::Hierarchy, joint);
        }
    }
    Ok(())
}

/// Checks that the linear part of each inverse bind matrix is a rotation.
fn check_inverse_binds(envelope: &Envelope<'_>, loading: &Loading<'_>) -> Checked {
    for (joint, matrix) in envelope.bind_words().iter().enumerate() {
        let matrix = rows(&floats(matrix));
        let rows = matrix.map(|[x, y, z, _]: [f32; 4]| [x, y, z]);
        let mut products = rows;
        turn_back(&rows, &mut products);
        let mut pairs = products.as_flattened().iter().zip(IDENTITY.as_flattened());
        let is_orthogonal = pairs.all(|(found, one)| (found - one).abs() <= BIND_TOLERANCE);
        if !is_orthogonal || is_hidden(&matrix) {
            return loading.invalid(SectionKind::InverseBinds, joint);
        }
    }
    Ok(())
}

/// Checks the joints of the keys, and the norms of their twists.
fn check_keys(envelope: &Envelope<'_>, loading: &Loading<'_>) -> Checked {
    let below = envelope.joint_len();
    let turns = |twist: &[Le; 9]| {
        let square: f32 = floats(twist).iter().map(|x| x * x).sum();
        square > TWIST_MAX * TWIST_MAX
    };
    for (index, key) in envelope.keys().enumerate() {
        let residual = key.residual.map_or(0, |(joint, _)| joint);
        let found = if key.joint < below { residual } else { key.joint };
        check_index(loading, SectionKind::Keys, index, below as u32, found as u32)?;
        if turns(key.twist) || key.residual.is_some_and(|(_, twist)| turns(twist)) {
            return loading.invalid(SectionKind::Keys, index);
        }
    }
    Ok(())
}

/// Checks the rows of the groups, and the counts that follow from all rows.
///
/// The groups must own every helper. The length of section `corrections` and the stated scratch must match the groups.
fn check_groups(envelope: &Envelope<'_>, loading: &Loading<'_>) -> Checked {
    let joint_len = envelope.joint_len() as u32;
    // The sum cannot overflow: at most 2^16 groups, each below 2^40 words.
    let (mut words, mut helpers, mut scratch) = (0u64, 0, 0);
    for (group, row) in envelope.group_rows().enumerate() {
        let wrong = wrong_row(&row, joint_len).or_else(|| {
            let values = [saturated(words), row.offset];
            (u64::from(row.offset) != words).then_some((Kind::Mismatch, values))
        });
        if let Some((kind, values)) = wrong {
            return Err(loading.refuse(kind, Some(SectionKind::Groups), group, values));
        }
        words += row.words();
        helpers += u32::from(row.proxy_len);
        scratch = scratch.max(row.scratch_len());
    }
    let section = SectionKind::EnvelopeCounts;
    let (bytes, found) = (saturated(4 * words), saturated(envelope.corrections_len() as u64));
    let scratch = saturated(scratch as u64);
    let (proxy_len, corrects) = (envelope.proxy_len() as u32, envelope.predictor().corrects());
    let stated = envelope.correction_len() as u32;
    let (kind, section, place, values) = if corrects && helpers != proxy_len {
        (Kind::Mismatch, section, place::PROXIES, [helpers, proxy_len])
    } else if bytes != found {
        (Kind::Length, SectionKind::Corrections, 0, [bytes, found])
    } else if scratch != stated {
        (Kind::Mismatch, section, place::CORRECTION, [scratch, stated])
    } else {
        return Ok(());
    };
    Err(loading.refuse(kind, Some(section), place, values))
}

/// Checks that the least value of each curve is at most the greatest.
#[cfg(feature = "curves")]
fn check_curves(envelope: &Envelope<'_>, loading: &Loading<'_>) -> Checked {
    let mut ranges = envelope.curve_ranges().iter().map(floats);
    match ranges.position(|[least, most]| least > most) {
        Some(curve) => loading.invalid(SectionKind::CurveRanges, curve),
        None => Ok(()),
    }
}

/// Checks that no spread is larger than 2, and that the diagonal of each is at least a hundredth.
#[cfg(feature = "trs")]
fn check_places(envelope: &Envelope<'_>, loading: &Loading<'_>) -> Checked {
    let is_wrong = |words: &[Le; 9]| {
        let (_, spread) = super::view::place(words);
        let [xx, _, _, yy, _, zz] = spread;
        spread.iter().any(|entry| entry.abs() > 2.0) || [xx, yy, zz].iter().any(|own| *own < 0.01)
    };
    match envelope.helper_places().iter().position(is_wrong) {
        Some(helper) => loading.invalid(SectionKind::HelperPlaces, helper),
        None => Ok(()),
    }
}

/// Checks one row of a group; returns the kind of error, expected and found.
fn wrong_row(row: &GroupRow, joint_len: u32) -> Option<(Kind, [u32; 2])> {
    let has_centres = row.centre_len > 0;
    let confidence = row.confidence.words();
    let has_joint = u32::from(row.joint) < joint_len
        || cfg!(feature = "curves") && joint_len == 0 && row.joint == NO_JOINT;
    if !has_joint {
        Some((Kind::Index, [joint_len, row.joint.into()]))
    } else if GroupKernel::from_number(row.kernel).is_none() {
        Some((Kind::Unsupported, [0, row.kernel.into()]))
    } else if row.proxy_len == 0 || has_centres && (row.input_len == 0 || row.rank == 0) {
        Some((Kind::Empty, [1, 0]))
    } else if outside(&confidence, [0.0, CORRECTION_MAX]).is_some()
        || has_centres && row.confidence.reach == 0.0
    {
        Some((Kind::Invalid, [0; 2]))
    } else {
        None
    }
}

/// Checks that inputs refer to features, and that every float of the kernel maps is in range.
fn check_corrections(envelope: &Envelope<'_>, loading: &Loading<'_>) -> Checked {
    let section = SectionKind::Corrections;
    let below = envelope.counts().feature_len() as u32;
    let mut words = envelope.corrections();
    let mut start = 0;
    for row in envelope.group_rows() {
        // An earlier step has checked that the section holds the words of all groups.
        let own = words.len().min(row.words() as usize);
        let (group, rest) = words.split_at(own);
        let (features, floats) = group.split_at(padded(row.input_len.into()).min(own));
        for (i, feature) in features.iter().enumerate() {
            check_index(loading, section, start + i, below, u32::from_le_bytes(*feature))?;
        }
        if let Some(at) = outside(floats, [-CORRECTION_MAX, CORRECTION_MAX]) {
            let index = start + features.len() + at;
            return Err(loading.refuse(Kind::Float, Some(section), index, [0; 2]));
        }
        (words, start) = (rest, start + own);
    }
    Ok(())
}
