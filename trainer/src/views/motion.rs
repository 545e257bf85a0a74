//! Motions of a figure of 16 joints: a walk by its phase, a jump by its time.

/// Joints, and the parent of each: parents stand first.
pub const JOINTS: [(&str, Option<usize>); 16] = [
    ("root", None),
    ("hip", Some(0)),
    ("torso", Some(1)),
    ("neck", Some(2)),
    ("right_shoulder", Some(2)),
    ("right_elbow", Some(4)),
    ("right_hand", Some(5)),
    ("left_shoulder", Some(2)),
    ("left_elbow", Some(7)),
    ("left_hand", Some(8)),
    ("right_hip", Some(0)),
    ("right_knee", Some(10)),
    ("right_foot", Some(11)),
    ("left_hip", Some(0)),
    ("left_knee", Some(13)),
    ("left_foot", Some(14)),
];

/// How far a figure is from rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// How far the root has moved, in heights of the figure, y down.
    pub shift: [f64; 2],
    /// Degrees by which the bone that ends at each joint has turned against its parent's, clockwise as seen.
    pub turns: [f64; 16],
}

/// A figure's joints, and how its bones have turned.
#[derive(Clone, Debug, PartialEq)]
pub struct Posed {
    /// Positions, pixels.
    pub joints: [[f64; 2]; 16],
    /// Radians by which the bone that ends at each joint has turned.
    pub turned: [f64; 16],
}

impl Pose {
    /// A stride and its way back: a phase of 360 degrees is one of 0.
    pub fn walk(phase: f64) -> Self {
        let phase = phase.to_radians();
        let (s, c) = phase.sin_cos();
        let mut turns = [0.0; 16];
        turns[2] = 3.0 * s;
        turns[3] = -4.0 * s;
        (turns[5], turns[8]) = (-24.0 * s, 24.0 * s);
        (turns[6], turns[9]) = (-12.0 - 10.0 * s, 12.0 - 10.0 * s);
        (turns[11], turns[14]) = (10.0 + 16.0 * s, -10.0 - 16.0 * s);
        (turns[12], turns[15]) = (16.0 * (1.0 - c), 16.0 * (1.0 + c));
        Self { shift: [0.0, 0.012 * (2.0 * phase).cos()], turns }
    }

    /// A jump from standing at 0 to standing at 1.
    pub fn jump(time: f64) -> Self {
        let up = (std::f64::consts::PI * time).sin();
        let bent = (2.0 * std::f64::consts::PI * time).sin().powi(2);
        let mut turns = [0.0; 16];
        (turns[5], turns[8]) = (45.0 * up, -45.0 * up);
        (turns[6], turns[9]) = (20.0 * up, -20.0 * up);
        (turns[11], turns[14]) = (20.0 * bent, -20.0 * bent);
        (turns[12], turns[15]) = (-35.0 * bent, 35.0 * bent);
        Self { shift: [0.0, -0.06 * up * up], turns }
    }

    /// Poses joints that are at rest, pixels.
    pub fn posed(&self, rest: &[[f64; 2]; 16]) -> Posed {
        let ends = |axis: usize| {
            let all = rest.map(|joint| joint[axis]);
            all.iter().copied().fold(f64::MIN, f64::max)
                - all.iter().copied().fold(f64::MAX, f64::min)
        };
        let height = ends(1);
        let mut out = Posed { joints: *rest, turned: [0.0; 16] };
        for (joint, (_, parent)) in JOINTS.iter().enumerate() {
            let Some(parent) = *parent else {
                out.joints[joint] =
                    [0, 1].map(|axis| rest[joint][axis] + height * self.shift[axis]);
                continue;
            };
            let turned = out.turned[parent] + self.turns[joint].to_radians();
            out.turned[joint] = turned;
            out.joints[joint] = carried(rest[joint], rest[parent], out.joints[parent], turned);
        }
        out
    }
}

/// Turns a point about where a joint was, and moves it with the joint.
pub fn carried(point: [f64; 2], rest: [f64; 2], joint: [f64; 2], turned: f64) -> [f64; 2] {
    let (s, c) = turned.sin_cos();
    let [x, y] = [point[0] - rest[0], point[1] - rest[1]];
    [joint[0] + c * x - s * y, joint[1] + s * x + c * y]
}

#[cfg(test)]
mod tests {
    use super::*;

    const REST: [[f64; 2]; 16] = [
        [50.0, 100.0],
        [50.0, 90.0],
        [50.0, 60.0],
        [50.0, 40.0],
        [40.0, 55.0],
        [25.0, 60.0],
        [10.0, 65.0],
        [60.0, 55.0],
        [75.0, 60.0],
        [90.0, 65.0],
        [45.0, 100.0],
        [43.0, 130.0],
        [41.0, 160.0],
        [55.0, 100.0],
        [57.0, 130.0],
        [59.0, 160.0],
    ];

    #[test]
    fn bones_keep_their_length_and_a_walk_comes_round() {
        let length = |joints: &[[f64; 2]; 16], joint: usize| {
            let parent = JOINTS[joint].1.unwrap();
            let [a, b] = [joints[joint], joints[parent]];
            (a[0] - b[0]).hypot(a[1] - b[1])
        };
        for pose in [Pose::walk(70.0), Pose::walk(250.0), Pose::jump(0.3), Pose::jump(0.9)] {
            let posed = pose.posed(&REST);
            assert_ne!(posed.joints, REST);
            for joint in 1..16 {
                assert!((length(&posed.joints, joint) - length(&REST, joint)).abs() < 1e-12);
            }
        }
        let [a, b] = [0.0, 360.0].map(|phase| Pose::walk(phase).posed(&REST).joints);
        let apart = a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| (a - b).abs());
        assert!(apart.fold(0.0, f64::max) < 1e-10);
        assert_eq!(Pose::jump(0.0).posed(&REST).joints, REST, "it begins standing");
    }
}
