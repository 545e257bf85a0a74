//! How a point of the skin follows the joints: by shares of their rotations, muscles swelling.

use nalgebra::Vector3;

use super::motion::{Pose, hinge};
use super::rotation::{bell, ramp, rotation};
use super::shape::{ELBOW, Point, SHOULDER, WRIST, above, arm, origins};

/// A point of the skin with what it takes from each joint.
///
/// Where a share is s, the skin turns by s times the joint's rotation about the joint's origin: a
/// section inside an elbow turns half way and keeps its size, where a blend of two matrices would
/// flatten it.
pub(super) struct Flesh {
    rest: Vector3<f64>,
    /// Shares, 0 on the chest's side of the joint and 1 beyond it.
    clavicle: f64,
    swing: f64,
    turn: f64,
    elbow: f64,
    twist: f64,
    hand: f64,
    /// Where the skin moves when the elbow is fully bent.
    bent: Vector3<f64>,
    /// Where it moves when the upper arm is fully raised.
    raised: Vector3<f64>,
    /// Where it moves when the upper arm is fully forward.
    forward: Vector3<f64>,
}

/// Angles at which swellings are full, radians: the elbow's and the upper arm's.
const FULL: (f64, f64) = (2.06, 1.4);

impl Flesh {
    /// Works out what a point of the rest skin takes from each joint.
    pub(super) fn new(point: &Point) -> Self {
        let &Point { position, along, around: (up, front) } = point;
        // Across the chest the sections are not yet those of the arm, so that its own axis counts.
        let outward = (position - SHOULDER).dot(&arm());
        let sides = bell(along, ELBOW, 0.035) * up;
        let deltoid = bell(along, 0.03, 0.06) * square(up.max(0.0));
        let breast = bell(along, -0.05, 0.05) * square(front.max(0.0));
        Self {
            rest: position,
            clavicle: ramp(position.x, -0.025, 0.12),
            swing: ramp(outward, -0.09, 0.09),
            turn: ramp(along, 0.0, 0.125),
            elbow: ramp(along, ELBOW - 0.12, ELBOW + 0.12),
            twist: ramp(along, ELBOW - 0.01, WRIST),
            hand: ramp(along, WRIST - 0.05, WRIST + 0.05),
            bent: Vector3::z() * bent(along, front) + above() * (0.008 * sides),
            raised: above() * (0.014 * deltoid),
            forward: Vector3::z() * (0.016 * breast),
        }
    }

    /// Moves the point to a pose: swells it at rest, then lets every joint turn it, hand first.
    pub(super) fn posed(&self, pose: &Pose) -> Vector3<f64> {
        let [_, clavicle, shoulder, _, elbow, _, wrist] = origins();
        let swollen = self.rest
            + self.bent * (pose.elbow / FULL.0)
            + self.raised * (pose.swing.z / FULL.1)
            + self.forward * (pose.swing.dot(&hinge()) / FULL.1);
        let turns = [
            (wrist, pose.hand * self.hand),
            (elbow, arm() * (pose.twist * self.twist)),
            (elbow, hinge() * (pose.elbow * self.elbow)),
            (shoulder, arm() * (pose.turn * self.turn)),
            (shoulder, pose.swing * self.swing),
            (clavicle, pose.clavicle * self.clavicle),
        ];
        let in_chest = turns
            .iter()
            .fold(swollen, |at, (origin, turn)| origin + rotation(turn) * (at - origin));
        let (linear, shift) = pose.chest;
        linear * in_chest + shift
    }
}

/// How far forward the skin moves when the elbow bends: biceps and forearm forward, the triceps and
/// the point of the elbow backward.
fn bent(along: f64, front: f64) -> f64 {
    let biceps = 0.030 * bell(along, 0.135, 0.04);
    let forearm = 0.010 * bell(along, 0.335, 0.035);
    let triceps = 0.006 * bell(along, 0.13, 0.06);
    let point = 0.008 * bell(along, ELBOW, 0.03);
    (biceps + forearm) * square(front.max(0.0)) - (triceps + point) * square(front.min(0.0))
}

fn square(x: f64) -> f64 {
    x * x
}
