//! A mesh with named shapes, as a face's file holds it.

use super::polygons::Polygons;
use super::warning::FormatWarning;
use sinew_runtime::format::Space;

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
