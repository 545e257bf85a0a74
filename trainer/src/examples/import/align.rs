//! Aligns meshes from two files. Tools use different axes and units, so one mesh may be rotated by right angles and
//! scaled. A rest mesh may also be translated.

use crate::Error;
use crate::examples::validate::same;
use crate::examples::{Examples, Matrix3x4, Warning, diagonal, spread};
use crate::mesh::EngineMesh;
use crate::numeric::affine::{apart_unordered, joined, parts, to_rows};
use crate::space::{SCALES, UNITS, axis, axis_names, direction, rotations};
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;
use sinew_runtime::format::{Axis, Space};
use std::fmt;

/// Largest residual of a similarity relative to the residual without one; above this ratio nothing is moved.
const BETTER: f64 = 0.5;
/// Largest distance of posed meshes from one-joint skinning, RMS relative to the diagonal.
const APART: f64 = 0.2;
/// Largest distance between equal rest meshes, RMS relative to the diagonal; both files round positions.
const SAME_MESH: f64 = 1e-3;
/// Translations below this fraction of the diagonal count as 0.
const NONE: f64 = 1e-5;
/// Sampled vertices and frames for aligning posed meshes.
const SAMPLE: (usize, usize) = (150, 8);
/// Sampled posed vertices, rest vertices and frames for detecting another vertex order.
const SHUFFLE_SAMPLE: (usize, usize, usize) = (12, 4000, 5);
/// Largest distance of a posed vertex from some joint's image, relative to the diagonal.
const NEAR: f64 = 0.02;
/// Largest ratio of sizes between posed meshes and the rest mesh, in either direction and in one unit.
const STRETCHED: f64 = 1.5;

/// A similarity x' = scale turn x + shift; the rotation `turn` maps axes to axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Similarity {
    turn: Matrix3<f64>,
    scale: f64,
    shift: Vector3<f64>,
}

impl Examples {
    /// Moves the examples so that their rest mesh coincides with a model's rest mesh, which may have other axes and
    /// units. Returns a warning with the conversion if anything moved.
    ///
    /// - `rest`: the model's rest positions; engine vertices or the mesh's vertices, in the examples' order.
    ///
    /// # Errors
    /// The model's mesh has another count of vertices, or no similarity aligns the rest meshes.
    pub fn move_to(&mut self, rest: &[[f64; 3]]) -> Result<Option<Warning>, Error> {
        self.unsplit_for(rest.len());
        let own = self.surface().copied(&self.rest);
        same("vertices", "the model's mesh", rest.len(), "the mesh of this file", own.len())?;
        let similarity = meshes(&own, rest).map_err(|percent| {
            let order = match are_shuffled(&own, rest) {
                true => ", the same vertices in another order; give a file of the kind that training had",
                false => "",
            };
            Error::mismatch(format!(
                "its rest mesh is not that of the model in any axes and unit: off by {percent:.1} % of the \
                 diagonal at best{order}"
            ))
        })?;
        similarity.move_joints(&mut self.skeleton.rest, &mut self.transforms);
        similarity.move_points(&mut self.rest);
        similarity.move_points(&mut self.vertices);
        similarity.turn(self.engine.as_mut());
        self.space = similarity.space(&self.space);
        Ok(similarity.warning("poses"))
    }
}

/// Finds the similarity between two rest meshes with the same vertices.
///
/// # Errors
/// The smallest RMS distance, in % of the diagonal, if no similarity aligns the meshes.
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

/// Returns whether two rest meshes have the same positions in another vertex order, up to a similarity.
fn are_shuffled(from: &[[f64; 3]], to: &[[f64; 3]]) -> bool {
    similarities(from, to).any(|similarity| {
        let moved = from.iter().map(|&x| similarity.point(x.into()).into());
        apart_unordered(&moved.collect::<Vec<_>>(), to) <= SAME_MESH * Cloud::new(to).diagonal
    })
}

/// Lists candidate similarities between two sets of as many points, independent of their order: the identity, then
/// every right-angle rotation with the scale and shift of the sets.
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

/// Finds the similarity that moves posed meshes onto the joints that carry the rest mesh; no translation.
///
/// # Errors
/// No candidate is close.
pub(super) fn poses(examples: &Examples) -> Result<Similarity, Error> {
    let diagonal = Cloud::new(&examples.rest).diagonal;
    let frames = spread(examples.frame_len(), SAMPLE.1);
    let vertices = spread(examples.vertex_len(), SAMPLE.0);
    let carried: Vec<_> = vertices.iter().map(|&v| paths(examples, &frames, v)).collect();
    let distance = |similarity: Similarity| {
        let squares = vertices.iter().zip(&carried).map(|(&vertex, paths)| {
            let there = similarity.path(examples, &frames, vertex);
            paths.iter().map(|path| squared(path, &there)).fold(f64::INFINITY, f64::min)
        });
        let count = (vertices.len() * frames.len()).max(1) as f64;
        (squares.sum::<f64>() / count).sqrt() / diagonal
    };
    let candidates: Vec<Similarity> = scaled_turns().collect();
    let scored: Vec<_> = candidates.into_par_iter().map(|s| (s, distance(s))).collect();
    let unmoved = Similarity::IDENTITY;
    match best(scored.into_iter(), (unmoved, distance(unmoved))) {
        (_, distance) if distance > APART => Err(targets_apart(100.0 * distance)),
        (similarity, _) => Ok(similarity),
    }
}

/// Creates the error of posed meshes that are not near the joints.
///
/// - `percent`: RMS distance, in % of the diagonal.
pub(super) fn targets_apart(percent: f64) -> Error {
    Error::mismatch(format!(
        "its meshes do not lie on the scene's joints in any axes and unit: off by {percent:.0} % of the diagonal at \
         best; export them in world space, and over the same frames as the clip"
    ))
}

/// Returns whether posed meshes have the rest mesh's vertices in another order: joints carry rest vertices to the posed
/// positions, but not the vertices with the same numbers. Considers right-angle rotations and changes of unit. Most
/// vertices must match in most frames, because an exploded frame proves nothing about the order.
pub(crate) fn is_shuffled(examples: &Examples) -> bool {
    let (vertex_len, frames) =
        (examples.vertex_len(), spread(examples.frame_len(), SHUFFLE_SAMPLE.2));
    if frames.is_empty() || vertex_len == 0 {
        return false;
    }
    let radius = |points: &[[f64; 3]]| Cloud::new(points).radius;
    let mut radii: Vec<f64> = frames.iter().map(|&frame| radius(examples.frame(frame))).collect();
    radii.sort_by(f64::total_cmp);
    let ratio = radius(&examples.rest) / radii[radii.len() / 2];
    let likely = |place: &Similarity| (1.0 / STRETCHED..STRETCHED).contains(&(place.scale / ratio));
    let paths = |v: usize| paths(examples, &frames, v);
    let all: Vec<Path> = spread(vertex_len, SHUFFLE_SAMPLE.1).into_iter().flat_map(paths).collect();
    let picked = spread(vertex_len, SHUFFLE_SAMPLE.0);
    let own: Vec<Vec<Path>> = picked.iter().map(|&v| paths(v)).collect();
    let near = NEAR * Cloud::new(&examples.rest).diagonal;
    let matches = |place: &Similarity, k: usize, paths: &[Path]| {
        let there = place.path(examples, &frames, picked[k]);
        paths.iter().any(|path| {
            let near = path.iter().zip(&there).filter(|(a, b)| (*a - *b).norm() < near);
            2 * near.count() > frames.len()
        })
    };
    let most = |matches: &dyn Fn(usize) -> bool| {
        2 * (0..picked.len()).filter(|&k| matches(k)).count() > picked.len()
    };
    let places: Vec<Similarity> = scaled_turns().filter(likely).collect();
    places.par_iter().any(|place| most(&|k| matches(place, k, &all)))
        && !places.iter().any(|place| most(&|k| matches(place, k, &own[k])))
}

/// Lists the right-angle rotations with every change of unit.
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

    /// Rotates the authored normals and tangents of a mesh.
    pub(super) fn turn(&self, engine: Option<&mut EngineMesh>) {
        if let Some(engine) = engine.filter(|_| !self.is_identity()) {
            engine.turn(|direction| (self.turn * Vector3::from(direction)).into(), false);
        }
    }

    /// Returns the space after the similarity.
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

    /// Moves the rest frames of joints, and their maps from rest pose to pose.
    pub(super) fn move_joints(&self, rest: &mut [Matrix3x4], transforms: &mut [Matrix3x4]) {
        if self.is_identity() {
            return;
        }
        for frame in rest {
            let (turn, origin) = parts(frame);
            *frame = to_rows(&joined(&(self.turn * turn), &self.point(origin)));
        }
        for map in transforms {
            // Conjugates the map by the similarity: back, map, forward.
            let (linear, offset) = parts(map);
            let linear = self.turn * linear * self.turn.transpose();
            let moved = self.turn * offset * self.scale + self.shift - linear * self.shift;
            *map = to_rows(&joined(&linear, &moved));
        }
    }

    pub(super) fn point(&self, x: Vector3<f64>) -> Vector3<f64> {
        self.turn * x * self.scale + self.shift
    }

    /// Returns the path of a posed vertex over some frames.
    pub(super) fn path(&self, examples: &Examples, frames: &[usize], vertex: usize) -> Path {
        let posed = frames.iter().map(|&frame| examples.frame(frame)[vertex]);
        posed.map(|x| self.point(x.into())).collect()
    }

    /// Returns a warning if anything moved.
    pub(super) fn warning(&self, what: &'static str) -> Option<Warning> {
        (!self.is_identity()).then(|| Warning::Moved { what, how: self.to_string() })
    }
}

impl fmt::Display for Similarity {
    /// Formats the similarity by the source of each axis, such as `(x, -z, y) x 0.01 + (0, 1.5, 0)`.
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

/// Points of a mesh with their centre and size.
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
        let diagonal = diagonal(points.iter().map(|&x| x.into())).max(f64::MIN_POSITIVE);
        Self { points, centre, radius, diagonal }
    }
}

/// Returns the candidate with the smallest residual, or the identity if its residual is nearly as small.
fn best(
    candidates: impl Iterator<Item = (Similarity, f64)>,
    unmoved: (Similarity, f64),
) -> (Similarity, f64) {
    let nearest = candidates.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or(unmoved);
    if nearest.1 < BETTER * unmoved.1 { nearest } else { unmoved }
}

/// Returns the unit ratio close to `ratio`, or `ratio` if there is none.
fn nearest_unit(ratio: f64) -> f64 {
    let near = |unit: &f64| (ratio / unit - 1.0).abs() < SAME_MESH;
    SCALES.into_iter().find(near).unwrap_or(ratio)
}

/// Positions of a vertex over some frames.
pub(super) type Path = Vec<Vector3<f64>>;

/// Returns the path of a rest vertex over some frames under each joint alone, J.
pub(super) fn paths(examples: &Examples, frames: &[usize], vertex: usize) -> Vec<Path> {
    let rest = Vector3::from(examples.rest[vertex]);
    let path = |joint: usize| {
        let maps = frames.iter().map(|&frame| parts(&examples.pose(frame)[joint]));
        maps.map(|(linear, offset)| linear * rest + offset).collect()
    };
    (0..examples.joint_len()).map(path).collect()
}

/// Returns the sum of the squared distances between two paths.
pub(super) fn squared(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).norm_squared()).sum()
}
