//! The engine's vertices of a mesh.

use super::normals::normals;
use nalgebra::Vector3;

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
    /// Authored tangents and, last, their handedness, E.
    pub tangents: Option<Vec<[f64; 4]>>,
    /// Texture coordinates, E; v grows upward, as in most formats but glTF.
    pub uv: Option<Vec<[f64; 2]>>,
}

impl EngineMesh {
    /// Makes one copy of each vertex, with texture coordinates.
    pub fn per_vertex(triangles: &[[usize; 3]], uv: Vec<[f64; 2]>) -> Self {
        Self {
            copy_of: (0..uv.len()).collect(),
            triangles: triangles.to_vec(),
            normals: None,
            tangents: None,
            uv: Some(uv),
        }
    }

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

    /// Brings authored normals to length 1. One that has no direction, or is not finite, becomes what the
    /// triangles around its vertex give; counts those.
    pub fn repair_normals(&mut self, positions: &[[f64; 3]], triangles: &[[usize; 3]]) -> usize {
        let Some(own) = &mut self.normals else { return 0 };
        let mut repaired = 0;
        let mut welded = None;
        for (normal, &vertex) in own.iter_mut().zip(&self.copy_of) {
            *normal = match unit(*normal) {
                Some(normal) => normal,
                None => {
                    repaired += 1;
                    welded.get_or_insert_with(|| normals(positions, triangles))[vertex]
                }
            };
        }
        repaired
    }
}

/// Brings a direction to length 1; `None` where it has none.
pub(super) fn unit(direction: [f64; 3]) -> Option<[f64; 3]> {
    let direction = Vector3::from(direction).try_normalize(0.0)?;
    direction.iter().all(|x| x.is_finite()).then(|| direction.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_without_direction_become_the_trainer_s_own() {
        let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let triangles = [[0, 1, 2]];
        let mut mesh = EngineMesh::per_vertex(&triangles, vec![[0.0; 2]; 3]);
        assert_eq!(mesh.repair_normals(&positions, &triangles), 0);
        mesh.normals = Some(vec![[0.0; 3], [f64::NAN, 0.0, 1.0], [0.0, 3.0, 4.0]]);
        assert_eq!(mesh.repair_normals(&positions, &triangles), 2);
        assert_eq!(mesh.normals.unwrap(), [[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0, 0.6, 0.8]]);
    }

    #[test]
    fn a_mirror_turns_triangles_and_handedness_over() {
        let mut mesh = EngineMesh::per_vertex(&[[0, 1, 2]], vec![[0.0; 2]; 3]);
        mesh.normals = Some(vec![[1.0, 0.0, 0.0]; 3]);
        mesh.tangents = Some(vec![[0.0, 1.0, 0.0, 1.0]; 3]);
        mesh.turn(|[x, y, z]| [-x, y, z], true);
        assert_eq!(mesh.triangles, [[0, 2, 1]]);
        assert_eq!(mesh.normals.unwrap(), [[-1.0, 0.0, 0.0]; 3]);
        assert_eq!(mesh.tangents.unwrap(), [[0.0, 1.0, 0.0, -1.0]; 3]);
    }
}
