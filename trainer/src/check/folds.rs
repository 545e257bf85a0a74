//! The faces in the training frames: triangles that collapse or turn over.

use super::finding::{Finding, Kind, Place, Severity, count, listed};
use super::seen::{Seen, worst_first};
use super::thresholds::{COLLAPSED, FLIPPED, MANY};
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

/// Triangles by number that are at fault in one frame.
#[derive(Default)]
struct Faults {
    collapsed: Vec<usize>,
    flipped: Vec<usize>,
}

pub(super) fn folds(seen: &Seen<'_>, findings: &mut Vec<Finding>) {
    let solid: Vec<usize> = {
        let mut solid = vec![true; seen.examples.triangles.len()];
        seen.examples.degenerate_triangles().into_iter().for_each(|t| solid[t] = false);
        (0..solid.len()).filter(|&t| solid[t]).collect()
    };
    let frames: Vec<Faults> =
        (0..seen.frames.len()).into_par_iter().map(|i| faults(seen, &solid, i)).collect();
    let (flipped, collapsed): (Vec<_>, Vec<_>) =
        frames.into_iter().map(|faults| (faults.flipped, faults.collapsed)).unzip();
    let (turn, lose) = (
        ("triangle turns over", "triangles turn over"),
        ("triangle loses its area", "triangles lose their area"),
    );
    findings.extend(report(seen, Kind::Flipped, turn, solid.len(), &flipped));
    findings.extend(report(seen, Kind::Collapsed, lose, solid.len(), &collapsed));
}

fn faults(seen: &Seen<'_>, solid: &[usize], i: usize) -> Faults {
    let (examples, weights) = (seen.examples, &seen.training.lbs.weights);
    let posed = examples.frame(seen.frames[i]);
    let pose = examples.pose(seen.frames[i]);
    let linear = |joint: usize| Matrix3::from_fn(|r, c| pose[joint][r][c]);
    let mut faults = Faults::default();
    for &number in solid {
        let triangle = examples.triangles[number];
        let (rest, now) = (normal(&examples.rest, triangle), normal(posed, triangle));
        if now.norm() < COLLAPSED * rest.norm() {
            faults.collapsed.push(number);
            continue;
        }
        let blended: Matrix3<f64> = triangle
            .into_iter()
            .flat_map(|vertex| weights.of(vertex))
            .map(|(joint, weight)| linear(joint) * weight)
            .sum();
        // The blend shrinks between joints, but its cofactors still point outward.
        let [a, b, c] = [0, 1, 2].map(|k| blended.column(k).into_owned());
        let expected = Matrix3::from_columns(&[b.cross(&c), c.cross(&a), a.cross(&b)]) * rest;
        if now.dot(&expected) < FLIPPED * now.norm() * expected.norm() {
            faults.flipped.push(number);
        }
    }
    faults
}

/// Twice the area, along the normal.
fn normal(points: &[[f64; 3]], triangle: [usize; 3]) -> Vector3<f64> {
    let [a, b, c] = triangle.map(|vertex| Vector3::from(points[vertex]));
    (b - a).cross(&(c - a))
}

fn report(
    seen: &Seen<'_>,
    kind: Kind,
    (one, many): (&str, &str),
    triangle_len: usize,
    frames: &[Vec<usize>],
) -> Option<Finding> {
    let mut times = vec![0usize; seen.examples.triangles.len()];
    frames.iter().flatten().for_each(|&triangle| times[triangle] += 1);
    let at_fault = (0..times.len()).filter(|&triangle| times[triangle] > 0);
    let triangles = worst_first(at_fault, |triangle| times[triangle] as f64);
    let in_frame = |i: usize| frames[i].len() as f64;
    let order = worst_first((0..frames.len()).filter(|&i| !frames[i].is_empty()), in_frame);
    let &worst = order.first()?;
    let line = |&triangle: &usize| format!("{triangle} ({})", times[triangle]);
    Some(Finding {
        kind,
        severity: if in_frame(worst) > MANY * triangle_len as f64 {
            Severity::Warning
        } else {
            Severity::Note
        },
        text: format!(
            "{} in {}, most of them ({}) in frame {}; by number (and frames): {}",
            count(triangles.len(), one, many),
            count(order.len(), "training frame", "training frames"),
            frames[worst].len(),
            seen.frame(worst),
            listed(triangles.iter().map(line))
        ),
        places: triangles
            .iter()
            .map(|&triangle| Place::Triangle(triangle))
            .chain(seen.frames(order))
            .collect(),
    })
}
