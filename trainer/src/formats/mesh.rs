//! A mesh by itself.
//! A mesh by itself, from whichever format.
//! A mesh with named shapes, as a face's file holds it.

use super::error::{FileError, FormatError, FormatWarning};
use super::extension::{check_content, extension, unknown_format};
use super::polygons::Polygons;
use super::scene::SceneError;
use super::{fbx, gltf, obj};
use crate::mesh::{EngineMesh, Surface};
use crate::space::Conversion;
use sinew_runtime::format::Space;
use std::path::Path;

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

impl MeshFile {
    /// Reads a mesh from a `.obj`, `.glb`, `.gltf` or `.fbx` file. Of a scene, meshes with a skin stand as they are bound;
    /// where none has one, all stand as their nodes do.
    ///
    /// # Errors
    /// [`FileError`]: the file cannot be read, or holds no triangles.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let blame = |error| FileError { file: path.to_owned(), error };
        check_content(path).map_err(blame)?;
        match extension(path).as_str() {
            "obj" => Ok(Self { mesh: obj::load(path)?, space: None, warnings: Vec::new() }),
            "glb" | "gltf" => gltf::read_mesh(path).map_err(blame),
            "fbx" => fbx::read_mesh(path).map_err(blame),
            _ => Err(blame(unknown_format(path, ".obj, .glb, .gltf or .fbx"))),
        }
    }
}

/// A mesh of V vertices and its S shapes, in the file's order and units.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShapedMesh {
    /// Positions, V.
    pub positions: Vec<[f64; 3]>,
    /// Vertex numbers of the corners of each face, F.
    pub faces: Vec<Vec<usize>>,
    /// Texture coordinates, v upward; none where the file has none.
    pub uv: Vec<[f64; 2]>,
    /// Which of them each corner has, F as `faces`; none where there are none.
    pub uv_faces: Vec<Vec<usize>>,
    /// Authored normals, V.
    pub normals: Option<Vec<[f64; 3]>>,
    /// Whether vertices are split where corners of one differ, as files for engines have them.
    pub is_split: bool,
    /// Shapes, S, each with a name of its own.
    pub shapes: Vec<NamedShape>,
    /// Axes and unit.
    pub space: Space,
    /// What was left out.
    pub warnings: Vec<FormatWarning>,
}

/// What a shape adds to a mesh at weight 1.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedShape {
    /// Its name.
    pub name: String,
    /// Displacements, V.
    pub deltas: Vec<[f64; 3]>,
}

impl ShapedMesh {
    /// Splits the faces into triangles.
    ///
    /// # Panics
    /// If a face names none of the V vertices.
    pub fn triangles(&self) -> Vec<[usize; 3]> {
        let mut polygons = Polygons::default();
        self.faces.iter().for_each(|face| polygons.push(face.iter().copied()));
        polygons.triangles(&self.positions)
    }

    /// Adds a shape of some vertices; those of one name on several meshes are one shape.
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
