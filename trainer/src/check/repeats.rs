//! Frames of one pose: repeated where their meshes are one too, contradicting where they are not.

use super::context::{Context, worst_first};
use super::finding::{Finding, Kind, Severity, count, listed};
use super::thresholds::{CONTRADICTION, SAME_POSE, VISIBLE};

/// A training frame that has the pose of an earlier one.
struct Repeat {
    frame: usize,
    first: usize,
    /// RMS difference of what LBS leaves, in diagonals.
    apart: f64,
}

pub(super) fn repeats(context: &Context<'_>, findings: &mut Vec<Finding>) {
    let mut firsts: Vec<usize> = Vec::new();
    let mut repeats = Vec::new();
    for frame in 0..context.frames.len() {
        let alike = |&first: &usize| (first, context.turns.apart(first, frame, SAME_POSE));
        let nearest = firsts.iter().map(alike).min_by(|a, b| a.1.total_cmp(&b.1));
        match nearest.filter(|nearest| nearest.1.is_finite()) {
            Some((first, _)) => {
                repeats.push(Repeat { frame, first, apart: apart(context, first, frame) })
            }
            None => firsts.push(frame),
        }
    }
    let most = VISIBLE.max(CONTRADICTION * context.lbs_rms());
    let (against, alike): (Vec<Repeat>, Vec<Repeat>) =
        repeats.into_iter().partition(|repeat| repeat.apart > most);
    let pair = |repeat: &Repeat| {
        format!("{} as {}", context.frame(repeat.frame), context.frame(repeat.first))
    };
    if !against.is_empty() {
        let order = worst_first(0..against.len(), |k| against[k].apart);
        let line = |&k: &usize| {
            let (vertex, distance) = farthest(context, against[k].first, against[k].frame);
            let pair = pair(&against[k]);
            format!("{pair}, {} apart at vertex {vertex}", context.length(distance))
        };
        findings.push(Finding {
            kind: Kind::Contradicting,
            severity: Severity::Warning,
            text: format!(
                "{} the joints of another within {SAME_POSE}° and another mesh, which no model of \
                 the pose can follow (dynamics, a simulation that had not settled, or meshes of \
                 another frame): {}",
                count(against.len(), "frame has", "frames have"),
                listed(order.iter().map(line))
            ),
            places: context
                .frames(order.iter().flat_map(|&k| [against[k].frame, against[k].first])),
        });
    }
    if !alike.is_empty() {
        findings.push(Finding {
            kind: Kind::Repeated,
            severity: Severity::Note,
            text: format!(
                "{} pose and mesh of another, and may be left out: {}",
                count(alike.len(), "frame repeats", "frames repeat"),
                listed(alike.iter().map(pair))
            ),
            places: context.frames(alike.iter().map(|repeat| repeat.frame)),
        });
    }
}

fn apart(context: &Context<'_>, a: usize, b: usize) -> f64 {
    let sum: f64 = (0..context.dominant.len()).map(|v| squared_gap(context, v, a, b)).sum();
    (sum / context.dominant.len() as f64).sqrt()
}

/// The vertex at which two frames differ most, beyond what LBS explains, and by how much.
fn farthest(context: &Context<'_>, a: usize, b: usize) -> (usize, f64) {
    let gaps = (0..context.dominant.len()).map(|v| (v, squared_gap(context, v, a, b).sqrt()));
    gaps.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0))
}

fn squared_gap(context: &Context<'_>, vertex: usize, a: usize, b: usize) -> f64 {
    let column = context.residuals.col_as_slice(vertex);
    (0..3).map(|axis| (column[3 * a + axis] - column[3 * b + axis]).powi(2)).sum()
}
