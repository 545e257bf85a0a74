//! Palettes and skins of frames of the examples, computed by the runtime.

use crate::Error;
use crate::examples::{self, Examples};
use sinew_runtime::skin::Output;
use sinew_runtime::{Envelope, Matrix3x4, Skin, SkinJob};

/// Lists the rest positions of a skin, V.
pub fn rest(skin: &Skin<'_>) -> Vec<[f64; 3]> {
    let position = |vertex| skin.rest_position(vertex).unwrap_or_default().map(f64::from);
    (0..skin.vertex_len()).map(position).collect()
}

/// Lists the influences of each vertex of a skin with a weight above 0, V lists of palette index and weight.
pub fn influences(skin: &Skin<'_>) -> Vec<Vec<(usize, f64)>> {
    let of = |vertex| skin.influences(vertex).filter(|&(_, weight)| weight > 0.0);
    let wide = |(index, weight): (usize, f32)| (index, f64::from(weight));
    (0..skin.vertex_len()).map(|vertex| of(vertex).map(wide).collect()).collect()
}

/// What moves a skin in a frame, for the runtime: J skinning matrices and C curves.
pub struct Pose {
    joints: Vec<Matrix3x4>,
    curves: Vec<f32>,
}

impl Pose {
    /// Converts the pose of a frame of the examples for an envelope, which may have fewer curves and no joints.
    pub fn of(envelope: &Envelope<'_>, examples: &Examples, frame: usize) -> Self {
        let curves = curves_of(envelope, examples, frame);
        Self::new(envelope, examples.pose(frame), &curves)
    }

    /// Converts J transforms and C curves.
    pub fn new(envelope: &Envelope<'_>, joints: &[examples::Matrix3x4], curves: &[f64]) -> Self {
        let joints = joints.iter().take(envelope.joint_len());
        Self {
            joints: joints.map(|m| m.map(|row| row.map(|x| x as f32))).collect(),
            curves: curves.iter().map(|value| *value as f32).collect(),
        }
    }
}

/// Picks the curves of an envelope, by name; 0 for a curve that the examples lack.
pub fn curves_of(envelope: &Envelope<'_>, examples: &Examples, frame: usize) -> Vec<f64> {
    let values = examples.curves_of(frame);
    let value = |curve: usize| {
        let name = envelope.curve_name(curve).unwrap_or_default();
        let place = examples.curve_names.iter().position(|own| own == name);
        place.map_or(0.0, |place| values[place])
    };
    (0..envelope.curve_len()).map(value).collect()
}

/// Computes the palette of a pose and its confidence.
///
/// - `frame`: frame index for errors.
///
/// # Errors
/// The runtime refuses the pose; the error has the frame.
pub fn palette(
    envelope: &Envelope<'_>,
    pose: &Pose,
    frame: usize,
) -> Result<(Vec<Matrix3x4>, f32), Error> {
    let mut scratch = vec![0.0; envelope.scratch_len()];
    let mut palette = vec![Matrix3x4::default(); envelope.palette_len()];
    let confidence = envelope
        .palette(&pose.joints, &pose.curves, &mut scratch, &mut palette)
        .map_err(|error| Error::from(error).in_frame(frame))?;
    Ok((palette, confidence))
}

/// Computes the confidence of each joint in a frame of the examples, J; `None` if the envelope has no kernel maps.
pub fn joint_confidences(
    envelope: &Envelope<'_>,
    examples: &Examples,
    frame: usize,
) -> Option<Vec<f32>> {
    let mut scratch = vec![0.0; envelope.scratch_len()];
    let mut found = vec![1.0; envelope.joint_len()];
    let Pose { joints, curves } = Pose::of(envelope, examples, frame);
    let done = envelope.joint_confidences(&joints, &curves, &mut scratch, &mut found);
    done.ok().map(|()| found)
}

/// Skins a mesh by the palette of a frame. Returns positions and normals, 3V floats each.
///
/// # Errors
/// The runtime refuses the palette; the error has the frame.
pub fn skin_on(
    skin: &Skin<'_>,
    palette: &[Matrix3x4],
    frame: usize,
) -> Result<[Vec<f32>; 2], Error> {
    let [mut positions, mut normals] = [0, 1].map(|_| vec![0.0; 3 * skin.vertex_len()]);
    SkinJob::new(*skin, palette)
        .positions(Output::new(&mut positions, 3))
        .normals(Output::new(&mut normals, 3))
        .run()
        .map_err(|error| Error::from(error).in_frame(frame))?;
    Ok([positions, normals])
}
