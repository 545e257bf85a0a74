//! Stage 3: on the palette that the pose has.

use crate::Subject;
use conformance::backend::{Backend, poisoned_palette};
use conformance::compare::{Mismatch, poisoned, within};
use conformance::poses::widened;
use conformance::tolerance::{self, Inexact, Map, UNDERFLOW};
use sinew_runtime::envelope::{Attribute, Buffer, SkinJob};
use sinew_runtime::{Envelope, Matrix3x4};
use sinew_trainer::envelope::oracle::Oracle;

/// Every attribute of every vertex, each in a run of its own.
pub(crate) struct Skin {
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) normals: Vec<[f32; 3]>,
    /// Empty if the model has none.
    pub(crate) tangents: Vec<[f32; 4]>,
}

/// Largest ratios: positions, normals, tangents.
pub(crate) fn body(backend: &impl Backend, subject: &Subject<'_>) -> Result<[f64; 3], Mismatch> {
    let Subject { envelope, oracle, poses, .. } = subject;
    let mut worst = [0.0_f64; 3];
    for pose in poses {
        let (palette, _) = palette_of(backend, envelope, &pose.maps);
        let found = skin(backend, envelope, &palette);
        let palette = Inexact::exact(palette.iter().map(widened).collect());
        let ratios = skin_within(&found, oracle, &palette)?;
        worst = std::array::from_fn(|i| worst[i].max(ratios[i]));
    }
    Ok(worst)
}

/// Evaluates the palette of a pose, and the confidence in it.
pub(crate) fn palette_of(
    backend: &impl Backend,
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
) -> (Vec<Matrix3x4>, f32) {
    let mut palette = poisoned_palette(envelope);
    let run = backend.whole_palette(envelope, pose, &mut palette);
    let confidence = run.expect("the pose is finite and the lengths are right");
    (palette, confidence)
}

/// Skins the whole mesh.
pub(crate) fn skin(backend: &impl Backend, envelope: &Envelope<'_>, palette: &[Matrix3x4]) -> Skin {
    let vertex_len = envelope.vertex_len();
    let with_tangents = envelope.has_tangents();
    let mut positions = poisoned::<3>(vertex_len);
    // Normals, then tangents.
    let mut directions =
        poisoned::<1>(3 * vertex_len + if with_tangents { 4 * vertex_len } else { 0 });
    let attribute = |buffer, offset, stride| Some(Attribute { buffer, offset, stride });
    let job = SkinJob {
        envelope: *envelope,
        palette,
        vertices: 0..vertex_len,
        positions: attribute(Buffer::A, 0, 3),
        normals: attribute(Buffer::B, 0, 3),
        tangents: attribute(Buffer::B, 3 * vertex_len, 4).filter(|_| with_tangents),
        out_a: positions.as_flattened_mut(),
        out_b: directions.as_flattened_mut(),
    };
    backend.skin(job).expect("the buffers are long enough");
    let (normals, tangents) = directions.as_flattened().split_at(3 * vertex_len);
    let (normals, tangents) = (normals.as_chunks().0.to_vec(), tangents.as_chunks().0.to_vec());
    Skin { positions, normals, tangents }
}

/// Compares a skin with the oracle's on a palette.
pub(crate) fn skin_within(
    found: &Skin,
    oracle: &Oracle,
    palette: &Inexact<Map>,
) -> Result<[f64; 3], Mismatch> {
    let mut expected = [const { Vec::new() }; 3];
    let mut tolerances = [const { Vec::new() }; 3];
    for vertex in &oracle.vertices {
        let skinned = oracle.skin(vertex, &palette.value);
        let bounds = tolerance::skin(vertex, palette);
        expected[0].extend(&skinned.position);
        tolerances[0].extend(bounds.position.iter().map(|e| e + UNDERFLOW));
        expected[1].extend(&skinned.normal);
        tolerances[1].extend([bounds.normal + UNDERFLOW; 3]);
        if let Some((tangent, hand)) = skinned.tangent {
            expected[2].extend(tangent.push(hand).iter());
            // The handedness is copied.
            let along = bounds.tangent + UNDERFLOW;
            tolerances[2].extend([along, along, along, 0.0]);
        }
    }
    let [positions, normals, tangents] = &expected;
    let tangents = match found.tangents.as_flattened() {
        [] if tangents.is_empty() => 0.0,
        found => within(found, tangents, &tolerances[2])?,
    };
    Ok([
        within(found.positions.as_flattened(), positions, &tolerances[0])?,
        within(found.normals.as_flattened(), normals, &tolerances[1])?,
        tangents,
    ])
}
