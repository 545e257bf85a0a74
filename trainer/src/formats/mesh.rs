//! Meshes from files of any format, and meshes with named shapes, as files of faces have them.

use super::FormatWarning;
use super::polygons::Polygons;
use super::scene::faults;
use crate::Error;
use crate::mesh::{EngineMesh, Surface};
use crate::space::Conversion;
use sinew_runtime::format::Space;

/// A mesh of V vertices, in the file's order and units.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Positions, V.
    pub positions: Vec<[f64; 3]>,
    /// Vertex indices of each triangle; quads are split along their first diagonal.
    pub triangles: Vec<[usize; 3]>,
    /// Engine vertices, if corners of a vertex differ or attributes are authored.
    pub engine: Option<EngineMesh>,
}

/// A mesh and the space of its file.
pub struct MeshFile {
    /// All meshes of the file, joined, in the rest pose.
    pub mesh: Mesh,
    /// Axes and unit, if the format states them.
    pub space: Option<Space>,
    /// Data that was left out.
    pub warnings: Vec<FormatWarning>,
}

impl Mesh {
    /// Returns the mesh as an engine draws it.
    pub fn surface(&self) -> Surface<'_> {
        let Self { positions, triangles, engine } = self;
        Surface { positions, triangles, engine: engine.as_ref() }
    }

    /// Returns the mesh.
    ///
    /// # Errors
    /// The mesh has no triangles.
    pub(super) fn checked(self) -> Result<Self, Error> {
        if self.triangles.is_empty() { Err(faults::no_mesh()) } else { Ok(self) }
    }

    /// Converts the mesh to another space; texture coordinates stay.
    pub fn convert(&mut self, conversion: &Conversion) {
        self.positions.iter_mut().for_each(|x| *x = conversion.point(*x));
        conversion.triangles(&mut self.triangles);
        if let Some(engine) = &mut self.engine {
            engine.turn(|direction| conversion.direction(direction), conversion.is_mirrored());
        }
    }
}

/// A mesh of V vertices and its S shapes, in the file's order and units.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShapedMesh {
    /// Positions, V.
    pub positions: Vec<[f64; 3]>,
    /// Vertex indices of the corners of each face, F.
    pub faces: Vec<Vec<usize>>,
    /// Texture coordinates, v upward; empty if the file has none.
    pub uv: Vec<[f64; 2]>,
    /// Index of each corner's texture coordinates, in the layout of `faces`; empty if the file has none.
    pub uv_faces: Vec<Vec<usize>>,
    /// Authored normals, V.
    pub normals: Option<Vec<[f64; 3]>>,
    /// Whether vertices are split where their corners differ, as in files for engines.
    pub is_split: bool,
    /// Shapes, S, with distinct names.
    pub shapes: Vec<NamedShape>,
    /// Axes and unit.
    pub space: Space,
    /// Data that was left out.
    pub warnings: Vec<FormatWarning>,
}

/// A named displacement of a mesh's vertices, at weight 1.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedShape {
    /// Name of the shape.
    pub name: String,
    /// Displacements, V.
    pub deltas: Vec<[f64; 3]>,
}

impl ShapedMesh {
    /// Splits the faces into triangles.
    ///
    /// # Panics
    /// If a face has a vertex index that is not below V.
    pub fn triangles(&self) -> Vec<[usize; 3]> {
        let mut polygons = Polygons::default();
        self.faces.iter().for_each(|face| polygons.push(face.iter().copied()));
        polygons.triangles(&self.positions)
    }

    /// Adds a shape of some vertices; shapes with one name on several meshes become one shape.
    pub(super) fn add(&mut self, name: &str, moved: impl Iterator<Item = (usize, [f64; 3])>) {
        let known = self.shapes.iter().position(|shape| shape.name == name);
        let place = known.unwrap_or_else(|| {
            let deltas = vec![[0.0; 3]; self.positions.len()];
            self.shapes.push(NamedShape { name: name.to_owned(), deltas });
            self.shapes.len() - 1
        });
        let deltas = &mut self.shapes[place].deltas;
        deltas.resize(self.positions.len(), [0.0; 3]);
        for (vertex, by) in moved {
            deltas[vertex] = by;
        }
    }
}
