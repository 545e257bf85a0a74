//! Transforms of an Alembic archive, as stacks of operations whose channels are sampled.

use nalgebra::{Matrix3, Matrix4, Rotation3, Unit, Vector3};

use super::error::{AlembicError, damaged};
use super::header::Metadata;
use super::objects::Object;
use super::property::{Numbers, Sampled};

/// The local transform of an object over time.
pub(super) struct Transform<'a> {
    /// Whether what stands above moves it too.
    pub(super) inherits: bool,
    /// The matrix of each stored sample.
    matrices: Vec<Matrix4<f64>>,
    /// Which of them is which sample; none of what stays in its place.
    values: Option<Sampled<'a>>,
}

impl<'a> Transform<'a> {
    /// Reads the `.xform` of an object.
    ///
    /// # Errors
    /// [`AlembicError::Damaged`] and [`AlembicError::TooLarge`].
    pub(super) fn read(object: &Object<'a>, metadata: &Metadata) -> Result<Self, AlembicError> {
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
        self.values.as_ref().map_or(1, |values| values.len)
    }

    /// Tells whether it stays as it is.
    pub(super) fn is_constant(&self) -> bool {
        self.matrices.len() < 2
    }

    /// Gives the matrix of sample `index`.
    pub(super) fn at(&self, index: usize) -> Matrix4<f64> {
        let place = self.values.as_ref().map(|values| values.place(index));
        let matrix = place.and_then(|place| self.matrices.get(place));
        matrix.copied().unwrap_or_else(Matrix4::identity)
    }
}

/// Multiplies a stack of operations, the first outermost, with the channels that they take one after another; none
/// where there are too few.
///
/// An operation is its kind in the upper four bits, and what it is for in the lower: scale, translation, rotation by
/// degrees about an axis, matrix by rows for row vectors, rotations about x, y and z (`XformOperationType` in
/// `lib/Alembic/AbcGeom/Foundation.h` of the Alembic library).
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
