//! Alembic, `.abc`: the polygon meshes of an Ogawa archive, posed frame by frame where its transforms put them.
//!
//! Axes and unit stay as they are in the file, which says nothing of them. Vertices are the meshes', in their order;
//! several meshes follow one another in the order of the file.
//! Reads an archive: its meshes as one, frame by frame.
//! What can be wrong with an Alembic archive.

mod objects;
mod ogawa;
mod schemas;
#[cfg(test)]
mod tests;

use super::error::FormatError;
use super::posed_meshes::{Part, PosedMeshes};
use nalgebra::{Matrix4, Point3};
use objects::{Object, Schema, list};
use ogawa::Archive;
use schemas::{Mesh, Transform};
use std::path::Path;

/// Reads the polygon meshes of a file, each frame a sample of them, where the transforms above put them.
///
/// # Errors
/// [`FormatError::Read`], and [`FormatError::Alembic`] with what is damaged or changes that may not.
pub(crate) fn read(path: &Path) -> Result<PosedMeshes, FormatError> {
    Ok(parse(&std::fs::read(path).map_err(FormatError::Read)?)?)
}

/// Reads the bytes of a file.
///
/// # Errors
/// An [`AlembicError`].
fn parse(bytes: &[u8]) -> Result<PosedMeshes, AlembicError> {
    let archive = Archive::new(bytes)?;
    let Scene { transforms, shown } = Scene::read(&archive)?;
    let frame_len = frame_len(&transforms, &shown)?;
    let vertex_len = shown.iter().map(|shown| shown.mesh.vertex_len).sum::<usize>();
    let position_len = frame_len.saturating_mul(vertex_len);
    archive.spend(position_len.saturating_mul(size_of::<[f64; 3]>()))?;
    let worlds: Vec<_> = shown.iter().map(|shown| World::new(&transforms, &shown.above)).collect();
    let moved: usize = worlds.iter().map(World::factor_len).sum();
    archive.spend(frame_len.saturating_mul(moved).saturating_mul(size_of::<Matrix4<f64>>()))?;

    let mut vertices = Vec::with_capacity(position_len);
    for frame in 0..frame_len {
        for (Shown { mesh, .. }, world) in shown.iter().zip(&worlds) {
            let world = world.at(frame);
            vertices.extend(mesh.at(frame)?.map(|x| carried(&world, x)));
        }
    }
    let first = vertices.get(..vertex_len).unwrap_or_default();
    let triangles = triangles(&shown, first);
    Ok(PosedMeshes {
        triangles: (!triangles.is_empty()).then_some(triangles),
        reference: reference(&shown),
        parts: parts(shown),
        ..PosedMeshes::bare(vertex_len, vertices)
    })
}

/// The meshes of an archive and what moves them.
struct Scene<'a> {
    /// The transform of each object; of none but transforms.
    transforms: Vec<Option<Transform<'a>>>,
    shown: Vec<Shown<'a>>,
}

/// A mesh.
struct Shown<'a> {
    mesh: Mesh<'a>,
    /// What it and the transform above it are called.
    names: Vec<String>,
    /// The transforms above it by object, the nearest first.
    above: Vec<usize>,
}

/// The product of the transforms above a mesh.
enum World<'t, 'a> {
    Constant(Matrix4<f64>),
    /// The farthest first.
    Moving(Vec<&'t Transform<'a>>),
}

impl<'a> Scene<'a> {
    fn read(archive: &'a Archive<'a>) -> Result<Self, AlembicError> {
        let (objects, metadata) = list(archive)?;
        let mut transforms = Vec::with_capacity(objects.len());
        let mut shown = Vec::new();
        for (number, object) in objects.iter().enumerate() {
            let is_transform = object.schema == Schema::Transform;
            let transform = is_transform.then(|| Transform::read(object, &metadata)).transpose()?;
            transforms.push(transform);
            if object.schema == Schema::Mesh {
                let above = above(&objects, &transforms, number);
                let nearest = above.first().map(|&transform| &objects[transform].name);
                let names = nearest.into_iter().chain([&object.name]).cloned().collect();
                shown.push(Shown { mesh: Mesh::read(object, &metadata)?, names, above });
            }
        }
        if shown.is_empty() {
            return Err(AlembicError::NoMesh);
        }
        Ok(Self { transforms, shown })
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

/// Counts the frames: the samples of what changes, which must be as many of all.
fn frame_len(
    transforms: &[Option<Transform<'_>>],
    shown: &[Shown<'_>],
) -> Result<usize, AlembicError> {
    // Whether it changes, its samples, and what it is.
    let mut sampled = Vec::new();
    for Shown { mesh, above, names } in shown {
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
        Some((_, found, object)) => Err(AlembicError::OtherSamples { object, found, expected }),
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

    /// Counts the matrices that are multiplied for a frame.
    fn factor_len(&self) -> usize {
        match self {
            Self::Constant(_) => 0,
            Self::Moving(all) => all.len(),
        }
    }
}

fn carried(world: &Matrix4<f64>, x: [f64; 3]) -> [f64; 3] {
    world.transform_point(&Point3::from(x)).into()
}

/// Splits the faces of all meshes into triangles, with vertices by their numbers among all.
fn triangles(shown: &[Shown<'_>], positions: &[[f64; 3]]) -> Vec<[usize; 3]> {
    let mut triangles = Vec::new();
    let mut first = 0;
    for Shown { mesh, .. } in shown {
        let own = mesh.polygons.triangles(&positions[first..][..mesh.vertex_len]);
        triangles.extend(own.into_iter().map(|corners| corners.map(|corner| corner + first)));
        first += mesh.vertex_len;
    }
    triangles
}

/// Joins the reference positions of all meshes, where all have some.
fn reference(shown: &[Shown<'_>]) -> Option<Vec<[f64; 3]>> {
    let all = shown.iter().map(|Shown { mesh, .. }| mesh.reference.as_deref());
    all.collect::<Option<Vec<_>>>().map(|all| all.concat())
}

/// Names the meshes and tells which vertices they have.
fn parts(shown: Vec<Shown<'_>>) -> Vec<Part> {
    let mut first = 0;
    let part = |Shown { mesh, names, .. }: Shown<'_>| {
        let range = first..first + mesh.vertex_len;
        first = range.end;
        Part { names, range }
    };
    shown.into_iter().map(part).collect()
}

/// An Alembic archive that cannot be read, or is not of one mesh.
#[derive(Debug, thiserror::Error)]
pub enum AlembicError {
    /// The archive is in a container that is not read.
    #[error(
        "is Alembic in an HDF5 container, which is not read; export it again with Ogawa as its data format"
    )]
    Hdf5,
    /// The file does not begin as an archive that is read.
    #[error("is no Alembic archive of Ogawa's version 1: {reason}; export it as .abc again")]
    NotAlembic {
        /// What is different.
        reason: String,
    },
    /// What wrote the file did not come to its end.
    #[error("was not closed by what wrote it; export it again, to the end")]
    Unfinished,
    /// The file says of itself what cannot be.
    #[error("is damaged: {what}; export it again")]
    Damaged {
        /// What cannot be.
        what: String,
    },
    /// The file names more than it can be meant to hold.
    #[error(
        "unfolds to more than {most} bytes, the most for a file of its size, by naming the same bytes again and \
         again; export the frames that are wanted alone"
    )]
    TooLarge {
        /// The most.
        most: usize,
    },
    /// There is no mesh.
    #[error("holds no polygon mesh: export the character's mesh, as polygons")]
    NoMesh,
    /// A mesh has no positions.
    #[error("mesh {mesh} has no vertex; leave it out, or export it with its points")]
    NoVertices {
        /// The mesh.
        mesh: String,
    },
    /// A mesh has other vertices in one frame than in the first.
    #[error(
        "mesh {mesh} has {found} vertices in frame {frame}, expected {expected} as in the first; export it \
         without what changes its vertices over time"
    )]
    OtherVertices {
        /// The mesh.
        mesh: String,
        /// The frame.
        frame: usize,
        /// Vertices in it.
        found: usize,
        /// Vertices in the first.
        expected: usize,
    },
    /// A mesh has other faces in one frame than in the first.
    #[error(
        "mesh {mesh} has other faces in frame {frame} than in the first; export it without what changes its \
         faces over time"
    )]
    OtherFaces {
        /// The mesh.
        mesh: String,
        /// The frame.
        frame: usize,
    },
    /// Two things are sampled differently often.
    #[error(
        "{object} has {found} samples, expected 1 or {expected} as others have; export all over the same frames \
         and at one rate"
    )]
    OtherSamples {
        /// The mesh or transform.
        object: String,
        /// Its samples.
        found: usize,
        /// The most that there are of one.
        expected: usize,
    },
}

/// Says what cannot be.
fn damaged(what: impl Into<String>) -> AlembicError {
    AlembicError::Damaged { what: what.into() }
}
