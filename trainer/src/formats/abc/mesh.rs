//! A mesh of an Alembic archive.

use super::error::{AlembicError, damaged};
use super::header::Metadata;
use super::objects::Object;
use super::property::{Compound, Numbers, Sampled};
use crate::formats::polygons::Polygons;

/// A mesh, whose positions are read frame by frame.
pub(super) struct Mesh<'a> {
    pub(super) name: String,
    /// Vertices of every frame.
    pub(super) vertex_len: usize,
    pub(super) polygons: Polygons,
    /// Positions by which its vertices may be known, of a file that has them.
    pub(super) reference: Option<Vec<[f64; 3]>>,
    positions: Sampled<'a>,
}

/// Bytes of a position.
const POINT_BYTES: usize = 12;

impl<'a> Mesh<'a> {
    /// Reads what of a mesh stays, and checks that it does.
    ///
    /// # Errors
    /// [`AlembicError::NoVertices`], [`AlembicError::OtherFaces`], [`AlembicError::Damaged`] and
    /// [`AlembicError::TooLarge`].
    pub(super) fn read(object: &Object<'a>, metadata: &Metadata) -> Result<Self, AlembicError> {
        let name = object.name.clone();
        let schema = object.properties.compound(".geom", metadata)?;
        let schema = schema.ok_or_else(|| damaged(format!("mesh {name} has no .geom")))?;
        let positions = schema.sampled("P", Numbers::F32, 3)?;
        let Some(positions) = positions else {
            return Err(AlembicError::NoVertices { mesh: name });
        };
        let vertex_len = positions.sample(0)?.len() / POINT_BYTES;
        if vertex_len == 0 {
            return Err(AlembicError::NoVertices { mesh: name });
        }
        let counts = constant(object, &schema, ".faceCounts")?;
        let corners = constant(object, &schema, ".faceIndices")?;
        let polygons = polygons(&counts, &corners, vertex_len).ok_or_else(|| {
            damaged(format!("the faces of mesh {name} name vertices or corners that are not there"))
        })?;
        let reference = match schema.compound(".arbGeomParams", metadata)? {
            Some(others) => others.sampled("Pref", Numbers::F32, 3)?,
            None => None,
        };
        let reference = reference.map(|reference| Ok(points(reference.sample(0)?).collect()));
        let reference = reference.transpose()?.filter(|all: &Vec<_>| all.len() == vertex_len);
        Ok(Self { name, vertex_len, polygons, reference, positions })
    }

    /// Counts the samples.
    pub(super) fn sample_len(&self) -> usize {
        self.positions.len
    }

    /// Tells whether it stays as it is.
    pub(super) fn is_constant(&self) -> bool {
        self.positions.is_constant()
    }

    /// Gives the positions of a frame.
    ///
    /// # Errors
    /// [`AlembicError::OtherVertices`] and [`AlembicError::Damaged`].
    pub(super) fn at(
        &self,
        frame: usize,
    ) -> Result<impl Iterator<Item = [f64; 3]> + use<'a>, AlembicError> {
        let bytes = self.positions.sample(frame)?;
        let (found, expected) = (bytes.len() / POINT_BYTES, self.vertex_len);
        if found != expected {
            let mesh = self.name.clone();
            return Err(AlembicError::OtherVertices { mesh, frame, found, expected });
        }
        Ok(points(bytes))
    }
}

fn points(bytes: &[u8]) -> impl Iterator<Item = [f64; 3]> + use<'_> {
    let points = bytes.as_chunks::<POINT_BYTES>().0.iter();
    points.map(|&[a, b, c, d, e, f, g, h, i, j, k, l]| {
        [[a, b, c, d], [e, f, g, h], [i, j, k, l]].map(|bytes| f64::from(f32::from_le_bytes(bytes)))
    })
}

/// Reads whole numbers that are the same in every frame; none where there are none.
fn constant(
    object: &Object<'_>,
    schema: &Compound<'_>,
    name: &str,
) -> Result<Vec<i32>, AlembicError> {
    let Some(sampled) = schema.sampled(name, Numbers::I32, 1)? else { return Ok(Vec::new()) };
    let first = sampled.sample(0)?;
    for place in 1..sampled.stored_len() {
        object.properties.spend(first.len())?;
        if sampled.stored(place)? != first {
            let (mesh, frame) = (object.name.clone(), sampled.frame(place));
            return Err(AlembicError::OtherFaces { mesh, frame });
        }
    }
    Ok(first.as_chunks().0.iter().map(|bytes| i32::from_le_bytes(*bytes)).collect())
}

/// Makes polygons of the count of each one's corners, and the corners, which turn the other way than elsewhere; none
/// where they do not fit together.
fn polygons(counts: &[i32], corners: &[i32], vertex_len: usize) -> Option<Polygons> {
    let vertex = |&corner: &i32| usize::try_from(corner).ok().filter(|vertex| *vertex < vertex_len);
    let mut left = corners;
    let mut polygons = Polygons::default();
    for &count in counts {
        let (own, others) = left.split_at_checked(usize::try_from(count).ok()?)?;
        let own: Option<Vec<usize>> = own.iter().rev().map(vertex).collect();
        polygons.push(own?);
        left = others;
    }
    left.is_empty().then_some(polygons)
}
