//! Alembic, `.abc`: reads the polygon meshes of an Ogawa archive, frame by frame, placed by its transforms.
//!
//! Axes and unit stay as they are in the file, which does not state them. Vertices keep their order; several meshes
//! follow one another in the order of the file.

mod objects;
mod ogawa;
mod schemas;
#[cfg(test)]
mod tests;

use super::posed_meshes::{Part, PosedMeshes};
use crate::Error;
use nalgebra::{Matrix4, Point3};
use objects::{Object, Schema, list};
use ogawa::Archive;
use schemas::{Mesh, Transform};
use std::path::Path;

/// Reads the polygon meshes of a file. Each sample is a frame, placed by the transforms above the mesh.
///
/// # Errors
/// The file cannot be read, is no Alembic archive or is damaged, has no mesh, or has meshes that change over time.
pub(crate) fn read(path: &Path) -> Result<PosedMeshes, Error> {
    parse(&std::fs::read(path).map_err(Error::read)?)
}

/// Reads the bytes of a file.
///
/// # Errors
/// Those of [`read`], except that the file cannot be read.
fn parse(bytes: &[u8]) -> Result<PosedMeshes, Error> {
    let archive = Archive::new(bytes)?;
    let Scene { transforms, meshes } = Scene::read(&archive)?;
    let frame_len = frame_len(&transforms, &meshes)?;
    let vertex_len = meshes.iter().map(|placed| placed.mesh.vertex_len).sum::<usize>();
    let position_len = frame_len.saturating_mul(vertex_len);
    archive.spend(position_len.saturating_mul(size_of::<[f64; 3]>()))?;
    let worlds: Vec<_> =
        meshes.iter().map(|placed| World::new(&transforms, &placed.above)).collect();
    let moved: usize = worlds.iter().map(World::factor_len).sum();
    archive.spend(frame_len.saturating_mul(moved).saturating_mul(size_of::<Matrix4<f64>>()))?;

    let mut vertices = Vec::with_capacity(position_len);
    for frame in 0..frame_len {
        for (PlacedMesh { mesh, .. }, world) in meshes.iter().zip(&worlds) {
            let world = world.at(frame);
            vertices.extend(mesh.at(frame)?.map(|x| transform_point(&world, x)));
        }
    }
    let first = vertices.get(..vertex_len).unwrap_or_default();
    let triangles = triangles(&meshes, first);
    Ok(PosedMeshes {
        triangles: (!triangles.is_empty()).then_some(triangles),
        reference: reference(&meshes),
        parts: parts(meshes),
        ..PosedMeshes::bare(vertex_len, vertices)
    })
}

/// The meshes of an archive, and the transforms that move them.
struct Scene<'a> {
    /// Transform of each object; `None` for objects of another kind.
    transforms: Vec<Option<Transform<'a>>>,
    meshes: Vec<PlacedMesh<'a>>,
}

/// A mesh and its place in the hierarchy.
struct PlacedMesh<'a> {
    mesh: Mesh<'a>,
    /// Names of the nearest transform above the mesh and of the mesh.
    names: Vec<String>,
    /// Objects of the transforms above the mesh, the nearest first.
    above: Vec<usize>,
}

/// The product of the transforms above a mesh.
enum World<'t, 'a> {
    Constant(Matrix4<f64>),
    /// The transforms, the root first.
    Moving(Vec<&'t Transform<'a>>),
}

impl<'a> Scene<'a> {
    fn read(archive: &'a Archive<'a>) -> Result<Self, Error> {
        let (objects, metadata) = list(archive)?;
        let mut transforms = Vec::with_capacity(objects.len());
        let mut meshes = Vec::new();
        for (number, object) in objects.iter().enumerate() {
            let is_transform = object.schema == Schema::Transform;
            let transform = is_transform.then(|| Transform::read(object, &metadata)).transpose()?;
            transforms.push(transform);
            if object.schema == Schema::Mesh {
                let above = above(&objects, &transforms, number);
                let nearest = above.first().map(|&transform| &objects[transform].name);
                let names = nearest.into_iter().chain([&object.name]).cloned().collect();
                meshes.push(PlacedMesh { mesh: Mesh::read(object, &metadata)?, names, above });
            }
        }
        if meshes.is_empty() {
            return Err(Error::missing(
                "holds no polygon mesh: export the character's mesh, as polygons",
            ));
        }
        Ok(Self { transforms, meshes })
    }
}

/// Lists the transforms that move an object, the nearest first.
fn above(
    objects: &[Object<'_>],
    transforms: &[Option<Transform<'_>>],
    number: usize,
) -> Vec<usize> {
    let mut above = Vec::new();
    let parents = std::iter::successors(objects[number].parent, |&parent| objects[parent].parent);
    for parent in parents {
        if let Some(transform) = &transforms[parent] {
            above.push(parent);
            if !transform.inherits {
                break;
            }
        }
    }
    above
}

/// Counts the frames: the number of samples, which all changing meshes and transforms must share.
fn frame_len(
    transforms: &[Option<Transform<'_>>],
    meshes: &[PlacedMesh<'_>],
) -> Result<usize, Error> {
    // For each mesh and transform: whether it changes, its number of samples, and its description.
    let mut sampled = Vec::new();
    for PlacedMesh { mesh, above, names } in meshes {
        sampled.push((!mesh.is_constant(), mesh.sample_len(), format!("mesh {}", mesh.name)));
        for transform in above.iter().filter_map(|&above| transforms[above].as_ref()) {
            let moves = !transform.is_constant();
            sampled.push((
                moves,
                transform.sample_len(),
                format!("a transform above {}", names[0]),
            ));
        }
    }
    let changes = sampled.iter().any(|(changes, ..)| *changes);
    sampled.retain(|(this, ..)| *this == changes);
    let expected = sampled.iter().map(|(_, len, _)| *len).max().unwrap_or_default();
    match sampled.into_iter().find(|(_, len, _)| changes && *len != expected) {
        Some((_, found, object)) => Err(Error::mismatch(format!(
            "{object} has {found} samples, expected 1 or {expected} as others have; export all \
             over the same frames and at one rate"
        ))),
        None => Ok(expected),
    }
}

impl<'t, 'a> World<'t, 'a> {
    fn new(transforms: &'t [Option<Transform<'a>>], above: &[usize]) -> Self {
        let above = above.iter().rev().filter_map(|&above| transforms[above].as_ref());
        let moving = Self::Moving(above.collect());
        match &moving {
            Self::Moving(all) if all.iter().all(|one| one.is_constant()) => {
                Self::Constant(moving.at(0))
            }
            _ => moving,
        }
    }

    fn at(&self, frame: usize) -> Matrix4<f64> {
        match self {
            Self::Constant(world) => *world,
            Self::Moving(all) => all.iter().map(|transform| transform.at(frame)).product(),
        }
    }

    /// Counts the matrices to multiply for each frame.
    fn factor_len(&self) -> usize {
        match self {
            Self::Constant(_) => 0,
            Self::Moving(all) => all.len(),
        }
    }
}

fn transform_point(world: &Matrix4<f64>, x: [f64; 3]) -> [f64; 3] {
    world.transform_point(&Point3::from(x)).into()
}

/// Splits the faces of all meshes into triangles, with vertices numbered across all meshes.
fn triangles(meshes: &[PlacedMesh<'_>], positions: &[[f64; 3]]) -> Vec<[usize; 3]> {
    let mut triangles = Vec::new();
    let mut first = 0;
    for PlacedMesh { mesh, .. } in meshes {
        let own = mesh.polygons.triangles(&positions[first..][..mesh.vertex_len]);
        triangles.extend(own.into_iter().map(|corners| corners.map(|corner| corner + first)));
        first += mesh.vertex_len;
    }
    triangles
}

/// Joins the reference positions of all meshes; `None` if a mesh has none.
fn reference(meshes: &[PlacedMesh<'_>]) -> Option<Vec<[f64; 3]>> {
    let all = meshes.iter().map(|PlacedMesh { mesh, .. }| mesh.reference.as_deref());
    all.collect::<Option<Vec<_>>>().map(|all| all.concat())
}

/// Lists the names and vertex ranges of the meshes.
fn parts(meshes: Vec<PlacedMesh<'_>>) -> Vec<Part> {
    let mut first = 0;
    let part = |PlacedMesh { mesh, names, .. }: PlacedMesh<'_>| {
        let range = first..first + mesh.vertex_len;
        first = range.end;
        Part { names, range }
    };
    meshes.into_iter().map(part).collect()
}
