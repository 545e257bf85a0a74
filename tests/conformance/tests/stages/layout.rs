//! Layouts, ranges and shortcuts give the bits of the plain call, and touch nothing else.

use crate::Subject;
use crate::correction::base_of;
use crate::features::features_of;
use crate::skin::{Skin, palette_of, skin};
use conformance::backend::Backend;
use conformance::compare::{Mismatch, poisoned, same_bits};
use sinew_runtime::envelope::{Attribute, Buffer, SkinJob};
use sinew_runtime::{Envelope, Matrix3x4};
use std::ops::Range;

/// Floats from a vertex to the next in the interleaved buffer, and where in it attributes start.
const STRIDE: usize = 13;
const POSITION: usize = 1;
const NORMAL: usize = 5;
const TANGENT: usize = 8;

/// Nothing is measured: what is compared is equal or not.
pub(crate) fn body(backend: &impl Backend, subject: &Subject<'_>) -> Result<[f64; 0], Mismatch> {
    let envelope = &subject.envelope;
    for pose in subject.poses.iter().take(28) {
        let (palette, _) = palette_of(backend, envelope, &pose.maps);
        same_palette_by_stages(backend, envelope, &pose.maps, &palette)?;
        let plain = skin(backend, envelope, &palette);
        let positions = positions_alone(backend, envelope, &palette);
        same_bits(positions.as_flattened(), plain.positions.as_flattened())?;
        for cuts in cuts(envelope.vertex_len()) {
            same_interleaved(backend, envelope, &palette, &cuts, &plain)?;
        }
    }
    Ok([])
}

fn same_palette_by_stages(
    backend: &impl Backend,
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
    whole: &[Matrix3x4],
) -> Result<(), Mismatch> {
    let mut palette = base_of(backend, envelope, pose);
    if envelope.predictor().corrects() {
        let features = features_of(backend, envelope, pose);
        let run = backend.correction(envelope, pose, &features, &mut palette);
        run.expect("the lengths are right");
    }
    same_bits(palette.as_flattened().as_flattened(), whole.as_flattened().as_flattened())
}

fn positions_alone(
    backend: &impl Backend,
    envelope: &Envelope<'_>,
    palette: &[Matrix3x4],
) -> Vec<[f32; 3]> {
    let mut positions = poisoned::<3>(envelope.vertex_len());
    let job = SkinJob {
        envelope: *envelope,
        palette,
        vertices: 0..envelope.vertex_len(),
        positions: Some(Attribute { buffer: Buffer::B, offset: 0, stride: 3 }),
        normals: None,
        tangents: None,
        out_a: &mut [],
        out_b: positions.as_flattened_mut(),
    };
    backend.skin(job).expect("the buffer is long enough");
    positions
}

/// The whole, and pieces of it: none, one, an odd number, the rest.
fn cuts(vertex_len: usize) -> [Vec<Range<usize>>; 2] {
    let (one, some) = (1.min(vertex_len), (vertex_len / 2) | 1);
    let some = some.clamp(one, vertex_len);
    let pieces = [0..0, 0..one, one..some, some..some, some..vertex_len, vertex_len..vertex_len];
    [std::iter::once(0..vertex_len).collect(), pieces.to_vec()]
}

fn same_interleaved(
    backend: &impl Backend,
    envelope: &Envelope<'_>,
    palette: &[Matrix3x4],
    ranges: &[Range<usize>],
    plain: &Skin,
) -> Result<(), Mismatch> {
    let mut out = poisoned::<STRIDE>(envelope.vertex_len());
    let attribute = |offset| Some(Attribute { buffer: Buffer::A, offset, stride: STRIDE });
    for range in ranges {
        let job = SkinJob {
            envelope: *envelope,
            palette,
            vertices: range.clone(),
            positions: attribute(POSITION),
            normals: attribute(NORMAL),
            tangents: attribute(TANGENT).filter(|_| envelope.has_tangents()),
            out_a: out[range.clone()].as_flattened_mut(),
            out_b: &mut [],
        };
        backend.skin(job).expect("the buffer is long enough");
    }
    let gather = |from: usize, len: usize| -> Vec<f32> {
        out.iter().flat_map(|vertex| vertex[from..from + len].iter().copied()).collect()
    };
    same_bits(&gather(POSITION, 3), plain.positions.as_flattened())?;
    same_bits(&gather(NORMAL, 3), plain.normals.as_flattened())?;
    if envelope.has_tangents() {
        same_bits(&gather(TANGENT, 4), plain.tangents.as_flattened())?;
    }
    let written = |float: usize| {
        let tangent = envelope.has_tangents() && (TANGENT..TANGENT + 4).contains(&float);
        (POSITION..POSITION + 3).contains(&float)
            || (NORMAL..NORMAL + 3).contains(&float)
            || tangent
    };
    for float in (0..STRIDE).filter(|&float| !written(float)) {
        assert!(
            gather(float, 1).iter().all(|x| x.is_nan()),
            "float {float} lies between attributes"
        );
    }
    Ok(())
}

#[test]
fn a_mesh_without_vertices_has_a_palette_and_nothing_to_skin() {
    use conformance::backend::Cpu;
    use conformance::models::{self, SHAPES};
    for shape in SHAPES.into_iter().filter(|shape| shape.vertices == 0) {
        let bytes = models::random(shape);
        let subject = Subject::new("nothing", &bytes, 14);
        assert!(!shape.predictor.reconstructs() || crate::palette::body(&Cpu, &subject).is_ok());
        assert!(!shape.predictor.corrects() || crate::correction::body(&Cpu, &subject).is_ok());
        let (palette, _) = palette_of(&Cpu, &subject.envelope, &subject.poses[0].maps);
        assert!(skin(&Cpu, &subject.envelope, &palette).positions.is_empty());
        assert_eq!(subject.envelope.bounds(&palette).unwrap(), None);
        assert_eq!(crate::skin::body(&Cpu, &subject), Err(Mismatch::Empty), "it proves nothing");
    }
}
