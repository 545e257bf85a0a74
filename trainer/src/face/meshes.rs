//! Example meshes as arrays: `meshes` (N, V, 3) or, of points in a plane, (N, V, 2); faces as `quads` and `tris`.

use super::basis::ExampleMeshes;
use super::error::FaceError;
use super::npz::{count, faces};
use crate::formats::npz::{Archive, ArrayError};
use crate::formats::{FormatError, ShapedMesh};
use std::path::Path;

/// Reads example meshes; those in a plane get z = 0.
pub(super) fn read(path: &Path) -> Result<ExampleMeshes, FaceError> {
    let mut archive = Archive::open(path)?;
    let in_space = archive.rows::<f64, 3>("meshes", &[0, 3]);
    let (lead, points) = match in_space {
        Ok(Some(rows)) => (rows.lead, rows.data),
        Ok(None) => {
            let array = "neutral, with expression_deltas and expression_names, or meshes";
            return Err(FormatError::from(ArrayError::Missing { array }).into());
        }
        Err(error) => match archive.rows::<f64, 2>("meshes", &[0, 2]) {
            Ok(Some(rows)) => (rows.lead, rows.data.iter().map(|&[x, y]| [x, y, 0.0]).collect()),
            _ => return Err(error.into()),
        },
    };
    let (n, len) = (lead[0], lead[1]);
    if n < 2 {
        return Err(FaceError::Count {
            array: "meshes",
            what: "meshes or more",
            expected: 2,
            found: n,
        });
    }
    if !points.as_flattened().iter().all(|x| x.is_finite()) {
        return Err(FaceError::NotFinite { array: "meshes" });
    }
    let positions: Vec<Vec<[f64; 3]>> = points.chunks(len.max(1)).map(<[_]>::to_vec).collect();
    count("meshes", "meshes with vertices", n, positions.len())?;
    let faces = faces(&mut archive, ["quads", "tris"], len)?;
    let mesh = ShapedMesh { positions: positions[0].clone(), faces, ..ShapedMesh::default() };
    Ok(ExampleMeshes { mesh, positions })
}
