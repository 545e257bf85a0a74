//! Joints on whose skin the joint weights that come with the mesh mislead.

use super::context::Context;
use super::finding::{Finding, Kind, Severity, count};
use super::joints::{names, places};
use super::thresholds::{MISLEADS, VISIBLE};
use crate::envelope::lbs::prior;

/// Warns of joints on whose skin painted weights leave several times the error of fitted weights.
pub(super) fn misleading(context: &Context<'_>, findings: &mut Vec<Finding>) {
    let Some(painted) = prior::painted(context.examples) else { return };
    let training = &context.training;
    let left = training.targets(&painted).residuals(&training.poses.stacked());
    // Below the error of all skin nobody looks.
    let unseen = context.lbs_rms().max(VISIBLE).powi(2) * training.poses.len() as f64;
    let joint_len = context.examples.joint_len();
    // Squared errors by painted and by fitted weights.
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
    findings.push(Finding {
        kind: Kind::Weights,
        severity: Severity::Warning,
        text: format!(
            "the joint weights that come with the mesh mislead about the skin of {}: their error is far larger than that of \
             fitted weights; look whether they are of this mesh and these joints, and more than a first binding: {}",
            count(joints.len(), "joint", "joints"),
            names(context, &joints)
        ),
        places: places(context, &joints),
    });
}
