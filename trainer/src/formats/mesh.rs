//! A mesh by itself.

use crate::space::Conversion;

/// A mesh of V vertices, in the file's order and units.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Positions, V.
    pub positions: Vec<[f64; 3]>,
    /// Vertex numbers of each triangle; quads are split along their first diagonal.
    pub triangles: Vec<[usize; 3]>,
    /// Texture coordinates, V, where all corners of each vertex have the same.
    pub uv: Option<Vec<[f64; 2]>>,
}

impl Mesh {
    /// Moves the mesh by what leads into another space; texture coordinates stay.
    pub fn convert(&mut self, conversion: &Conversion) {
        self.positions.iter_mut().for_each(|x| *x = conversion.point(*x));
        conversion.triangles(&mut self.triangles);
    }
}
