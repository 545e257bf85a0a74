//! Point caches: `X.pc2`, the posed positions of a mesh, frame after frame (PointCache2).

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use crate::files::Part;

use super::{ExamplesError, LoadError};

/// Writes N frames of V positions in f32, one sample a frame from frame 0 on; `vertices` is
/// frame-major. The file is written beside its place and moved there when complete.
///
/// # Errors
/// A [`LoadError`] with the file that could not be written.
pub fn save_pc2(path: &Path, vertex_len: usize, vertices: &[[f64; 3]]) -> Result<(), LoadError> {
    Part::create(path)
        .and_then(|mut part| write(part.file(), vertex_len, vertices).and_then(|()| part.finish()))
        .map_err(|error| LoadError { file: path.to_owned(), error: ExamplesError::Write(error) })
}

fn write(file: &mut File, vertex_len: usize, vertices: &[[f64; 3]]) -> io::Result<()> {
    let too_many = |_| io::Error::new(io::ErrorKind::InvalidInput, "too many for a point cache");
    let points = i32::try_from(vertex_len).map_err(too_many)?;
    let samples = i32::try_from(vertices.len() / vertex_len.max(1)).map_err(too_many)?;
    let mut file = BufWriter::new(file);
    file.write_all(b"POINTCACHE2\0")?;
    file.write_all(&1i32.to_le_bytes())?;
    file.write_all(&points.to_le_bytes())?;
    file.write_all(&0f32.to_le_bytes())?;
    file.write_all(&1f32.to_le_bytes())?;
    file.write_all(&samples.to_le_bytes())?;
    for coordinate in vertices.as_flattened() {
        file.write_all(&(*coordinate as f32).to_le_bytes())?;
    }
    file.flush()
}
