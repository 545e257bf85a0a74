//! A mesh by itself.

use super::error::FormatError;
use super::scene::SceneError;
use super::warning::FormatWarning;
use crate::mesh::{EngineMesh, Surface};
use crate::space::Conversion;
use sinew_runtime::format::Space;

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

/// A mesh and the space of its file.
pub struct MeshFile {
    /// The meshes of the file as one, in the rest pose.
    pub mesh: Mesh,
    /// Axes and unit, as far as they are known.
    pub space: Option<Space>,
    /// What was left out.
    pub warnings: Vec<FormatWarning>,
}

impl Mesh {
    /// Gives the mesh as an engine draws it.
    pub fn surface(&self) -> Surface<'_> {
        let Self { positions, triangles, engine } = self;
        Surface { positions, triangles, engine: engine.as_ref() }
    }

    /// Refuses a mesh without triangles.
    pub(super) fn checked(self) -> Result<Self, FormatError> {
        if self.triangles.is_empty() { Err(SceneError::NoMesh.into()) } else { Ok(self) }
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
