//! Tests whether mesh and skeleton agree in units, axes, position and vertex order.
//!
//! Each vertex of a sample follows the single joint that fits the vertex best. If the error is large, the rest mesh,
//! the posed meshes or the joints are tried in other units and axes, and shifted.

use super::context::{Context, worst_first};
use super::finding::{Finding, Kind, count};
use super::thresholds::{MISPLACED, REMEDIED};
use crate::envelope::clean::rigid_offsets;
use crate::examples::{Examples, Split, diagonal, is_shuffled, spread};
use crate::numeric::affine::from_rows;
use crate::space::{axis_names, rotations};
use nalgebra::{Matrix3, Matrix3x4, Vector3};
use rayon::prelude::*;

/// Vertices and frames of the sample: enough to tell a wrong unit from a bend.
const SAMPLE: (usize, usize) = (120, 8);

/// Length ratios of usual units.
const SCALES: [f64; 5] = [1.0, 0.01, 0.1, 10.0, 100.0];

/// The part of the examples that may have been exported with other settings.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Part {
    Joints,
    Rest,
    Posed,
}

/// A remedy of one part: its points go to `turn x + shift`.
#[derive(Clone, Copy, Debug)]
struct Remedy {
    part: Part,
    turn: Matrix3<f64>,
    shift: Vector3<f64>,
}

/// A remedy that makes mesh and skeleton fit.
pub(super) struct Convention {
    kind: Kind,
    /// The remedy in words.
    pub(super) change: String,
    /// Error of the best single joint of each vertex with the remedy and without, RMS in diagonals of the posed
    /// mesh.
    errors: [f64; 2],
}

impl Convention {
    /// Makes the finding.
    ///
    /// - `place`: prefix of the text; empty for all clips.
    pub(super) fn finding(self, place: &str) -> Finding {
        let Self { kind, change, errors } = self;
        let [with, without] = errors.map(|share| 100.0 * share);
        let text = format!(
            "{place}{change}: the error of the best single joint of each vertex is then {with:.2} % of the diagonal \
             instead of {without:.0} %; do not rely on the findings below until this is fixed"
        );
        Finding::warning(kind, text, Vec::new())
    }
}

/// Reports different units, axes and positions. Returns whether mesh and skeleton do not fit for an unknown reason.
pub(super) fn convention(examples: &Examples, findings: &mut Vec<Finding>) -> bool {
    let sample = Sample::new(examples, &examples.frames_of(Split::Train));
    let remedy = sample.check(&[Part::Joints, Part::Rest, Part::Posed]).err();
    let is_unknown = matches!(remedy, Some(None));
    findings.extend(remedy.flatten().map(|remedy| remedy.finding("")));
    is_unknown
}

/// Returns the remedy of a clip's units, axes or position if the other clips are right. All clips share the rest mesh,
/// so only joints and posed meshes are tried.
pub(super) fn of_clip(examples: &Examples, frames: &[usize]) -> Option<Convention> {
    Sample::new(examples, frames).check(&[Part::Posed, Part::Joints]).err().flatten()
}

/// Some vertices in some training frames.
struct Sample {
    rest: Vec<Vector3<f64>>,
    /// Maps of the joints, by frame.
    joints: Vec<Vec<Matrix3x4<f64>>>,
    /// Posed vertices, by frame.
    posed: Vec<Vec<Vector3<f64>>>,
    /// Diagonal of the posed mesh.
    unit: f64,
}

impl Sample {
    fn new(examples: &Examples, frames: &[usize]) -> Self {
        let vertices = spread(examples.vertex_len(), SAMPLE.0);
        let frames = spread(frames.len(), SAMPLE.1).into_iter().map(|i| frames[i]);
        let at = |points: &[[f64; 3]]| vertices.iter().map(|&v| points[v].into()).collect();
        let posed: Vec<Vec<Vector3<f64>>> = frames.clone().map(|f| at(examples.frame(f))).collect();
        let points = posed.iter().take(1).flatten().map(|&x| x.into());
        let maps = |frame| examples.pose(frame).iter().map(from_rows).collect();
        Self {
            rest: at(&examples.rest),
            joints: frames.map(maps).collect(),
            unit: diagonal(points),
            posed,
        }
    }

    /// Checks whether mesh and skeleton fit together, and tries remedies, each of one part.
    ///
    /// # Errors
    /// They do not fit: the remedy after which they fit; `None` if no remedy helps.
    fn check(&self, parts: &[Part]) -> Result<(), Option<Convention>> {
        let as_it_is =
            Remedy { part: Part::Rest, turn: Matrix3::identity(), shift: Vector3::zeros() };
        let error = self.error(&as_it_is);
        if error < MISPLACED * self.unit {
            return Ok(());
        }
        let mut remedies = Vec::new();
        for &part in parts {
            for scale in SCALES {
                let turns = rotations();
                remedies.extend(turns.map(|turn| Remedy { part, turn: turn * scale, ..as_it_is }));
            }
        }
        remedies.extend(parts.iter().map(|&part| self.shift(part)));
        let errors: Vec<f64> = remedies.par_iter().map(|remedy| self.error(remedy)).collect();
        let best = (0..errors.len()).min_by(|&a, &b| errors[a].total_cmp(&errors[b])).unwrap_or(0);
        if errors[best] > REMEDIED * error {
            return Err(None);
        }
        Err(Some(Convention {
            kind: remedies[best].kind(),
            change: remedies[best].describe(),
            errors: [errors[best], error].map(|error| error / self.unit),
        }))
    }

    /// Returns the RMS distance of vertices from their positions after a remedy, in units of the posed meshes.
    fn error(&self, remedy: &Remedy) -> f64 {
        let Remedy { part, turn, shift } = *remedy;
        let moved = |x: &Vector3<f64>, fixed: Part| match part == fixed {
            true => *x,
            false => turn * x + shift,
        };
        let scale = if part == Part::Rest { 1.0 } else { remedy.scale() };
        let sum: f64 = (0..self.rest.len())
            .map(|v| {
                let x = moved(&self.rest[v], Part::Posed).push(1.0);
                let truth = self.posed.iter().map(|posed| moved(&posed[v], Part::Rest));
                let truth: Vec<_> = truth.collect();
                let of = |joint: usize| -> f64 {
                    let maps = self.joints.iter().map(|pose| pose[joint]);
                    maps.zip(&truth).map(|(map, y)| (map * x - y).norm_squared()).sum()
                };
                (0..self.joint_len()).map(of).fold(f64::INFINITY, f64::min)
            })
            .sum();
        (sum / (self.rest.len() * self.posed.len()).max(1) as f64).sqrt() / scale
    }

    /// Returns the median of the vertices' shifts, each with the joint that then fits the vertex best.
    fn shift(&self, part: Part) -> Remedy {
        let shifts: Vec<Vector3<f64>> = (0..self.rest.len())
            .into_par_iter()
            .filter_map(|v| {
                let of = |joint| self.shift_of(part, v, joint);
                let all = (0..self.joint_len()).filter_map(of);
                all.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(shift, _)| shift)
            })
            .collect();
        let median = |axis: usize| {
            let mut along: Vec<f64> = shifts.iter().map(|shift| shift[axis]).collect();
            along.sort_by(f64::total_cmp);
            along.get(along.len() / 2).copied().unwrap_or(0.0)
        };
        Remedy { part, turn: Matrix3::identity(), shift: Vector3::from_fn(|axis, _| median(axis)) }
    }

    /// Returns the shift with which a joint fits a vertex best, and the squared error; `None` if the joint does not
    /// determine the shift.
    fn shift_of(&self, part: Part, v: usize, joint: usize) -> Option<(Vector3<f64>, f64)> {
        let equations: Vec<(Matrix3<f64>, Vector3<f64>)> = (0..self.posed.len())
            .map(|frame| {
                let map = &self.joints[frame][joint];
                let linear: Matrix3<f64> = map.fixed_columns::<3>(0).into();
                let gap = self.posed[frame][v] - map * self.rest[v].push(1.0);
                let factor = match part {
                    Part::Joints => linear - Matrix3::identity(),
                    Part::Rest => linear,
                    Part::Posed => -Matrix3::identity(),
                };
                (factor, gap)
            })
            .collect();
        let normal: Matrix3<f64> = equations.iter().map(|(a, _)| a.transpose() * a).sum();
        let right: Vector3<f64> = equations.iter().map(|(a, gap)| a.transpose() * gap).sum();
        // If a joint hardly turns, every shift has the same effect.
        let eigen = normal.symmetric_eigen();
        if eigen.eigenvalues.min() < 1e-2 * self.posed.len() as f64 {
            return None;
        }
        let shift = normal.cholesky()?.solve(&right);
        let left = equations.iter().map(|(a, gap)| (gap - a * shift).norm_squared()).sum();
        Some((shift, left))
    }

    fn joint_len(&self) -> usize {
        self.joints.first().map_or(0, Vec::len)
    }
}

impl Remedy {
    fn kind(&self) -> Kind {
        if self.shift != Vector3::zeros() {
            Kind::Shifted
        } else if (self.scale() - 1.0).abs() > 0.5 {
            Kind::OtherUnits
        } else {
            Kind::OtherAxes
        }
    }

    fn scale(&self) -> f64 {
        self.turn.column(0).norm()
    }

    /// Describes the remedy: the changed part and the parts that it then fits.
    fn describe(&self) -> String {
        let (what, against) = match self.part {
            Part::Joints => ("the joints", "the meshes"),
            Part::Rest => ("the rest mesh", "joints and posed meshes"),
            Part::Posed => ("the posed meshes", "joints and rest mesh"),
        };
        // For the joints, the remedy was applied to the meshes.
        let (turn, shift, scale) = match self.part {
            Part::Joints => (self.turn.transpose(), -self.shift, 1.0 / self.scale()),
            _ => (self.turn, self.shift, self.scale()),
        };
        if self.kind() == Kind::Shifted {
            let [x, y, z]: [f64; 3] = shift.into();
            return format!("{what} should be moved by ({x:.4}, {y:.4}, {z:.4}) to fit {against}");
        }
        let units = format!("{what} should be {scale} times the size");
        let axes = axis_names(&turn);
        let unturned = axes == axis_names(&Matrix3::identity());
        match self.kind() {
            Kind::OtherUnits if unturned => format!("{units} to fit {against}"),
            Kind::OtherUnits => format!("{units}, with axes {axes}, to fit {against}"),
            _ => format!("{what} should have the axes {axes} to fit {against}"),
        }
    }
}

/// Reports another vertex order, for meshes that do not fit the joints for an unknown reason.
pub(super) fn vertex_order(examples: &Examples) -> Option<Finding> {
    let text = "the posed meshes have the vertices of the rest mesh in another order: export both from one mesh; \
                do not rely on the findings below until this is fixed";
    is_shuffled(examples).then(|| Finding::warning(Kind::VertexOrder, text.to_owned(), Vec::new()))
}

/// Share of a frame's squared error that may remain after the offset is removed. The bound is loose because the many
/// displaced frames distort LBS.
const REMAINING: f64 = 0.25;

/// Reports an offset of the meshes in most training frames. If fewer frames are displaced, the others show it
/// ([`super::frames::broken`]).
pub(super) fn offset(context: &Context<'_>) -> Option<Finding> {
    let offsets = rigid_offsets(context.lbs_residuals());
    let places = (0..offsets.len()).filter(|&pose| offsets[pose].is_offset(REMAINING));
    let worst = worst_first(places, |pose| offsets[pose].distance);
    if 2 * worst.len() < offsets.len() {
        return None;
    }
    let farthest = *worst.first()?;
    let text = format!(
        "{} of {} a mesh with an offset from the joints as a whole, by up to {} in frame {}: perhaps the root moves only \
         in the meshes or only in the joints, all meshes are displaced, or the meshes belong to other frames; do not \
         rely on the findings below until this is fixed",
        worst.len(),
        count(offsets.len(), "training frame has", "training frames have"),
        context.length(offsets[farthest].distance),
        context.frame(farthest)
    );
    Some(Finding::warning(Kind::Elsewhere, text, context.frames(worst)))
}
