//! Makes poses within the ranges that a file states, as a caller would, and poses that scale, shear
//! and hide joints.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew_runtime::format::TRAVEL_MAX;
use sinew_runtime::{Envelope, LocalTransform, Matrix3x4, model_space_pose};
use std::f64::consts::PI;

/// A transform in f64, the precision of poses in the making.
type Transform = [[f64; 4]; 3];

const IDENTITY: Transform = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// Largest distance of a pose from the rest position, in diagonals of the character.
const FAR: f64 = 100.0;

/// Number of kinds of poses, which alternate.
pub const KINDS: usize = 7;

/// Makes a pose of J skinning matrices, whose kind depends on `number`:
///
/// - rest;
/// - every joint at the end of its range;
/// - every joint somewhere in its range;
/// - every joint somewhere in its range, far from the rest position;
/// - every joint somewhere in its range, far away and through [`model_space_pose`];
/// - every joint somewhere in its range; joints that stretch have their largest scale and shear;
/// - the same, with about half of the joints hidden or mirrored.
///
/// A hostile range may exceed every rotation: angles stop at π.
pub fn pose(envelope: &Envelope<'_>, number: usize) -> Vec<Matrix3x4> {
    let mut random = ChaCha8Rng::seed_from_u64(number as u64);
    let kind = number % KINDS;
    match kind {
        0 => vec![IDENTITY.map(|row| row.map(|x| x as f32)); envelope.joint_len()],
        1 => skinning(envelope, &turns(envelope, true, &mut random), &IDENTITY),
        2 => skinning(envelope, &turns(envelope, false, &mut random), &IDENTITY),
        3 => {
            let far = FAR * f64::from(envelope.certificate().diagonal.abs());
            let mut motion = rotation(&mut random, PI);
            motion.iter_mut().for_each(|row| row[3] = far * random.random_range(-1.0..1.0));
            skinning(envelope, &turns(envelope, false, &mut random), &motion)
        }
        4 => from_local(envelope, &local(envelope, number)),
        _ => {
            let mut pose = skinning(envelope, &turns(envelope, false, &mut random), &IDENTITY);
            stretch(envelope, &mut pose, &mut random);
            if kind == 6 {
                hide(envelope, &mut pose, &mut random);
            }
            pose
        }
    }
}

/// Makes the C curves of a pose: at rest, at the end of their ranges, somewhere in their ranges, or
/// anywhere that a curve may be.
pub fn curves(envelope: &Envelope<'_>, number: usize) -> Vec<f32> {
    let mut random = ChaCha8Rng::seed_from_u64(number as u64);
    let ranges = (0..envelope.curve_len()).map(|c| envelope.curve_range(c).unwrap_or_default());
    let value = |[least, most]: [f32; 2]| match number % KINDS {
        0 => 0.0,
        1 => most,
        3 => random.random_range(-TRAVEL_MAX..TRAVEL_MAX),
        _ => random.random_range(least..=most),
    };
    ranges.map(value).collect()
}

/// Scales and shears the joints that stretch, by factors of 1/4 to 4 along any three axes.
fn stretch(envelope: &Envelope<'_>, pose: &mut [Matrix3x4], random: &mut ChaCha8Rng) {
    let joints = pose.iter_mut().enumerate();
    for (_, map) in joints.filter(|(joint, _)| envelope.stretch_range(*joint) > Some(0.0)) {
        let axes = rotation(random, PI);
        let factors: [f64; 3] = [(); 3].map(|()| 4f64.powf(random.random_range(-1.0..=1.0)));
        let scaled = axes.map(|row| [0, 1, 2].map(|c| row[c] * factors[c]));
        // The product of the scaled axes and the axes transposed.
        let stretch = [0, 1, 2]
            .map(|r| [0, 1, 2].map(|c| (0..3).map(|k| scaled[r][k] * axes[c][k]).sum::<f64>()));
        *map = map.map(|row| {
            let [x, y, z] = [0, 1, 2]
                .map(|c| (0..3).map(|k| f64::from(row[k]) * stretch[k][c]).sum::<f64>() as f32);
            [x, y, z, row[3]]
        });
    }
}

/// Hides about half of the joints, by a scale of 0 along an axis or more or by a mirror. The root
/// stays unless it is alone, because all follow it.
fn hide(envelope: &Envelope<'_>, pose: &mut [Matrix3x4], random: &mut ChaCha8Rng) {
    let is_alone = pose.len() == 1;
    let joints = pose.iter_mut().enumerate();
    for (_, map) in joints.filter(|(joint, _)| is_alone || *joint != envelope.root()) {
        let factors = match random.random_range(0..8) {
            0 => [0.0; 3],
            1 => [0.0, 1.0, 1.0],
            2 => [-1.0, 1.0, 1.0],
            3 => [-1.0; 3],
            _ => continue,
        };
        for row in map {
            row.iter_mut().zip(factors).for_each(|(x, factor)| *x *= factor);
        }
    }
}

/// Turns each joint in its local frame, as an engine does that plays clips: within its range or at
/// its end.
pub fn local(envelope: &Envelope<'_>, number: usize) -> Vec<LocalTransform> {
    let mut random = ChaCha8Rng::seed_from_u64(number as u64);
    let turns = turns(envelope, number.is_multiple_of(2), &mut random);
    let local = turns.iter().enumerate().map(|(joint, turn)| {
        let frame = rest_frame(envelope, joint);
        let parent = envelope.parent(joint).map(|parent| inverse(&rest_frame(envelope, parent)));
        let rest = parent.map_or(frame, |parent| compose(&parent, &frame));
        let turned = compose(&rest, turn);
        LocalTransform { rotation: quaternion(&turned), translation: turned.map(|r| r[3] as f32) }
    });
    local.collect()
}

/// Computes the pose of local transforms that use the file's frames.
pub fn from_local(envelope: &Envelope<'_>, local: &[LocalTransform]) -> Vec<Matrix3x4> {
    let mut out = vec![[[0.0; 4]; 3]; envelope.joint_len()];
    match model_space_pose(envelope, local, &mut out) {
        Ok(()) => out,
        Err(error) => panic!("a local transform of the file's own frames is refused: {error}"),
    }
}

/// Draws a rotation per joint, by an angle within the joint's range or at its end.
fn turns(envelope: &Envelope<'_>, at_end: bool, random: &mut ChaCha8Rng) -> Vec<Transform> {
    let ranges = (0..envelope.joint_len()).map(|j| envelope.pose_range(j).unwrap_or_default());
    let angle = |random: &mut ChaCha8Rng| if at_end { 1.0 } else { random.random_range(0.0..1.0) };
    ranges
        .map(|range| {
            let angle = f64::from(range).min(PI) * angle(random);
            rotation(random, angle)
        })
        .collect()
}

/// Turns each joint about its rest origin, in the axes of the rest pose, then moves the whole
/// character.
fn skinning(envelope: &Envelope<'_>, turns: &[Transform], motion: &Transform) -> Vec<Matrix3x4> {
    let mut transforms = vec![*motion; envelope.joint_len()];
    for joint in envelope.evaluation_order() {
        let origin = rest_frame(envelope, joint).map(|row| row[3]);
        let mut local = turns[joint];
        for (row, origin_r) in local.iter_mut().zip(origin) {
            row[3] = origin_r - (0..3).map(|c| row[c] * origin[c]).sum::<f64>();
        }
        let parent = envelope.parent(joint).map_or(*motion, |parent| transforms[parent]);
        transforms[joint] = compose(&parent, &local);
    }
    transforms.iter().map(|transform| transform.map(|row| row.map(|x| x as f32))).collect()
}

/// Returns the frame of a joint in the rest pose, with the bind matrix taken as rigid.
fn rest_frame(envelope: &Envelope<'_>, joint: usize) -> Transform {
    let bind = envelope.inverse_bind(joint).unwrap_or([[0.0; 4]; 3]);
    inverse(&bind.map(|row| row.map(f64::from)))
}

fn inverse(m: &Transform) -> Transform {
    [0, 1, 2].map(|r| {
        let t = (0..3).map(|k| m[k][r] * m[k][3]).sum::<f64>();
        [m[0][r], m[1][r], m[2][r], -t]
    })
}

fn compose(a: &Transform, b: &Transform) -> Transform {
    a.map(|row| {
        let mut out = [0, 1, 2, 3].map(|c| (0..3).map(|k| row[k] * b[k][c]).sum::<f64>());
        out[3] += row[3];
        out
    })
}

/// Draws a rotation of an angle about any axis.
fn rotation(random: &mut ChaCha8Rng, angle: f64) -> Transform {
    let axis: [f64; 3] = [(); 3].map(|()| random.random_range(-1.0..1.0));
    let length = axis.iter().map(|x| x * x).sum::<f64>().sqrt().max(1e-9);
    let [x, y, z] = axis.map(|x| x / length);
    let (s, c) = angle.sin_cos();
    let v = 1.0 - c;
    [
        [c + v * x * x, v * x * y - s * z, v * x * z + s * y, 0.0],
        [v * x * y + s * z, c + v * y * y, v * y * z - s * x, 0.0],
        [v * x * z - s * y, v * y * z + s * x, c + v * z * z, 0.0],
    ]
}

/// Converts a rotation to a quaternion, by the largest of the four components (Shepperd 1978).
fn quaternion(m: &Transform) -> [f32; 4] {
    let [[xx, xy, xz, _], [yx, yy, yz, _], [zx, zy, zz, _]] = *m;
    let q = if xx + yy + zz >= 0.0 {
        [zy - yz, xz - zx, yx - xy, 1.0 + xx + yy + zz]
    } else if xx >= yy && xx >= zz {
        [1.0 + xx - yy - zz, xy + yx, xz + zx, zy - yz]
    } else if yy >= zz {
        [xy + yx, 1.0 + yy - xx - zz, yz + zy, xz - zx]
    } else {
        [xz + zx, yz + zy, 1.0 + zz - xx - yy, yx - xy]
    };
    let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    q.map(|x| (x / length) as f32)
}
