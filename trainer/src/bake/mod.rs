//! The only writer of the file that [`sinew_runtime`] reads.

mod groups;

pub use groups::Group;

use crate::examples::Matrix3x4;
use nalgebra::Matrix4;
use sinew_runtime::format::{
    CHECKSUM_OFFSET, Certificate, EnvelopeCounts, FEATURES, File, MAGIC, NO_JOINT, PartRow,
    Predictor, Presence, SectionKind, SectionRow, VERSION, checksum,
};
use sinew_runtime::{FormatError, Model};

/// Everything that an envelope part holds, in f64 and in the examples' order.
#[derive(Clone, Debug)]
pub struct EnvelopeParts {
    /// Name of the part.
    pub name: String,
    /// J names.
    pub joint_names: Vec<String>,
    /// Parent of each joint, J; `None` for the root alone.
    pub parents: Vec<Option<usize>>,
    /// The reference root.
    pub root: usize,
    /// Model-space rest frame of each joint, J; the file holds their inverses, and their origins
    /// if there are groups.
    pub rest_frames: Vec<Matrix3x4>,
    /// Rest positions, V.
    pub rest_positions: Vec<[f64; 3]>,
    /// Rest normals, V, of length 1 or 0.
    pub rest_normals: Vec<[f64; 3]>,
    /// Rest tangents of length 1 and, last, handedness, V.
    pub rest_tangents: Option<Vec<[f64; 4]>>,
    /// Influences of each vertex, V: palette index and weight. K is the longest list's length.
    pub influences: Vec<Vec<(usize, f64)>>,
    /// The proxies' reconstruction; `None` for the kernel predictor, of joints and helpers.
    pub reconstruction: Option<Reconstruction>,
    /// Kernel maps of the helpers, or of what the reconstruction leaves over. Their proxies follow
    /// each other and are all there are; a rotational model has no group.
    pub groups: Vec<Group>,
    /// Largest rotation of each joint relative to its parent in training, J, in radians.
    pub pose_ranges: Vec<f64>,
    /// What the fit was measured to reach.
    pub certificate: Certificate,
}

/// What predicts the maps of P proxies: `t = c1 d + c2 q`.
#[derive(Clone, Debug)]
pub struct Reconstruction {
    /// Key predictors, P.
    pub keys: Vec<Key>,
    /// c1, row-major, 4 P x 3 P.
    pub c1: Vec<f64>,
    /// c2, row-major, 4 P x 4 J.
    pub c2: Vec<f64>,
}

impl EnvelopeParts {
    /// Returns the predictor that the parts make.
    pub fn predictor(&self) -> Predictor {
        match &self.reconstruction {
            None => Predictor::Kernel,
            Some(_) if self.groups.is_empty() => Predictor::Rotational,
            Some(_) => Predictor::Hybrid,
        }
    }
}

/// A key predictor: `D = Q_p exp(A theta_b) [exp(A' theta_c)] (I + sym(H [theta_b; theta_p]))`.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// The joint b that it follows.
    pub joint: usize,
    /// A = u W, rows.
    pub twist: [[f64; 3]; 3],
    /// The residual joint c and its A', rows.
    pub residual: Option<(usize, [[f64; 3]; 3])>,
    /// H, rows xx, xy, xz, yy, yz, zz.
    pub shear: [[f64; 6]; 6],
}

/// What every section starts on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Alignment {
    /// 16 bytes.
    #[default]
    Bytes16,
    /// 256 bytes, which any GPU accepts as a binding's offset.
    Bytes256,
}

/// Why an envelope could not be baked.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum BakeError {
    /// An array does not fit the others.
    #[error("{what}: expected {expected} elements, found {found}")]
    Length {
        /// The array.
        what: &'static str,
        /// What the other arrays imply.
        expected: usize,
        /// What it has.
        found: usize,
    },
    /// A number is too large for its place in the file.
    #[error("{what}: {found} does not fit the file")]
    Size {
        /// What is counted or indexed.
        what: &'static str,
        /// The number.
        found: usize,
    },
    /// A joint cannot be reached from the root by way of parents.
    #[error("joint {joint} does not descend from the root")]
    Hierarchy {
        /// The joint.
        joint: usize,
    },
    /// A rest frame has no inverse.
    #[error("the rest frame of joint {joint} cannot be inverted")]
    RestFrame {
        /// The joint.
        joint: usize,
    },
    /// The weights of a vertex do not have a positive sum.
    #[error("the weights of vertex {vertex} sum to {sum}, expected 1")]
    Weights {
        /// The vertex.
        vertex: usize,
        /// Their sum.
        sum: f64,
    },
    /// The runtime refuses what was written.
    #[error("the runtime refuses the baked model: {0}")]
    Refused(FormatError),
}

/// Bakes an envelope into a file with sections on 16 bytes.
///
/// # Errors
/// See [`bake_aligned`].
pub fn bake(parts: &EnvelopeParts) -> Result<Vec<u8>, BakeError> {
    bake_aligned(parts, Alignment::Bytes16)
}

/// Bakes an envelope into a file and loads it once, so that what is returned is known to load.
///
/// Weights are divided by their sum, then rounded; all else is rounded as it is.
///
/// # Errors
/// - [`BakeError::Length`]: arrays do not fit each other.
/// - [`BakeError::Size`]: an index or a size does not fit the file.
/// - [`BakeError::Hierarchy`]: joints do not form one tree.
/// - [`BakeError::RestFrame`]: a rest frame is singular.
/// - [`BakeError::Weights`]: a vertex has no positive sum of weights.
/// - [`BakeError::Refused`]: anything else that the runtime would refuse, as a number that is not
///   finite.
pub fn bake_aligned(parts: &EnvelopeParts, alignment: Alignment) -> Result<Vec<u8>, BakeError> {
    let predictor = parts.predictor();
    let groups = groups::write(parts)?;
    let counts = counts(parts, groups.scratch_len)?;
    let reconstruction = parts.reconstruction.as_ref();
    let corrects = predictor.corrects();
    let rest_positions =
        parts.rest_positions.iter().map(|x| x.map(|x| x as f32)).collect::<Vec<_>>();
    let sections = [
        (SectionKind::Names, Some(names(parts)?)),
        (SectionKind::Hierarchy, Some(hierarchy(parts)?)),
        (SectionKind::InverseBinds, Some(inverse_binds(&parts.rest_frames)?)),
        (SectionKind::RestPositions, Some(floats(parts.rest_positions.as_flattened()))),
        (SectionKind::RestNormals, Some(floats(parts.rest_normals.as_flattened()))),
        (SectionKind::RestTangents, parts.rest_tangents.as_ref().map(|t| floats(t.as_flattened()))),
        (SectionKind::InfluenceIndices, Some(indices(parts, counts.influence_len as usize)?)),
        (SectionKind::InfluenceWeights, Some(weights(parts, counts.influence_len as usize)?)),
        (SectionKind::Keys, reconstruction.map(|r| keys(&r.keys)).transpose()?),
        (SectionKind::C1, reconstruction.map(|r| blocks(&r.c1, 3 * r.keys.len()))),
        (SectionKind::C2, reconstruction.map(|r| blocks(&r.c2, 4 * parts.parents.len()))),
        (
            SectionKind::RestBoxes,
            Some(rest_boxes(parts, &rest_positions, counts.palette_len(predictor))),
        ),
        (SectionKind::PoseRanges, Some(floats(&parts.pose_ranges))),
        (SectionKind::Origins, corrects.then(|| groups::origins(parts))),
        (SectionKind::Groups, corrects.then_some(groups.rows)),
        (SectionKind::Corrections, corrects.then_some(groups.words)),
    ];
    let row = PartRow::envelope(predictor, counts, parts.certificate);
    let bytes = assemble(predictor, &row, &sections, alignment)?;
    Model::from_bytes(&bytes).map_err(BakeError::Refused)?;
    Ok(bytes)
}

/// Checks the arrays against each other and counts them.
fn counts(parts: &EnvelopeParts, scratch_len: usize) -> Result<EnvelopeCounts, BakeError> {
    let (v, j) = (parts.rest_positions.len(), parts.parents.len());
    let helpers = parts.groups.iter().map(|group| group.proxies).sum();
    let p = parts.reconstruction.as_ref().map_or(helpers, |r| r.keys.len());
    let tangent_len = parts.rest_tangents.as_ref().map_or(v, Vec::len);
    for (what, expected, found) in [
        ("joint names", j, parts.joint_names.len()),
        ("rest frames", j, parts.rest_frames.len()),
        ("pose ranges", j, parts.pose_ranges.len()),
        ("rest normals", v, parts.rest_normals.len()),
        ("rest tangents", v, tangent_len),
        ("influences", v, parts.influences.len()),
    ] {
        check_len(what, expected, found)?;
    }
    if let Some(reconstruction) = &parts.reconstruction {
        check_len("c1", 12 * p * p, reconstruction.c1.len())?;
        check_len("c2", 16 * p * j, reconstruction.c2.len())?;
    }
    if parts.predictor().corrects() {
        check_len("proxies of all groups", p, helpers)?;
    }
    let k = parts.influences.iter().map(Vec::len).max().unwrap_or(0).max(1);
    Ok(EnvelopeCounts {
        vertex_len: narrow("vertices", v)?,
        joint_len: narrow("joints", j)?,
        proxy_len: narrow("proxies", p)?,
        influence_len: narrow("influences", k)?,
        root: narrow("root", parts.root)?,
        group_len: narrow("groups", parts.groups.len())?,
        scratch_len: narrow("scratch", scratch_len)?,
    })
}

/// Lays sections out in a blob, writes the message, and seals it with its checksum.
fn assemble(
    predictor: Predictor,
    part: &PartRow,
    sections: &[(SectionKind, Option<Vec<u8>>)],
    alignment: Alignment,
) -> Result<Vec<u8>, BakeError> {
    let alignment_log2 = match alignment {
        Alignment::Bytes16 => 4,
        Alignment::Bytes256 => 8,
    };
    let align = 1 << alignment_log2;
    let (mut rows, mut blob) = (Vec::new(), Vec::new());
    for (kind, content) in sections {
        let Some(content) = content else { continue };
        blob.resize(blob.len().next_multiple_of(align), 0);
        let row = SectionRow {
            kind: kind.number(),
            part: 0,
            flags: u8::from(kind.presence(predictor) != Presence::Optional),
            offset: narrow("blob bytes", blob.len())?,
            bytes: narrow("section bytes", content.len())?,
        };
        rows.extend(row.to_bytes());
        blob.extend(content);
    }
    let mut file = File {
        magic: MAGIC,
        version: VERSION,
        alignment_log2,
        features: FEATURES.to_le_bytes(),
        checksum: [0; 4],
        parts: &part.to_bytes(),
        sections: &rows,
        padding: &[],
        blob: &[],
    };
    // The padding's own length is a varint that grows at 128, so 383 zeros may be needed.
    let zeros = [0; 384];
    let blob_len = serialize(&blob.len()).len();
    let padding = (0..zeros.len()).map(|len| &zeros[..len]).find(|&padding| {
        // One byte of the head is the length of its empty blob.
        (serialize(&File { padding, ..file }).len() - 1 + blob_len).is_multiple_of(align)
    });
    file.padding = padding.unwrap_or_default();
    file.blob = &blob;
    let mut bytes = serialize(&file);
    let sum = checksum(&bytes).to_le_bytes();
    if let Some(field) = bytes.get_mut(CHECKSUM_OFFSET..CHECKSUM_OFFSET + 4) {
        field.copy_from_slice(&sum);
    }
    Ok(bytes)
}

fn serialize(value: &impl serde::Serialize) -> Vec<u8> {
    // A Vec takes any number of bytes, and every length here is known, so this cannot fail; if it
    // did, the runtime would refuse the empty file.
    postcard::to_extend(value, Vec::new()).unwrap_or_default()
}

/// Writes the end of each name, then the names.
fn names(parts: &EnvelopeParts) -> Result<Vec<u8>, BakeError> {
    let (mut ends, mut text) = (Vec::new(), Vec::<u8>::new());
    for name in std::iter::once(&parts.name).chain(&parts.joint_names) {
        text.extend(name.as_bytes());
        ends.extend(narrow::<u32>("name bytes", text.len())?.to_le_bytes());
    }
    ends.extend(text);
    Ok(ends)
}

/// Writes parents, the evaluation order (breadth first, by number), and its inverse.
fn hierarchy(parts: &EnvelopeParts) -> Result<Vec<u8>, BakeError> {
    let parents = &parts.parents;
    let mut order = Vec::from([parts.root]);
    let mut next = 0;
    while let Some(&parent) = order.get(next) {
        order.extend((0..parents.len()).filter(|&j| parents[j] == Some(parent) && j != parts.root));
        next += 1;
    }
    let rank = |joint: usize| order.iter().position(|&j| j == joint);
    let ranks = (0..parents.len())
        .map(|joint| rank(joint).ok_or(BakeError::Hierarchy { joint }))
        .collect::<Result<Vec<_>, _>>()?;
    let mut out = Vec::new();
    for parent in parents {
        out.extend(joint_number(*parent)?);
    }
    for joint in order.into_iter().chain(ranks) {
        out.extend(joint_number(Some(joint))?);
    }
    Ok(out)
}

fn joint_number(joint: Option<usize>) -> Result<[u8; 2], BakeError> {
    joint.map_or(Ok(NO_JOINT), |joint| narrow("joint", joint)).map(u16::to_le_bytes)
}

fn inverse_binds(rest_frames: &[Matrix3x4]) -> Result<Vec<u8>, BakeError> {
    let mut out = Vec::new();
    for (joint, [x, y, z]) in rest_frames.iter().enumerate() {
        let rows = [*x, *y, *z, [0.0, 0.0, 0.0, 1.0]];
        let frame = Matrix4::from_row_slice(rows.as_flattened());
        let inverse = frame.try_inverse().ok_or(BakeError::RestFrame { joint })?;
        // The transpose's columns are the rows.
        out.extend(floats(&inverse.transpose().as_slice()[..12]));
    }
    Ok(out)
}

/// Writes K palette indices a vertex; those that are not used point to map 0.
fn indices(parts: &EnvelopeParts, k: usize) -> Result<Vec<u8>, BakeError> {
    let mut out = Vec::new();
    for influences in &parts.influences {
        for slot in 0..k {
            let index = influences.get(slot).map_or(0, |&(index, _)| index);
            out.extend(narrow::<u16>("palette index", index)?.to_le_bytes());
        }
    }
    Ok(out)
}

/// Writes K weights a vertex, those that are not used as 0.
fn weights(parts: &EnvelopeParts, k: usize) -> Result<Vec<u8>, BakeError> {
    let mut out = Vec::new();
    for (vertex, influences) in parts.influences.iter().enumerate() {
        let sum = influences.iter().map(|&(_, weight)| weight).sum::<f64>();
        if !(sum > 0.0 && sum.is_finite()) {
            return Err(BakeError::Weights { vertex, sum });
        }
        let normalised = influences.iter().map(|&(_, weight)| weight / sum);
        out.extend(floats(&normalised.chain(std::iter::repeat(0.0)).take(k).collect::<Vec<_>>()));
    }
    Ok(out)
}

fn keys(keys: &[Key]) -> Result<Vec<u8>, BakeError> {
    let mut out = Vec::new();
    for key in keys {
        out.extend(joint_number(Some(key.joint))?);
        out.extend(joint_number(key.residual.map(|(joint, _)| joint))?);
        out.extend(floats(key.twist.as_flattened()));
        out.extend(floats(key.residual.map_or([[0.0; 3]; 3], |(_, twist)| twist).as_flattened()));
        out.extend(floats(key.shear.as_flattened()));
    }
    Ok(out)
}

/// Cuts a row-major matrix into blocks of 8 rows, column-major, the last padded with zeros.
fn blocks(matrix: &[f64], column_len: usize) -> Vec<u8> {
    let mut out = Vec::new();
    for block in matrix.chunks(8 * column_len.max(1)) {
        for column in 0..column_len {
            let rows = (0..8).map(|row| block.get(row * column_len + column).copied());
            out.extend(floats(&rows.map(Option::unwrap_or_default).collect::<Vec<_>>()));
        }
    }
    out
}

/// Computes the box of the rounded rest positions that each map of the palette moves; min > max if
/// it moves none.
fn rest_boxes(parts: &EnvelopeParts, rest_positions: &[[f32; 3]], palette_len: usize) -> Vec<u8> {
    let mut boxes = vec![None::<([f32; 3], [f32; 3])>; palette_len];
    for (influences, &x) in parts.influences.iter().zip(rest_positions) {
        for &(index, weight) in influences {
            let Some(rest_box) = boxes.get_mut(index).filter(|_| weight > 0.0) else { continue };
            let (min, max) = rest_box.unwrap_or((x, x));
            let union = |i: usize| (min[i].min(x[i]), max[i].max(x[i]));
            let [x, y, z] = [0, 1, 2].map(union);
            *rest_box = Some(([x.0, y.0, z.0], [x.1, y.1, z.1]));
        }
    }
    let corners = boxes.into_iter().map(|rest_box| rest_box.unwrap_or(([1.0; 3], [-1.0; 3])));
    corners.flat_map(|(min, max)| min.into_iter().chain(max)).flat_map(f32::to_le_bytes).collect()
}

fn floats(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|&x| (x as f32).to_le_bytes()).collect()
}

fn check_len(what: &'static str, expected: usize, found: usize) -> Result<(), BakeError> {
    if found == expected { Ok(()) } else { Err(BakeError::Length { what, expected, found }) }
}

fn narrow<T: TryFrom<usize>>(what: &'static str, found: usize) -> Result<T, BakeError> {
    T::try_from(found).map_err(|_| BakeError::Size { what, found })
}
