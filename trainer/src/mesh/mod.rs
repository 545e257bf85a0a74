//! A mesh at rest: the vertices that a fit moves, the vertices that an engine draws, and their directions.
//!
//! A fit's vertex is a point of the surface. An artist authors texture coordinates, normals and tangents by face
//! corner. They may differ among the corners of one point; an engine then has several vertices there.

mod corners;
mod surface;

pub use corners::Corners;
pub use surface::Surface;

use nalgebra::Vector3;

/// Engine vertices of a mesh: E copies of its V vertices, with the attributes that the artist authored.
#[derive(Clone, Debug, PartialEq)]
pub struct EngineMesh {
    /// Mesh vertex that each engine vertex copies, E; every mesh vertex has a copy.
    pub copy_of: Vec<usize>,
    /// Engine vertices of each triangle, T, in the order of the mesh's triangles.
    pub triangles: Vec<[usize; 3]>,
    /// Authored unit normals, E; 0 if a vertex has no authored normal and its triangles have no area.
    pub normals: Option<Vec<[f64; 3]>>,
    /// Tangents and their handedness (last), E: authored, or computed by MikkTSpace.
    pub tangents: Option<Vec<[f64; 4]>>,
    /// Texture coordinates, E; v grows upward, as in most formats but glTF.
    pub uv: Option<Vec<[f64; 2]>>,
}

impl EngineMesh {
    /// Returns whether the mesh has no authored attributes and every vertex has one copy, in order.
    pub fn is_plain(&self) -> bool {
        let authored = self.normals.is_some() || self.tangents.is_some() || self.uv.is_some();
        !authored && self.is_one_each()
    }

    /// Returns whether every vertex has exactly one copy, in the mesh's order.
    pub fn is_one_each(&self) -> bool {
        self.copy_of.iter().enumerate().all(|(engine, &vertex)| engine == vertex)
    }

    /// Rotates normals and tangents; a mirroring also reverses the triangles' winding and the tangents' handedness.
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

/// Distance below which two unit normals count as equal: files round them.
const SAME_NORMAL: f64 = 1e-3;

/// Returns whether two unit normals are equal up to rounding.
pub(crate) fn same_normal(a: &[f64; 3], b: &[f64; 3]) -> bool {
    (Vector3::from(*a) - Vector3::from(*b)).norm() <= SAME_NORMAL
}

/// Computes a mesh's unit normals, weighted by triangle area; zero at a vertex without area.
pub(crate) fn normals(positions: &[[f64; 3]], triangles: &[[usize; 3]]) -> Vec<[f64; 3]> {
    let mut normals = vec![Vector3::zeros(); positions.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|vertex| Vector3::from(positions[vertex]));
        let twice_area = (b - a).cross(&(c - a));
        for &vertex in triangle {
            normals[vertex] += twice_area;
        }
    }
    normals.iter().map(|normal| normal.try_normalize(0.0).unwrap_or_default().into()).collect()
}

/// Normalises authored normals and returns the number of repaired ones. A normal without a direction, or not finite,
/// becomes the area-weighted normal of its vertex.
fn repair(
    authored: &mut [[f64; 3]],
    vertices: &[usize],
    positions: &[[f64; 3]],
    triangles: &[[usize; 3]],
) -> usize {
    let mut repaired = 0;
    let mut welded = None;
    for (normal, &vertex) in authored.iter_mut().zip(vertices) {
        *normal = unit(*normal).unwrap_or_else(|| {
            repaired += 1;
            welded.get_or_insert_with(|| normals(positions, triangles))[vertex]
        });
    }
    repaired
}

/// Normalises a direction; `None` if it is zero or not finite.
fn unit(direction: [f64; 3]) -> Option<[f64; 3]> {
    let direction = Vector3::from(direction).try_normalize(0.0)?;
    direction.iter().all(|x| x.is_finite()).then(|| direction.into())
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

    #[test]
    fn normals_without_direction_become_the_trainer_s_own() {
        let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let mut authored = [[0.0; 3], [f64::NAN, 0.0, 1.0], [0.0, 3.0, 4.0], [f64::INFINITY; 3]];
        let repaired = repair(&mut authored, &[0, 1, 2, 2], &positions, &[[0, 1, 2]]);
        let own = [0.0, 0.0, 1.0];
        assert_eq!((repaired, authored), (3, [own, own, [0.0, 0.6, 0.8], own]));
    }
}
