//! The faces in the training frames: triangles that collapse, fold over, or look inward.

use super::context::{Context, worst_first};
use super::faces::edges;
use super::finding::{Finding, Kind, Place, Severity, count, listed};
use super::thresholds::{COLLAPSED, FLIPPED, MANY};
use crate::numeric::affine::cofactors;
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

pub(super) fn folded(context: &Context<'_>, findings: &mut Vec<Finding>) {
    let surface = RestFaces::new(context);
    let frames: Vec<Faults> =
        (0..context.frames.len()).into_par_iter().map(|i| surface.faults(context, i)).collect();
    let part = |of: fn(&Faults) -> &Vec<usize>| frames.iter().map(of).cloned().collect::<Vec<_>>();
    let inward = Words {
        kind: Kind::Flipped,
        words: ["triangle looks", "triangles look"],
        meaning: "against where the joints take it, as in a mirrored or inverted mesh",
    };
    let over = Words {
        kind: Kind::Folded,
        words: ["triangle folds", "triangles fold"],
        meaning: "over a neighbour, as skin does in deep bends",
    };
    let lost = Words {
        kind: Kind::Collapsed,
        words: ["triangle keeps", "triangles keep"],
        meaning: "less than a hundredth of the area at rest",
    };
    let len = surface.triangles.len();
    findings.extend(inward.report(context, len, &part(|faults| &faults.flipped)));
    findings.extend(over.report(context, len, &part(|faults| &faults.folded)));
    findings.extend(lost.report(context, len, &part(|faults| &faults.collapsed)));
}

/// The triangles that have an area at rest.
struct RestFaces {
    triangles: Vec<usize>,
    /// Pairs of them that share an edge without a crease, by place in the list.
    neighbours: Vec<[usize; 2]>,
    /// Twice their area at rest, along the normal.
    rest: Vec<Vector3<f64>>,
}

/// Triangles by number that are at fault in one frame.
struct Faults {
    flipped: Vec<usize>,
    folded: Vec<usize>,
    collapsed: Vec<usize>,
}

impl RestFaces {
    fn new(context: &Context<'_>) -> Self {
        let examples = context.examples;
        let mut place = vec![None; examples.triangles.len()];
        let flat = examples.degenerate_triangles();
        let triangles: Vec<usize> =
            (0..place.len()).filter(|t| flat.binary_search(t).is_err()).collect();
        triangles.iter().enumerate().for_each(|(k, &t)| place[t] = Some(k));
        let rest: Vec<_> =
            triangles.iter().map(|&t| normal(&examples.rest, examples.triangles[t])).collect();
        let neighbours = edges(examples)
            .into_values()
            .filter_map(|uses| match uses[..] {
                [(a, one), (b, other)] if one != other => Some([place[a]?, place[b]?]),
                _ => None,
            })
            .filter(|&[a, b]| rest[a].dot(&rest[b]) > 0.0)
            .collect();
        Self { triangles, neighbours, rest }
    }

    fn faults(&self, context: &Context<'_>, i: usize) -> Faults {
        let (examples, weights) = (context.examples, &context.training.lbs.weights);
        let posed = examples.frame(context.frames[i]);
        let pose = examples.pose(context.frames[i]);
        let linear = |joint: usize| Matrix3::from_fn(|r, c| pose[joint][r][c]);
        let of = |&t: &usize| normal(posed, examples.triangles[t]);
        let now: Vec<Vector3<f64>> = self.triangles.iter().map(of).collect();
        let collapsed: Vec<bool> =
            now.iter().zip(&self.rest).map(|(n, r)| n.norm() < COLLAPSED * r.norm()).collect();
        let flipped = |k: usize| {
            let blended: Matrix3<f64> = examples.triangles[self.triangles[k]]
                .into_iter()
                .flat_map(|vertex| weights.of(vertex))
                .map(|(joint, weight)| linear(joint) * weight)
                .sum();
            !collapsed[k] && opposed(&now[k], &(cofactors(&blended) * self.rest[k]))
        };
        let flipped: Vec<bool> = (0..now.len()).map(flipped).collect();
        let mut folded = vec![false; now.len()];
        for &[a, b] in &self.neighbours {
            if opposed(&now[a], &now[b]) {
                folded[a] |= flipped[a];
                folded[b] |= flipped[b];
            }
        }
        let many = flipped.iter().filter(|flipped| **flipped).count() as f64
            > MANY * self.triangles.len() as f64;
        let named = |at_fault: &[bool]| {
            let places = (0..at_fault.len()).filter(|&k| at_fault[k]);
            places.map(|k| self.triangles[k]).collect()
        };
        Faults {
            // A few that look inward, without a fold, are a bend that LBS does not foresee.
            flipped: if many { named(&flipped) } else { Vec::new() },
            folded: if many { Vec::new() } else { named(&folded) },
            collapsed: named(&collapsed),
        }
    }
}

/// Whether two directions are further apart than any bulge.
fn opposed(a: &Vector3<f64>, b: &Vector3<f64>) -> bool {
    a.dot(b) < FLIPPED * a.norm() * b.norm()
}

/// Twice the area, along the normal.
fn normal(points: &[[f64; 3]], triangle: [usize; 3]) -> Vector3<f64> {
    let [a, b, c] = triangle.map(|vertex| Vector3::from(points[vertex]));
    (b - a).cross(&(c - a))
}

/// How a fault is told.
struct Words {
    kind: Kind,
    words: [&'static str; 2],
    meaning: &'static str,
}

impl Words {
    fn report(
        &self,
        context: &Context<'_>,
        triangle_len: usize,
        frames: &[Vec<usize>],
    ) -> Option<Finding> {
        let mut times = vec![0usize; context.examples.triangles.len()];
        frames.iter().flatten().for_each(|&triangle| times[triangle] += 1);
        let at_fault = (0..times.len()).filter(|&triangle| times[triangle] > 0);
        let triangles = worst_first(at_fault, |triangle| times[triangle] as f64);
        let in_frame = |i: usize| frames[i].len() as f64;
        let order = worst_first((0..frames.len()).filter(|&i| !frames[i].is_empty()), in_frame);
        let &worst = order.first()?;
        let many = in_frame(worst) > MANY * triangle_len as f64;
        let [one, more] = self.words;
        let line = |&triangle: &usize| format!("{triangle} ({})", times[triangle]);
        Some(Finding {
            kind: self.kind,
            severity: if many { Severity::Warning } else { Severity::Note },
            text: format!(
                "{} {}, in {}, most of them ({}) in frame {}; triangles (in frames): {}",
                count(triangles.len(), one, more),
                self.meaning,
                count(order.len(), "training frame", "training frames"),
                frames[worst].len(),
                context.frame(worst),
                listed(triangles.iter().map(line))
            ),
            places: triangles
                .iter()
                .map(|&triangle| Place::Triangle(triangle))
                .chain(context.frames(order))
                .collect(),
        })
    }
}
