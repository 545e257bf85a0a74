//! A hand drawing with its mask and 16 joints, cut into triangles and set in motion.

use super::data::{Examples, Layer, Parameter, View, ViewSet};
use super::elements::Element;
use super::error::SetError;
use super::image::{Image, size};
use super::silhouette::Silhouette;
use crate::formats::FormatError;
use crate::page::picture::Picture;
use crate::views::motion::{JOINTS, Pose, Posed, carried};
use std::path::Path;

/// Triangles' sides along the longer side of the drawing.
const ACROSS: f64 = 32.0;
/// How fast the hold of a bone falls with the distance from it.
const FALL: i32 = 4;
/// Phases of the walk that are examples, degrees.
const PHASES: [f64; 8] = [0.0, 45.0, 90.0, 135.0, 180.0, 225.0, 270.0, 315.0];
/// Times of the jump that are examples; the first is the drawing.
const TIMES: [f64; 7] = [0.0, 0.15, 0.3, 0.5, 0.7, 0.85, 1.0];

/// Reads a drawing by its description, `char_cfg.yaml`, beside which `texture.png` and `mask.png` lie: points
/// are its joints and the corners of triangles inside the mask, motions a walk and a jump.
///
/// # Errors
/// [`SetError`].
pub fn read_drawing(description: &Path) -> Result<ViewSet, SetError> {
    let text = std::fs::read_to_string(description).map_err(FormatError::Read)?;
    let rest = joints(&text)?;
    let folder = description.parent().unwrap_or(Path::new(""));
    let image = Image {
        file: folder.join("texture.png"),
        mask: Some(folder.join("mask.png")),
        layer: None,
    };
    let size = size(&image.file)?;
    let mesh = Mesh::new(&image.load(size)?, &rest)?;
    let view = |pose: Pose, name: &str, value: f64, image: Option<Image>| {
        let points = mesh.posed(&rest, &pose.posed(&rest));
        View {
            values: [(name.to_owned(), value)].into(),
            visible: vec![true; points.len()],
            points: points.into_iter().map(Some).collect(),
            depths: Vec::new(),
            image,
            layers: Vec::new(),
        }
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

/// Reads the joints: of each its place and its name.
fn joints(text: &str) -> Result<[[f64; 2]; 16], SetError> {
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
    let lacking = |joint: usize| SetError::Parameter {
        view: "skeleton".to_owned(),
        name: JOINTS[joint].0.to_owned(),
        what: "missing",
    };
    missing.map_or_else(|| Ok(out.map(Option::unwrap_or_default)), |joint| Err(lacking(joint)))
}

/// Triangles over a drawing, and what holds their corners.
struct Mesh {
    corners: Vec<[f64; 2]>,
    /// How much each bone holds a corner, by the joint at its end.
    weights: Vec<[f64; 16]>,
    /// Of the joints and the corners behind them: what is in the middle of the figure last.
    elements: Vec<Element>,
}

impl Mesh {
    fn new(picture: &Picture, rest: &[[f64; 2]; 16]) -> Result<Self, SetError> {
        let Silhouette { corners, faces } = Silhouette::of(picture, ACROSS, 0)?;
        let weights: Vec<[f64; 16]> = corners.iter().map(|corner| held(*corner, rest)).collect();
        let mut order: Vec<(usize, [usize; 3])> = Vec::new();
        for own in faces {
            let strongest = |k: usize| {
                let weights = &weights[own[k]];
                (0..16).max_by(|&a, &b| weights[a].total_cmp(&weights[b])).unwrap_or_default()
            };
            order.push((layer(strongest(0)), own));
        }
        order.sort_by_key(|(layer, _)| *layer);
        let behind =
            |(_, face): (usize, [usize; 3])| Element::Triangle(face.map(|c| JOINTS.len() + c));
        Ok(Self { corners, weights, elements: order.into_iter().map(behind).collect() })
    }

    /// Lists joints and corners of a pose.
    fn posed(&self, rest: &[[f64; 2]; 16], posed: &Posed) -> Vec<[f64; 2]> {
        let corner = |(corner, weights): (&[f64; 2], &[f64; 16])| {
            let mut out = [0.0; 2];
            for (joint, weight) in weights.iter().enumerate() {
                let Some(parent) = JOINTS[joint].1 else { continue };
                let own = carried(*corner, rest[parent], posed.joints[parent], posed.turned[joint]);
                (0..2).for_each(|axis| out[axis] += weight * own[axis]);
            }
            out
        };
        let corners = self.corners.iter().zip(&self.weights).map(corner);
        posed.joints.iter().copied().chain(corners).collect()
    }
}

/// Returns how far in front a bone lies: legs, arms, then what is in the middle.
fn layer(joint: usize) -> usize {
    match joint {
        10..=15 => 0,
        4..=9 => 1,
        _ => 2,
    }
}

/// Returns how much each bone holds a point.
fn held(point: [f64; 2], rest: &[[f64; 2]; 16]) -> [f64; 16] {
    let mut out = [0.0; 16];
    for (joint, (_, parent)) in JOINTS.iter().enumerate() {
        if let Some(parent) = *parent {
            out[joint] = 1.0 / (1.0 + distance(point, rest[parent], rest[joint])).powi(FALL);
        }
    }
    let sum: f64 = out.iter().sum();
    out.map(|weight| weight / sum)
}

/// Returns how far a point is from a line between two others.
fn distance(point: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let along = [b[0] - a[0], b[1] - a[1]];
    let to = [point[0] - a[0], point[1] - a[1]];
    let squared = along[0] * along[0] + along[1] * along[1];
    let share = if squared > 0.0 { (to[0] * along[0] + to[1] * along[1]) / squared } else { 0.0 };
    let share = share.clamp(0.0, 1.0);
    (to[0] - share * along[0]).hypot(to[1] - share * along[1])
}
