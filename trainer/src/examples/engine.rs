//! The checks of the engine's vertices.

use super::validate::{numbers, same};
use super::{Element, Examples, ExamplesError};

impl Examples {
    /// Leaves the engine's vertices out where a skin has as many as the mesh itself: it was made without them.
    pub fn unsplit_for(&mut self, skin_vertex_len: usize) {
        if skin_vertex_len == self.vertex_len() && skin_vertex_len != self.surface().engine_len() {
            self.engine = None;
        }
    }

    /// Checks that the engine's vertices are copies of the mesh's, every one of them has one, the triangles are
    /// the same, and all numbers are finite.
    pub(super) fn check_engine(&self) -> Result<(), ExamplesError> {
        let Some(engine) = &self.engine else { return Ok(()) };
        let (engine_len, vertex_len) = (engine.copy_of.len(), self.vertex_len());
        for (array, len) in [
            ("normals", engine.normals.as_ref().map(Vec::len)),
            ("tangents", engine.tangents.as_ref().map(Vec::len)),
            ("uv", engine.uv.as_ref().map(Vec::len)),
        ] {
            let len = len.unwrap_or(engine_len);
            same("vertices", "the engine's mesh", engine_len, array, len)?;
        }
        let mut has_copy = vec![false; vertex_len];
        for (face, &vertex) in engine.copy_of.iter().enumerate() {
            let outside = ExamplesError::VertexOutOfRange {
                array: "engine vertex",
                face,
                vertex: vertex.try_into().unwrap_or(i64::MAX),
                vertex_len,
            };
            *has_copy.get_mut(vertex).ok_or(outside)? = true;
        }
        if let Some(vertex) = has_copy.iter().position(|has| !has) {
            return Err(ExamplesError::NoCopy { vertex });
        }
        let (mesh, own) = (self.triangles.len(), engine.triangles.len());
        same("triangles", "rest", mesh, "the engine's mesh", own)?;
        for (triangle, (&expected, corners)) in
            self.triangles.iter().zip(&engine.triangles).enumerate()
        {
            if let Some(&corner) = corners.iter().find(|&&corner| corner >= engine_len) {
                return Err(ExamplesError::VertexOutOfRange {
                    array: "triangle of the engine's",
                    face: triangle,
                    vertex: corner.try_into().unwrap_or(i64::MAX),
                    vertex_len: engine_len,
                });
            }
            let found = corners.map(|corner| engine.copy_of[corner]);
            if found != expected {
                return Err(ExamplesError::OtherCopy { triangle, expected, found });
            }
        }
        let vertex = |number: usize| Element::Vertex(number);
        let all = |_| true;
        let normals = engine.normals.iter().flatten().map(<[_; 3]>::as_slice);
        numbers("normals", normals, None, vertex, all)?;
        let tangents = engine.tangents.iter().flatten().map(<[_; 4]>::as_slice);
        numbers("tangents", tangents, None, vertex, all)?;
        let uv = engine.uv.iter().flatten().map(<[_; 2]>::as_slice);
        numbers("uv", uv, None, vertex, all)
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::triangle;
    use crate::mesh::EngineMesh;

    #[test]
    fn what_the_engine_s_vertices_cannot_be_is_refused() {
        let good = EngineMesh {
            copy_of: vec![0, 1, 1, 2],
            triangles: vec![[0, 2, 3]],
            normals: Some(vec![[0.0, 0.0, 1.0]; 4]),
            tangents: Some(vec![[1.0, 0.0, 0.0, 1.0]; 4]),
            uv: Some(vec![[0.0; 2]; 4]),
        };
        let fault = |spoil: &dyn Fn(&mut EngineMesh)| {
            let mut examples = triangle(1);
            let mut engine = good.clone();
            spoil(&mut engine);
            examples.engine = Some(engine);
            examples.validate().err().map(|error| error.to_string()).unwrap_or_default()
        };
        assert_eq!(fault(&|_| ()), "");
        for (spoil, words) in [
            (
                &(|m: &mut EngineMesh| m.uv = Some(Vec::new())) as &dyn Fn(&mut EngineMesh),
                "the engine's mesh has 4 vertices, uv has 0",
            ),
            (&|m| m.copy_of[3] = 3, "engine vertex 3 names vertex 3 of 3"),
            (&|m| m.copy_of[3] = 1, "vertex 2 has no copy among the engine's vertices"),
            (&|m| m.triangles.clear(), "rest has 1 triangles, the engine's mesh has 0"),
            (&|m| m.triangles[0][1] = 4, "triangle of the engine's 0 names vertex 4 of 4"),
            (
                &|m| m.triangles[0][1] = 3,
                "triangle 0 has the vertices [0, 1, 2], by the engine's vertices it has copies of [0, 2, 2]",
            ),
            (&|m| m.uv.as_mut().unwrap()[2][1] = f64::NAN, "array uv is not finite at vertex 2"),
            (
                &|m| m.tangents.as_mut().unwrap()[1][3] = f64::INFINITY,
                "array tangents is not finite at vertex 1",
            ),
        ] {
            assert_eq!(fault(spoil), words);
        }
    }
}
