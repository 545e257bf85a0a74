//! Other layouts, ranges of vertices, and stages run alone give the bits of the plain call, and
//! change no other float.

use super::correction::base_of;
use super::features::features_of;
use super::polar::split_of;
use super::skin::{Skinned, places, skinned_by, whole_of};
use crate::backend::{Backend, Failure, attributes, floats, poisoned_out};
use crate::compare::POISON;
use crate::finding::Finding;
use crate::subject::Subject;
use sinew_gpu::layout::{Attribute, Resource, SkinBatch, Stage};
use sinew_runtime::{Matrix3x4, Skin};
use std::ops::Range;

/// Compares palettes that are evaluated stage by stage, and skins in other layouts, bit by bit with
/// the plain call.
///
/// # Errors
/// The backend's error; [`Failure::Touched`] if a float between attributes has changed.
pub fn body(backend: &dyn Backend, subject: &Subject<'_>) -> Result<Vec<Finding>, Failure> {
    let (skin, n) = (&subject.loaded.skin, subject.poses.len());
    let whole = whole_of(backend, subject)?;
    let [mut palettes, mut confidences, mut skins] =
        ["palettes by stages", "confidences by stages", "skins otherwise"].map(Finding::new);
    let (found, certain) = by_stages(backend, subject)?;
    palettes.equal(floats(&found), floats(&whole.palettes));
    confidences.equal(&certain, &whole.confidences);
    let plain_layout = SkinBatch::new(skin);
    let plain = skinned_by(backend, subject, &whole.palettes)?;
    let end_to_end = Skinned::gather(&whole.skin, &plain_layout, n);
    same(&mut skins, &end_to_end, &plain);
    untouched(&whole.skin, &[plain_layout], n)?;
    for layout in layouts(skin, n) {
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
    let (loaded, poses) = (&subject.loaded, subject.inputs());
    if !loaded.envelope.predictor().corrects() {
        let rotations = super::gradients::gradients_of(backend, subject)?.rotations;
        let split = split_of(backend, subject)?;
        backend.confidence(loaded, poses, &rotations, &split, &mut confidences)?;
    } else if backend.has(loaded, Stage::Correction) {
        let features = features_of(backend, subject)?;
        backend.correction(loaded, poses, &features, &mut palettes, &mut confidences)?;
    } else {
        // Nothing is added, so the confidence is 1.
        confidences.fill(1.0);
    }
    Ok((palettes, confidences))
}

/// Lists layouts, each as the pieces of the mesh that are skinned: positions alone; interleaved
/// attributes with gaps, whole and in pieces; all instances of a vertex side by side.
fn layouts(skin: &Skin<'_>, n: usize) -> [Vec<SkinBatch>; 4] {
    let vertex_len = skin.vertex_len();
    let attribute =
        |offset, stride, instance_stride| Some(Attribute { offset, stride, instance_stride });
    let whole = SkinBatch::new(skin);
    let positions = SkinBatch {
        positions: attribute(0, 3, 3 * vertex_len),
        normals: None,
        tangents: None,
        ..whole.clone()
    };
    let interleaved = |vertices: Range<usize>| {
        let at = |offset| attribute(offset + 13 * vertices.start, 13, 13 * vertex_len + 4);
        let tangents = at(8).filter(|_| skin.has_tangents());
        SkinBatch { positions: at(1), normals: at(5), tangents, vertices, ..whole.clone() }
    };
    // All instances of a vertex side by side; one unused float between two vertices.
    let at = |offset| attribute(offset, 12 * n + 1, 12);
    let within = SkinBatch {
        positions: at(2),
        normals: at(5),
        tangents: at(8).filter(|_| skin.has_tangents()),
        ..whole.clone()
    };
    let pieces = cuts(vertex_len).map(interleaved).to_vec();
    [vec![positions], vec![interleaved(0..vertex_len)], pieces, vec![within]]
}

/// Cuts a mesh into ranges: empty, one vertex, up to an odd number, and the rest.
fn cuts(vertex_len: usize) -> [Range<usize>; 6] {
    let (one, some) = (1.min(vertex_len), (vertex_len / 2) | 1);
    let some = some.clamp(one, vertex_len);
    [0..0, 0..one, one..some, some..some, some..vertex_len, vertex_len..vertex_len]
}

/// Skins the mesh piece by piece, and gathers the attributes.
fn pieces(
    backend: &dyn Backend,
    subject: &Subject<'_>,
    palettes: &[Matrix3x4],
    pieces: &[SkinBatch],
) -> Result<Skinned, Failure> {
    let n = subject.poses.len();
    let all = SkinBatch { vertices: 0..subject.loaded.skin.vertex_len(), ..pieces[0].clone() };
    let mut out = poisoned_out(&all, n);
    for piece in pieces {
        backend.skin(&subject.loaded, palettes, piece, &mut out)?;
    }
    untouched(&out, pieces, n)?;
    Ok(Skinned::gather(&out, &all, n))
}

/// Checks that every float outside the attributes is unchanged.
fn untouched(out: &[f32], pieces: &[SkinBatch], n: usize) -> Result<(), Failure> {
    let mut own = vec![false; out.len()];
    for skin in pieces {
        for (attribute, len) in attributes(skin) {
            let starts = attribute.iter().flat_map(|attribute| places(attribute, skin, n));
            starts.for_each(|start| own[start..start + len].fill(true));
        }
    }
    let changed = |(x, own): (&f32, bool)| !own && x.to_bits() != POISON.to_bits();
    match out.iter().zip(own).position(changed) {
        None => Ok(()),
        Some(float) => {
            let (stage, resource) = (Stage::Skin.name(), Resource::Out.name());
            Err(Failure::Touched { stage, resource, float })
        }
    }
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
