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
use sinew_runtime::envelope::{
    Certificate, ENVELOPE_SECTIONS, EnvelopeCounts, NO_JOINT, Predictor,
};
use sinew_runtime::format::{
    ALIGNMENT, CHECKSUM_OFFSET, Element, File, MAGIC, PartKind, PartRow, SectionKind, SectionRow,
    Space, VERSION, checksum,
};
use sinew_runtime::skin::{NO_ENVELOPE, Output, Rest, SKIN_SECTIONS, SkinCounts, cells};
use sinew_runtime::{
    Argument, CallError, CallErrorKind, Envelope, FileError, FileErrorKind, Matrix3x4, Model, Skin,
    SkinJob, model_space_pose,
};
use std::cell::Cell;
use std::sync::LazyLock;

/// Every field of a file, each free to be wrong.
#[derive(Clone)]
pub struct Builder {
    pub magic: [u8; 4],
    pub version: u8,
    pub features: u32,
    pub space: [u8; 8],
    pub parts: Vec<PartRow>,
    pub sections: Vec<Content>,
    /// Changes the section table just before it is written.
    pub edit_rows: fn(&mut Vec<SectionRow>),
}

#[derive(Clone)]
pub struct Content {
    pub kind: u16,
    pub part: u16,
    pub element: u8,
    pub flags: u8,
    pub reserved: u16,
    pub bytes: Vec<u8>,
}

impl Content {
    /// Makes a section that a reader must know.
    pub fn new(kind: SectionKind, part: u16, bytes: Vec<u8>) -> Self {
        let element = kind.element().number();
        Self { kind: kind.number(), part, element, flags: 1, reserved: 0, bytes }
    }

    /// Makes one of a kind that no reader knows.
    pub fn unknown(kind: u16, part: u16, flags: u8) -> Self {
        let element = Element::Mixed.number();
        Self { kind, part, element, flags, reserved: 0, bytes: vec![1; 5] }
    }
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

    /// Makes a model of an envelope, part 0, and its skin, part 1, whose rest pose is exact: every
    /// coefficient is a multiple of 1/64, and the rows of c1 and c2 together give [I | 0] for d = I,
    /// q = rest. Kernel maps are those of [`sample_groups`].
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
            predictor,
            joint_len: j as u32,
            proxy_len: p as u32,
            root: root as u32,
            group_len: 0,
            correction_len: 0,
        };
        // Two ranges, the second empty where there are few vertices, and a gap between.
        let (cut, end) = (v as u32 / 2, v as u32);
        let skin_counts =
            SkinCounts { vertex_len: end, influence_len: k as u32, envelope: 0, range_len: 2 };
        let ranges = [0, cut, end.min(cut + 1), end];
        let palette_len = counts.palette_len();
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
        let pose_ranges = vec![1.5; j];
        let origins = ranks.iter().flat_map(|&rank| [f32::from(rank), 0.0, 0.0]);
        let origins = origins.collect::<Vec<_>>();
        let names = (0..j).map(|joint| format!("joint {joint}")).collect::<Vec<_>>();
        let certificate = Certificate {
            diagonal: 3.0,
            training_rms: 0.01,
            cross_validated_rms: 0.02,
            lbs_training_rms: 0.04,
            correction_error: 0.0,
        };
        let mut contents = vec![
            (0, SectionKind::EnvelopeCounts, words(&counts.words())),
            (0, SectionKind::Certificate, floats(&certificate.figures())),
            (0, SectionKind::Names, names_bytes("arm", &names)),
            (0, SectionKind::Hierarchy, halves(&[parents, order, ranks].concat())),
            (0, SectionKind::InverseBinds, floats(&inverse_binds)),
            (0, SectionKind::Keys, keys),
            (0, SectionKind::C1, blocks(&c1)),
            (0, SectionKind::C2, blocks(&c2)),
            (0, SectionKind::PoseRanges, floats(&pose_ranges)),
            (0, SectionKind::Origins, floats(&origins)),
            (0, SectionKind::Groups, Vec::new()),
            (0, SectionKind::Corrections, Vec::new()),
            (1, SectionKind::SkinCounts, words(&skin_counts.words())),
            (1, SectionKind::Names, names_bytes("sleeve", &["upper".into(), "lower".into()])),
            (1, SectionKind::RestPositions, floats(&positions)),
            (1, SectionKind::RestNormals, floats(&normals)),
            (1, SectionKind::RestTangents, floats(&tangent_values)),
            (1, SectionKind::InfluenceIndices, halves(&indices)),
            (1, SectionKind::InfluenceWeights, floats(&weights)),
            (1, SectionKind::RestBoxes, floats(boxes.as_flattened())),
            (1, SectionKind::Ranges, words(&ranges)),
        ];
        let written = contents.iter().map(|(_, kind, _)| *kind);
        assert!(written.eq(ENVELOPE_SECTIONS.into_iter().chain(SKIN_SECTIONS)));
        contents.retain(|(_, kind, _)| tangents || *kind != SectionKind::RestTangents);
        contents.retain(|(part, kind, _)| *part == 1 || counts.has(*kind));
        let content = |(part, kind, bytes)| {
            // A skin may lack tangents, so that a reader may.
            let flags = u8::from(kind != SectionKind::RestTangents);
            Content { flags, ..Content::new(kind, part, bytes) }
        };
        let mut builder = Self {
            magic: MAGIC,
            version: VERSION,
            features: 0,
            space: Space::default().to_bytes(),
            parts: vec![PartRow::new(PartKind::Envelope), PartRow::new(PartKind::Skin)],
            sections: contents.into_iter().map(content).collect(),
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

    /// Makes a skin that follows no envelope, alone in its file.
    pub fn loose(shape: Shape) -> Self {
        let mut builder = Self::sample(shape);
        builder.parts.remove(0);
        builder.sections.retain(|content| content.part == 1);
        let dropped =
            [SectionKind::InfluenceIndices, SectionKind::InfluenceWeights, SectionKind::RestBoxes];
        builder.sections.retain(|content| dropped.iter().all(|d| d.number() != content.kind));
        builder.sections.iter_mut().for_each(|content| content.part = 0);
        builder.set_word(SectionKind::SkinCounts, 1, 0);
        builder.set_word(SectionKind::SkinCounts, 2, NO_ENVELOPE);
        *builder.section(SectionKind::Names) = names_bytes("eye", &["white".into(), "iris".into()]);
        builder
    }

    /// Makes two envelopes and three skins, one of which follows none: parts arm and sleeve, arm and
    /// sleeve of the kernel predictor, eye.
    pub fn several() -> Self {
        let mut builder = Self::small(Predictor::Rotational);
        builder.append(Self::small(Predictor::Kernel));
        builder.append(Self::loose(Shape { vertices: 3, ..SMALL }));
        builder
    }

    /// Appends the parts of another file; what its skins follow goes with them.
    pub fn append(&mut self, other: Self) {
        let first = self.parts.len() as u16;
        self.parts.extend(other.parts);
        for mut content in other.sections {
            content.part += first;
            if content.kind == SectionKind::SkinCounts.number() {
                let envelope = &mut content.bytes.as_chunks_mut::<4>().0[2];
                let number = u32::from_le_bytes(*envelope);
                if number != NO_ENVELOPE {
                    *envelope = (number + u32::from(first)).to_le_bytes();
                }
            }
            self.sections.push(content);
        }
    }

    /// Returns a section's content, to be changed: of the names, the envelope's.
    pub fn section(&mut self, kind: SectionKind) -> &mut Vec<u8> {
        let found = self.sections.iter_mut().find(|content| content.kind == kind.number());
        &mut found.unwrap().bytes
    }

    /// Returns the content of a part's section, to be changed.
    pub fn section_of(&mut self, part: u16, kind: SectionKind) -> &mut Vec<u8> {
        let is_it = |content: &&mut Content| (content.part, content.kind) == (part, kind.number());
        &mut self.sections.iter_mut().find(is_it).unwrap().bytes
    }

    /// Replaces a word of a section, as a count.
    pub fn set_word(&mut self, kind: SectionKind, index: usize, value: u32) {
        self.section(kind)[4 * index..][..4].copy_from_slice(&value.to_le_bytes());
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
        let (mut blob, mut rows) = (Vec::new(), Vec::new());
        for &Content { kind, part, element, flags, reserved, ref bytes } in &self.sections {
            blob.resize(blob.len().next_multiple_of(ALIGNMENT), 0);
            let (offset, len) = (blob.len() as u32, bytes.len() as u32);
            rows.push(SectionRow { kind, part, element, flags, reserved, offset, bytes: len });
            blob.extend(bytes);
        }
        (self.edit_rows)(&mut rows);
        let parts = self.parts.iter().flat_map(PartRow::to_bytes).collect::<Vec<_>>();
        let sections = rows.iter().flat_map(SectionRow::to_bytes).collect::<Vec<_>>();
        let zeros = [0; 2 * ALIGNMENT];
        let file = File {
            magic: self.magic,
            version: self.version,
            features: self.features.to_le_bytes(),
            checksum: [0; 4],
            space: self.space,
            parts: &parts,
            sections: &sections,
            padding: &[],
            blob: &blob,
        };
        let serialize = |file: &File<'_>| postcard::to_extend(file, Vec::new()).unwrap();
        let length =
            |file: &File<'_>| postcard::serialize_with_flavor(file, Size::default()).unwrap();
        let mut padded = (0..zeros.len()).map(|len| File { padding: &zeros[..len], ..file });
        let aligned = |file: &File<'_>| (length(file) - blob.len()).is_multiple_of(ALIGNMENT);
        let mut file = padded.find(aligned).unwrap();
        edit(&mut file);
        let mut bytes = serialize(&file);
        seal(&mut bytes);
        bytes
    }
}

/// What is wrong with a call; fields that a kind does not use are 0.
pub const fn call_error(kind: CallErrorKind, argument: Argument) -> CallError {
    CallError { kind, argument, index: 0, expected: 0, found: 0 }
}

/// An argument of another length.
pub const fn length_error(argument: Argument, expected: usize, found: usize) -> CallError {
    CallError { expected, found, ..call_error(CallErrorKind::Length, argument) }
}

/// An argument that is too short.
pub const fn short_error(argument: Argument, expected: usize, found: usize) -> CallError {
    CallError { expected, found, ..call_error(CallErrorKind::TooShort, argument) }
}

/// A stage that a predictor does not have.
pub fn stage_error(predictor: Predictor) -> CallError {
    let found = predictor.number().into();
    CallError { found, ..call_error(CallErrorKind::NoStage, Argument::Call) }
}

/// What is wrong with a file as a whole; fields that a kind does not use are 0.
pub const fn file_error(kind: FileErrorKind) -> FileError {
    FileError { kind, part: None, section: None, index: 0, expected: 0, found: 0 }
}

/// What is wrong with a section of the sample's envelope.
pub const fn envelope_error(kind: FileErrorKind, section: SectionKind) -> FileError {
    FileError { part: Some(0), section: Some(section), ..file_error(kind) }
}

/// What is wrong with a section of the sample's skin.
pub const fn skin_error(kind: FileErrorKind, section: SectionKind) -> FileError {
    FileError { part: Some(1), section: Some(section), ..file_error(kind) }
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

pub fn words(values: &[u32]) -> Vec<u8> {
    values.iter().flat_map(|x| x.to_le_bytes()).collect()
}

pub fn halves(values: &[u16]) -> Vec<u8> {
    values.iter().flat_map(|x| x.to_le_bytes()).collect()
}

fn names_bytes(part: &str, others: &[String]) -> Vec<u8> {
    let (mut ends, mut text) = (Vec::new(), String::new());
    for name in std::iter::once(part).chain(others.iter().map(String::as_str)) {
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
    let mut scratch = vec![f32::NAN; envelope.scratch_len()];
    let mut out = vec![[[f32::NAN; 4]; 3]; envelope.palette_len()];
    let confidence = envelope.palette(pose, &mut scratch, &mut out).unwrap();
    (out, confidence)
}

/// Returns the largest difference; panics on NaN, on nothing to compare, on unequal lengths.
pub fn max_difference(a: &[f32], b: &[f32]) -> f32 {
    assert_eq!(a.len(), b.len(), "lengths");
    assert!(!a.is_empty(), "nothing to compare");
    assert!(a.iter().chain(b).all(|x| x.is_finite()), "not finite");
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

/// Returns the bits of floats, which tell -0 from 0.
pub fn bits(floats: &[f32]) -> Vec<u32> {
    floats.iter().map(|x| x.to_bits()).collect()
}

pub fn with_envelope(shape: Shape, test: impl FnOnce(Envelope<'_>)) {
    with_predictor(Predictor::Rotational, shape, test);
}

pub fn with_predictor(predictor: Predictor, shape: Shape, test: impl FnOnce(Envelope<'_>)) {
    with_model(predictor, shape, |envelope, _| test(envelope));
}

/// Runs a test on the sample's envelope and its skin.
pub fn with_skin(shape: Shape, test: impl FnOnce(Envelope<'_>, Skin<'_>)) {
    with_model(Predictor::Rotational, shape, test);
}

pub fn with_model(predictor: Predictor, shape: Shape, test: impl FnOnce(Envelope<'_>, Skin<'_>)) {
    let model = Model::from_bytes(Builder::of(predictor, shape).bytes()).unwrap();
    test(model.envelope().unwrap(), model.skin().unwrap());
}

/// Lends floats to an attribute.
pub const fn output(floats: &[Cell<f32>], stride: usize) -> Option<Output<'_>> {
    Some(Output { floats, stride })
}

/// Makes a job of all vertices that writes nothing yet.
pub fn job<'a>(skin: Skin<'a>, palette: &'a [Matrix3x4]) -> SkinJob<'a> {
    let (vertices, rest) = (0..skin.vertex_len(), Rest::default());
    let (positions, normals, tangents) = (None, None, None);
    SkinJob { skin, palette, vertices, remap: None, rest, positions, normals, tangents }
}

/// Runs a job with positions, normals (3 each) and tangents (4), each in a run of its own; without
/// tangents where nothing has them.
pub fn run(job: &SkinJob<'_>) -> Vec<f32> {
    let n = job.vertices.len();
    let has_tangents = job.skin.has_tangents() || job.rest.tangents.is_some();
    let mut out = vec![f32::NAN; if has_tangents { 10 } else { 6 } * n];
    let (positions, rest) = out.split_at_mut(3 * n);
    let (normals, tangents) = rest.split_at_mut(3 * n);
    SkinJob {
        positions: output(cells(positions), 3),
        normals: output(cells(normals), 3),
        tangents: output(cells(tangents), 4).filter(|_| has_tangents),
        ..job.clone()
    }
    .run()
    .unwrap();
    out
}

/// Skins every vertex; see [`run`].
pub fn skinned(skin: Skin<'_>, palette: &[Matrix3x4]) -> Vec<f32> {
    run(&job(skin, palette))
}

/// The rest mesh, laid out as [`run`] does.
pub fn rest(skin: Skin<'_>) -> Vec<f32> {
    let v = 0..skin.vertex_len();
    let positions = v.clone().flat_map(|v| skin.rest_position(v).unwrap());
    let normals = v.clone().flat_map(|v| skin.rest_normal(v).unwrap());
    positions.chain(normals).chain(v.filter_map(|v| skin.rest_tangent(v)).flatten()).collect()
}

/// Evaluates everything that a model offers: none of it may panic.
pub fn exercise(bytes: &[u8]) -> Option<()> {
    let model = Model::from_bytes(bytes).ok()?;
    assert!(model.sections().all(|section| section.bytes.len() == section.row.bytes as usize));
    let known = [PartKind::Envelope, PartKind::Skin].map(|kind| kind.number());
    let found = model.envelopes().count() + model.skins().count();
    assert_eq!(found, model.parts().filter(|row| known.contains(&row.kind)).count());
    model.envelopes().for_each(|envelope| exercise_envelope(&envelope));
    for skin in model.skins() {
        let envelope = model.envelope_of(&skin);
        assert_eq!(envelope.is_some(), skin.envelope_part().is_some());
        let len = envelope.map_or(0, |envelope| envelope.palette_len());
        assert_eq!(skin.palette_len(), len);
        exercise_skin(skin, &vec![IDENTITY; len]);
        if let Some(envelope) = envelope {
            let pose = vec![IDENTITY; envelope.joint_len()];
            exercise_skin(skin, &palette(&envelope, &pose));
        }
    }
    Some(())
}

fn exercise_envelope(envelope: &Envelope<'_>) {
    assert!((0..envelope.joint_len()).all(|j| envelope.joint_name(j).is_some()));
    let reconstructs = envelope.predictor().reconstructs();
    assert!((0..envelope.proxy_len()).all(|l| envelope.key(l).is_some() == reconstructs));
    assert_eq!(envelope.groups().count(), envelope.group_len());
    let (transforms, _) = confident_palette(envelope, &vec![IDENTITY; envelope.joint_len()]);
    assert!(transforms.as_flattened().as_flattened().iter().all(|x| x.is_finite()));
    // A pose that turns gives the kernel maps something to do.
    let local = vec![Rng(1).local(0.2); envelope.joint_len()];
    let mut pose = vec![IDENTITY; envelope.joint_len()];
    if model_space_pose(envelope, &local, &mut pose).is_ok() && rigid(&pose) {
        let (transforms, confidence) = confident_palette(envelope, &pose);
        assert!(transforms.as_flattened().as_flattened().iter().all(|x| x.is_finite()));
        assert!((0.0..=1.0).contains(&confidence));
    }
}

fn exercise_skin(skin: Skin<'_>, palette: &[Matrix3x4]) {
    assert!(skinned(skin, palette).iter().all(|x| x.is_finite()));
    assert!(skin.bounds(palette, 0.0).is_ok());
    let v = 0..skin.vertex_len();
    assert!(v.clone().all(|v| skin.influences(v).all(|i| i.0 < palette.len())));
    assert!(v.clone().all(|v| skin.influences(v).len() == skin.influence_len()));
    assert_eq!(skin.ranges().count(), skin.counts().range_len as usize);
    assert!(skin.ranges().all(|(_, range)| range.start <= range.end && range.end <= v.end));
}

/// Whether a pose's matrices are rotations, as those of a damaged file's bind matrices are not.
fn rigid(pose: &[Matrix3x4]) -> bool {
    let unit = |m: &Matrix3x4| m.map(|[x, y, z, _]| (x * x + y * y + z * z - 1.0).abs() < 1e-3);
    pose.iter().all(|m| unit(m) == [true; 3] && m.iter().all(|row| row[3].abs() < 1e3))
}
