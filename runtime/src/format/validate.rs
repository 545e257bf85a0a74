//! Every check of a file, once, in the order that FORMAT.md lists.
//!
//! The checks of one step read nothing that an earlier step has not checked. All of them together
//! read each byte a bounded number of times and allocate nothing.

use super::manifest::REQUIRED;
use super::{
    ALIGNMENT_LOG2, BIND_TOLERANCE, CORRECTION_MAX, EnvelopeCounts, FEATURES, File, GroupRow,
    KEY_WORDS, MAGIC, MAGNITUDE_MAX, Manifest, PARTS_MAX, PartKind, PartRow, Predictor,
    SECTIONS_MAX, SectionKind, SectionRow, TWIST_MAX, VERSION, WEIGHT_SUM_TOLERANCE, checksum,
};
use crate::envelope::Envelope;
use crate::error::FormatError;
use crate::kernel::{Kernel, padded};
use crate::limits::{Limits, Quantity};
use crate::linear::{Le, dot, floats};
use crate::numeric::greater;

/// Reads and checks a whole file.
///
/// # Errors
/// Every variant of [`FormatError`].
pub(crate) fn read<'a>(bytes: &'a [u8], limits: &Limits) -> Result<Manifest<'a>, FormatError> {
    let manifest = check_tables(check_message(bytes, limits)?)?;
    for (part, row) in manifest.parts.iter().map(PartRow::from_bytes).enumerate() {
        if row.kind == PartKind::Envelope.number() {
            check_envelope_row(&row, limits)?;
            Envelope::check_sections(&manifest, part, &row)?;
            if let Some(envelope) = Envelope::view(&manifest, part, &row) {
                check_envelope(&envelope)?;
            }
        }
    }
    Ok(manifest)
}

/// Checks what stands before the tables: size, magic, version, checksum, features, alignment.
fn check_message<'a>(bytes: &'a [u8], limits: &Limits) -> Result<File<'a>, FormatError> {
    check_limit(Quantity::FileBytes, limits.file_bytes, bytes.len())?;
    let (&magic, rest) = bytes.split_first_chunk().ok_or(FormatError::Malformed)?;
    if magic != MAGIC {
        return Err(FormatError::Magic { found: magic });
    }
    let version = *rest.first().ok_or(FormatError::Malformed)?;
    if version != VERSION {
        return Err(FormatError::Version { expected: VERSION, found: version });
    }
    let (file, rest) =
        postcard::take_from_bytes::<File<'a>>(bytes).map_err(|_| FormatError::Malformed)?;
    let (expected, found) = (u32::from_le_bytes(file.checksum), checksum(bytes));
    if expected != found {
        return Err(FormatError::Checksum { expected, found });
    }
    if !rest.is_empty() {
        return Err(FormatError::TrailingBytes { found: rest.len() });
    }
    let unknown = u32::from_le_bytes(file.features) & !FEATURES;
    if unknown != 0 {
        return Err(FormatError::Features { unknown });
    }
    let log2 = file.alignment_log2;
    let blob_start = bytes.len() - file.blob.len();
    if !ALIGNMENT_LOG2.contains(&log2) || blob_start & ((1 << log2) - 1) != 0 {
        return Err(FormatError::Alignment { log2 });
    }
    if file.padding.iter().any(|&byte| byte != 0) {
        return Err(FormatError::Padding);
    }
    Ok(file)
}

/// Checks the two tables, so that every row has a part and a place of its own in the blob.
fn check_tables<'a>(file: File<'a>) -> Result<Manifest<'a>, FormatError> {
    let (parts, rest) = file.parts.as_chunks();
    if !rest.is_empty() || parts.is_empty() || parts.len() > PARTS_MAX {
        return Err(FormatError::PartTable { bytes: file.parts.len() });
    }
    let (sections, rest) = file.sections.as_chunks();
    if !rest.is_empty() || sections.len() > SECTIONS_MAX {
        return Err(FormatError::SectionTable { bytes: file.sections.len() });
    }
    let manifest = Manifest { parts, sections, blob: file.blob };
    for row in parts.iter().map(PartRow::from_bytes) {
        check_flags(row.flags)?;
        // Parts that the format names and does not yet hold are unknown to this reader.
        if row.kind != PartKind::Envelope.number() && row.required() {
            return Err(FormatError::UnknownPart { kind: row.kind });
        }
    }
    let mut end = 0;
    for (index, row) in manifest.rows().enumerate() {
        check_section_row(&manifest, index, row)?;
        if row.offset as usize & ((1 << file.alignment_log2) - 1) != 0 {
            return Err(FormatError::SectionAlignment { row: index });
        }
        if u64::from(row.offset) < end {
            return Err(FormatError::SectionOverlap { row: index });
        }
        end = u64::from(row.offset) + u64::from(row.bytes);
        if end > file.blob.len() as u64 {
            return Err(FormatError::SectionBounds { row: index });
        }
    }
    for (index, row) in manifest.rows().enumerate() {
        if manifest.rows().take(index).any(|r| (r.part, r.kind) == (row.part, row.kind)) {
            return Err(FormatError::DuplicateSection { row: index });
        }
    }
    Ok(manifest)
}

fn check_section_row(
    manifest: &Manifest<'_>,
    index: usize,
    row: SectionRow,
) -> Result<(), FormatError> {
    check_flags(u16::from(row.flags))?;
    let part = manifest.parts.get(usize::from(row.part)).map(PartRow::from_bytes);
    let Some(part) = part else {
        return Err(FormatError::SectionPart { row: index, found: row.part });
    };
    let known = part.kind == PartKind::Envelope.number();
    if known && row.required() && SectionKind::from_number(row.kind).is_none() {
        return Err(FormatError::UnknownSection { kind: row.kind });
    }
    Ok(())
}

fn check_flags(found: u16) -> Result<(), FormatError> {
    if found & !REQUIRED == 0 { Ok(()) } else { Err(FormatError::Flags { found }) }
}

/// Checks an envelope's row: predictor, counts within limits, certificate.
fn check_envelope_row(row: &PartRow, limits: &Limits) -> Result<(), FormatError> {
    let predictor = Predictor::from_number(row.predictor)
        .ok_or(FormatError::Predictor { found: row.predictor })?;
    let EnvelopeCounts { vertex_len, joint_len, proxy_len, influence_len, group_len, .. } =
        row.envelope_counts();
    // Indices are u16, and the greatest stands for none; more influences have no maps to be of.
    let indexed = u32::from(u16::MAX);
    // Each group owns a proxy.
    let groups = if predictor.corrects() { proxy_len } else { 0 };
    for (quantity, most, found) in [
        (Quantity::Vertices, limits.vertices, vertex_len),
        (Quantity::Joints, limits.joints.min(indexed), joint_len),
        (Quantity::Proxies, limits.proxies.min(indexed), proxy_len),
        (Quantity::Influences, limits.influences.min(indexed), influence_len),
        (Quantity::Groups, groups, group_len),
    ] {
        check_limit(quantity, most, found as usize)?;
        let may_lack = match quantity {
            Quantity::Vertices | Quantity::Groups => true,
            Quantity::Proxies => !predictor.reconstructs(),
            _ => false,
        };
        if found == 0 && !may_lack {
            return Err(FormatError::Empty { quantity });
        }
    }
    match outside(&row.figures.map(f32::to_le_bytes), SIGNED) {
        Some(index) => Err(FormatError::Float { section: None, index }),
        None => Ok(()),
    }
}

fn check_limit(quantity: Quantity, most: u32, found: usize) -> Result<(), FormatError> {
    let found = u32::try_from(found).unwrap_or(u32::MAX);
    if found > most { Err(FormatError::Limit { quantity, most, found }) } else { Ok(()) }
}

/// Checks the content of an envelope whose sections all have their length.
fn check_envelope(envelope: &Envelope<'_>) -> Result<(), FormatError> {
    check_names(envelope)?;
    check_hierarchy(envelope)?;
    let e = envelope;
    let tangents = e.tangents.unwrap_or_default().as_flattened();
    check_floats(SectionKind::InverseBinds, e.inverse_binds.as_flattened(), SIGNED)?;
    check_floats(SectionKind::RestPositions, e.positions.as_flattened(), SIGNED)?;
    check_floats(SectionKind::RestNormals, e.normals.as_flattened(), SIGNED)?;
    check_floats(SectionKind::RestTangents, tangents, SIGNED)?;
    check_matrices(e)?;
    check_floats(SectionKind::C1, e.c1.as_flattened(), SIGNED)?;
    check_floats(SectionKind::C2, e.c2.as_flattened(), SIGNED)?;
    check_floats(SectionKind::RestBoxes, e.boxes.as_flattened(), SIGNED)?;
    check_floats(SectionKind::Origins, e.origins.as_flattened(), SIGNED)?;
    check_floats(SectionKind::PoseRanges, e.pose_ranges, UNSIGNED)?;
    check_floats(SectionKind::InfluenceWeights, e.weights, UNSIGNED)?;
    check_inverse_binds(e)?;
    check_keys(e)?;
    check_groups(e)?;
    check_corrections(e)?;
    check_influences(e)
}

const SIGNED: [f32; 2] = [-MAGNITUDE_MAX, MAGNITUDE_MAX];
const UNSIGNED: [f32; 2] = [0.0, MAGNITUDE_MAX];

fn check_floats(section: SectionKind, floats: &[Le], range: [f32; 2]) -> Result<(), FormatError> {
    match outside(floats, range) {
        Some(index) => Err(FormatError::Float { section: Some(section), index }),
        None => Ok(()),
    }
}

/// Checks the matrices of the keys, which stand after a word of joints each.
fn check_matrices(envelope: &Envelope<'_>) -> Result<(), FormatError> {
    for (key, words) in envelope.keys.iter().enumerate() {
        let matrices = words.split_first().map_or(&[][..], |(_, matrices)| matrices);
        if let Some(at) = outside(matrices, SIGNED) {
            let index = key * (KEY_WORDS - 1) + at;
            return Err(FormatError::Float { section: Some(SectionKind::Keys), index });
        }
    }
    Ok(())
}

/// Finds the first float that is not within `[least, greatest]`, as none is that is no number.
#[inline(never)]
fn outside(floats: &[Le], [least, greatest]: [f32; 2]) -> Option<usize> {
    let within = |x: f32| least <= x && x <= greatest;
    floats.iter().position(|le| !within(f32::from_le_bytes(*le)))
}

/// Checks that names follow each other from first byte to last, each UTF-8.
fn check_names(envelope: &Envelope<'_>) -> Result<(), FormatError> {
    let names = envelope.names;
    let last = names.ends.len() - 1;
    let mut start = 0;
    for (index, end) in names.ends.iter().map(|le| u32::from_le_bytes(*le) as usize).enumerate() {
        let whole = index != last || end == names.text.len();
        let text = names.text.get(start..end).filter(|_| whole);
        if text.is_none_or(|text| core::str::from_utf8(text).is_err()) {
            return Err(FormatError::Name { index });
        }
        start = end;
    }
    Ok(())
}

/// Checks that the root alone has no parent, and that the evaluation order is a permutation in
/// which parents come first. The stored inverse makes this linear without scratch.
fn check_hierarchy(envelope: &Envelope<'_>) -> Result<(), FormatError> {
    let joint_len = envelope.joint_len();
    let rank =
        |joint: usize| envelope.ranks.get(joint).map(|le| usize::from(u16::from_le_bytes(*le)));
    for (position, joint) in envelope.evaluation_order().enumerate() {
        if rank(joint) != Some(position) {
            return Err(FormatError::Hierarchy { joint: joint.min(joint_len) });
        }
    }
    for joint in 0..joint_len {
        let fits = match envelope.parent(joint) {
            None => joint == envelope.root(),
            Some(parent) => parent < joint_len && rank(parent) < rank(joint),
        };
        if !fits {
            return Err(FormatError::Hierarchy { joint });
        }
    }
    Ok(())
}

/// Checks that each inverse bind matrix turns as a rotation does and mirrors nothing.
fn check_inverse_binds(envelope: &Envelope<'_>) -> Result<(), FormatError> {
    let near = |found: f32, expected: f32| (found - expected).abs() <= BIND_TOLERANCE;
    for joint in 0..envelope.joint_len() {
        let Some(matrix) = envelope.inverse_bind(joint) else { continue };
        let [x, y, z] = matrix.map(|[a, b, c, _]| [a, b, c]);
        let units = [x, y, z].iter().all(|row| near(dot(*row, *row), 1.0));
        let apart = near(dot(x, y), 0.0) && near(dot(y, z), 0.0) && near(dot(z, x), 0.0);
        let across =
            [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]];
        if !(units && apart && dot(across, z) > 0.0) {
            return Err(FormatError::InverseBind { joint });
        }
    }
    Ok(())
}

fn check_keys(envelope: &Envelope<'_>) -> Result<(), FormatError> {
    let below = envelope.joint_len();
    for index in 0..envelope.proxy_len() {
        let Some(key) = envelope.key(index) else { continue };
        let residual = key.residual.map_or(0, |(joint, _)| joint);
        let found = if key.joint < below { residual } else { key.joint };
        if found >= below {
            return Err(FormatError::Index { section: SectionKind::Keys, index, below, found });
        }
        let norm = |m: &[[f32; 3]; 3]| m.as_flattened().iter().map(|x| x * x).sum::<f32>();
        let residual = key.residual.map_or(0.0, |(_, twist)| norm(&twist));
        if greater(norm(&key.twist), residual) > TWIST_MAX * TWIST_MAX {
            return Err(FormatError::Twist { key: index });
        }
    }
    Ok(())
}

/// Checks the groups' rows, that together they own every proxy, that the corrections have the
/// length which follows from them, and that the scratch stated is what they need.
fn check_groups(envelope: &Envelope<'_>) -> Result<(), FormatError> {
    let saturated = |value: u64| u32::try_from(value).unwrap_or(u32::MAX);
    // Sums of at most 2^16 groups, each below 2^40 words.
    let (mut words, mut proxies, mut scratch) = (0u64, 0u64, 0);
    for (group, row) in envelope.groups.iter().map(GroupRow::from_bytes).enumerate() {
        check_group(envelope, group, &row)?;
        if u64::from(row.offset) != words {
            let expected = saturated(words);
            return Err(FormatError::GroupOffset { group, expected, found: row.offset });
        }
        words += row.words();
        proxies += u64::from(row.proxy_len);
        scratch = scratch.max(row.scratch_len());
    }
    let expected = envelope.counts.proxy_len;
    if envelope.predictor.corrects() && proxies != u64::from(expected) {
        return Err(FormatError::GroupProxies { expected, found: saturated(proxies) });
    }
    let (section, found) = (SectionKind::Corrections, envelope.corrections.len());
    if 4 * words != found as u64 {
        let expected = saturated(4 * words);
        return Err(FormatError::SectionLength { section, expected, found });
    }
    let (expected, found) = (saturated(scratch as u64), envelope.counts.scratch_len);
    if expected != found {
        return Err(FormatError::Scratch { expected, found });
    }
    Ok(())
}

fn check_group(envelope: &Envelope<'_>, group: usize, row: &GroupRow) -> Result<(), FormatError> {
    let (below, found) = (envelope.joint_len(), usize::from(row.joint));
    if found >= below {
        let section = SectionKind::Groups;
        return Err(FormatError::Index { section, index: group, below, found });
    }
    if Kernel::from_number(row.kernel).is_none() {
        return Err(FormatError::Kernel { group, found: row.kernel });
    }
    if row.reserved != 0 {
        return Err(FormatError::Reserved { group });
    }
    let has_centres = row.centre_len > 0;
    if row.proxy_len == 0 || has_centres && (row.input_len == 0 || row.rank == 0) {
        return Err(FormatError::EmptyGroup { group });
    }
    let (start, end) = (row.fade_start, row.fade_end);
    let within = (0.0..=CORRECTION_MAX).contains(&start) && (0.0..=CORRECTION_MAX).contains(&end);
    if !within || has_centres && start >= end {
        return Err(FormatError::Fade { group });
    }
    Ok(())
}

/// Checks that inputs point to features, and every float of the kernel maps.
fn check_corrections(envelope: &Envelope<'_>) -> Result<(), FormatError> {
    let section = SectionKind::Corrections;
    let below = 12 * envelope.joint_len();
    let mut words = envelope.corrections.as_chunks::<4>().0;
    let mut start = 0;
    for row in envelope.groups.iter().map(GroupRow::from_bytes) {
        // The section has the words of all groups, so that each finds its own.
        let own = usize::try_from(row.words()).unwrap_or(words.len()).min(words.len());
        let (group, rest) = words.split_at(own);
        let (features, floats) = group.split_at(padded(row.input_len.into()).min(own));
        for (i, feature) in features.iter().enumerate() {
            let found = u32::from_le_bytes(*feature) as usize;
            if found >= below {
                return Err(FormatError::Index { section, index: start + i, below, found });
            }
        }
        if let Some(at) = outside(floats, [-CORRECTION_MAX, CORRECTION_MAX]) {
            let index = start + features.len() + at;
            return Err(FormatError::Float { section: Some(section), index });
        }
        (words, start) = (rest, start + own);
    }
    Ok(())
}

/// Checks that influences point into the palette, sum to one, and stay in their maps' boxes.
fn check_influences(envelope: &Envelope<'_>) -> Result<(), FormatError> {
    let section = SectionKind::InfluenceIndices;
    let below = envelope.palette_len();
    for (vertex, position) in envelope.positions.iter().map(floats).enumerate() {
        let mut sum = 0.0;
        for (k, (found, weight)) in envelope.influences(vertex).enumerate() {
            if found >= below {
                let index = vertex * envelope.influence_len() + k;
                return Err(FormatError::Index { section, index, below, found });
            }
            sum += weight;
            let inside = envelope.rest_box(found).is_some_and(|rest| rest.contains(position));
            if weight > 0.0 && !inside {
                return Err(FormatError::RestBox { index: found, vertex });
            }
        }
        if (sum - 1.0).abs() > WEIGHT_SUM_TOLERANCE {
            return Err(FormatError::Weights { vertex });
        }
    }
    Ok(())
}
