//! Tangents as normal maps are made for: MikkTSpace (M. Mikkelsen, *Simulation of wrinkled surfaces revisited*, 2008).

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};

/// Triangles with texture coordinates.
pub(super) struct Textured<'a> {
    /// Positions of the vertices.
    pub(super) positions: &'a [[f64; 3]],
    /// The vertex at each corner, C.
    pub(super) vertices: &'a [usize],
    /// Normals of the corners, of length 1, C.
    pub(super) normals: &'a [[f64; 3]],
    /// Texture coordinates of the corners, C.
    pub(super) uv: &'a [[f64; 2]],
    /// Corners of each triangle, T.
    pub(super) triangles: &'a [[usize; 3]],
}

impl Textured<'_> {
    /// Computes the tangent and handedness at each corner of the triangles, 3T; 0 where texture says nothing.
    pub(super) fn tangents(&self) -> Vec<[f64; 4]> {
        let mut faces = Faces { mesh: self, found: vec![[0.0; 4]; 3 * self.triangles.len()] };
        // Who checks the mesh says what is wrong with it.
        if !self.is_finite() {
            return faces.found;
        }
        // There is no error that it could return.
        let _ = generate_tangents(&mut faces);
        faces.found
    }

    fn is_finite(&self) -> bool {
        let all = self.positions.as_flattened().iter().chain(self.uv.as_flattened());
        all.chain(self.normals.as_flattened()).all(|&x| (x as f32).is_finite())
    }
}

struct Faces<'a> {
    mesh: &'a Textured<'a>,
    found: Vec<[f64; 4]>,
}

impl Geometry for Faces<'_> {
    fn num_faces(&self) -> usize {
        self.mesh.triangles.len()
    }

    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }

    fn position(&self, face: usize, vert: usize) -> [f32; 3] {
        let corner = self.mesh.triangles[face][vert];
        self.mesh.positions[self.mesh.vertices[corner]].map(|x| x as f32)
    }

    fn normal(&self, face: usize, vert: usize) -> [f32; 3] {
        self.mesh.normals[self.mesh.triangles[face][vert]].map(|x| x as f32)
    }

    fn tex_coord(&self, face: usize, vert: usize) -> [f32; 2] {
        self.mesh.uv[self.mesh.triangles[face][vert]].map(|x| x as f32)
    }

    fn set_tangent(&mut self, tangent: Option<TangentSpace>, face: usize, vert: usize) {
        if let Some(tangent) = tangent {
            self.found[3 * face + vert] = tangent.tangent_encoded().map(f64::from);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const POSITIONS: [[f64; 3]; 3] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

    fn of(uv: [[f64; 2]; 3]) -> Vec<[f64; 4]> {
        let normals = &[[0.0, 0.0, 1.0]; 3];
        let (vertices, triangles) = (&[0, 1, 2], &[[0, 1, 2]]);
        Textured { positions: &POSITIONS, vertices, normals, uv: &uv, triangles }.tangents()
    }

    #[test]
    fn tangents_point_along_u_and_mirrored_texture_flips_the_handedness() {
        assert_eq!(of([[0.0, 0.0], [0.5, 0.0], [0.0, 0.5]]), [[1.0, 0.0, 0.0, 1.0]; 3]);
        assert_eq!(of([[0.0, 0.0], [-0.5, 0.0], [0.0, 0.5]]), [[-1.0, 0.0, 0.0, -1.0]; 3]);
        // A quarter turn: v grows along -x.
        assert_eq!(of([[0.0, 0.0], [0.0, -0.5], [0.5, 0.0]]), [[0.0, 1.0, 0.0, 1.0]; 3]);
    }

    #[test]
    fn a_texture_without_area_gives_no_nan() {
        assert!(of([[0.5, 0.5]; 3]).iter().flatten().all(|x| x.is_finite()));
        assert_eq!(of([[0.0, f64::NAN], [1.0, 0.0], [0.0, 1e300]]), [[0.0; 4]; 3]);
    }
}
