//! Face corners, and the engine's vertices that they make.

use super::engine::EngineMesh;
use super::mikktspace::Textured;
use super::normals::{SAME_NORMAL, normals as by_area, repair, same_normal};
use super::surface::Surface;

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
    /// order in which triangles name them; a vertex without a corner has one copy. Where there are texture coordinates
    /// and no tangents they get those of MikkTSpace, which part where texture is mirrored.
    ///
    /// Normals without a direction become those of the faces around the vertex; counts their corners.
    ///
    /// - `positions`: of the vertices, V.
    /// - `triangles`: corners of each, by their places.
    ///
    /// # Panics
    /// If a corner is none of the C, or names none of the V vertices.
    pub fn engine_mesh(
        &self,
        positions: &[[f64; 3]],
        triangles: &[[usize; 3]],
    ) -> (EngineMesh, usize) {
        let at = triangles.as_flattened();
        let of_mesh: Vec<[usize; 3]> =
            triangles.iter().map(|corners| corners.map(|corner| self.vertices[corner])).collect();
        let mut normals = self.normals.clone();
        let repaired = normals
            .as_mut()
            .map_or(0, |normals| repair(normals, &self.vertices, positions, &of_mesh));
        let own = self.tangents.as_ref();
        let tangents =
            own.map(|all| at.iter().map(|&corner| all[corner]).collect()).or_else(|| {
                let welded = || {
                    let welded = by_area(positions, &of_mesh);
                    self.vertices.iter().map(|&vertex| welded[vertex]).collect()
                };
                let normals = &normals.clone().unwrap_or_else(welded);
                let (vertices, uv) = (&self.vertices, self.uv.as_deref()?);
                Some(Textured { positions, vertices, normals, uv, triangles }.tangents())
            });
        let authored = Authored { normals, tangents, uv: self.uv.as_deref() };

        // Of each vertex the first corner of every copy; and the copy at each corner, both as places among triangles'.
        let mut copies: Vec<Vec<usize>> = vec![Vec::new(); positions.len()];
        let mut copy_at = Vec::with_capacity(at.len());
        for (place, &corner) in at.iter().enumerate() {
            let own = &mut copies[self.vertices[corner]];
            let same = |&first: &usize| authored.are_alike((first, at[first]), (place, corner));
            let known = own.iter().position(same);
            match known {
                Some(copy) if authored.has_no_tangent(own[copy]) => own[copy] = place,
                Some(_) => (),
                None => own.push(place),
            }
            copy_at.push(known.unwrap_or(own.len() - 1));
        }
        let mut first = Vec::with_capacity(positions.len());
        let mut place_of = Vec::new();
        let mut copy_of = Vec::new();
        for (vertex, own) in copies.iter().enumerate() {
            first.push(copy_of.len());
            let len = own.len().max(1);
            copy_of.resize(copy_of.len() + len, vertex);
            place_of.extend((0..len).map(|copy| own.get(copy).copied()));
        }
        let engine: Vec<usize> = at
            .iter()
            .zip(copy_at)
            .map(|(&corner, copy)| first[self.vertices[corner]] + copy)
            .collect();
        let corner_of: Vec<_> = place_of.iter().map(|place| place.map(|place| at[place])).collect();
        let mesh = EngineMesh {
            triangles: engine.as_chunks::<3>().0.to_vec(),
            copy_of,
            normals: authored.normals.as_deref().map(|all| gathered(all, &corner_of)),
            tangents: authored.tangents.as_deref().map(|all| gathered(all, &place_of)),
            uv: authored.uv.map(|all| gathered(all, &corner_of)),
        };
        (mesh, repaired)
    }
}

impl EngineMesh {
    /// Makes the engine's vertices of a mesh whose corners of triangles have texture coordinates, 3T.
    pub fn of_corners(positions: &[[f64; 3]], triangles: &[[usize; 3]], uv: Vec<[f64; 2]>) -> Self {
        let vertices = triangles.as_flattened().to_vec();
        let places: Vec<usize> = (0..vertices.len()).collect();
        let corners = Corners { vertices, uv: Some(uv), ..Corners::default() };
        corners.engine_mesh(positions, places.as_chunks().0).0
    }

    /// Makes the engine's vertices of a mesh whose vertices have texture coordinates, V.
    pub fn of_vertices(positions: &[[f64; 3]], triangles: &[[usize; 3]], uv: &[[f64; 2]]) -> Self {
        let of_corners = triangles.as_flattened().iter().map(|&vertex| uv[vertex]).collect();
        Self::of_corners(positions, triangles, of_corners)
    }

    /// Completes what was authored of vertices that stay as they are: normals without a direction become those of the
    /// faces, and where there are texture coordinates and no tangents they get those of MikkTSpace, of the first corner
    /// that has any. Counts those normals.
    ///
    /// - `positions`, `triangles`: of the mesh that they are copies of.
    pub fn complete(&mut self, positions: &[[f64; 3]], triangles: &[[usize; 3]]) -> usize {
        let own = self.normals.as_mut();
        let repaired = own.map_or(0, |own| repair(own, &self.copy_of, positions, triangles));
        if let Some(uv) = self.uv.as_deref().filter(|_| self.tangents.is_none()) {
            let normals = &Surface { positions, triangles, engine: Some(self) }.normals();
            let (vertices, triangles) = (&self.copy_of, &self.triangles);
            let found = Textured { positions, vertices, normals, uv, triangles }.tangents();
            let mut own = vec![[0.0; 4]; vertices.len()];
            for (&vertex, tangent) in triangles.as_flattened().iter().zip(found) {
                if own[vertex][..3] == [0.0; 3] {
                    own[vertex] = tangent;
                }
            }
            self.tangents = Some(own);
        }
        repaired
    }
}

/// What corners are told apart by.
struct Authored<'a> {
    /// C.
    normals: Option<Vec<[f64; 3]>>,
    /// 3T, of the corners of triangles.
    tangents: Option<Vec<[f64; 4]>>,
    /// C.
    uv: Option<&'a [[f64; 2]]>,
}

impl Authored<'_> {
    /// Compares two corners, each a place among those of triangles, and among all.
    fn are_alike(&self, a: (usize, usize), b: (usize, usize)) -> bool {
        let tangents = |all: &Vec<[f64; 4]>| {
            let apart = all[a.0].iter().zip(&all[b.0]).map(|(a, b)| (a - b).abs());
            let none = self.has_no_tangent(a.0) || self.has_no_tangent(b.0);
            none || apart.fold(0.0, f64::max) <= SAME_NORMAL
        };
        self.uv.is_none_or(|uv| uv[a.1] == uv[b.1])
            && self.normals.as_ref().is_none_or(|all| same_normal(&all[a.1], &all[b.1]))
            && self.tangents.as_ref().is_none_or(tangents)
    }

    fn has_no_tangent(&self, place: usize) -> bool {
        let is_zero = |all: &Vec<[f64; 4]>| all[place][..3] == [0.0; 3];
        self.tangents.as_ref().is_some_and(is_zero)
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
    const POSITIONS: [[f64; 3]; 5] =
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [5.0, 5.0, 5.0], [0.0, 1.0, 0.0]];

    fn corners() -> Corners {
        Corners { vertices: vec![2, 0, 1, 0, 2, 4], ..Corners::default() }
    }

    fn split(corners: Corners) -> EngineMesh {
        corners.engine_mesh(&POSITIONS, &TRIANGLES).0
    }

    #[test]
    fn alike_corners_are_one_vertex_in_the_mesh_s_order() {
        let plain = split(corners());
        assert!(plain.is_plain());
        assert_eq!(plain.triangles, [[2, 0, 1], [0, 2, 4]]);
        let uv = [[1.0, 0.5], [0.0, 0.0], [1.0, 0.0], [0.0, 0.0], [1.0, 0.75], [0.0, 1.0]];
        let split = split(Corners { uv: Some(uv.to_vec()), ..corners() });
        // At 0 the coordinates agree, but the seam runs from there and parts the tangents.
        assert_eq!(split.copy_of, [0, 0, 1, 2, 2, 3, 4]);
        assert_eq!(split.triangles, [[3, 0, 2], [1, 4, 6]]);
        let expected = [uv[1], uv[3], uv[2], uv[0], uv[4], [0.0; 2], uv[5]];
        assert_eq!(split.uv.unwrap(), expected);
    }

    #[test]
    fn normals_part_a_vertex_unless_rounding_does() {
        let leaning = |x: f64| vec![[x, 0.0, 1.0], [0.0, 0.0, 2.0], [0.0, 0.0, 1.0]];
        let with = |x: f64| {
            let normals = [vec![[0.0, 0.0, 1.0]; 3], leaning(x)].concat();
            split(Corners { normals: Some(normals), ..corners() })
        };
        assert!(with(1e-4).is_one_each());
        let hard = with(0.1);
        assert_eq!(hard.copy_of, [0, 0, 1, 2, 3, 4]);
        let normals = hard.normals.unwrap();
        assert!((normals[1][0] - 0.1 / 1.01_f64.sqrt()).abs() < 1e-15);
        assert_eq!(normals[4], [0.0; 3], "no corner says");
    }

    #[test]
    fn a_normal_without_direction_is_that_of_the_faces() {
        let mut normals = vec![[0.0, 0.0, 1.0]; 6];
        normals[4] = [0.0; 3];
        let (mesh, repaired) =
            Corners { normals: Some(normals), ..corners() }.engine_mesh(&POSITIONS, &TRIANGLES);
        assert!(mesh.is_one_each() && repaired == 1);
    }

    #[test]
    fn mirrored_texture_parts_a_vertex_by_its_tangents() {
        // As a sheet whose halves share one picture: u grows away from the edge between 0 and 2 on both sides.
        let uv = [[0.0, 1.0], [0.0, 0.0], [1.0, 0.0], [0.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
        let mesh = split(Corners { uv: Some(uv.to_vec()), ..corners() });
        assert_eq!(mesh.copy_of, [0, 0, 1, 2, 2, 3, 4]);
        assert_eq!(mesh.triangles, [[3, 0, 2], [1, 4, 6]]);
        let tangents = mesh.tangents.unwrap();
        assert_eq!(tangents[0][3], -tangents[1][3]);
        // The one triangle's picture is turned over, the other's is as it stands.
        let along = |copy: usize| nalgebra::Vector3::from_column_slice(&tangents[copy][..3]);
        assert!(along(0).dot(&nalgebra::Vector3::new(1.0, 0.0, 0.0)) > 0.5);
        assert!(along(1).dot(&nalgebra::Vector3::new(-1.0, 0.0, 0.0)) > 0.5);
    }

    #[test]
    fn authored_tangents_part_a_vertex_but_none_joins_any() {
        let mut tangents = vec![[1.0, 0.0, 0.0, 1.0]; 6];
        tangents[4][3] = -1.0;
        let mesh = split(Corners { tangents: Some(tangents.clone()), ..corners() });
        assert_eq!(mesh.copy_of, [0, 1, 2, 2, 3, 4]);
        assert_eq!(mesh.tangents.unwrap()[3], [1.0, 0.0, 0.0, -1.0]);
        tangents[0] = [0.0; 4];
        let mesh = split(Corners { tangents: Some(tangents), ..corners() });
        assert!(mesh.is_one_each());
        assert_eq!(mesh.tangents.unwrap()[2], [1.0, 0.0, 0.0, -1.0]);
    }
}
