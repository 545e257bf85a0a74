//! The engine's vertices of a mesh.

/// The vertices that an engine draws a mesh of V vertices with: E, each a copy of one of the V, and what the
/// artist authored of them.
#[derive(Clone, Debug, PartialEq)]
pub struct EngineMesh {
    /// The vertex that each is a copy of, E; every one of the V has a copy.
    pub copy_of: Vec<usize>,
    /// Engine vertices of each triangle, T: copies of the mesh's own, in its order.
    pub triangles: Vec<[usize; 3]>,
    /// Authored normals of length 1, E; 0 where the triangles around a vertex have no area either.
    pub normals: Option<Vec<[f64; 3]>>,
    /// Tangents and, last, their handedness, E: authored, or those of MikkTSpace.
    pub tangents: Option<Vec<[f64; 4]>>,
    /// Texture coordinates, E; v grows upward, as in most formats but glTF.
    pub uv: Option<Vec<[f64; 2]>>,
}

impl EngineMesh {
    /// Tells whether nothing is authored, so that the mesh says as much without.
    pub fn is_plain(&self) -> bool {
        let authored = self.normals.is_some() || self.tangents.is_some() || self.uv.is_some();
        !authored && self.is_one_each()
    }

    /// Tells whether the vertices are the mesh's own, in its order.
    pub fn is_one_each(&self) -> bool {
        self.copy_of.iter().enumerate().all(|(engine, &vertex)| engine == vertex)
    }

    /// Turns normals and tangents, and the triangles over where that mirrors.
    pub fn turn(&mut self, turn: impl Fn([f64; 3]) -> [f64; 3], mirrored: bool) {
        self.normals.iter_mut().flatten().for_each(|normal| *normal = turn(*normal));
        for tangent in self.tangents.iter_mut().flatten() {
            let [x, y, z, hand] = *tangent;
            let [x, y, z] = turn([x, y, z]);
            *tangent = [x, y, z, if mirrored { -hand } else { hand }];
        }
        if mirrored {
            self.triangles.iter_mut().for_each(|[_, b, c]| std::mem::swap(b, c));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mirror_turns_triangles_and_handedness_over() {
        let mut mesh = EngineMesh {
            copy_of: vec![0, 1, 2],
            triangles: vec![[0, 1, 2]],
            normals: Some(vec![[1.0, 0.0, 0.0]; 3]),
            tangents: Some(vec![[0.0, 1.0, 0.0, 1.0]; 3]),
            uv: None,
        };
        mesh.turn(|[x, y, z]| [-x, y, z], true);
        assert_eq!(mesh.triangles, [[0, 2, 1]]);
        assert_eq!(mesh.normals.unwrap(), [[-1.0, 0.0, 0.0]; 3]);
        assert_eq!(mesh.tangents.unwrap(), [[0.0, 1.0, 0.0, -1.0]; 3]);
    }
}
