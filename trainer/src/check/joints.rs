//! Single joints: rigid maps, half turns, joints without motion or skin, and joint weights that are wrong for the skin.

use super::context::{Context, worst_first};
use super::finding::{Finding, FrameName, Kind, Place, count, listed};
use super::thresholds::{IDLE, MISLEADS, SCALED, STILL, VISIBLE};
use crate::envelope::choose::report::SEAM;
use crate::envelope::lbs::prior;
use crate::examples::{Matrix3x4, Warning};
use nalgebra::Matrix3;

pub(super) fn joints(context: &Context<'_>, warnings: &[Warning], findings: &mut Vec<Finding>) {
    findings.extend(warnings.iter().filter_map(|warning| non_rigid(context, warning)));
    half_turns(context, findings);
    let joints = 0..context.examples.joint_len();
    let root = context.examples.skeleton.root();
    let still = |&j: &usize| j != root && context.turns.largest_bend(j) < STILL;
    let still: Vec<usize> = joints.clone().filter(still).collect();
    if !still.is_empty() {
        let [parents, they, one] = match still.len() {
            1 => ["its parent", "it", "it"],
            _ => ["their parents", "them", "one"],
        };
        let text = format!(
            "{} against {parents} in training: {}; no frame shows which skin follows {they}, so the nearest skin does, \
             and the confidence of a model falls where a pose turns {one}",
            count(still.len(), "joint never moves", "joints never move"),
            names(context, &still)
        );
        findings.push(Finding::note(Kind::Still, text, places(context, &still)));
    }
    let mut used = vec![false; context.examples.joint_len()];
    let weights = &context.training.lbs.weights;
    for vertex in 0..weights.len() {
        weights.of(vertex).for_each(|(joint, weight)| used[joint] |= weight > IDLE);
    }
    // For a joint that never moves, the frames do not show its skin.
    let idle: Vec<usize> = joints.filter(|j| !used[*j] && !still.contains(j)).collect();
    if !idle.is_empty() {
        let moves = count(idle.len(), "joint moves", "joints move");
        let text = format!("{moves} no vertex: {}", names(context, &idle));
        findings.push(Finding::note(Kind::Idle, text, places(context, &idle)));
    }
}

fn non_rigid(context: &Context<'_>, warning: &Warning) -> Option<Finding> {
    let Warning::NonRigidJoint { joint, worst_frame, .. } = warning else { return None };
    let worst_frame = worst_frame.and_then(|frame| usize::try_from(frame).ok());
    let number = context.examples.skeleton.names.iter().position(|name| name == joint).unwrap_or(0);
    let map = match worst_frame {
        Some(frame) => &context.examples.pose(frame)[number],
        None => &context.examples.skeleton.rest[number],
    };
    let mut places = vec![Place::Joint(joint.clone())];
    let frame = worst_frame.map(|frame| FrameName::new(context.clips, frame));
    places.extend(frame.map(Place::Frame));
    let warning = warning.clone().called(context.clips);
    let text = format!("{warning}; {}: export joints without scale", stretch(map));
    Some(Finding::warning(Kind::NonRigid, text, places))
}

/// Says whether a joint's map is scaled evenly or stretched.
fn stretch(map: &Matrix3x4) -> String {
    let linear = Matrix3::from_fn(|row, column| map[row][column]);
    let sigma = linear.singular_values();
    let (most, least) = (sigma.max(), sigma.min());
    if most - least < SCALED {
        return format!("it is scaled by {:.4}", sigma.mean());
    }
    format!("it is stretched by {least:.4} to {most:.4}")
}

fn half_turns(context: &Context<'_>, findings: &mut Vec<Finding>) {
    let ranges = context.training.poses.angle_ranges();
    let over = (0..ranges.len()).filter(|&joint| ranges[joint] > SEAM);
    let over = worst_first(over, |joint| ranges[joint]);
    if over.is_empty() {
        return;
    }
    let worst = |joint: usize| {
        let angle = |i: usize| context.training.poses.angle(i, joint).norm();
        (0..context.frames.len()).max_by(|&a, &b| angle(a).total_cmp(&angle(b))).unwrap_or(0)
    };
    let line = |&joint: &usize| {
        let (degrees, frame) = (ranges[joint].to_degrees(), context.frame(worst(joint)));
        format!("{} by {degrees:.0}° in frame {frame}", context.joint(joint))
    };
    let text = format!(
        "{} near a half turn against the parent, where the rotational predictor jumps: {}; use `--predictor \
         kernel`, or share the turn with another joint",
        count(over.len(), "joint comes", "joints come"),
        listed(over.iter().map(line))
    );
    let both =
        |&joint: &usize| [context.joint_place(joint), Place::Frame(context.frame(worst(joint)))];
    let places = over.iter().flat_map(both).collect();
    findings.push(Finding::warning(Kind::HalfTurn, text, places));
}

fn names(context: &Context<'_>, joints: &[usize]) -> String {
    listed(joints.iter().map(|&joint| context.joint(joint)))
}

fn places(context: &Context<'_>, joints: &[usize]) -> Vec<Place> {
    joints.iter().map(|&joint| context.joint_place(joint)).collect()
}

/// Warns of joints where painted weights have several times the error of fitted weights.
pub(super) fn misleading_weights(context: &Context<'_>, findings: &mut Vec<Finding>) {
    let Some(painted) = prior::painted(context.examples) else { return };
    let training = &context.training;
    let left = training.targets(&painted).residuals(&training.poses.stacked());
    // Errors below the RMS error of all skin do not count.
    let unseen = training.lbs_rms().max(VISIBLE).powi(2) * training.poses.len() as f64;
    let joint_len = context.examples.joint_len();
    // Squared errors of painted and of fitted weights.
    let mut sums = vec![[0.0; 2]; joint_len];
    for (vertex, fitted) in training.lbs.errors.iter().enumerate() {
        let Some(joint) = painted.strongest(vertex) else { continue };
        sums[joint][0] += left.col(vertex).squared_norm_l2();
        sums[joint][1] += fitted.max(unseen);
    }
    let misleads = |&joint: &usize| sums[joint][0] > MISLEADS.powi(2) * sums[joint][1];
    let joints: Vec<usize> = (0..joint_len).filter(misleads).collect();
    if joints.is_empty() {
        return;
    }
    let text = format!(
        "the mesh's own joint weights are wrong for the skin of {}: their error is far larger than that of \
         fitted weights; check that they belong to this mesh and these joints, and are more than an automatic binding: {}",
        count(joints.len(), "joint", "joints"),
        names(context, &joints)
    );
    findings.push(Finding::warning(Kind::Weights, text, places(context, &joints)));
}
