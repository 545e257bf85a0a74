//! Scale and place of the mesh.

use super::finding::{Finding, Kind, Severity, short};
use super::thresholds::{FAR, GROUND, TALL};
use crate::envelope::{COARSE, FitError};
use crate::examples::Examples;
use crate::space::millimetres;
use serde::Serialize;

/// The mesh's size at rest, in units of the input.
#[derive(Clone, Debug, Serialize)]
pub struct MeshSize {
    /// Extents along x, y and z.
    pub extents: [f64; 3],
    /// Diagonal of the bounding box.
    pub diagonal: f64,
    /// The axis on whose zero the mesh stands, where there is one.
    pub ground: Option<char>,
    /// The axis along which the mesh is longest.
    pub longest: char,
    /// Length in metres along the longest axis; `None` where the unit is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub metres: Option<f64>,
    /// Units in which its largest extent is that of a character, and it in metres.
    pub units: Vec<(&'static str, f64)>,
    /// Bits of an f32 that its distance from the origin costs.
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
    if let Some(error) = FitError::too_far(examples, COARSE.1) {
        findings.push(Finding {
            kind: Kind::TooFar,
            severity: Severity::Warning,
            text: error.to_string(),
            places: Vec::new(),
        });
    } else if distance > FAR.0 * diagonal {
        findings.push(Finding {
            kind: Kind::FarAway,
            severity: if distance > FAR.1 * diagonal { Severity::Warning } else { Severity::Note },
            text: format!(
                "the mesh stands {:.0} diagonals from the origin, which costs {:.0} of the 24 bits \
                 of its positions: move mesh and skeleton to the origin before export",
                distance / diagonal,
                size.bits_lost
            ),
            places: Vec::new(),
        });
    }
    let odd = match size.metres {
        Some(metres) if !is_usual(metres) => Some(known(metres, &size.units)),
        None if size.units.is_empty() => Some(format!(
            "{} units are no character's size in metres, centimetres or millimetres; a \
             training does not mind",
            short(extents[longest])
        )),
        _ => None,
    };
    if let Some(text) = odd {
        findings.push(Finding {
            kind: Kind::OddSize,
            severity: Severity::Note,
            text,
            places: Vec::new(),
        });
    }
    size
}

/// Returns whether a character may be this long, in metres.
fn is_usual(metres: f64) -> bool {
    (TALL.0..=TALL.1).contains(&metres)
}

/// Says that a mesh in a known unit has an unusual size, and which unit would make that usual.
fn known(metres: f64, units: &[(&'static str, f64)]) -> String {
    let other =
        units.iter().map(|(unit, metres)| format!(" (in {unit} it would be {metres:.2} m)"));
    format!(
        "the mesh is {} m long by the unit of its file, no usual size of a character{}: errors in millimetres follow that \
         unit; a training does not mind",
        short(metres),
        other.collect::<String>()
    )
}
