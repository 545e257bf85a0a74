//! Saves sampled poses as NumPy arrays.

use super::SampledPoses;
use crate::Error;
use crate::examples::{Examples, Matrix3x4};
use crate::files::PendingFile;
use crate::formats::npz::Writer;
use nalgebra::Matrix4;
use std::fs::File;
use std::io;
use std::path::Path;

/// Saves poses in double precision, in the arrays that training reads, without `vertices`. `inverse_binds` (J, 4, 4)
/// holds the inverses of `joint_world_rest`. Equal poses give equal bytes.
///
/// - `rig`: rig of the poses.
///
/// # Errors
/// The file cannot be written; the error names the file.
pub fn save_poses(path: &Path, rig: &Examples, poses: &SampledPoses) -> Result<(), Error> {
    PendingFile::create(path)
        .and_then(|mut part| write(&mut part.file, rig, poses).and_then(|()| part.finish()))
        .map_err(|error| Error::write(error).in_file(path))
}

fn write(file: &mut File, rig: &Examples, poses: &SampledPoses) -> io::Result<()> {
    let mut archive = Writer::new(file);
    let (joints, curves) = (rig.joint_len(), rig.curve_names.len());
    let n = (poses.transforms.len() / joints.max(1)) as u64;
    if !rig.skeleton.is_still {
        let j = joints as u64;
        let parents = rig.skeleton.own_parents().into_iter();
        let parents = parents.map(|parent| parent.map_or(-1, |parent| parent as i64));
        let rest: Vec<Matrix4<f64>> = rig.skeleton.rest.iter().map(square).collect();
        let inverses = rest.iter().map(|rest| rest.try_inverse().unwrap_or_default());
        let posed = poses.transforms.iter().map(square);
        archive.texts("bone_names", &rig.skeleton.names)?;
        archive.numbers("bone_parents", &[j], parents)?;
        archive.numbers("joint_world_rest", &[j, 4, 4], rows(rest.iter().copied()))?;
        archive.numbers("inverse_binds", &[j, 4, 4], rows(inverses))?;
        archive.numbers("bone_transforms", &[n, j, 4, 4], rows(posed))?;
    }
    if curves > 0 {
        archive.texts("curve_names", &rig.curve_names)?;
        archive.numbers("curves", &[n, curves as u64], poses.curves.iter().copied())?;
    }
    archive.finish()
}

/// Returns a map as a matrix of four rows.
fn square(map: &Matrix3x4) -> Matrix4<f64> {
    let [x, y, z] = *map;
    Matrix4::from_fn(|row, column| [x, y, z, [0.0, 0.0, 0.0, 1.0]][row][column])
}

/// Lists the numbers of matrices, row by row.
fn rows(matrices: impl Iterator<Item = Matrix4<f64>>) -> impl Iterator<Item = f64> {
    matrices.flat_map(|matrix| matrix.transpose().iter().copied().collect::<Vec<_>>())
}
