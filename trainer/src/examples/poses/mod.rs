//! Poses to train on: every joint and curve moves through its range, alone and with others.

mod plan;
mod ranges;
pub(super) mod save;

use self::plan::{Movers, plan};
use self::ranges::{Carried, Freedoms, Local, of_clips, of_degrees};
use super::{Examples, Matrix3x4};
use crate::Error;

/// Request of poses to train on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseRequest {
    /// Number of poses, N.
    pub frames: usize,
    /// Largest rotation of every joint about each axis of its rest frame, in degrees; curves then go from 0 to 1. `None`
    /// takes the ranges of the training frames.
    pub degrees: Option<f64>,
    /// Seed of the random choices. Equal seeds give equal poses.
    pub seed: u64,
}

impl Default for PoseRequest {
    fn default() -> Self {
        Self { frames: 150, degrees: None, seed: 0 }
    }
}

/// Poses to train on, without meshes. Poses of joints and curves that move alone come first, then those of neighbours,
/// then those in which all move.
#[derive(Clone, Debug, PartialEq)]
pub struct SampledPoses {
    /// Map from the rest pose to the posed joint, N x J, frame-major, model space.
    pub transforms: Vec<Matrix3x4>,
    /// Values of the curves, N x C, frame-major.
    pub curves: Vec<f64>,
    /// Number of joints that move.
    pub joints: usize,
    /// Number of poses in which joints and curves move alone. If poses are few, some that are far apart share a pose.
    pub alone: usize,
    /// Number of poses in which neighbours move: a joint and its parent, or two curves.
    pub paired: usize,
}

/// Samples poses of a rig: each joint and each curve alone, with its neighbours, and all together.
///
/// Every value of a group of poses is used once and is evenly spaced over its range, so few poses cover the ranges
/// (Latin hypercube). A joint turns, slides and stretches along its own rest axes, against the joint that carries it.
/// The root turns and slides in no pose, because training removes such motion; it stretches.
///
/// - `rig`: skeleton, rest mesh and curves. Its training frames give the ranges, with a tenth more on either side. An
///   end near the rest pose gets nothing more.
///
/// # Errors
/// Nothing moves: the training frames are at rest, or there is neither a second joint nor a curve.
pub fn sample_poses(rig: &Examples, request: &PoseRequest) -> Result<SampledPoses, Error> {
    let carried = Carried::new(rig);
    let (joints, curves) = match request.degrees {
        Some(degrees) => of_degrees(rig, &carried, degrees),
        None => of_clips(rig, &carried),
    };
    let movers: Vec<&Freedoms> = joints.iter().chain(&curves).collect();
    if movers.iter().all(|mover| mover.len() == 0) {
        return Err(Error::missing(match request.degrees {
            None => {
                "its training frames move no joint and no curve, so its ranges are unknown: give --degrees N, or \
                     clips that show the ranges"
            }
            Some(_) => {
                "it has neither a curve nor a joint beside the root: there is nothing to pose"
            }
        }));
    }
    let rests: Vec<_> = movers.iter().map(|mover| mover.rests()).collect();
    let plan = plan(
        &Movers { rests: &rests, parents: &carried.parents, curves: curves.len() },
        request.frames,
        request.seed,
    );
    let mut sampled = SampledPoses {
        transforms: Vec::new(),
        curves: Vec::new(),
        joints: joints.iter().filter(|joint| joint.len() > 0).count(),
        alone: plan.alone,
        paired: plan.paired,
    };
    for places in &plan.frames {
        let mut places = &places[..];
        let mut values = movers.iter().map(|mover| {
            let (own, others) = places.split_at(mover.len());
            places = others;
            mover.values(own)
        });
        let locals: Vec<Local> = values.by_ref().take(joints.len()).collect();
        sampled.curves.extend(values.map(|value| value[0]));
        sampled.transforms.extend(carried.pose(&locals));
    }
    Ok(sampled)
}
