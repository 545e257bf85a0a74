//! A hand drawing with a mask and 16 joints: cuts it into triangles and animates a walk and a jump.

use super::data::{Element, Examples, Image, Layer, Parameter, View, ViewSet, picture_size};
use super::elements::Silhouette;
use super::json::missing_parameter;
use crate::Error;
use crate::numeric::columns::ends;
use crate::page::picture::Picture;
use std::path::Path;

/// Number of triangle sides along the longer side of the drawing.
const ACROSS: f64 = 32.0;
/// Exponent of the distance in the weight of a bone.
const FALLOFF: i32 = 4;
/// Phases of the walk's training views, degrees.
const PHASES: [f64; 8] = [0.0, 45.0, 90.0, 135.0, 180.0, 225.0, 270.0, 315.0];
/// Times of the jump's training views. The drawing is the first.
const TIMES: [f64; 7] = [0.0, 0.15, 0.3, 0.5, 0.7, 0.85, 1.0];

/// Names of the joints, and the index of each parent. Parents come first.
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

/// Reads a drawing by its description `char_cfg.yaml`, with `texture.png` and `mask.png` in the same folder. Points are
/// the joints and the corners of triangles inside the mask. The motions are a walk and a jump.
///
/// # Errors
/// A file cannot be read or is damaged, a joint is missing, the mask has another size than the texture, or the mask is
/// empty.
pub fn read_drawing(description: &Path) -> Result<ViewSet, Error> {
    let text = std::fs::read_to_string(description).map_err(Error::read)?;
    let rest = joints(&text)?;
    let folder = description.parent().unwrap_or(Path::new(""));
    let mask = Some(folder.join("mask.png"));
    let image = Image { mask, ..Image::of_file(folder.join("texture.png")) };
    let size = picture_size(&image.file)?;
    let mesh = Mesh::new(&image.load(size)?, &rest)?;
    let view = |pose: Pose, name: &str, value: f64, image: Option<Image>| {
        let points = mesh.posed(&rest, &pose.posed(&rest));
        View { image, ..View::of_points([(name.to_owned(), value)].into(), points) }
    };
    let key = |time: f64| (time == TIMES[0]).then(|| image.clone());
    let jump = TIMES.map(|time| view(Pose::jump(time), "time", time, key(time)));
    let walk = PHASES.map(|phase| view(Pose::walk(phase), "phase", phase, None));
    let phase = Parameter::Rotation { angles: [None, None, Some("phase".to_owned())], order: None };
    let map = |name: &str, parameter, train: Vec<View>| Examples {
        name: name.to_owned(),
        parameters: vec![parameter],
        train,
        test: Vec::new(),
    };
    let name = folder.file_name().map(|name| name.to_string_lossy().into_owned());
    let name = name.unwrap_or_default();
    let layer = Layer::whole(&name, JOINTS.len() + mesh.corners.len(), mesh.elements);
    Ok(ViewSet {
        name,
        size,
        layers: vec![layer],
        maps: vec![
            map("walk", phase, walk.into()),
            map("jump", Parameter::Scalar("time".to_owned()), jump.into()),
        ],
    })
}

/// Reads the positions of the joints, pixels.
fn joints(text: &str) -> Result<[[f64; 2]; 16], Error> {
    let mut out = [None; 16];
    let mut place = Vec::new();
    for line in text.lines() {
        let line = line.trim().trim_start_matches("- ");
        if line == "loc:" {
            place.clear();
        } else if let Ok(number) = line.parse::<f64>() {
            place.push(number);
        } else if let Some(name) = line.strip_prefix("name:")
            && let Some(joint) = JOINTS.iter().position(|(known, _)| *known == name.trim())
            && let &[x, y] = place.as_slice()
        {
            out[joint] = Some([x, y]);
        }
    }
    let missing = out.iter().position(Option::is_none);
    match missing {
        None => Ok(out.map(Option::unwrap_or_default)),
        Some(joint) => Err(missing_parameter("skeleton", JOINTS[joint].0)),
    }
}

/// Triangles over a drawing, and the bone weights of their corners.
struct Mesh {
    corners: Vec<[f64; 2]>,
    /// Weight of each bone at each corner. A bone has the index of the joint at its end.
    weights: Vec<[f64; 16]>,
    /// Elements over points: the joints, then the corners. Elements in the middle of the figure come last.
    elements: Vec<Element>,
}

impl Mesh {
    fn new(picture: &Picture, rest: &[[f64; 2]; 16]) -> Result<Self, Error> {
        let Silhouette { corners, mut faces } = Silhouette::of(picture, ACROSS, 0)?;
        let weights: Vec<[f64; 16]> =
            corners.iter().map(|corner| bone_weights(*corner, rest)).collect();
        faces.sort_by_key(|[corner, ..]| {
            let weights = &weights[*corner];
            let strongest = (0..16).max_by(|&a, &b| weights[a].total_cmp(&weights[b]));
            depth_order(strongest.unwrap_or_default())
        });
        let element = |face: [usize; 3]| Element::Triangle(face.map(|c| JOINTS.len() + c));
        Ok(Self { corners, weights, elements: faces.into_iter().map(element).collect() })
    }

    /// Lists joints and corners in a pose.
    fn posed(&self, rest: &[[f64; 2]; 16], posed: &Posed) -> Vec<[f64; 2]> {
        let corner = |(corner, weights): (&[f64; 2], &[f64; 16])| {
            let mut out = [0.0; 2];
            for (joint, weight) in weights.iter().enumerate() {
                let Some(parent) = JOINTS[joint].1 else { continue };
                let own = rotated(*corner, rest[parent], posed.joints[parent], posed.turned[joint]);
                (0..2).for_each(|axis| out[axis] += weight * own[axis]);
            }
            out
        };
        let corners = self.corners.iter().zip(&self.weights).map(corner);
        posed.joints.iter().copied().chain(corners).collect()
    }
}

/// Returns the depth order of a bone: legs, then arms, then the middle in front.
fn depth_order(joint: usize) -> usize {
    match joint {
        10..=15 => 0,
        4..=9 => 1,
        _ => 2,
    }
}

/// Returns the weight of each bone at a point.
fn bone_weights(point: [f64; 2], rest: &[[f64; 2]; 16]) -> [f64; 16] {
    let mut out = [0.0; 16];
    for (joint, (_, parent)) in JOINTS.iter().enumerate() {
        if let Some(parent) = *parent {
            out[joint] =
                1.0 / (1.0 + segment_distance(point, rest[parent], rest[joint])).powi(FALLOFF);
        }
    }
    let sum: f64 = out.iter().sum();
    out.map(|weight| weight / sum)
}

/// Returns the distance of a point from a line segment.
pub(in crate::views) fn segment_distance(point: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let along = [b[0] - a[0], b[1] - a[1]];
    let to = [point[0] - a[0], point[1] - a[1]];
    let squared = along[0] * along[0] + along[1] * along[1];
    let share = if squared > 0.0 { (to[0] * along[0] + to[1] * along[1]) / squared } else { 0.0 };
    let share = share.clamp(0.0, 1.0);
    (to[0] - share * along[0]).hypot(to[1] - share * along[1])
}

/// A pose, relative to rest.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Pose {
    /// Shift of the root, in heights of the figure, y down.
    shift: [f64; 2],
    /// Angle of the bone that ends at each joint, relative to the parent's bone, degrees, clockwise on the screen.
    turns: [f64; 16],
}

/// Joints of a posed figure, and the turns of its bones.
#[derive(Clone, Debug, PartialEq)]
struct Posed {
    /// Positions, pixels.
    joints: [[f64; 2]; 16],
    /// Absolute turn of the bone that ends at each joint, radians.
    turned: [f64; 16],
}

impl Pose {
    /// Walks: a phase of 360 degrees is the same as 0.
    fn walk(phase: f64) -> Self {
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

    /// Jumps: the figure stands at times 0 and 1.
    fn jump(time: f64) -> Self {
        let up = (std::f64::consts::PI * time).sin();
        let bent = (2.0 * std::f64::consts::PI * time).sin().powi(2);
        let mut turns = [0.0; 16];
        (turns[5], turns[8]) = (45.0 * up, -45.0 * up);
        (turns[6], turns[9]) = (20.0 * up, -20.0 * up);
        (turns[11], turns[14]) = (20.0 * bent, -20.0 * bent);
        (turns[12], turns[15]) = (-35.0 * bent, 35.0 * bent);
        Self { shift: [0.0, -0.06 * up * up], turns }
    }

    /// Poses joints.
    ///
    /// - `rest`: positions at rest, pixels.
    fn posed(&self, rest: &[[f64; 2]; 16]) -> Posed {
        let [top, bottom] = ends(&rest.map(|joint| joint[1]));
        let height = bottom - top;
        let mut out = Posed { joints: *rest, turned: [0.0; 16] };
        for (joint, (_, parent)) in JOINTS.iter().enumerate() {
            let Some(parent) = *parent else {
                out.joints[joint] =
                    [0, 1].map(|axis| rest[joint][axis] + height * self.shift[axis]);
                continue;
            };
            let turned = out.turned[parent] + self.turns[joint].to_radians();
            out.turned[joint] = turned;
            out.joints[joint] = rotated(rest[joint], rest[parent], out.joints[parent], turned);
        }
        out
    }
}

/// Turns a point around the rest position of a joint, and moves the point with the joint.
fn rotated(point: [f64; 2], rest: [f64; 2], joint: [f64; 2], turned: f64) -> [f64; 2] {
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
