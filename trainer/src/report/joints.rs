//! Errors by joint: each vertex counts for the joint that LBS lets it follow most.

use super::comparison::Comparison;

/// The vertices of one joint and their errors.
pub(super) struct JointErrors {
    /// The joint.
    pub(super) joint: usize,
    /// Its vertices.
    pub(super) vertices: usize,
    /// RMS error in all frames of each of [`Comparison::series`], in % of the rest diagonal.
    pub(super) rms_percent: Vec<f64>,
    /// Number of the frame in which the model errs most on them, and its RMS error there.
    pub(super) worst: (usize, f64),
}

/// Measures the errors of every joint that some vertex counts for, the model's largest first.
pub(super) fn by_joint(comparison: &Comparison<'_>) -> Vec<JointErrors> {
    let examples = comparison.source.examples;
    let mut vertices = vec![Vec::new(); examples.joint_len()];
    for vertex in 0..examples.vertex_len() {
        let strongest = comparison.baselines.lbs.baseline.weights.strongest(vertex);
        vertices[strongest.unwrap_or(examples.skeleton.root())].push(vertex);
    }
    let (measured, series) = (&comparison.model.measured, comparison.series());
    let mut joints: Vec<JointErrors> = vertices
        .iter()
        .enumerate()
        .filter(|(_, vertices)| !vertices.is_empty())
        .map(|(joint, vertices)| {
            let frames = measured.frames.iter().enumerate();
            let worst = frames
                .map(|(place, frame)| (frame.frame, measured.rms_percent_in(place, vertices)))
                .fold((0, -1.0), |worst, next| if next.1 > worst.1 { next } else { worst });
            let of = series.iter().map(|series| series.measured.rms_percent_of(vertices));
            JointErrors { joint, vertices: vertices.len(), rms_percent: of.collect(), worst }
        })
        .collect();
    let own = |joint: &JointErrors| joint.rms_percent[comparison.model_place()];
    joints.sort_by(|a, b| own(b).total_cmp(&own(a)));
    joints
}
