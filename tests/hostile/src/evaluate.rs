//! Everything that an accepted file offers, evaluated and held to what the runtime promises.

use crate::poses::pose;
use sinew_runtime::envelope::{Attribute, Bounds, Buffer, SkinJob};
use sinew_runtime::format::{PartKind, SectionKind};
use sinew_runtime::{Envelope, EvalError, Matrix3x4, Model};
use std::ops::Range;

/// Reads all that a model's accessors give.
///
/// # Panics
/// Where an accessor lacks what a loaded model must have, or where the model asks for more work or
/// memory than a file of its length may: every loop of loading and evaluating runs over these counts
/// or over bytes of the file.
pub fn read(model: &Model<'_>, file_bytes: usize) {
    assert!(model.sections().all(|section| section.bytes.len() == section.row.bytes as usize));
    for envelope in envelopes(model) {
        let (joint_len, palette_len) = (envelope.joint_len(), envelope.palette_len());
        assert_eq!(envelope.evaluation_order().count(), joint_len);
        for joint in 0..joint_len {
            assert!(envelope.joint_name(joint).is_some() && envelope.inverse_bind(joint).is_some());
            assert!(envelope.parent(joint).is_none_or(|parent| parent < joint_len));
        }
        let (v, k) = (envelope.vertex_len(), envelope.influence_len());
        for cost in [24 * v, 6 * v * k, 58 * joint_len, 24 * palette_len, envelope.workspace_len()]
        {
            assert!(cost <= file_bytes, "a file of {file_bytes} bytes costs {cost}");
        }
        let reconstructs = envelope.predictor().reconstructs();
        assert!((0..envelope.proxy_len()).all(|l| envelope.key(l).is_some() == reconstructs));
        assert_eq!(envelope.groups().count(), envelope.group_len());
        for vertex in 0..envelope.vertex_len() {
            assert!(envelope.influences(vertex).all(|(index, _)| index < palette_len));
        }
    }
}

/// Evaluates every envelope of a model over poses within its certificate's ranges, by the numbers of
/// [`pose`].
///
/// # Panics
/// Where a call is refused, a result is not finite, a confidence is outside 0 and 1, or a vertex
/// outside its bounds.
pub fn evaluate(model: &Model<'_>, numbers: Range<usize>) {
    for envelope in envelopes(model) {
        for number in numbers.clone() {
            evaluate_pose(&envelope, number, &pose(&envelope, number));
        }
    }
}

/// Finds every envelope by its name; of several with one name, the first.
fn envelopes<'a>(model: &Model<'a>) -> impl Iterator<Item = Envelope<'a>> + use<'a> {
    let model = *model;
    let parts: Vec<_> = model.parts().collect();
    let names = model.sections().filter(|s| s.row.kind == SectionKind::Names.number());
    names.filter_map(move |names| {
        let part = parts.get(usize::from(names.row.part))?;
        if part.kind != PartKind::Envelope.number() {
            return None;
        }
        let text = names.bytes.get(4 * (part.envelope_counts().joint_len as usize + 1)..)?;
        let end = u32::from_le_bytes(*names.bytes.first_chunk()?) as usize;
        let name = std::str::from_utf8(text.get(..end)?).ok()?;
        let found = model.envelope_named(name);
        assert!(found.is_some(), "no envelope is named {name:?}");
        found
    })
}

/// Evaluates one pose; its number tells it from others.
///
/// # Panics
/// As [`evaluate`] does.
pub fn evaluate_pose(envelope: &Envelope<'_>, number: usize, pose: &[Matrix3x4]) {
    let check = |what: &str, values: &[f32]| {
        let unsound = values.iter().position(|x| !x.is_finite());
        assert!(unsound.is_none(), "pose {number}: {what} {unsound:?} is not finite");
    };
    check("pose", pose.as_flattened().as_flattened());
    let found = match evaluated(envelope, pose) {
        Ok(found) => found,
        Err(error) => panic!("pose {number}: {error}"),
    };
    let Evaluated { confidence, palette, skin, bounds } = found;
    assert!((0.0..=1.0).contains(&confidence), "pose {number}: confidence {confidence}");
    check("palette", palette.as_flattened().as_flattened());
    if let Some(bounds) = bounds {
        check("bounds", &[bounds.min, bounds.max].concat());
    }
    for (vertex, values) in skin.chunks_exact(stride(envelope.has_tangents())).enumerate() {
        check("vertex", values);
        let position = [values[0], values[1], values[2]];
        let within = bounds.is_some_and(|bounds| bounds.contains(position));
        assert!(within, "pose {number}: vertex {vertex} at {position:?} is outside {bounds:?}");
    }
}

/// What the runtime computes of a pose.
pub(crate) struct Evaluated {
    pub(crate) confidence: f32,
    pub(crate) palette: Vec<Matrix3x4>,
    /// Position, normal and, where there are any, tangent of each vertex; not a number where nothing was
    /// written.
    pub(crate) skin: Vec<f32>,
    pub(crate) bounds: Option<Bounds>,
}

/// Evaluates one pose.
pub(crate) fn evaluated(
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
) -> Result<Evaluated, EvalError> {
    let mut workspace = vec![f32::NAN; envelope.workspace_len()];
    let mut palette = vec![[[f32::NAN; 4]; 3]; envelope.palette_len()];
    let confidence = envelope.palette(pose, &mut workspace, &mut palette)?;
    let has_tangents = envelope.has_tangents();
    let stride = stride(has_tangents);
    let mut skin = vec![f32::NAN; stride * envelope.vertex_len()];
    let attribute = |offset| Some(Attribute { buffer: Buffer::A, offset, stride });
    SkinJob {
        envelope: *envelope,
        palette: &palette,
        vertices: 0..envelope.vertex_len(),
        positions: attribute(0),
        normals: attribute(3),
        tangents: attribute(6).filter(|_| has_tangents),
        out_a: &mut skin,
        out_b: &mut [],
    }
    .run()?;
    let bounds = envelope.bounds(&palette)?;
    Ok(Evaluated { confidence, palette, skin, bounds })
}

/// Returns the floats of a vertex in the skin.
pub(crate) const fn stride(has_tangents: bool) -> usize {
    if has_tangents { 10 } else { 6 }
}
