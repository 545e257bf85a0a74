//! Whether the rest mesh belongs to the poses: near rest, the joints alone must give the meshes.

use super::context::{Context, worst_first};
use super::finding::{Finding, FrameName, Kind, Place, Severity, count, listed};
use super::thresholds::{NEAR_REST, REST_ERROR, ROUNDED, VISIBLE};
use crate::envelope::clean::HOPS;
use crate::envelope::correction::features::near;
use crate::envelope::lbs::weights::Lbs;
use crate::space::written;
use serde::Serialize;

/// How the rest mesh was tested.
#[derive(Clone, Debug, Serialize)]
pub struct Rest {
    /// The training frame whose joints are nearest to rest.
    pub nearest: FrameName,
    /// The largest angle of its joints, in degrees.
    pub nearest_degrees: f64,
    /// RMS error of LBS in it, in % of the diagonal.
    pub nearest_lbs_percent: f64,
    /// That error in millimetres; `None` where the unit is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nearest_lbs_mm: Option<f64>,
    /// Joints with skin of their own.
    pub joints: usize,
    /// Of them, those near rest, with their neighbours, in some training frame.
    pub tested: usize,
}

pub(super) fn rest(context: &Context<'_>, findings: &mut Vec<Finding>) -> Rest {
    let poses = 0..context.frames.len();
    let joint_len = context.examples.joint_len();
    let bend = |i: usize| (0..joint_len).map(|j| context.turns.bend(i, j)).fold(0.0, f64::max);
    let nearest = poses.clone().min_by(|&a, &b| bend(a).total_cmp(&bend(b))).unwrap_or(0);
    let all: Vec<usize> = (0..context.dominant.len()).collect();

    let seen = VISIBLE.max(ROUNDED * context.examples.coarseness());
    // By weights that the poses alone decide: painted ones may be off near rest too.
    let training = &context.training;
    let Lbs { weights, errors, .. } = training.free_lbs();
    let left = training.targets(&weights).residuals(&training.poses.stacked());
    let rms = |sum: f64, count: usize| (sum / count.max(1) as f64).sqrt();
    let (mut joints, mut tested) = (0, 0);
    let mut off = Vec::new();
    for (joint, skin) in context.skins().iter().enumerate().filter(|(_, skin)| !skin.is_empty()) {
        joints += 1;
        let around = near(&context.training.skeleton.parents, joint, HOPS);
        let bend = |i: usize| around.iter().map(|&j| context.turns.bend(i, j)).fold(0.0, f64::max);
        // One frame with the rest mesh is enough: in others muscles may tense without a joint.
        let squared = |i: usize, v: usize| left.col(v).subrows(3 * i, 3).squared_norm_l2();
        let error = |&i: &usize| rms(skin.iter().map(|&v| squared(i, v)).sum(), skin.len());
        let near_rest = poses.clone().filter(|&i| bend(i) <= NEAR_REST);
        let Some(least) = near_rest.min_by(|a, b| error(a).total_cmp(&error(b))) else { continue };
        tested += 1;
        let here = error(&least);
        let usual = rms(skin.iter().map(|&v| errors[v]).sum(), skin.len() * poses.len());
        if here > seen && here > REST_ERROR * usual {
            off.push((joint, least, bend(least), here));
        }
    }
    if !off.is_empty() {
        let order = worst_first(0..off.len(), |k| off[k].3);
        let line = |&k: &usize| {
            let (joint, frame, bend, error) = off[k];
            let (name, frame, error) =
                (context.joint(joint), context.frame(frame), context.length(error));
            format!("{name} by {error} in frame {frame}, {bend:.0}° from rest")
        };
        findings.push(Finding {
            kind: Kind::RestDiffers,
            severity: Severity::Warning,
            text: format!(
                "no mesh near rest is the rest mesh, as if that were another sculpt; the nearest: {}",
                listed(order.iter().map(line))
            ),
            places: order.iter().map(|&k| context.joint_place(off[k].0)).collect(),
        });
    }
    // Where LBS leaves nothing, every frame shows that the rest mesh belongs to the poses.
    if tested == 0 && context.lbs_rms() > seen {
        findings.push(Finding {
            kind: Kind::RestUntested,
            severity: Severity::Note,
            text: format!(
                "no training frame is near rest (the nearest is frame {}, {:.0}° away), so that \
                 nothing shows whether the rest mesh belongs to the poses: add the rest pose",
                context.frame(nearest),
                bend(nearest)
            ),
            places: vec![Place::Frame(context.frame(nearest))],
        });
    }
    let nearest_lbs_percent = 100.0 * context.rms(nearest, &all);
    Rest {
        nearest: context.frame(nearest),
        nearest_degrees: bend(nearest),
        nearest_lbs_percent,
        nearest_lbs_mm: context.mm(nearest_lbs_percent),
        joints,
        tested,
    }
}

impl Rest {
    /// Tells what was tested, in a line.
    pub fn describe(&self) -> String {
        let mm = self.nearest_lbs_mm.map_or(String::new(), |mm| format!(" ({} mm)", written(mm)));
        format!(
            "near rest in some training frame: the skin of {} of {}; the nearest frame is {}, {:.0}° from rest, \
             where LBS is off by {:.4} %{mm}",
            self.tested,
            count(self.joints, "joint", "joints"),
            self.nearest,
            self.nearest_degrees,
            self.nearest_lbs_percent
        )
    }
}
