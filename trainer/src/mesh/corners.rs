//! Face corners, and the engine's vertices that they make.

use super::engine::{EngineMesh, unit};
use super::normals::{SAME_NORMAL, same_normal};

/// The C corners of a mesh's faces, and what is authored of each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Corners {
    /// The vertex at each, C.
    pub vertices: Vec<usize>,
    /// Normals, C; 0 where there is none.
    pub normals: Option<Vec<[f64; 3]>>,
    /// Tangents and, last, their handedness, C; 0 where there is none.
    pub tangents: Option<Vec<[f64; 4]>>,
    /// Texture coordinates, C, v upward.
    pub uv: Option<Vec<[f64; 2]>>,
}

impl Corners {
    /// Makes an engine's vertex of the corners that have one vertex and are authored alike: texture coordinates to
    /// the last bit, directions but for rounding. They are in the order of the mesh's vertices, those of one in the
    /// order in which triangles name them; a vertex without a corner has one copy.
    ///
    /// - `triangles`: corners of each, by their places.
    ///
    /// # Panics
    /// If a corner is none of the C, or names none of the `vertex_len` vertices.
    pub fn engine_mesh(mut self, vertex_len: usize, triangles: &[[usize; 3]]) -> EngineMesh {
        for normal in self.normals.iter_mut().flatten() {
            *normal = unit(*normal).unwrap_or_default();
        }
        // Of each vertex the first corner of every copy.
        let mut copies: Vec<Vec<usize>> = vec![Vec::new(); vertex_len];
        let mut copy_at = vec![0; self.vertices.len()];
        for &corner in triangles.as_flattened() {
            let own = &mut copies[self.vertices[corner]];
            let known = own.iter().position(|&first| self.are_alike(first, corner));
            copy_at[corner] = known.unwrap_or(own.len());
            if known.is_none() {
                own.push(corner);
            }
        }
        let mut first = Vec::with_capacity(vertex_len);
        let mut corner_of = Vec::new();
        let mut copy_of = Vec::new();
        for (vertex, own) in copies.iter().enumerate() {
            first.push(copy_of.len());
            let len = own.len().max(1);
            copy_of.resize(copy_of.len() + len, vertex);
            corner_of.extend((0..len).map(|copy| own.get(copy).copied()));
        }
        let engine = |corner: usize| first[self.vertices[corner]] + copy_at[corner];
        EngineMesh {
            triangles: triangles.iter().map(|corners| corners.map(engine)).collect(),
            copy_of,
            normals: self.normals.as_deref().map(|all| gathered(all, &corner_of)),
            tangents: self.tangents.as_deref().map(|all| gathered(all, &corner_of)),
            uv: self.uv.as_deref().map(|all| gathered(all, &corner_of)),
        }
    }

    fn are_alike(&self, a: usize, b: usize) -> bool {
        let tangents = |all: &Vec<[f64; 4]>| {
            let apart = all[a].iter().zip(&all[b]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            apart <= SAME_NORMAL
        };
        self.uv.as_ref().is_none_or(|uv| uv[a] == uv[b])
            && self.normals.as_ref().is_none_or(|normals| same_normal(&normals[a], &normals[b]))
            && self.tangents.as_ref().is_none_or(tangents)
    }
}

fn gathered<T: Copy + Default>(all: &[T], corners: &[Option<usize>]) -> Vec<T> {
    corners.iter().map(|corner| corner.map(|corner| all[corner]).unwrap_or_default()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two triangles that share the edge from 0 to 2, and a vertex that no face has.
    const TRIANGLES: [[usize; 3]; 2] = [[0, 1, 2], [3, 4, 5]];

    fn corners() -> Corners {
        Corners { vertices: vec![2, 0, 1, 0, 2, 4], ..Corners::default() }
    }

    #[test]
    fn alike_corners_are_one_vertex_in_the_mesh_s_order() {
        let plain = corners().engine_mesh(5, &TRIANGLES);
        assert!(plain.is_plain());
        assert_eq!(plain.triangles, [[2, 0, 1], [0, 2, 4]]);
        let uv = [[0.5, 0.0], [0.0, 0.0], [1.0, 0.0], [0.0, 0.0], [0.25, 0.0], [1.0, 1.0]];
        let split = Corners { uv: Some(uv.to_vec()), ..corners() }.engine_mesh(5, &TRIANGLES);
        assert_eq!(split.copy_of, [0, 1, 2, 2, 3, 4]);
        assert_eq!(split.triangles, [[2, 0, 1], [0, 3, 5]]);
        let expected = [uv[1], uv[2], uv[0], uv[4], [0.0; 2], uv[5]];
        assert_eq!(split.uv.unwrap(), expected);
    }

    #[test]
    fn normals_part_a_vertex_unless_rounding_does() {
        let leaning = |x: f64| vec![[x, 0.0, 1.0], [0.0, 0.0, 2.0], [0.0, 0.0, 1.0]];
        let with = |x: f64| {
            let normals = [vec![[0.0, 0.0, 1.0]; 3], leaning(x)].concat();
            Corners { normals: Some(normals), ..corners() }.engine_mesh(5, &TRIANGLES)
        };
        assert!(with(1e-4).is_one_each());
        let hard = with(0.1);
        assert_eq!(hard.copy_of, [0, 0, 1, 2, 3, 4]);
        let normals = hard.normals.unwrap();
        assert!((normals[1][0] - 0.1 / 1.01_f64.sqrt()).abs() < 1e-15);
        assert_eq!(normals[4], [0.0; 3], "no corner says");
    }

    #[test]
    fn a_mirrored_tangent_parts_a_vertex() {
        let mut tangents = vec![[1.0, 0.0, 0.0, 1.0]; 6];
        tangents[4][3] = -1.0;
        let split = Corners { tangents: Some(tangents), ..corners() }.engine_mesh(5, &TRIANGLES);
        assert_eq!(split.copy_of, [0, 1, 2, 2, 3, 4]);
        assert_eq!(split.tangents.unwrap()[3], [1.0, 0.0, 0.0, -1.0]);
    }
}
