//! A mesh by itself.

use crate::mesh::{EngineMesh, Surface};
use crate::space::Conversion;

/// A mesh of V vertices, in the file's order and units.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Positions, V.
    pub positions: Vec<[f64; 3]>,
    /// Vertex numbers of each triangle; quads are split along their first diagonal.
    pub triangles: Vec<[usize; 3]>,
    /// The vertices that an engine draws it with, where corners of one differ or anything is authored.
    pub engine: Option<EngineMesh>,
}

impl Mesh {
    /// Gives the mesh as an engine draws it.
    pub fn surface(&self) -> Surface<'_> {
        let Self { positions, triangles, engine } = self;
        Surface { positions, triangles, engine: engine.as_ref() }
    }

    /// Moves the mesh by what leads into another space; texture coordinates stay.
    pub fn convert(&mut self, conversion: &Conversion) {
        self.positions.iter_mut().for_each(|x| *x = conversion.point(*x));
        conversion.triangles(&mut self.triangles);
        if let Some(engine) = &mut self.engine {
            engine.turn(|direction| conversion.direction(direction), conversion.is_mirrored());
        }
    }
}
