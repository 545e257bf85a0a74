//! Joints by themselves: rigidity, half turns, and those that do nothing.

use super::finding::{Finding, Kind, Place, Severity, count, listed};
use super::seen::{Seen, worst_first};
use super::thresholds::{IDLE, SCALED, STILL};
use crate::envelope::choose::SEAM;
use crate::examples::{Matrix3x4, Warning};
use nalgebra::Matrix3;

pub(super) fn joints(seen: &Seen<'_>, warnings: &[Warning], findings: &mut Vec<Finding>) {
    for warning in warnings {
        if let Warning::NonRigidJoint { joint, worst_frame, .. } = warning {
            findings.push(non_rigid(seen, warning, joint, *worst_frame));
        }
    }
    half_turns(seen, findings);
    let joints = 0..seen.examples.joint_len();
    let root = seen.examples.skeleton.root();
    let still = |&j: &usize| j != root && seen.turns.farthest(j) < STILL;
    let still: Vec<usize> = joints.clone().filter(still).collect();
    if !still.is_empty() {
        findings.push(Finding {
            kind: Kind::Still,
            severity: Severity::Note,
            text: format!(
                "{} against {} in training, so that nothing is learned of {}: {}",
                count(still.len(), "joint never moves", "joints never move"),
                if still.len() == 1 { "its parent" } else { "their parents" },
                if still.len() == 1 { "it" } else { "them" },
                names(seen, &still)
            ),
            places: places(seen, &still),
        });
    }
    let mut used = vec![false; seen.examples.joint_len()];
    let weights = &seen.training.lbs.weights;
    for vertex in 0..weights.len() {
        weights.of(vertex).for_each(|(joint, weight)| used[joint] |= weight > IDLE);
    }
    // Of a joint that never moves, no fit can tell what follows it.
    let idle: Vec<usize> = joints.filter(|j| !used[*j] && !still.contains(j)).collect();
    if !idle.is_empty() {
        findings.push(Finding {
            kind: Kind::Idle,
            severity: Severity::Note,
            text: format!(
                "{} no vertex: {}",
                count(idle.len(), "joint moves", "joints move"),
                names(seen, &idle)
            ),
            places: places(seen, &idle),
        });
    }
}

fn non_rigid(
    seen: &Seen<'_>,
    warning: &Warning,
    joint: &str,
    worst_frame: Option<usize>,
) -> Finding {
    let number = seen.examples.skeleton.names.iter().position(|name| name == joint).unwrap_or(0);
    let map = match worst_frame {
        Some(frame) => &seen.examples.pose(frame)[number],
        None => &seen.examples.skeleton.rest[number],
    };
    let mut places = vec![Place::Joint(joint.to_owned())];
    let frame = worst_frame.map(|frame| super::finding::FrameName::new(seen.clips, frame));
    places.extend(frame.map(Place::Frame));
    Finding {
        kind: Kind::NonRigid,
        severity: Severity::Warning,
        text: format!("{warning}; {}: export joints without scale", stretch(map)),
        places,
    }
}

/// Tells a scale from a stretch.
fn stretch(map: &Matrix3x4) -> String {
    let linear = Matrix3::from_fn(|row, column| map[row][column]);
    let sigma = linear.singular_values();
    let (most, least) = (sigma.max(), sigma.min());
    if most - least < SCALED {
        return format!("it is scaled by {:.4}", sigma.mean());
    }
    format!("it is stretched by {least:.4} to {most:.4}")
}

fn half_turns(seen: &Seen<'_>, findings: &mut Vec<Finding>) {
    let ranges = seen.training.poses.angle_ranges();
    let over = (0..ranges.len()).filter(|&joint| ranges[joint] > SEAM);
    let over = worst_first(over, |joint| ranges[joint]);
    if over.is_empty() {
        return;
    }
    let worst = |joint: usize| {
        let angle = |i: usize| seen.training.poses.angle(i, joint).norm();
        (0..seen.frames.len()).max_by(|&a, &b| angle(a).total_cmp(&angle(b))).unwrap_or(0)
    };
    let line = |&joint: &usize| {
        let degrees = ranges[joint].to_degrees();
        format!("{} by {degrees:.0}° in frame {}", seen.joint(joint), seen.frame(worst(joint)))
    };
    findings.push(Finding {
        kind: Kind::HalfTurn,
        severity: Severity::Warning,
        text: format!(
            "near a half turn against the parent the rotation vector jumps; `--predictor kernel` \
             does not mind, or share the turn with another joint: {}",
            listed(over.iter().map(line))
        ),
        places: over
            .iter()
            .flat_map(|&joint| [seen.joint_place(joint), Place::Frame(seen.frame(worst(joint)))])
            .collect(),
    });
}

fn names(seen: &Seen<'_>, joints: &[usize]) -> String {
    listed(joints.iter().map(|&joint| seen.joint(joint)))
}

fn places(seen: &Seen<'_>, joints: &[usize]) -> Vec<Place> {
    joints.iter().map(|&joint| seen.joint_place(joint)).collect()
}
