//! Valid samples: an envelope and its skin, of any predictor and shape.

use crate::bytes::{blocks, eights, floats, halves, names, words};
use crate::groups::sample_groups;
use crate::message::head;
use crate::pieces::{Content, Pieces};
use crate::rng::Rng;
use crate::shape::{SMALL, Shape};
use sinew_runtime::envelope::{ENVELOPE_SECTIONS, HelperKind, NO_JOINT, Predictor};
use sinew_runtime::format::{PartKind, PartRow, SectionKind};
use sinew_runtime::skin::SKIN_SECTIONS;
use std::sync::LazyLock;

impl Pieces {
    /// Makes a model of an envelope, part 0, and its skin, part 1, whose rest pose is exact: every
    /// coefficient is a multiple of 1/64, and the rows of c1 and c2 together give [I | 0] for d =
    /// I, q = rest. Kernel maps are those of [`sample_groups`]. Joint k has a stretch range of
    /// k mod 3 quarters.
    ///
    /// # Panics
    /// If the order of sections differs from FORMAT.md.
    pub fn sample(predictor: Predictor, shape: Shape) -> Self {
        let mut rng = Rng(7);
        let reconstructs = predictor != Predictor::Kernel;
        let palette_len = if reconstructs { 0 } else { shape.joints } + shape.proxies;
        let skin = skin(shape, palette_len, &mut rng);
        let envelope = envelope(predictor, shape, &mut rng);
        let written = envelope.iter().chain(&skin).map(|(kind, _)| *kind);
        // Sections of shapes come last: see [`Pieces::set_shapes`].
        let of_skin = SKIN_SECTIONS.into_iter().take(skin.len());
        assert!(written.eq(ENVELOPE_SECTIONS.into_iter().chain(of_skin)));
        let envelope = envelope.into_iter().filter(|(kind, _)| has(predictor, shape, *kind));
        let skin = skin.into_iter().filter(|(kind, _)| match kind {
            SectionKind::RestTangents => shape.tangents,
            SectionKind::TangentCoefficients => shape.coefficients && shape.influences > 1,
            SectionKind::NormalErrors => shape.coefficients,
            _ => true,
        });
        let content = |part, kind, bytes| {
            // These sections are optional, so readers may ignore them.
            let may_lack = [
                SectionKind::HelperPlaces,
                SectionKind::RestTangents,
                SectionKind::TangentCoefficients,
                SectionKind::NormalErrors,
            ];
            let flags = u8::from(!may_lack.contains(&kind));
            Content { flags, ..Content::new(kind, part, bytes) }
        };
        let envelope = envelope.map(|(kind, bytes)| content(0, kind, bytes));
        let mut pieces = Self {
            head: head::SOUND,
            parts: [PartKind::Envelope, PartKind::Skin].map(required).to_vec(),
            sections: envelope.chain(skin.map(|(kind, bytes)| content(1, kind, bytes))).collect(),
        };
        if predictor != Predictor::Rotational {
            pieces.set_groups(&sample_groups(shape));
        }
        pieces
    }

    /// Returns the model of the shape [`SMALL`]. The model is made once, because that takes seconds
    /// under Miri.
    ///
    /// # Panics
    /// As [`Pieces::sample`] does.
    pub fn small(predictor: Predictor) -> Self {
        static MADE: LazyLock<[Pieces; 2]> =
            LazyLock::new(|| Predictor::ALL.map(|predictor| Pieces::sample(predictor, SMALL)));
        let mut found = Predictor::ALL.iter().zip(&*MADE).filter(|(own, _)| **own == predictor);
        found.next().expect("every predictor has a sample").1.clone()
    }

    /// Makes a file of one skin that follows no envelope.
    ///
    /// # Panics
    /// As [`Pieces::sample`] does.
    pub fn loose(shape: Shape) -> Self {
        let mut pieces = Self::sample(Predictor::Rotational, shape);
        pieces.loosen();
        *pieces.section(SectionKind::Names) = names("eye", &["white".into(), "iris".into()]);
        pieces
    }

    /// Makes two envelopes and three skins: arm and sleeve, arm and sleeve of the kernel predictor,
    /// and an eye that follows no envelope.
    ///
    /// # Panics
    /// As [`Pieces::sample`] does.
    pub fn several() -> Self {
        let mut pieces = Self::small(Predictor::Rotational);
        pieces.append(Self::small(Predictor::Kernel));
        pieces.append(Self::loose(Shape { vertices: 3, ..SMALL }));
        pieces
    }
}

/// Draws a direction that mostly points up.
pub fn direction(rng: &mut Rng) -> [f32; 3] {
    unit([rng.unit(), rng.unit(), rng.unit() + 1.5])
}

fn unit(v: [f32; 3]) -> [f32; 3] {
    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    v.map(|x| x / length)
}

/// Makes a vector perpendicular to a normal, of length 1.
fn across(v: [f32; 3], normal: [f32; 3]) -> [f32; 3] {
    let along = v.iter().zip(normal).map(|(x, n)| x * n).sum::<f32>();
    unit([0, 1, 2].map(|c| v[c] - along * normal[c]))
}

/// Kind and bytes of a section.
type Written = (SectionKind, Vec<u8>);

fn required(kind: PartKind) -> PartRow {
    PartRow { kind: kind.number(), flags: 1 }
}

/// Returns whether an envelope has a section, by FORMAT.md's table.
fn has(predictor: Predictor, shape: Shape, kind: SectionKind) -> bool {
    match kind {
        SectionKind::StretchRanges => shape.stretches,
        SectionKind::KeyStretches => shape.stretches && predictor != Predictor::Kernel,
        SectionKind::CurveRanges => curve_len(predictor, shape) > 0,
        SectionKind::Keys | SectionKind::C1 | SectionKind::C2 => predictor != Predictor::Kernel,
        SectionKind::Origins | SectionKind::Groups | SectionKind::Corrections => {
            predictor != Predictor::Rotational
        }
        _ => true,
    }
}

fn curve_len(predictor: Predictor, shape: Shape) -> usize {
    if predictor == Predictor::Kernel { shape.curves } else { 0 }
}

/// Draws a multiple of 1/64.
fn dyadic(rng: &mut Rng, scale: f32) -> f32 {
    (rng.unit() * scale * 64.0).round() / 64.0
}

/// Makes the sections of a skin that follows part 0. The skin has two ranges with a gap between;
/// the second is empty if there are few vertices.
fn skin(shape: Shape, palette_len: usize, rng: &mut Rng) -> Vec<Written> {
    let Shape { vertices: v, influences: k, .. } = shape;
    let positions = (0..3 * v).map(|_| dyadic(rng, 2.0)).collect::<Vec<_>>();
    let normals = (0..v).map(|_| direction(rng)).collect::<Vec<_>>();
    let tangents = normals.iter().flat_map(|normal| {
        let [x, y, z] = across(direction(rng), *normal);
        [x, y, z, if rng.unit() < 0.0 { -1.0 } else { 1.0 }]
    });
    let tangents = tangents.collect::<Vec<_>>();
    let (cut, end) = (v as u32 / 2, v as u32);
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
    // Without others the section is left out.
    let others = k.saturating_sub(1).max(1);
    let pairs = halves(&tangent_coefficients(v * others));
    vec![
        // V, K, the envelope, R, and no shapes.
        (SectionKind::SkinCounts, words(&[end, k as u32, 0, 2, 0, 0, 0])),
        (SectionKind::Names, names("sleeve", &["upper".into(), "lower".into()])),
        (SectionKind::RestPositions, eights(&floats(&positions), 3, 4)),
        (SectionKind::RestNormals, eights(&floats(normals.as_flattened()), 3, 4)),
        (SectionKind::RestTangents, eights(&floats(&tangents), 4, 4)),
        (SectionKind::InfluenceIndices, eights(&halves(&indices), k, 2)),
        (SectionKind::InfluenceWeights, eights(&floats(&weights), k, 4)),
        (SectionKind::RestBoxes, floats(boxes.as_flattened())),
        (SectionKind::Ranges, words(&[0, cut, end.min(cut + 1), end])),
        (SectionKind::TangentCoefficients, eights(&pairs, others, 4)),
        // Errors of the model, of its palette with cofactors, and of linear blend skinning.
        (SectionKind::NormalErrors, floats(&[0.03125, 0.0625, 0.125])),
    ]
}

/// Makes `pair_len` pairs of tangent coefficients in f16, with magnitudes from 2^-5 to 4, and a few
/// zeros.
fn tangent_coefficients(pair_len: usize) -> Vec<u16> {
    // A separate generator, so that the rest of a sample does not depend on these draws.
    let mut rng = Rng(11);
    let half = |rng: &mut Rng| {
        let x = rng.unit();
        let (sign, bits) = (u16::from(x < 0.0) << 15, (x.abs() * 7168.0) as u16);
        if bits % 9 == 4 { sign } else { sign | ((10 << 10) + bits) }
    };
    (0..2 * pair_len).map(|_| half(&mut rng)).collect()
}

/// Makes every section that an envelope may have; the sections of groups stay empty.
fn envelope(predictor: Predictor, shape: Shape, rng: &mut Rng) -> Vec<Written> {
    let Shape { joints: j, proxies: p, .. } = shape;
    let (root, c) = (1.min(j.saturating_sub(1)), curve_len(predictor, shape));
    let order = evaluation_order(j);
    let mut parents = vec![NO_JOINT; j];
    let mut ranks = vec![0; j];
    for (rank, &joint) in order.iter().enumerate() {
        ranks[joint] = rank as u16;
        if rank > 0 {
            parents[joint] = order[rank - 1] as u16;
        }
    }
    let order = order.iter().map(|&joint| joint as u16).collect::<Vec<_>>();
    // Joints lie along x, one unit apart, without rotation.
    let inverse_binds = ranks.iter().flat_map(|&rank| {
        [[1.0, 0.0, 0.0, -f32::from(rank)], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]
    });
    let inverse_binds = inverse_binds.flatten().collect::<Vec<_>>();
    let origins = ranks.iter().flat_map(|&rank| [f32::from(rank), 0.0, 0.0]).collect::<Vec<_>>();
    let joint_names = (0..j).map(|joint| format!("joint {joint}"));
    let all_names = joint_names.chain((0..c).map(|curve| format!("curve {curve}")));
    let all_names = all_names.collect::<Vec<_>>();
    let keys = keys(shape, rng);
    let [c1, c2] = coefficients(shape, root, rng);
    let stretch_ranges = (0..j).map(|joint| 0.25 * (joint % 3) as f32).collect::<Vec<_>>();
    let key_stretches = (0..36 * p).map(|_| dyadic(rng, 0.25)).collect::<Vec<_>>();
    let curve_range = |curve: usize| [[0.0, 1.0], [-0.5, 0.5], [0.25, 2.0]][curve % 3];
    let curve_ranges = (0..c).flat_map(curve_range).collect::<Vec<_>>();
    // Centres lie along x, as the joints do.
    let place = |l: usize| [0.5 + l as f32, 0.25, -0.125, 0.5, 0.125, -0.0625, 0.375, 0.0, 0.25];
    let places = (0..p).flat_map(place).collect::<Vec<_>>();
    // Predictor with the kind of helpers, J, P, root, G, floats of scratch, whether joints stretch, C.
    let stretches = shape.stretches.into();
    let [number, j32, p32] = [predictor.number().into(), j as u32, p as u32];
    let kind = if predictor == Predictor::Kernel { shape.kind } else { HelperKind::Affine };
    let number = number + u32::from(kind.number());
    let counts = [number, j32, p32, root as u32, 0, 0, stretches, c as u32];
    // Diagonal; RMS errors of training, of cross-validation, of linear blend skinning, of rounding,
    // of the base, of another clip; largest error of bones.
    let certificate = [3.0, 0.01, 0.02, 0.04, 0.0, 0.03, 0.05, 0.06];
    vec![
        (SectionKind::EnvelopeCounts, words(&counts)),
        (SectionKind::Certificate, floats(&certificate)),
        (SectionKind::Names, names("arm", &all_names)),
        (SectionKind::Hierarchy, halves(&[parents, order, ranks].concat())),
        (SectionKind::InverseBinds, floats(&inverse_binds)),
        (SectionKind::Keys, keys),
        (SectionKind::C1, blocks(&c1)),
        (SectionKind::C2, blocks(&c2)),
        (SectionKind::PoseRanges, floats(&[vec![1.5; j], vec![0.125; j]].concat())),
        (SectionKind::Origins, floats(&origins)),
        (SectionKind::Groups, Vec::new()),
        (SectionKind::Corrections, Vec::new()),
        (SectionKind::StretchRanges, floats(&stretch_ranges)),
        (SectionKind::KeyStretches, floats(&key_stretches)),
        (SectionKind::CurveRanges, floats(&curve_ranges)),
        (SectionKind::HelperPlaces, floats(&places)),
    ]
}

/// Lists joints in evaluation order: root 1, its child 2, then 0, then the rest in order.
fn evaluation_order(joint_len: usize) -> Vec<usize> {
    match joint_len {
        0 => Vec::new(),
        1 => vec![0],
        2 => vec![1, 0],
        _ => [1, 2, 0].into_iter().chain(3..joint_len).collect(),
    }
}

/// Makes a key for each proxy; every second key has a residual joint.
fn keys(shape: Shape, rng: &mut Rng) -> Vec<u8> {
    let Shape { joints: j, proxies: p, .. } = shape;
    let mut keys = Vec::new();
    for proxy in 0..p {
        // A kernel sample without joints drops the keys.
        let joint = |proxy: usize| (proxy % j.max(1)) as u16;
        let residual = if proxy % 2 == 0 { NO_JOINT } else { joint(proxy) };
        keys.extend(halves(&[joint(proxy + 2), residual]));
        let matrices = (0..54).map(|at| {
            if at % 18 == 0 { 0.5 } else { dyadic(rng, if at < 18 { 0.5 } else { 0.1 }) }
        });
        keys.extend(floats(&matrices.collect::<Vec<_>>()));
    }
    keys
}

/// Makes c1 and c2. The root's block compensates for the other blocks, so that rest stays rest.
fn coefficients(shape: Shape, root: usize, rng: &mut Rng) -> [Vec<Vec<f32>>; 2] {
    let Shape { joints: j, proxies: p, .. } = shape;
    let mut c1 = vec![vec![0.0; 3 * p]; 4 * p];
    let mut c2 = vec![vec![0.0; 4 * j]; 4 * p];
    for (row, (c1, c2)) in c1.iter_mut().zip(&mut c2).enumerate() {
        for x in c1.iter_mut().chain(c2.iter_mut()) {
            *x = dyadic(rng, 0.25);
        }
        for c in 0..3 {
            let rest = c1.iter().skip(c).step_by(3).chain(c2.iter().skip(c).step_by(4));
            let excess = rest.sum::<f32>() - if row % 4 == c { 1.0 } else { 0.0 };
            if let Some(own) = c2.get_mut(4 * root + c) {
                *own -= excess;
            }
        }
    }
    [c1, c2]
}
