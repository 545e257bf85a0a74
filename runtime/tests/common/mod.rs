//! A builder of model files, sound and hostile, and seeded numbers for the tests.
#![allow(
    dead_code,
    unreachable_pub,
    missing_docs,
    clippy::unwrap_used,
    reason = "each test uses a part of it"
)]

pub mod groups;
#[path = "../../../tests/golden/rng.rs"]
mod rng;

pub use rng::Rng;

use groups::sample_groups;
use postcard::ser_flavors::Size;
use sinew_runtime::envelope::{Attribute, Buffer, SkinJob};
use sinew_runtime::format::{
    CHECKSUM_OFFSET, Certificate, EnvelopeCounts, File, MAGIC, NO_JOINT, PartRow, Predictor,
    Presence, SectionKind, SectionRow, VERSION, checksum,
};
use sinew_runtime::{Envelope, Matrix3x4, Model, model_space_pose};
use std::sync::LazyLock;

/// Every field of a file, each free to be wrong.
#[derive(Clone)]
pub struct Builder {
    pub magic: [u8; 4],
    pub version: u8,
    pub alignment_log2: u8,
    pub features: u32,
    pub parts: Vec<PartRow>,
    pub sections: Vec<Content>,
    /// Changes the section table just before it is written.
    pub edit_rows: fn(&mut Vec<SectionRow>),
}

#[derive(Clone)]
pub struct Content {
    pub kind: u16,
    pub part: u8,
    pub flags: u8,
    pub bytes: Vec<u8>,
}

/// Shape of a sample model: joints 0 -> 2 -> 1 (root), then a chain below joint 0.
#[derive(Clone, Copy)]
pub struct Shape {
    pub vertices: usize,
    pub joints: usize,
    pub proxies: usize,
    pub influences: usize,
    pub tangents: bool,
}

pub const SMALL: Shape =
    Shape { vertices: 7, joints: 4, proxies: 3, influences: 2, tangents: true };

impl Builder {
    /// Makes a rotational model.
    pub fn sample(shape: Shape) -> Self {
        Self::of(Predictor::Rotational, shape)
    }

    /// Makes a model whose rest pose is exact: every coefficient is a multiple of 1/64, and the
    /// rows of c1 and c2 together give [I | 0] for d = I, q = rest. Kernel maps are those of
    /// [`sample_groups`].
    pub fn of(predictor: Predictor, shape: Shape) -> Self {
        let Shape { vertices: v, joints: j, proxies: p, influences: k, tangents } = shape;
        let mut rng = Rng(7);
        let dyadic = |rng: &mut Rng, scale: f32| (rng.unit() * scale * 64.0).round() / 64.0;
        let root = 1.min(j - 1);
        let order = sample_order(j);
        let mut parents = vec![NO_JOINT; j];
        let mut ranks = vec![0; j];
        for (rank, &joint) in order.iter().enumerate() {
            ranks[joint] = rank as u16;
            if rank > 0 {
                parents[joint] = order[rank - 1] as u16;
            }
        }
        let order = order.iter().map(|&joint| joint as u16).collect::<Vec<_>>();
        let inverse_binds = (0..j).flat_map(|joint| {
            let x = -(ranks[joint] as f32);
            [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]
        });
        let inverse_binds = inverse_binds.flatten().collect::<Vec<_>>();
        let positions = (0..3 * v).map(|_| dyadic(&mut rng, 2.0)).collect::<Vec<_>>();
        let normals = (0..v).flat_map(|_| direction(&mut rng)).collect::<Vec<_>>();
        let tangent = |rng: &mut Rng| {
            let [x, y, z] = direction(rng);
            [x, y, z, if rng.unit() < 0.0 { -1.0 } else { 1.0 }]
        };
        let tangent_values = (0..v).flat_map(|_| tangent(&mut rng)).collect::<Vec<_>>();
        let counts = EnvelopeCounts {
            vertex_len: v as u32,
            joint_len: j as u32,
            proxy_len: p as u32,
            influence_len: k as u32,
            root: root as u32,
            group_len: 0,
            scratch_len: 0,
        };
        let palette_len = counts.palette_len(predictor);
        let mut indices = Vec::new();
        let mut weights = Vec::new();
        for vertex in 0..v {
            let mut left = 1.0;
            for slot in 0..k {
                indices.push(((vertex + slot) % palette_len) as u16);
                let weight = if slot + 1 == k { left } else { left * 0.75 };
                weights.push(weight);
                left -= weight;
            }
        }
        let mut boxes = vec![[1.0, 1.0, 1.0, -1.0, -1.0, -1.0f32]; palette_len];
        for (at, &index) in indices.iter().enumerate() {
            let rest_box = &mut boxes[usize::from(index)];
            let x = &positions[at / k * 3..][..3];
            let empty = rest_box[0] > rest_box[3];
            for c in 0..3 {
                rest_box[c] = if empty { x[c] } else { rest_box[c].min(x[c]) };
                rest_box[3 + c] = if empty { x[c] } else { rest_box[3 + c].max(x[c]) };
            }
        }
        let mut keys = Vec::new();
        for proxy in 0..p {
            let residual = if proxy % 2 == 0 { NO_JOINT } else { (proxy % j) as u16 };
            keys.extend(halves(&[((proxy + 2) % j) as u16, residual]));
            let matrices = (0..54).map(|at| {
                if at % 18 == 0 { 0.5 } else { dyadic(&mut rng, if at < 18 { 0.5 } else { 0.1 }) }
            });
            keys.extend(floats(&matrices.collect::<Vec<_>>()));
        }
        let mut c1 = vec![vec![0.0; 3 * p]; 4 * p];
        let mut c2 = vec![vec![0.0; 4 * j]; 4 * p];
        for (row, (c1, c2)) in c1.iter_mut().zip(&mut c2).enumerate() {
            for x in c1.iter_mut().chain(c2.iter_mut()) {
                *x = dyadic(&mut rng, 0.25);
            }
            for c in 0..3 {
                let rest = c1.iter().skip(c).step_by(3).chain(c2.iter().skip(c).step_by(4));
                let excess = rest.sum::<f32>() - if row % 4 == c { 1.0 } else { 0.0 };
                c2[4 * root + c] -= excess;
            }
        }
        let ranges = vec![1.5; j];
        let origins = ranks.iter().flat_map(|&rank| [f32::from(rank), 0.0, 0.0]);
        let origins = origins.collect::<Vec<_>>();
        let names = (0..j).map(|joint| format!("joint {joint}")).collect::<Vec<_>>();
        let mut sections = vec![
            (SectionKind::Names, names_bytes("arm", &names)),
            (SectionKind::Hierarchy, halves(&[parents, order, ranks].concat())),
            (SectionKind::InverseBinds, floats(&inverse_binds)),
            (SectionKind::RestPositions, floats(&positions)),
            (SectionKind::RestNormals, floats(&normals)),
            (SectionKind::RestTangents, floats(&tangent_values)),
            (SectionKind::InfluenceIndices, halves(&indices)),
            (SectionKind::InfluenceWeights, floats(&weights)),
            (SectionKind::Keys, keys),
            (SectionKind::C1, blocks(&c1)),
            (SectionKind::C2, blocks(&c2)),
            (SectionKind::RestBoxes, floats(boxes.as_flattened())),
            (SectionKind::PoseRanges, floats(&ranges)),
            (SectionKind::Origins, floats(&origins)),
            (SectionKind::Groups, Vec::new()),
            (SectionKind::Corrections, Vec::new()),
        ];
        sections.retain(|(kind, _)| tangents || *kind != SectionKind::RestTangents);
        sections.retain(|(kind, _)| kind.presence(predictor) != Presence::Absent);
        let certificate = Certificate {
            diagonal: 3.0,
            training_rms: 0.01,
            cross_validated_rms: 0.02,
            lbs_training_rms: 0.04,
            correction_error: 0.0,
        };
        let mut builder = Self {
            magic: MAGIC,
            version: VERSION,
            alignment_log2: 4,
            features: 0,
            parts: vec![PartRow::envelope(predictor, counts, certificate)],
            sections: sections
                .into_iter()
                .map(|(kind, bytes)| Content { kind: kind.number(), part: 0, flags: 1, bytes })
                .collect(),
            edit_rows: |_| {},
        };
        if predictor.corrects() {
            builder.set_groups(&sample_groups(j, p));
        }
        builder
    }

    /// Returns the model of the shape [`SMALL`], which is made once: under Miri that takes seconds.
    pub fn small(predictor: Predictor) -> Self {
        static MADE: LazyLock<[Builder; 3]> =
            LazyLock::new(|| Predictor::ALL.map(|predictor| Builder::of(predictor, SMALL)));
        let found = Predictor::ALL.iter().zip(&*MADE).find(|(own, _)| **own == predictor);
        found.unwrap().1.clone()
    }

    /// Returns a section's content, to be changed.
    pub fn section(&mut self, kind: SectionKind) -> &mut Vec<u8> {
        let found = self.sections.iter_mut().find(|content| content.kind == kind.number());
        &mut found.unwrap().bytes
    }

    /// Replaces a float of a section.
    pub fn set_float(&mut self, kind: SectionKind, index: usize, value: f32) {
        self.section(kind)[4 * index..][..4].copy_from_slice(&value.to_le_bytes());
    }

    /// Replaces a u16 of a section.
    pub fn set_half(&mut self, kind: SectionKind, index: usize, value: u16) {
        self.section(kind)[2 * index..][..2].copy_from_slice(&value.to_le_bytes());
    }

    /// Writes the file and seals it.
    pub fn bytes(&self) -> Vec<u8> {
        self.bytes_with(|_| {})
    }

    /// Writes the file, its head changed by `edit` after everything else is laid out, and seals it.
    pub fn bytes_with(&self, edit: impl FnOnce(&mut File<'_>)) -> Vec<u8> {
        let align = 1usize << self.alignment_log2.min(12);
        let (mut blob, mut rows) = (Vec::new(), Vec::new());
        for Content { kind, part, flags, bytes } in &self.sections {
            blob.resize(blob.len().next_multiple_of(align), 0);
            let (offset, len) = (blob.len() as u32, bytes.len() as u32);
            rows.push(SectionRow { kind: *kind, part: *part, flags: *flags, offset, bytes: len });
            blob.extend(bytes);
        }
        (self.edit_rows)(&mut rows);
        let parts = self.parts.iter().flat_map(PartRow::to_bytes).collect::<Vec<_>>();
        let sections = rows.iter().flat_map(SectionRow::to_bytes).collect::<Vec<_>>();
        let zeros = vec![0; align + 128];
        let file = File {
            magic: self.magic,
            version: self.version,
            alignment_log2: self.alignment_log2,
            features: self.features.to_le_bytes(),
            checksum: [0; 4],
            parts: &parts,
            sections: &sections,
            padding: &[],
            blob: &blob,
        };
        let serialize = |file: &File<'_>| postcard::to_extend(file, Vec::new()).unwrap();
        // The padding's own length takes up to two bytes more than none: start a little below.
        let length =
            |file: &File<'_>| postcard::serialize_with_flavor(file, Size::default()).unwrap();
        let head = length(&file) - blob.len();
        let least = (head.next_multiple_of(align) - head).saturating_sub(2);
        let mut padded = (least..zeros.len()).map(|len| File { padding: &zeros[..len], ..file });
        let aligned = |file: &File<'_>| (length(file) - blob.len()).is_multiple_of(align);
        let mut file = padded.find(aligned).unwrap();
        edit(&mut file);
        let mut bytes = serialize(&file);
        seal(&mut bytes);
        bytes
    }
}

/// Joints in evaluation order: the root is 1, its child 2, then 0, then the rest in order.
fn sample_order(joint_len: usize) -> Vec<usize> {
    match joint_len {
        1 => vec![0],
        2 => vec![1, 0],
        _ => [1, 2, 0].into_iter().chain(3..joint_len).collect(),
    }
}

/// How far apart the cases of a loop are taken: 1 takes all. Miri is a thousand times slower.
pub const fn apart(under_miri: usize) -> usize {
    if cfg!(miri) { under_miri } else { 1 }
}

/// Repairs the checksum of a file.
pub fn seal(bytes: &mut [u8]) {
    let sum = checksum(bytes).to_le_bytes();
    if let Some(field) = bytes.get_mut(CHECKSUM_OFFSET..CHECKSUM_OFFSET + 4) {
        field.copy_from_slice(&sum);
    }
}

pub fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|x| x.to_le_bytes()).collect()
}

pub fn halves(values: &[u16]) -> Vec<u8> {
    values.iter().flat_map(|x| x.to_le_bytes()).collect()
}

fn names_bytes(part: &str, joints: &[String]) -> Vec<u8> {
    let (mut ends, mut text) = (Vec::new(), String::new());
    for name in std::iter::once(part).chain(joints.iter().map(String::as_str)) {
        text += name;
        ends.extend((text.len() as u32).to_le_bytes());
    }
    [ends, text.into_bytes()].concat()
}

fn blocks(matrix: &[Vec<f32>]) -> Vec<u8> {
    let mut out = Vec::new();
    for block in matrix.chunks(8) {
        for column in 0..block[0].len() {
            for row in 0..8 {
                out.extend(block.get(row).map_or(0.0, |row| row[column]).to_le_bytes());
            }
        }
    }
    out
}

/// A direction, mostly up.
pub fn direction(rng: &mut Rng) -> [f32; 3] {
    let v = [rng.unit(), rng.unit(), rng.unit() + 1.5];
    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    v.map(|x| x / length)
}

/// Makes the J skinning matrices of a random pose.
pub fn random_pose(envelope: &Envelope<'_>, rng: &mut Rng, turn: f32) -> Vec<Matrix3x4> {
    let local = (0..envelope.joint_len()).map(|_| rng.local(turn)).collect::<Vec<_>>();
    let mut pose = vec![IDENTITY; envelope.joint_len()];
    model_space_pose(envelope, &local, &mut pose).unwrap();
    pose
}

pub const IDENTITY: Matrix3x4 = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// Computes the palette in scratch of exactly the stated length.
pub fn palette(envelope: &Envelope<'_>, pose: &[Matrix3x4]) -> Vec<Matrix3x4> {
    confident_palette(envelope, pose).0
}

/// The same, with the pose's confidence.
pub fn confident_palette(envelope: &Envelope<'_>, pose: &[Matrix3x4]) -> (Vec<Matrix3x4>, f32) {
    let mut workspace = vec![f32::NAN; envelope.workspace_len()];
    let mut out = vec![[[f32::NAN; 4]; 3]; envelope.palette_len()];
    let confidence = envelope.palette(pose, &mut workspace, &mut out).unwrap();
    (out, confidence)
}

/// Returns the largest difference; panics on NaN, on nothing to compare, on unequal lengths.
pub fn max_difference(a: &[f32], b: &[f32]) -> f32 {
    assert_eq!(a.len(), b.len(), "lengths");
    assert!(!a.is_empty(), "nothing to compare");
    assert!(a.iter().chain(b).all(|x| x.is_finite()), "not finite");
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

pub fn with_envelope(shape: Shape, test: impl FnOnce(Envelope<'_>)) {
    with_predictor(Predictor::Rotational, shape, test);
}

pub fn with_predictor(predictor: Predictor, shape: Shape, test: impl FnOnce(Envelope<'_>)) {
    let bytes = Builder::of(predictor, shape).bytes();
    test(Model::from_bytes(&bytes).unwrap().envelope().unwrap());
}

pub fn attribute(buffer: Buffer, offset: usize, stride: usize) -> Option<Attribute> {
    Some(Attribute { buffer, offset, stride })
}

/// Positions, normals (3 each) and tangents (4) of every vertex, each in a run of its own.
pub fn skin(envelope: Envelope<'_>, palette: &[Matrix3x4]) -> Vec<f32> {
    let v = envelope.vertex_len();
    let mut out = vec![f32::NAN; 10 * v];
    SkinJob {
        envelope,
        palette,
        vertices: 0..v,
        positions: attribute(Buffer::A, 0, 3),
        normals: attribute(Buffer::A, 3 * v, 3),
        tangents: attribute(Buffer::A, 6 * v, 4),
        out_a: &mut out,
        out_b: &mut [],
    }
    .run()
    .unwrap();
    out
}

pub fn rest(envelope: Envelope<'_>) -> Vec<f32> {
    let v = 0..envelope.vertex_len();
    let positions = v.clone().flat_map(|v| envelope.rest_position(v).unwrap());
    let normals = v.clone().flat_map(|v| envelope.rest_normal(v).unwrap());
    positions.chain(normals).chain(v.flat_map(|v| envelope.rest_tangent(v).unwrap())).collect()
}

/// Evaluates everything that a model offers: none of it may panic.
pub fn exercise(bytes: &[u8]) -> Option<()> {
    let model = Model::from_bytes(bytes).ok()?;
    assert!(model.sections().all(|section| section.bytes.len() == section.row.bytes as usize));
    let envelope = model.envelope()?;
    let maps = palette(&envelope, &vec![IDENTITY; envelope.joint_len()]);
    let mut out = vec![[0.0; 3]; envelope.vertex_len()];
    envelope.skin_positions(&maps, &mut out).unwrap();
    assert!(out.as_flattened().iter().all(|x| x.is_finite()));
    assert!(envelope.bounds(&maps).is_ok());
    assert!((0..envelope.joint_len()).all(|j| envelope.joint_name(j).is_some()));
    let reconstructs = envelope.predictor().reconstructs();
    assert!((0..envelope.proxy_len()).all(|l| envelope.key(l).is_some() == reconstructs));
    assert_eq!(envelope.groups().count(), envelope.group_len());
    // A pose that turns gives the kernel maps something to do.
    let local = vec![Rng(1).local(0.2); envelope.joint_len()];
    let mut pose = vec![IDENTITY; envelope.joint_len()];
    if model_space_pose(&envelope, &local, &mut pose).is_ok() && rigid(&pose) {
        let (maps, confidence) = confident_palette(&envelope, &pose);
        assert!(maps.as_flattened().as_flattened().iter().all(|x| x.is_finite()));
        assert!((0.0..=1.0).contains(&confidence));
    }
    assert!((0..envelope.vertex_len()).all(|v| envelope.influences(v).all(|i| i.0 < maps.len())));
    Some(())
}

/// Whether a pose's matrices are rotations, as those of a damaged file's bind matrices are not.
fn rigid(pose: &[Matrix3x4]) -> bool {
    let unit = |m: &Matrix3x4| m.map(|[x, y, z, _]| (x * x + y * y + z * z - 1.0).abs() < 1e-3);
    pose.iter().all(|m| unit(m) == [true; 3] && m.iter().all(|row| row[3].abs() < 1e3))
}
