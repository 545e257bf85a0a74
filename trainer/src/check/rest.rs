//! The rest mesh: size and position, and whether the rest mesh belongs to the poses. Near rest, LBS must reproduce the
//! posed meshes.

use super::context::{Context, worst_first};
use super::finding::{Finding, FrameName, Kind, Severity, count, listed, short};
use super::thresholds::{FAR, GROUND, NEAR_REST, REST_ERROR, ROUNDED, TALL, VISIBLE};
use crate::envelope::clean::HOPS;
use crate::envelope::correction::features::near;
use crate::envelope::lbs::weights::Lbs;
use crate::envelope::{COARSE, too_far};
use crate::examples::Examples;
use crate::space::{millimetres, written};
use serde::Serialize;

/// The mesh's size at rest, in units of the input.
#[derive(Clone, Debug, Serialize)]
pub struct MeshSize {
    /// Extents along x, y and z.
    pub extents: [f64; 3],
    /// Diagonal of the bounding box.
    pub diagonal: f64,
    /// The axis on whose zero the mesh stands, if there is exactly one.
    pub ground: Option<char>,
    /// The axis of the largest extent.
    pub longest: char,
    /// Largest extent in metres; `None` if the unit is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub metres: Option<f64>,
    /// Units in which the largest extent suits a character, and the extent in metres.
    pub units: Vec<(&'static str, f64)>,
    /// Bits of an f32 that the distance from the origin costs.
    pub bits_lost: f64,
}

const AXES: [char; 3] = ['x', 'y', 'z'];
const UNITS: [(&str, f64); 3] = [("metres", 1.0), ("centimetres", 0.01), ("millimetres", 0.001)];

pub(super) fn size(examples: &Examples, findings: &mut Vec<Finding>) -> MeshSize {
    let [low, high] = examples.bounds();
    let extents = [0, 1, 2].map(|axis| high[axis] - low[axis]);
    let longest = (0..3).rev().max_by(|&a, &b| extents[a].total_cmp(&extents[b])).unwrap_or(0);
    let stands = |&axis: &usize| low[axis].abs() < GROUND * extents[axis];
    let ground: Vec<usize> = (0..3).filter(stands).collect();
    let candidates = UNITS.map(|(unit, metres)| (unit, metres * extents[longest]));
    let diagonal = examples.diagonal();
    let distance = examples.centroid().iter().map(|x| x * x).sum::<f64>().sqrt();
    let size = MeshSize {
        extents,
        diagonal,
        ground: if let [axis] = ground[..] { Some(AXES[axis]) } else { None },
        longest: AXES[longest],
        metres: millimetres(&examples.space).map(|unit| 1e-3 * unit * extents[longest]),
        units: candidates.into_iter().filter(|m| is_usual(m.1)).collect(),
        bits_lost: (distance / diagonal).max(1.0).log2(),
    };
    if let Some(error) = too_far(examples, COARSE.1) {
        findings.push(Finding::warning(Kind::TooFar, error.to_string(), Vec::new()));
    } else if distance > FAR.0 * diagonal {
        let severity = if distance > FAR.1 * diagonal { Severity::Warning } else { Severity::Note };
        let text = format!(
            "the mesh stands {:.0} diagonals from the origin, which costs {:.0} of the 24 bits \
             of its positions: move mesh and skeleton to the origin before export",
            distance / diagonal,
            size.bits_lost
        );
        findings.push(Finding::new(severity, Kind::FarAway, text, Vec::new()));
    }
    let odd = match size.metres {
        Some(metres) if !is_usual(metres) => Some(unusual_size(metres, &size.units)),
        None if size.units.is_empty() => Some(format!(
            "{} units are no usual length of a character in metres, centimetres or millimetres; \
             a training works all the same",
            short(extents[longest])
        )),
        _ => None,
    };
    findings.extend(odd.map(|text| Finding::note(Kind::OddSize, text, Vec::new())));
    size
}

/// Returns whether a character may be this long, in metres.
fn is_usual(metres: f64) -> bool {
    (TALL.0..=TALL.1).contains(&metres)
}

/// Says that a mesh in a known unit has an unusual size, and names units in which the size is usual.
fn unusual_size(metres: f64, units: &[(&'static str, f64)]) -> String {
    let other =
        units.iter().map(|(unit, metres)| format!(" (in {unit} it would be {metres:.2} m)"));
    format!(
        "the mesh is {} m long in the unit of its file, an unusual length for a character{}: errors in millimetres use this \
         unit; a training works all the same",
        short(metres),
        other.collect::<String>()
    )
}

/// How far the rest mesh was tested.
#[derive(Clone, Debug, Serialize)]
pub struct Rest {
    /// The training frame nearest to rest.
    pub nearest: FrameName,
    /// The largest angle of its joints, in degrees.
    pub nearest_degrees: f64,
    /// RMS error of LBS in this frame, in % of the diagonal.
    pub nearest_lbs_percent: f64,
    /// The error in millimetres; `None` if the unit is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nearest_lbs_mm: Option<f64>,
    /// Number of joints with skin.
    pub joints: usize,
    /// Number of these joints that are near rest, with their neighbours, in some training frame.
    pub tested: usize,
}

pub(super) fn rest(context: &Context<'_>, findings: &mut Vec<Finding>) -> Rest {
    let poses = 0..context.frames.len();
    let joint_len = context.examples.joint_len();
    let bend = |i: usize| (0..joint_len).map(|j| context.turns.bend(i, j)).fold(0.0, f64::max);
    let nearest = poses.clone().min_by(|&a, &b| bend(a).total_cmp(&bend(b))).unwrap_or(0);
    let all: Vec<usize> = (0..context.dominant.len()).collect();

    let seen = VISIBLE.max(ROUNDED * context.examples.coarseness());
    // The fitted weights ignore painted weights, which may be wrong near rest too.
    let training = &context.training;
    let Lbs { weights, errors, .. } = training.free_lbs();
    let left = training.targets(&weights).residuals(&training.poses.stacked());
    let rms = |sum: f64, count: usize| (sum / count.max(1) as f64).sqrt();
    let (mut joints, mut tested) = (0, 0);
    let mut off = Vec::new();
    let skins = context.lbs_residuals().skins();
    for (joint, skin) in skins.iter().enumerate().filter(|(_, skin)| !skin.is_empty()) {
        joints += 1;
        let around = near(&context.training.skeleton.parents, joint, HOPS);
        let bend = |i: usize| around.iter().map(|&j| context.turns.bend(i, j)).fold(0.0, f64::max);
        // One frame with the rest mesh is enough: in other frames muscles may tense while the joints rest.
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
        let text = format!(
            "no mesh near rest matches the rest mesh, which may be another sculpt; differences: {}",
            listed(order.iter().map(line))
        );
        let places = order.iter().map(|&k| context.joint_place(off[k].0)).collect();
        findings.push(Finding::warning(Kind::RestDiffers, text, places));
    }
    // If LBS is exact, every frame shows that the rest mesh belongs to the poses.
    if tested == 0 && training.lbs_rms() > seen {
        let text = format!(
            "no training frame is near rest (the nearest is frame {}, {:.0}° away), so \
             nothing shows whether the rest mesh belongs to the poses: add the rest pose",
            context.frame(nearest),
            bend(nearest)
        );
        findings.push(Finding::note(Kind::RestUntested, text, context.frames([nearest])));
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
    /// Describes the tests in one line.
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
