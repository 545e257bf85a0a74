//! Meshes as Wavefront OBJ.

use std::fs::File;
use std::io;
use std::path::Path;

use obj::{LoadConfig, ObjData};

use super::{Element, ExamplesError, LoadError};

/// A mesh of V vertices at rest.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Positions, V.
    pub positions: Vec<[f64; 3]>,
    /// Vertex numbers of each triangle; polygons are split into a fan about their first corner.
    pub triangles: Vec<[usize; 3]>,
    /// Texture coordinates, V, where no vertex has two.
    pub uv: Option<Vec<[f64; 2]>>,
}

/// Reads the mesh of an OBJ file, all its objects and groups together.
///
/// # Errors
/// A [`LoadError`] with the file: it cannot be read, has no vertex or no face, a position that is
/// not finite, or a face that names a vertex that does not exist.
pub fn load(path: &Path) -> Result<Mesh, LoadError> {
    let blame = |error| LoadError { file: path.to_owned(), error };
    let file = File::open(path).map_err(|error| blame(ExamplesError::Read(error)))?;
    let data =
        ObjData::load_buf_with_config(file, LoadConfig { strict: false }).map_err(|error| {
            blame(ExamplesError::Read(io::Error::new(
                io::ErrorKind::InvalidData,
                error.to_string(),
            )))
        })?;
    mesh(&data).map_err(blame)
}

fn mesh(data: &ObjData) -> Result<Mesh, ExamplesError> {
    let vertex_len = data.position.len();
    let positions: Vec<_> = data.position.iter().map(|x| x.map(f64::from)).collect();
    if let Some(vertex) = positions.iter().position(|x| !x.iter().all(|x| x.is_finite())) {
        let (array, frame, element) = ("v", None, Element::Vertex(vertex));
        return Err(ExamplesError::NotFinite { array, frame, element });
    }
    let mut uv: Vec<Option<usize>> = vec![None; vertex_len];
    let mut one_each = !data.texture.is_empty();
    let mut triangles = Vec::new();
    let polygons = data.objects.iter().flat_map(|object| &object.groups).flat_map(|g| &g.polys);
    for (face, polygon) in polygons.enumerate() {
        for corner in &polygon.0 {
            if corner.0 >= vertex_len {
                let (array, vertex) = ("f", corner.0 as i64);
                return Err(ExamplesError::VertexOutOfRange { array, face, vertex, vertex_len });
            }
            let known = uv[corner.0].get_or_insert(corner.1.unwrap_or(usize::MAX));
            one_each &= Some(*known) == corner.1 && *known < data.texture.len();
        }
        let fan = (2..polygon.0.len()).map(|k| [0, k - 1, k].map(|corner| polygon.0[corner].0));
        triangles.extend(fan);
    }
    for (array, len) in [("v", vertex_len), ("f", triangles.len())] {
        if len == 0 {
            return Err(ExamplesError::Empty { array });
        }
    }
    let coordinates = uv.iter().map(|&uv| uv.and_then(|uv| data.texture.get(uv)));
    let coordinates = coordinates.map(|uv| uv.copied().unwrap_or_default().map(f64::from));
    let uv = one_each.then(|| coordinates.collect());
    Ok(Mesh { positions, triangles, uv })
}
