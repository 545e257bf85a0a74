//! How a point of the skin follows the joints: by shares of their rotations, muscles swelling.

use nalgebra::Vector3;

use super::motion::{Pose, hinge};
use super::rotation::{bell, ramp, rotation};
use super::shape::{ELBOW, Point, WRIST, above, arm, origins};

/// A point of the skin with what it takes from each joint.
pub(super) struct Flesh {
    rest: Vector3<f64>,
    /// Share of each rotation, from the chest (0) to the joint (1).
    clavicle: f64,
    swing: f64,
    turn: f64,
    elbow: f64,
    twist: f64,
    hand: f64,
    /// Swelling at full flexion of the elbow, and at full raise and full forward of the arm.
    flexed: Vector3<f64>,
    raised: Vector3<f64>,
    forward: Vector3<f64>,
}

/// Full flexion and full raise, radians.
const FULL: (f64, f64) = (2.06, 1.4);

impl Flesh {
    /// Works out what a point of the rest skin takes from each joint.
    pub(super) fn new(point: &Point) -> Self {
        let &Point { position, along, around: (up, front) } = point;
        let outward = (position - origins()[2]).dot(&arm());
        Self {
            rest: position,
            clavicle: ramp(position.x, -0.025, 0.12),
            swing: ramp(outward, -0.09, 0.09),
            turn: ramp(along, 0.0, 0.125),
            elbow: ramp(along, ELBOW - 0.12, ELBOW + 0.12),
            twist: ramp(along, ELBOW - 0.01, WRIST),
            hand: ramp(along, WRIST - 0.05, WRIST + 0.05),
            flexed: Vector3::z() * flexed_front(along, front)
                + above() * (0.008 * bell(along, ELBOW, 0.035) * up),
            raised: above() * (0.010 * bell(along, 0.335, 0.035) * up.max(0.0)),
            forward: Vector3::z() * (0.016 * bell(along, -0.05, 0.05) * front.max(0.0)),
        }
    }

    /// Moves the point to a pose: swells it at rest, then lets every joint turn it, hand first.
    pub(super) fn posed(&self, pose: &Pose) -> Vector3<f64> {
        let [_, clavicle, shoulder, _, elbow, _, wrist] = origins();
        let mut at = self.rest
            + self.flexed * (pose.elbow / FULL.0)
            + self.raised * (pose.swing.z / FULL.1)
            + self.forward * (pose.swing.dot(&hinge()) / FULL.1);
        let about = |at: &mut Vector3<f64>, origin: Vector3<f64>, vector: Vector3<f64>| {
            *at = origin + rotation(&vector) * (*at - origin);
        };
        about(&mut at, wrist, pose.hand * self.hand);
        about(&mut at, elbow, arm() * (pose.twist * self.twist));
        about(&mut at, elbow, hinge() * (pose.elbow * self.elbow));
        about(&mut at, shoulder, arm() * (pose.turn * self.turn));
        about(&mut at, shoulder, pose.swing * self.swing);
        about(&mut at, clavicle, pose.clavicle * self.clavicle);
        let (linear, shift) = pose.root();
        linear * at + shift
    }
}

/// How far forward the skin moves when the elbow bends: biceps, forearm, and, backward, the
/// triceps and the point of the elbow.
fn flexed_front(along: f64, front: f64) -> f64 {
    let before = front.max(0.0) * front.max(0.0);
    let behind = front.min(0.0) * front.min(0.0);
    let biceps = 0.030 * bell(along, 0.135, 0.04) * before;
    let forearm = 0.010 * bell(along, 0.335, 0.035) * before;
    let triceps = -0.006 * bell(along, 0.13, 0.06) * behind;
    let point = -0.008 * bell(along, ELBOW, 0.03) * behind;
    biceps + forearm + triceps + point
}
