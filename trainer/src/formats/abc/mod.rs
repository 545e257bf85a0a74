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
use nalgebra::Matrix4;
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
    let (transforms, meshes) = scene(&archive)?;
    let frame_len = frame_len(&transforms, &meshes)?;
    let vertex_len = meshes.last().map_or(0, |placed| placed.part.range.end);
    let position_len = frame_len.saturating_mul(vertex_len);
    archive.spend(position_len.saturating_mul(size_of::<[f64; 3]>()))?;
    // For each mesh, the transforms above it, the root first, and their product if all are constant.
    let worlds = meshes.iter().map(|placed| {
        let above = placed.above.iter().rev().filter_map(|&above| transforms[above].as_ref());
        let above: Vec<&Transform<'_>> = above.collect();
        let constant = above.iter().all(|one| one.is_constant()).then(|| world(&above, 0));
        (above, constant)
    });
    let worlds: Vec<_> = worlds.collect();
    let moving = worlds.iter().filter(|(_, constant)| constant.is_none());
    let moved: usize = moving.map(|(above, _)| above.len()).sum();
    archive.spend(frame_len.saturating_mul(moved).saturating_mul(size_of::<Matrix4<f64>>()))?;

    let mut vertices = Vec::with_capacity(position_len);
    for frame in 0..frame_len {
        for (PlacedMesh { mesh, .. }, (above, constant)) in meshes.iter().zip(&worlds) {
            let world = constant.unwrap_or_else(|| world(above, frame));
            let place = |x: [f64; 3]| -> [f64; 3] { world.transform_point(&x.into()).into() };
            vertices.extend(mesh.at(frame)?.map(place));
        }
    }
    let first = vertices.get(..vertex_len).unwrap_or_default();
    let triangles = triangles(&meshes, first);
    let reference = meshes.iter().map(|PlacedMesh { mesh, .. }| mesh.reference.as_deref());
    Ok(PosedMeshes {
        triangles: (!triangles.is_empty()).then_some(triangles),
        reference: reference.collect::<Option<Vec<_>>>().map(|all| all.concat()),
        parts: meshes.into_iter().map(|placed| placed.part).collect(),
        ..PosedMeshes::bare(vertex_len, vertices)
    })
}

/// A mesh and its place in the hierarchy.
struct PlacedMesh<'a> {
    mesh: Mesh<'a>,
    /// Names of the nearest transform above the mesh and of the mesh; vertices among those of all meshes.
    part: Part,
    /// Objects of the transforms above the mesh, the nearest first.
    above: Vec<usize>,
}

/// Transform of each object; `None` for objects of another kind.
type Transforms<'a> = Vec<Option<Transform<'a>>>;

/// Reads the meshes of an archive, and the transforms that move them.
fn scene<'a>(archive: &'a Archive<'a>) -> Result<(Transforms<'a>, Vec<PlacedMesh<'a>>), Error> {
    let (objects, metadata) = list(archive)?;
    let mut transforms = Vec::with_capacity(objects.len());
    let mut meshes = Vec::new();
    let mut first = 0;
    for (number, object) in objects.iter().enumerate() {
        let is_transform = object.schema == Schema::Transform;
        let transform = is_transform.then(|| Transform::read(object, &metadata)).transpose()?;
        transforms.push(transform);
        if object.schema == Schema::Mesh {
            let above = above(&objects, &transforms, number);
            let nearest = above.first().map(|&transform| &objects[transform].name);
            let names = nearest.into_iter().chain([&object.name]).cloned().collect();
            let mesh = Mesh::read(object, &metadata)?;
            let range = first..first + mesh.vertex_len;
            first = range.end;
            meshes.push(PlacedMesh { mesh, part: Part { names, range }, above });
        }
    }
    if meshes.is_empty() {
        return Err(Error::missing(
            "holds no polygon mesh: export the character's mesh, as polygons",
        ));
    }
    Ok((transforms, meshes))
}

/// Multiplies transforms at a frame.
fn world(above: &[&Transform<'_>], frame: usize) -> Matrix4<f64> {
    above.iter().map(|transform| transform.at(frame)).product()
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
    for PlacedMesh { mesh, above, part } in meshes {
        let Mesh { name, positions, .. } = mesh;
        sampled.push((!positions.is_constant(), positions.len(), format!("mesh {name}")));
        for transform in above.iter().filter_map(|&above| transforms[above].as_ref()) {
            let object = format!("a transform above {}", part.names[0]);
            sampled.push((!transform.is_constant(), transform.sample_len(), object));
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

/// Splits the faces of all meshes into triangles, with vertices numbered across all meshes.
fn triangles(meshes: &[PlacedMesh<'_>], positions: &[[f64; 3]]) -> Vec<[usize; 3]> {
    let mut triangles = Vec::new();
    for PlacedMesh { mesh, part, .. } in meshes {
        let own = mesh.polygons.triangles(&positions[part.range.clone()]).into_iter();
        triangles.extend(own.map(|corners| corners.map(|corner| corner + part.range.start)));
    }
    triangles
}
