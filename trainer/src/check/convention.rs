//! Whether mesh and skeleton speak of the same space: units, axes and place.
//!
//! Every vertex of a sample is carried by whichever single joint carries it best. Where that is far
//! off, the rest mesh, the posed meshes or the joints are tried in other units and axes, and moved.

use super::finding::{Finding, Kind, Severity};
use super::thresholds::{MISPLACED, RIGHTED};
use crate::examples::{Examples, Split, spread};
use crate::numeric::affine::from_rows;
use crate::space::{axis_names, rotations};
use nalgebra::{Matrix3, Matrix3x4, Vector3};
use rayon::prelude::*;

/// Vertices and frames of the sample: enough to tell a hundredfold error from a bend.
const SAMPLE: (usize, usize) = (120, 8);

/// Factors of length between usual units.
const SCALES: [f64; 5] = [1.0, 0.01, 0.1, 10.0, 100.0];

/// What may have been exported otherwise than the rest.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Odd {
    Joints,
    Rest,
    Posed,
}

const ODD: [Odd; 3] = [Odd::Joints, Odd::Rest, Odd::Posed];
/// The same where other clips are right: there is but one rest mesh.
const ODD_IN_A_CLIP: [Odd; 2] = [Odd::Posed, Odd::Joints];

/// What puts it right: its points go to `turn x + shift`.
#[derive(Clone, Copy, Debug)]
struct Remedy {
    odd: Odd,
    turn: Matrix3<f64>,
    shift: Vector3<f64>,
}

/// How mesh and skeleton lie to each other.
enum Lie {
    /// As they are to.
    Together,
    /// Apart, but for a remedy.
    Odd(Convention),
    /// Apart for another reason.
    Apart,
}

/// What would put mesh and skeleton together.
pub(super) struct Convention {
    kind: Kind,
    /// What should be otherwise, in words.
    pub(super) what: String,
    /// What the best single joint of each vertex leaves with that and without, RMS in diagonals of the posed mesh.
    leaves: [f64; 2],
}

impl Convention {
    /// Tells of it.
    ///
    /// - `place`: where, if not everywhere.
    pub(super) fn finding(self, place: &str) -> Finding {
        let Self { kind, what, leaves } = self;
        let [with, without] = leaves.map(|share| 100.0 * share);
        Finding {
            kind,
            severity: Severity::Warning,
            text: format!(
                "{place}{what}: with that, the best single joint of each vertex leaves {with:.2} % of the diagonal \
                 instead of {without:.0} %; nothing below is to be trusted until it is exported so"
            ),
            places: Vec::new(),
        }
    }
}

/// Tells of other units, axes and places; and returns whether mesh and skeleton lie apart for another reason.
pub(super) fn convention(examples: &Examples, findings: &mut Vec<Finding>) -> bool {
    match Sample::new(examples, &examples.frames_of(Split::Train)).lie(&ODD) {
        Lie::Together => false,
        Lie::Odd(convention) => {
            findings.push(convention.finding(""));
            false
        }
        Lie::Apart => true,
    }
}

/// Finds other units, axes and places of a clip, where others are right.
pub(super) fn of_clip(examples: &Examples, frames: &[usize]) -> Option<Convention> {
    match Sample::new(examples, frames).lie(&ODD_IN_A_CLIP) {
        Lie::Odd(convention) => Some(convention),
        Lie::Together | Lie::Apart => None,
    }
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
        let frames: Vec<usize> =
            spread(frames.len(), SAMPLE.1).into_iter().map(|i| frames[i]).collect();
        let at = |points: &[[f64; 3]]| vertices.iter().map(|&v| points[v].into()).collect();
        let posed: Vec<Vec<Vector3<f64>>> = frames.iter().map(|&f| at(examples.frame(f))).collect();
        let corner = |pick: fn(&Vector3<f64>, &Vector3<f64>) -> Vector3<f64>| {
            posed.first().and_then(|points| points.iter().copied().reduce(|a, b| pick(&a, &b)))
        };
        let (low, high) = (corner(|a, b| a.inf(b)), corner(|a, b| a.sup(b)));
        Self {
            rest: at(&examples.rest),
            joints: frames
                .iter()
                .map(|&frame| examples.pose(frame).iter().map(from_rows).collect())
                .collect(),
            unit: (high.unwrap_or_default() - low.unwrap_or_default()).norm(),
            posed,
        }
    }

    /// Tries remedies, each for one of what may be odd.
    fn lie(&self, odd: &[Odd]) -> Lie {
        let as_it_is =
            Remedy { odd: Odd::Rest, turn: Matrix3::identity(), shift: Vector3::zeros() };
        let error = self.error(&as_it_is);
        if error < MISPLACED * self.unit {
            return Lie::Together;
        }
        let mut remedies = Vec::new();
        for &odd in odd {
            for scale in SCALES {
                let turns = rotations();
                remedies.extend(turns.map(|turn| Remedy { odd, turn: turn * scale, ..as_it_is }));
            }
        }
        remedies.extend(odd.iter().map(|&odd| self.shift(odd)));
        let errors: Vec<f64> = remedies.par_iter().map(|remedy| self.error(remedy)).collect();
        let best = (0..errors.len()).min_by(|&a, &b| errors[a].total_cmp(&errors[b])).unwrap_or(0);
        if errors[best] > RIGHTED * error {
            return Lie::Apart;
        }
        Lie::Odd(Convention {
            kind: remedies[best].kind(),
            what: remedies[best].describe(),
            leaves: [errors[best], error].map(|error| error / self.unit),
        })
    }

    /// RMS distance, in units of the posed meshes, of the vertices from where a remedy takes them.
    fn error(&self, remedy: &Remedy) -> f64 {
        let Remedy { odd, turn, shift } = *remedy;
        let apply = |x: &Vector3<f64>| turn * x + shift;
        let rest = |v: usize| match odd {
            Odd::Posed => self.rest[v],
            _ => apply(&self.rest[v]),
        };
        let scale = match odd {
            Odd::Rest => 1.0,
            _ => turn.column(0).norm(),
        };
        let posed = |frame: usize, v: usize| match odd {
            Odd::Rest => self.posed[frame][v],
            _ => apply(&self.posed[frame][v]),
        };
        let sum: f64 = (0..self.rest.len())
            .map(|v| {
                let x = rest(v).push(1.0);
                let truth: Vec<_> = (0..self.posed.len()).map(|f| posed(f, v)).collect();
                let of = |joint: usize| -> f64 {
                    let maps = self.joints.iter().map(|pose| pose[joint]);
                    maps.zip(&truth).map(|(map, y)| (map * x - y).norm_squared()).sum()
                };
                (0..self.joint_len()).map(of).fold(f64::INFINITY, f64::min)
            })
            .sum();
        (sum / (self.rest.len() * self.posed.len()).max(1) as f64).sqrt() / scale
    }

    /// The median of the shifts that each vertex asks for with the joint that then carries it best.
    fn shift(&self, odd: Odd) -> Remedy {
        let wanted: Vec<Vector3<f64>> = (0..self.rest.len())
            .into_par_iter()
            .filter_map(|v| {
                let of = |joint| self.shift_of(odd, v, joint);
                let all = (0..self.joint_len()).filter_map(of);
                all.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(shift, _)| shift)
            })
            .collect();
        let median = |axis: usize| {
            let mut along: Vec<f64> = wanted.iter().map(|shift| shift[axis]).collect();
            along.sort_by(f64::total_cmp);
            along.get(along.len() / 2).copied().unwrap_or(0.0)
        };
        Remedy { odd, turn: Matrix3::identity(), shift: Vector3::from_fn(|axis, _| median(axis)) }
    }

    /// The shift with which a joint carries a vertex best, and the squared error it leaves; none
    /// where the joint leaves the shift open.
    fn shift_of(&self, odd: Odd, v: usize, joint: usize) -> Option<(Vector3<f64>, f64)> {
        let equations: Vec<(Matrix3<f64>, Vector3<f64>)> = (0..self.posed.len())
            .map(|frame| {
                let map = &self.joints[frame][joint];
                let linear: Matrix3<f64> = map.fixed_columns::<3>(0).into();
                let gap = self.posed[frame][v] - map * self.rest[v].push(1.0);
                let factor = match odd {
                    Odd::Joints => linear - Matrix3::identity(),
                    Odd::Rest => linear,
                    Odd::Posed => -Matrix3::identity(),
                };
                (factor, gap)
            })
            .collect();
        let normal: Matrix3<f64> = equations.iter().map(|(a, _)| a.transpose() * a).sum();
        let right: Vector3<f64> = equations.iter().map(|(a, gap)| a.transpose() * gap).sum();
        // A joint that hardly turns is moved alike by every shift.
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

    /// Says what is odd: against the skeleton, or what of the mesh.
    fn describe(&self) -> String {
        let (what, against) = match self.odd {
            Odd::Joints => ("the joints", "the meshes"),
            Odd::Rest => ("the rest mesh", "joints and posed meshes"),
            Odd::Posed => ("the posed meshes", "joints and rest mesh"),
        };
        // For the joints, the remedy was applied to the meshes.
        let (turn, shift, scale) = match self.odd {
            Odd::Joints => (self.turn.transpose(), -self.shift, 1.0 / self.scale()),
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
