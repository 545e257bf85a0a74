//! Layouts, ranges and shortcuts give the bits of the plain call, and touch nothing else.

use super::correction::base_of;
use super::features::features_of;
use super::skin::{Skinned, places, plain, skinned_by, whole_of};
use crate::backend::{Backend, Buffers, Failure, attributes, floats};
use crate::compare::POISON;
use crate::finding::Finding;
use crate::subject::Subject;
use sinew_gpu::layout::{Attribute, Buffer, Resource, Skin, Stage};
use sinew_runtime::{Envelope, Matrix3x4};
use std::ops::Range;

/// Compares palettes made stage by stage, and skins laid out otherwise: equal or not.
///
/// # Errors
/// What the backend refuses; [`Failure::Touched`] if a float between attributes is written to.
pub fn body(backend: &dyn Backend, subject: &Subject<'_>) -> Result<Vec<Finding>, Failure> {
    let (envelope, n) = (&subject.loaded.envelope, subject.poses.len());
    let whole = whole_of(backend, subject)?;
    let [mut palettes, mut confidences, mut skins] =
        ["palettes by stages", "confidences by stages", "skins otherwise"].map(Finding::new);
    let (found, certain) = by_stages(backend, subject)?;
    palettes.equal(floats(&found), floats(&whole.palettes));
    confidences.equal(&certain, &whole.confidences);
    let plain_layout = plain(envelope);
    let plain = skinned_by(backend, subject, &whole.palettes)?;
    let end_to_end = Skinned::gather(&whole.skin, &plain_layout, n);
    same(&mut skins, &end_to_end, &plain);
    untouched(&whole.skin, &[plain_layout], n)?;
    for layout in layouts(envelope, n) {
        let skinned = pieces(backend, subject, &whole.palettes, &layout)?;
        let only = |list: &Vec<f32>, wanted: bool| if wanted { list.clone() } else { Vec::new() };
        let expected = Skinned {
            positions: only(&plain.positions, layout[0].positions.is_some()),
            normals: only(&plain.normals, layout[0].normals.is_some()),
            tangents: only(&plain.tangents, layout[0].tangents.is_some()),
        };
        same(&mut skins, &skinned, &expected);
    }
    Ok(vec![palettes, confidences, skins])
}

/// Evaluates palettes and confidences stage by stage.
fn by_stages(
    backend: &dyn Backend,
    subject: &Subject<'_>,
) -> Result<(Vec<Matrix3x4>, Vec<f32>), Failure> {
    let n = subject.poses.len();
    let (mut palettes, mut confidences) = (base_of(backend, subject)?, vec![POISON; n]);
    let (loaded, poses) = (&subject.loaded, &subject.maps);
    if !loaded.envelope.predictor().corrects() {
        let rotations = super::gradients::gradients_of(backend, subject)?.rotations;
        backend.confidence(loaded, &rotations, &mut confidences)?;
    } else if backend.has(loaded, Stage::Correction) {
        let features = features_of(backend, subject)?;
        backend.correction(loaded, poses, &features, &mut palettes, &mut confidences)?;
    } else {
        // Nothing is added, and nothing is in doubt.
        confidences.fill(1.0);
    }
    Ok((palettes, confidences))
}

/// Lists layouts, each as the pieces that the mesh is skinned in: positions alone; interleaved with
/// gaps and in pieces; instance by instance within each vertex.
fn layouts(envelope: &Envelope<'_>, n: usize) -> [Vec<Skin>; 4] {
    let vertex_len = envelope.vertex_len();
    let attribute = |buffer, offset, stride, instance_stride| {
        Some(Attribute { buffer, offset, stride, instance_stride })
    };
    let positions = Skin {
        vertices: 0..vertex_len,
        positions: attribute(Buffer::B, 0, 3, 3 * vertex_len),
        normals: None,
        tangents: None,
    };
    let interleaved = |vertices: Range<usize>| {
        let at =
            |offset| attribute(Buffer::A, offset + 13 * vertices.start, 13, 13 * vertex_len + 4);
        let tangents = at(8).filter(|_| envelope.has_tangents());
        Skin { positions: at(1), normals: at(5), tangents, vertices }
    };
    let within = Skin {
        vertices: 0..vertex_len,
        positions: attribute(Buffer::B, 2, 3 * n, 3),
        normals: attribute(Buffer::A, 0, 7 * n + 1, 7),
        tangents: attribute(Buffer::A, 3, 7 * n + 1, 7).filter(|_| envelope.has_tangents()),
    };
    let pieces = cuts(vertex_len).map(interleaved).to_vec();
    [vec![positions], vec![interleaved(0..vertex_len)], pieces, vec![within]]
}

/// Cuts a mesh: none, one, an odd number, the rest.
fn cuts(vertex_len: usize) -> [Range<usize>; 6] {
    let (one, some) = (1.min(vertex_len), (vertex_len / 2) | 1);
    let some = some.clamp(one, vertex_len);
    [0..0, 0..one, one..some, some..some, some..vertex_len, vertex_len..vertex_len]
}

/// Skins the mesh piece by piece, and gathers it.
fn pieces(
    backend: &dyn Backend,
    subject: &Subject<'_>,
    palettes: &[Matrix3x4],
    pieces: &[Skin],
) -> Result<Skinned, Failure> {
    let n = subject.poses.len();
    let all = Skin { vertices: 0..subject.loaded.envelope.vertex_len(), ..pieces[0].clone() };
    let mut out = Buffers::poisoned(&all, n);
    for piece in pieces {
        backend.skin(&subject.loaded, palettes, piece, &mut out)?;
    }
    untouched(&out, pieces, n)?;
    Ok(Skinned::gather(&out, &all, n))
}

/// Checks that every float which is no attribute's is as it was.
fn untouched(out: &Buffers, pieces: &[Skin], n: usize) -> Result<(), Failure> {
    for (buffer, resource, floats) in
        [(Buffer::A, Resource::OutA, &out.a), (Buffer::B, Resource::OutB, &out.b)]
    {
        let mut own = vec![false; floats.len()];
        for skin in pieces {
            for (attribute, len) in attributes(skin) {
                let Some(attribute) = attribute.filter(|own| own.buffer == buffer) else {
                    continue;
                };
                for start in places(&attribute, skin, n) {
                    own[start..start + len].fill(true);
                }
            }
        }
        let changed = |(x, own): (&f32, bool)| !own && x.to_bits() != POISON.to_bits();
        if let Some(float) = floats.iter().zip(own).position(changed) {
            let (stage, resource) = (Stage::Skin.name(), resource.name());
            return Err(Failure::Touched { stage, resource, float });
        }
    }
    Ok(())
}

fn same(finding: &mut Finding, found: &Skinned, expected: &Skinned) {
    for (found, expected) in [
        (&found.positions, &expected.positions),
        (&found.normals, &expected.normals),
        (&found.tangents, &expected.tangents),
    ] {
        if !expected.is_empty() {
            finding.equal(found, expected);
        }
    }
}
