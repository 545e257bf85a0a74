//! Meshes and transforms of an Alembic archive. A transform is a stack of operations with sampled channels.

use super::objects::{Compound, Numbers, Object, Sampled};
use super::ogawa::{Metadata, damaged};
use crate::Error;
use crate::formats::polygons::Polygons;
use nalgebra::{Matrix3, Matrix4, Rotation3, Unit, Vector3};

/// Bytes of a position.
const POINT_BYTES: usize = 12;

/// A mesh whose positions are read frame by frame.
pub(super) struct Mesh<'a> {
    pub(super) name: String,
    /// Number of vertices, in every frame.
    pub(super) vertex_len: usize,
    pub(super) polygons: Polygons,
    /// Reference positions, which identify the vertices, if the file has them.
    pub(super) reference: Option<Vec<[f64; 3]>>,
    pub(super) positions: Sampled<'a>,
}

impl<'a> Mesh<'a> {
    /// Reads the constant parts of a mesh, and checks that its faces do not change.
    ///
    /// # Errors
    /// The mesh has no vertex, its faces change, the file is damaged, or it exceeds the memory budget.
    pub(super) fn read(object: &Object<'a>, metadata: &Metadata) -> Result<Self, Error> {
        let name = object.name.clone();
        let schema = object.properties.compound(".geom", metadata)?;
        let schema = schema.ok_or_else(|| damaged(format!("mesh {name} has no .geom")))?;
        let positions = schema.sampled("P", Numbers::F32, 3)?;
        let Some(positions) = positions else {
            return Err(no_vertices(&name));
        };
        let vertex_len = positions.sample(0)?.len() / POINT_BYTES;
        if vertex_len == 0 {
            return Err(no_vertices(&name));
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
        let reference =
            reference.map(|reference| reference.sample(0).map(|all| points(all).collect()));
        let reference = reference.transpose()?.filter(|all: &Vec<_>| all.len() == vertex_len);
        Ok(Self { name, vertex_len, polygons, reference, positions })
    }

    /// Returns the positions of a frame.
    ///
    /// # Errors
    /// The frame has another number of vertices than the first, or is damaged.
    pub(super) fn at(
        &self,
        frame: usize,
    ) -> Result<impl Iterator<Item = [f64; 3]> + use<'a>, Error> {
        let bytes = self.positions.sample(frame)?;
        let (found, expected) = (bytes.len() / POINT_BYTES, self.vertex_len);
        if found != expected {
            let mesh = &self.name;
            let error = Error::mismatch(format!(
                "mesh {mesh} has {found} vertices, expected {expected} as in the first; export it \
                 without modifiers that change its vertices over time"
            ));
            return Err(error.in_frame(frame));
        }
        Ok(points(bytes))
    }
}

/// The local transform of an object over time.
pub(super) struct Transform<'a> {
    /// Whether the transforms above apply too.
    pub(super) inherits: bool,
    /// Matrix of each stored sample.
    matrices: Vec<Matrix4<f64>>,
    /// Maps samples to stored matrices; `None` for a constant transform.
    values: Option<Sampled<'a>>,
}

impl<'a> Transform<'a> {
    /// Reads the `.xform` of an object.
    ///
    /// # Errors
    /// The file is damaged, or exceeds the memory budget.
    pub(super) fn read(object: &Object<'a>, metadata: &Metadata) -> Result<Self, Error> {
        let mut transform = Self { inherits: true, matrices: Vec::new(), values: None };
        let Some(schema) = object.properties.compound(".xform", metadata)? else {
            return Ok(transform);
        };
        if let Some(inherits) = schema.sampled(".inherits", Numbers::Bool, 1)? {
            transform.inherits = inherits.sample(0)?.first() != Some(&0);
        }
        let Some(operations) = schema.sampled(".ops", Numbers::U8, 0)? else {
            return Ok(transform);
        };
        let operations = operations.sample(0)?;
        if let Some(values) = schema.sampled(".vals", Numbers::F64, 0)? {
            for place in 0..values.stored_len() {
                let channels = values.stored(place)?;
                object.properties.spend(channels.len() + size_of::<Matrix4<f64>>())?;
                let channels =
                    channels.as_chunks().0.iter().map(|bytes| f64::from_le_bytes(*bytes));
                let matrix = matrix(operations, channels).ok_or_else(|| {
                    damaged(format!(
                        "transform {} has too few numbers or an operation that is not known",
                        object.name
                    ))
                })?;
                transform.matrices.push(matrix);
            }
            transform.values = Some(values);
        }
        Ok(transform)
    }

    /// Counts the samples.
    pub(super) fn sample_len(&self) -> usize {
        self.values.as_ref().map_or(1, Sampled::len)
    }

    /// Returns whether the transform never changes.
    pub(super) fn is_constant(&self) -> bool {
        self.matrices.len() < 2
    }

    /// Returns the matrix of sample `index`.
    pub(super) fn at(&self, index: usize) -> Matrix4<f64> {
        let place = self.values.as_ref().map(|values| values.place(index));
        let matrix = place.and_then(|place| self.matrices.get(place));
        matrix.copied().unwrap_or_else(Matrix4::identity)
    }
}

fn no_vertices(mesh: &str) -> Error {
    Error::missing(format!("mesh {mesh} has no vertex; leave it out, or export it with its points"))
}

fn points(bytes: &[u8]) -> impl Iterator<Item = [f64; 3]> + use<'_> {
    let points = bytes.as_chunks::<4>().0.as_chunks::<3>().0.iter();
    points.map(|point| point.map(|bytes| f64::from(f32::from_le_bytes(bytes))))
}

/// Reads whole numbers and checks that they are equal in every frame; empty if the property is missing.
fn constant(object: &Object<'_>, schema: &Compound<'_>, name: &str) -> Result<Vec<i32>, Error> {
    let Some(sampled) = schema.sampled(name, Numbers::I32, 1)? else { return Ok(Vec::new()) };
    let first = sampled.sample(0)?;
    for place in 1..sampled.stored_len() {
        object.properties.spend(first.len())?;
        if sampled.stored(place)? != first {
            let mesh = &object.name;
            let error = Error::mismatch(format!(
                "mesh {mesh} has other faces than in the first; export it without modifiers that \
                 change its faces over time"
            ));
            return Err(error.in_frame(sampled.frame(place)));
        }
    }
    Ok(first.as_chunks().0.iter().map(|bytes| i32::from_le_bytes(*bytes)).collect())
}

/// Makes polygons from the number of corners of each polygon and the vertices of all corners; `None` if they do not fit
/// together. Alembic winds its polygons the other way round, so the corners are reversed.
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

/// Multiplies a stack of operations, the outermost first; `None` if a channel is missing or an operation is not known.
///
/// The upper four bits of an operation state its kind, the lower four its purpose. The kinds are: scale, translation,
/// rotation by degrees about an axis, matrix (by rows, for row vectors), rotations about x, y and z
/// (`XformOperationType` in `lib/Alembic/AbcGeom/Foundation.h` of the Alembic library).
fn matrix(operations: &[u8], mut channels: impl Iterator<Item = f64>) -> Option<Matrix4<f64>> {
    let mut stack = Matrix4::identity();
    for operation in operations {
        let mut next = || channels.next();
        let kind = operation >> 4;
        stack *= match kind {
            0 => Matrix4::new_nonuniform_scaling(&Vector3::new(next()?, next()?, next()?)),
            1 => Matrix4::new_translation(&Vector3::new(next()?, next()?, next()?)),
            2 => turn(Vector3::new(next()?, next()?, next()?), next()?),
            3 => {
                let mut rows = [0.0; 16];
                for number in &mut rows {
                    *number = next()?;
                }
                Matrix4::from_column_slice(&rows)
            }
            4 => turn(Vector3::x(), next()?),
            5 => turn(Vector3::y(), next()?),
            6 => turn(Vector3::z(), next()?),
            _ => return None,
        };
    }
    Some(stack)
}

fn turn(axis: Vector3<f64>, degrees: f64) -> Matrix4<f64> {
    let turn = Unit::try_new(axis, 0.0).map_or_else(Matrix3::identity, |axis| {
        Rotation3::from_axis_angle(&axis, degrees.to_radians()).into_inner()
    });
    turn.to_homogeneous()
}
