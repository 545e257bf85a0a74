//! Where meshes from two files lie to each other: tools disagree about axes and units, so one is
//! found to be the other turned by right angles, scaled and, for rest meshes, moved.

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;
use sinew_runtime::format::{Axis, Space};
use std::fmt;

use super::error::ImportError;
use crate::examples::sample::spread;
use crate::examples::validate::same;
use crate::examples::{Examples, ExamplesError, Matrix3x4, Skeleton, Warning};
use crate::mesh::EngineMesh;
use crate::numeric::affine::apart_unordered;
use crate::numeric::affine::{joined, parts, to_rows};
use crate::space::{SCALES, UNITS};
use crate::space::{axis, axis_names, direction, rotations};

/// A change of axes or units must leave less than this share of the distance that there is without.
const BETTER: f64 = 0.5;
/// Farthest that posed meshes may lie from a skin of one joint a vertex, RMS over the diagonal.
const APART: f64 = 0.2;
/// Farthest that two rest meshes may lie apart, RMS over the diagonal; both files round positions.
const SAME_MESH: f64 = 1e-3;
/// A similarity this near to none, over the diagonal, is none.
const NONE: f64 = 1e-5;
/// Vertices and frames that are looked at.
const SAMPLE: (usize, usize) = (150, 8);

/// x' = scale turn x + shift, where the turn maps axes to axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Similarity {
    turn: Matrix3<f64>,
    scale: f64,
    shift: Vector3<f64>,
}

impl Examples {
    /// Moves examples to where their rest mesh is this one of the same engine's vertices, which may be in other
    /// axes and units; tells how, where they had to be moved.
    ///
    /// # Errors
    /// [`ExamplesError::Mismatch`] for another count of vertices, [`ImportError::OtherMesh`] where no
    /// turn by right angles, scale and shift brings the rest meshes together.
    pub fn move_to(&mut self, rest: &[[f64; 3]]) -> Result<Option<Warning>, ExamplesError> {
        self.unsplit_for(rest.len());
        let own = self.surface().copied(&self.rest);
        same("vertices", "the model's mesh", rest.len(), "the mesh of this file", own.len())?;
        let similarity = meshes(&own, rest);
        let other =
            |percent| ImportError::OtherMesh { percent, is_shuffled: are_shuffled(&own, rest) };
        let similarity = similarity.map_err(other)?;
        similarity.move_joints(&mut self.skeleton, &mut self.transforms);
        similarity.move_points(&mut self.rest);
        similarity.move_points(&mut self.vertices);
        similarity.turn(self.engine.as_mut());
        self.space = similarity.space(&self.space);
        let how = similarity.to_string();
        Ok((!similarity.is_identity()).then_some(Warning::Moved { what: "poses", how }))
    }
}

/// Finds how a rest mesh became another one of the same vertices.
///
/// # Errors
/// How far apart the nearest comes, RMS in % of the diagonal, where no turn by right angles brings
/// them together.
pub(super) fn meshes(from: &[[f64; 3]], to: &[[f64; 3]]) -> Result<Similarity, f64> {
    let (from, to) = (Cloud::new(from), Cloud::new(to));
    let distance = |similarity: &Similarity| {
        let squares = from.points.iter().zip(&to.points);
        let squares = squares.map(|(a, b)| (similarity.point(*a) - b).norm_squared());
        (squares.sum::<f64>() / to.points.len().max(1) as f64).sqrt() / to.diagonal
    };
    let unmoved = Similarity::IDENTITY;
    let best = best(between(&from, &to).map(|s| (s, distance(&s))), (unmoved, distance(&unmoved)));
    match best {
        (_, distance) if distance > SAME_MESH => Err(100.0 * distance),
        (mut similarity, _) => {
            if similarity.shift.norm() < NONE * to.diagonal {
                similarity.shift = Vector3::zeros();
            }
            Ok(similarity)
        }
    }
}

/// Tells whether a rest mesh has the places of another's vertices, turned by right angles, scaled and moved, in any order.
fn are_shuffled(from: &[[f64; 3]], to: &[[f64; 3]]) -> bool {
    similarities(from, to).any(|similarity| {
        let moved = from.iter().map(|&x| similarity.point(x.into()).into());
        apart_unordered(&moved.collect::<Vec<_>>(), to) <= SAME_MESH * diagonal(to)
    })
}

/// Lists what may lead from one cloud of points to another of as many, in any order: none, then every turn by right
/// angles, with the scale and shift that the clouds have.
pub(super) fn similarities(
    from: &[[f64; 3]],
    to: &[[f64; 3]],
) -> impl Iterator<Item = Similarity> + use<> {
    std::iter::once(Similarity::IDENTITY).chain(between(&Cloud::new(from), &Cloud::new(to)))
}

fn between(from: &Cloud, to: &Cloud) -> impl Iterator<Item = Similarity> + use<> {
    let scale = nearest_unit(to.radius / from.radius);
    let (from, to) = (from.centre, to.centre);
    rotations().map(move |turn| Similarity { turn, scale, shift: to - turn * from * scale })
}

/// Finds how posed meshes, frame-major, must be turned and scaled to lie on the joints that carry
/// the rest mesh.
///
/// # Errors
/// [`ImportError::TargetsApart`] where none brings them near.
pub(super) fn poses(
    rest: &[[f64; 3]],
    transforms: &[Matrix3x4],
    posed: &[[f64; 3]],
) -> Result<Similarity, ImportError> {
    let cloud = Cloud::new(rest);
    let frame_len = posed.len() / rest.len().max(1);
    let joint_len = transforms.len() / frame_len.max(1);
    let frames: Vec<usize> = spread(frame_len, SAMPLE.1);
    let vertices: Vec<usize> = spread(rest.len(), SAMPLE.0);
    // Where each joint alone would carry each vertex.
    let carried: Vec<Vec<Vec<Vector3<f64>>>> = vertices
        .iter()
        .map(|&vertex| {
            let carried = |joint: usize| {
                let maps = frames.iter().map(|&frame| &transforms[frame * joint_len + joint]);
                maps.map(|map| carry(map, &rest[vertex])).collect()
            };
            (0..joint_len).map(carried).collect()
        })
        .collect();
    let distance = |similarity: Similarity| {
        let squares = vertices.iter().zip(&carried).map(|(&vertex, by_joint)| {
            let there: Vec<_> = frames
                .iter()
                .map(|&frame| similarity.point(posed[frame * rest.len() + vertex].into()))
                .collect();
            let joint = by_joint.iter().map(|carried| {
                carried.iter().zip(&there).map(|(a, b)| (a - b).norm_squared()).sum::<f64>()
            });
            joint.fold(f64::INFINITY, f64::min)
        });
        let count = (vertices.len() * frames.len()).max(1) as f64;
        (squares.sum::<f64>() / count).sqrt() / cloud.diagonal
    };
    let candidates: Vec<Similarity> = scaled_turns().collect();
    let scored: Vec<_> = candidates.into_par_iter().map(|s| (s, distance(s))).collect();
    let unmoved = Similarity::IDENTITY;
    match best(scored.into_iter(), (unmoved, distance(unmoved))) {
        (_, distance) if distance > APART => {
            Err(ImportError::TargetsApart { percent: 100.0 * distance })
        }
        (similarity, _) => Ok(similarity),
    }
}

/// Lists the turns by right angles with every change of units.
pub(super) fn scaled_turns() -> impl Iterator<Item = Similarity> {
    let shift = Vector3::zeros();
    rotations().flat_map(move |turn| SCALES.map(|scale| Similarity { turn, scale, shift }))
}

impl Similarity {
    pub(super) const IDENTITY: Self = Self {
        turn: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        scale: 1.0,
        shift: Vector3::new(0.0, 0.0, 0.0),
    };

    pub(super) fn is_identity(&self) -> bool {
        *self == Self::IDENTITY
    }

    pub(super) fn move_points(&self, points: &mut [[f64; 3]]) {
        if !self.is_identity() {
            points.par_iter_mut().for_each(|point| *point = self.point((*point).into()).into());
        }
    }

    /// Turns what is authored of a mesh.
    pub(super) fn turn(&self, engine: Option<&mut EngineMesh>) {
        if let Some(engine) = engine.filter(|_| !self.is_identity()) {
            engine.turn(|direction| (self.turn * Vector3::from(direction)).into(), false);
        }
    }

    /// Tells what becomes of a space.
    pub(super) fn space(&self, from: &Space) -> Space {
        if self.is_identity() {
            return *from;
        }
        let turned = |from: Axis| axis(&(self.turn * direction(from)));
        let unit = from.unit.map(|metres| metres / self.scale as f32);
        let unit = unit.filter(|metres| UNITS.contains(metres));
        let (up, forward) = (from.up.and_then(turned), from.forward.and_then(turned));
        Space { up, forward, unit, ..*from }
    }

    /// Moves a skeleton and its maps from rest to posed.
    pub(super) fn move_joints(&self, skeleton: &mut Skeleton, transforms: &mut [Matrix3x4]) {
        if self.is_identity() {
            return;
        }
        for frame in &mut skeleton.rest {
            let (turn, origin) = parts(frame);
            *frame = to_rows(&joined(&(self.turn * turn), &self.point(origin)));
        }
        for map in transforms {
            // The image of the map from the other side: there and back again.
            let (linear, offset) = parts(map);
            let linear = self.turn * linear * self.turn.transpose();
            let moved = self.turn * offset * self.scale + self.shift - linear * self.shift;
            *map = to_rows(&joined(&linear, &moved));
        }
    }

    /// Tells how much larger things become.
    pub(super) fn scale(&self) -> f64 {
        self.scale
    }

    pub(super) fn point(&self, x: Vector3<f64>) -> Vector3<f64> {
        self.turn * x * self.scale + self.shift
    }
}

impl fmt::Display for Similarity {
    /// Writes where the axes come from, as in `(x, -z, y) x 0.01 + (0, 1.5, 0)`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&axis_names(&self.turn))?;
        if self.scale != 1.0 {
            write!(f, " x {}", self.scale)?;
        }
        if self.shift != Vector3::zeros() {
            let [x, y, z]: [f64; 3] = self.shift.into();
            write!(f, " + ({x:.4}, {y:.4}, {z:.4})")?;
        }
        Ok(())
    }
}

/// A mesh's points with their centre and sizes.
struct Cloud {
    points: Vec<Vector3<f64>>,
    centre: Vector3<f64>,
    /// RMS distance from the centre.
    radius: f64,
    diagonal: f64,
}

impl Cloud {
    fn new(points: &[[f64; 3]]) -> Self {
        let points: Vec<Vector3<f64>> = points.iter().map(|&point| point.into()).collect();
        let count = points.len().max(1) as f64;
        let centre = points.iter().sum::<Vector3<f64>>() / count;
        let squares = points.iter().map(|point| (point - centre).norm_squared());
        let radius = (squares.sum::<f64>() / count).sqrt().max(f64::MIN_POSITIVE);
        let low = points.iter().fold(centre, |low, point| low.inf(point));
        let high = points.iter().fold(centre, |high, point| high.sup(point));
        Self { points, centre, radius, diagonal: (high - low).norm().max(f64::MIN_POSITIVE) }
    }
}

/// Takes the candidate that leaves least, unless what is there without any is nearly as good.
fn best(
    candidates: impl Iterator<Item = (Similarity, f64)>,
    unmoved: (Similarity, f64),
) -> (Similarity, f64) {
    let nearest = candidates.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or(unmoved);
    if nearest.1 < BETTER * unmoved.1 { nearest } else { unmoved }
}

/// The unit nearest to a ratio where one is near, else the ratio itself.
fn nearest_unit(ratio: f64) -> f64 {
    let near = |unit: &f64| (ratio / unit - 1.0).abs() < SAME_MESH;
    SCALES.into_iter().find(near).unwrap_or(ratio)
}

/// Measures the diagonal of the box around some points.
pub(super) fn diagonal(points: &[[f64; 3]]) -> f64 {
    Cloud::new(points).diagonal
}

/// Measures how far points lie from their centre, RMS.
pub(super) fn radius(points: &[[f64; 3]]) -> f64 {
    Cloud::new(points).radius
}

/// Gives where a joint alone carries a vertex.
pub(super) fn carry(map: &Matrix3x4, x: &[f64; 3]) -> Vector3<f64> {
    let (linear, offset) = parts(map);
    linear * Vector3::from(*x) + offset
}
