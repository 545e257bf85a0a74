//! The tolerance of stage shapes.

use super::directions::{Bounded, frame};
use crate::shapes::ShapeSubject;
use nalgebra::Vector3;
use sinew_trainer::regression::arithmetic::{Arithmetic, gamma};

/// Bounds the position, the normal, and the tangent with its handedness, of a shaped vertex, entry
/// by entry.
///
/// Each term of a sum is a weight times a step times a number, and the oracle's product of step and
/// number is rounded once: three roundings, and those of the sum. The position is one sum more.
pub fn shapes(
    subject: &ShapeSubject<'_>,
    number: usize,
    weights: &[f32],
    arithmetic: Arithmetic,
) -> Vec<(Vec<f64>, Vec<f64>)> {
    let oracle = &subject.oracle;
    let vertex = oracle.vertex(number);
    let (mut moved, mut magnitude) = (Vector3::zeros(), Vector3::<f64>::zeros());
    let (mut tilt, mut tilts) = ([0.0; 2], [0.0_f64; 2]);
    let mut terms = 0;
    for (s, weight) in weights.iter().map(|weight| f64::from(*weight)).enumerate() {
        let delta = weight * Vector3::from(oracle.shapes.deltas[s][number]);
        (moved, magnitude) = (moved + delta, magnitude + delta.abs());
        for (k, slope) in oracle.shapes.slopes[s][number].into_iter().enumerate() {
            (tilt[k], tilts[k]) = (tilt[k] + weight * slope, tilts[k] + (weight * slope).abs());
        }
        terms += usize::from(weight != 0.0);
    }
    let moved = Bounded { value: moved, error: magnitude * gamma(terms + 3) };
    let position = Bounded::exact(vertex.position.xyz()).plus(&moved);
    let slope = |k: usize| (tilt[k], tilts[k] * gamma(terms + 3));
    let less = |k: usize| (-tilt[k], tilts[k] * gamma(terms + 3));
    let tangent = vertex.tangent.map(|(tangent, _)| tangent);
    let [g, h] = frame(vertex.normal, tangent, arithmetic);
    let normal = Bounded::exact(vertex.normal);
    let tilted = normal.plus(&g.times(less(0))).plus(&h.times(less(1)));
    let tilted = tilted.direction(vertex.normal, arithmetic);
    let entries = |v: &Vector3<f64>| v.iter().copied().collect::<Vec<_>>();
    let mut out = vec![
        (entries(&position.value), entries(&position.error)),
        (entries(&tilted.value), vec![tilted.error; 3]),
    ];
    if let Some((rest, hand)) = vertex.tangent {
        let lifted = Bounded::exact(rest).plus(&normal.times(slope(0)));
        let lifted = lifted.direction(rest, arithmetic);
        // The handedness is copied.
        let mut error = vec![lifted.error; 3];
        error.push(0.0);
        out.push((lifted.value.push(hand).iter().copied().collect(), error));
    }
    out
}
