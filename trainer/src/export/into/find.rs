//! Finds a model in an artist's file: the model's vertices among those of the meshes, by position.

use nalgebra::{Matrix3, Matrix4, Point3, Vector3};
use rayon::prelude::*;

use crate::Error;
use crate::examples::{Matrix3x4, spread};
use crate::formats::gltf::rigged::{RiggedFile, RiggedMesh};
use crate::numeric::grid::Grid;
use crate::space::{SCALES, rotations};

/// Largest distance between a vertex of the file and the same vertex of the model, in the model's diagonals.
const SAME_PLACE: f64 = 1e-4;
/// Number of vertices of each mesh in the search for axes and units.
const SAMPLE: usize = 50;
/// Trace of a rotation by 45 degrees. A larger rotation is a change of axes, not a pose.
const TURNED: f64 = 1.0 + std::f64::consts::SQRT_2;

/// Position of a model in a file.
#[derive(Debug)]
pub(super) struct Found {
    /// Map from the space of the file's bound joints to the space of the model's rest mesh.
    pub(super) to_model: Matrix4<f64>,
    /// Map from the space of the model's posed mesh to the file's world.
    pub(super) to_world: Matrix4<f64>,
    /// Map from the space of the bound joints to the world, with the file's joints at rest.
    pub(super) at_rest: Matrix4<f64>,
    /// The model's vertex for each vertex of each primitive, by mesh of the file; `None` for a mesh that is not the
    /// model's.
    pub(super) vertices: Vec<Option<Vec<Vec<usize>>>>,
}

impl Found {
    /// Finds a model's rest mesh in a file, which may have other axes and another unit. Tries rotations by right angles
    /// and usual scales, of the bound and of the placed meshes, and takes the combination that matches most vertices.
    ///
    /// - `root`: node of the reference root; `None` if the file lacks it.
    /// - `poses`: the poses to play.
    ///
    /// # Errors
    /// - [`ErrorKind::Missing`](crate::ErrorKind::Missing): no mesh has the model's vertices.
    /// - [`ErrorKind::Mismatch`](crate::ErrorKind::Mismatch): a mesh has some of the model's vertices and others.
    pub(super) fn new(
        file: &RiggedFile,
        root: Option<usize>,
        rest: &[[f64; 3]],
        diagonal: f64,
        poses: &[Vec<Matrix3x4>],
    ) -> Result<Self, Error> {
        let root = root.and_then(|root| Some((root, file.binds[root]?.try_inverse()?)));
        let still = file.meshes.first().filter(|mesh| mesh.skin.is_none());
        let worlds = file.worlds();
        let at_rest = match (root, still) {
            (Some((root, inverse)), _) => worlds[root] * inverse,
            (None, Some(mesh)) => worlds[mesh.node],
            (None, None) => Matrix4::identity(),
        };
        let unit = at_rest.fixed_view::<3, 3>(0, 0).determinant().abs().cbrt();
        let places = Grid::new(rest, SAME_PLACE * diagonal);
        let sample: Vec<_> = file.meshes.iter().flat_map(sample).collect();
        let unmoved = Candidate { to_model: Matrix4::identity(), turned: false, bound: true };
        let mut best = (0, unmoved);
        for candidate in candidates(&at_rest, unit) {
            let there = |x: &&Point3<f64>| {
                point_at(&places, candidate.to_model.transform_point(x), None).is_some()
            };
            let count = sample.iter().filter(there).count();
            if count > best.0 {
                best = (count, candidate);
            }
        }
        let (_, Candidate { to_model, turned, bound }) = best;
        let vertices = match_all(file, &places, &to_model)?;
        if vertices.iter().all(Option::is_none) {
            return Err(Error::missing(
                "no mesh has the model's vertices, within 1e-4 of the diagonal, in any axes and \
                 unit: give the character that the model was trained on, in its rest pose",
            ));
        }
        let back = to_model.try_inverse().unwrap_or_else(Matrix4::identity);
        // The nodes above the joints may rotate the bound joints. Poses from the same file contain this rotation. Other
        // poses start at the rest mesh and take the file's rotation. A rotation of the root joint itself is a pose.
        let above = root.and_then(|(root, _)| file.parents[root]).map(|parent| worlds[parent]);
        let [turn, above] = [at_rest, above.unwrap_or_else(Matrix4::identity)].map(|world| {
            let world = world / world.fixed_view::<3, 3>(0, 0).determinant().abs().cbrt();
            (to_model * world * back).fixed_view::<3, 3>(0, 0).into_owned()
        });
        let posed_in_world = match turn.trace() < TURNED && turn.dot(&above) > TURNED {
            true => traces(poses, &turn) > traces(poses, &Matrix3::identity()),
            false => !turned,
        };
        let to_world = match bound && still.is_none() && posed_in_world {
            true => Matrix4::new_scaling(unit) * back,
            false => at_rest * back,
        };
        Ok(Self { to_model, to_world, at_rest, vertices })
    }
}

/// A candidate for the map from the file to the model's rest mesh.
struct Candidate {
    to_model: Matrix4<f64>,
    /// Whether the map changes axes.
    turned: bool,
    /// Whether the map starts at the bound joints, rather than at the placed mesh.
    bound: bool,
}

fn candidates(at_rest: &Matrix4<f64>, unit: f64) -> impl Iterator<Item = Candidate> {
    let bases =
        [(Matrix4::new_scaling(unit), true), (Matrix4::identity(), true), (*at_rest, false)];
    let turns = rotations().enumerate();
    let turned = turns.flat_map(|(number, turn)| SCALES.map(|scale| (number > 0, turn * scale)));
    turned.flat_map(move |(turned, linear)| {
        let linear = linear.to_homogeneous();
        bases.map(|(base, bound)| Candidate { to_model: linear * base, turned, bound })
    })
}

/// Sums the traces of poses relative to a rotation; a larger sum means nearer poses.
fn traces(poses: &[Vec<Matrix3x4>], turn: &Matrix3<f64>) -> f64 {
    let linear = |map: &Matrix3x4| Matrix3::from_fn(|row, column| map[row][column]);
    poses.iter().flatten().map(|map| turn.dot(&linear(map))).sum()
}

fn sample(mesh: &RiggedMesh) -> impl Iterator<Item = Point3<f64>> {
    let surfaces = mesh.positions.iter().zip(&mesh.surfaces).filter(|(_, surface)| **surface);
    let all: Vec<_> = surfaces.flat_map(|(positions, _)| positions).collect();
    let few = spread(all.len(), SAMPLE).into_iter();
    few.map(move |vertex| mesh.to_bind.transform_point(&Point3::from(*all[vertex])))
}

/// Finds the model's vertices in every mesh.
///
/// # Errors
/// A mesh has some of the model's vertices and others.
fn match_all(
    file: &RiggedFile,
    places: &Grid<'_>,
    to_model: &Matrix4<f64>,
) -> Result<Vec<Option<Vec<Vec<usize>>>>, Error> {
    let mut first = 0;
    let mut all = Vec::new();
    for mesh in &file.meshes {
        let to_model = to_model * mesh.to_bind;
        let mut missing = None;
        let (mut number, mut found) = (0, 0);
        let mut primitives = Vec::new();
        for (positions, is_surface) in mesh.positions.iter().zip(&mesh.surfaces) {
            let mut vertices = Vec::with_capacity(positions.len());
            if !is_surface {
                primitives.push(vertices);
                continue;
            }
            for x in positions {
                let place = to_model.transform_point(&Point3::from(*x));
                let vertex = point_at(places, place, Some(first + number));
                match vertex {
                    Some(_) => found += 1,
                    None => missing = missing.or(Some((number, *x))),
                }
                vertices.push(vertex.unwrap_or_default());
                number += 1;
            }
            primitives.push(vertices);
        }
        first += number;
        all.push(match missing {
            None if found > 0 => {
                // Points and lines are not in the model; they follow its nearest vertices.
                for (vertices, positions) in primitives.iter_mut().zip(&mesh.positions) {
                    if vertices.is_empty() {
                        let place = |x: &[f64; 3]| to_model.transform_point(&Point3::from(*x));
                        let nearest = |x| nearest(places.points, place(x));
                        *vertices = positions.par_iter().map(nearest).collect();
                    }
                }
                Some(primitives)
            }
            None => None,
            Some(_) if found == 0 => None,
            Some((vertex, at)) => {
                return Err(Error::mismatch(format!(
                    "mesh {}: vertex {vertex} at {at:?} is not in the model, {found} of {number} are: train on \
                     the mesh as it is, or move the added vertices to a separate mesh",
                    mesh.name
                )));
            }
        });
    }
    Ok(all)
}

/// Returns the point nearest to a position.
fn nearest(points: &[[f64; 3]], place: Point3<f64>) -> usize {
    let distance = |point: &[f64; 3]| (Vector3::from(*point) - place.coords).norm_squared();
    let all = points.iter().map(distance).enumerate();
    all.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(number, _)| number)
}

/// Returns the point at a position: the expected point if it is there, which separates points with a common position;
/// else the nearest point, the first of several.
fn point_at(places: &Grid<'_>, place: Point3<f64>, expected: Option<usize>) -> Option<usize> {
    let place: [f64; 3] = place.coords.into();
    let distance = |number: usize| places.distance(number, place);
    expected.filter(|&number| distance(number) <= places.reach).or_else(|| {
        let near = places.near(place).into_iter();
        near.min_by(|&a, &b| distance(a).total_cmp(&distance(b)))
    })
}
