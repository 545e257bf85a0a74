//! Face corners, and the engine vertices that they make.
//!
//! Tangents follow MikkTSpace, for which normal maps are made (M. Mikkelsen, *Simulation of wrinkled surfaces
//! revisited*, 2008).

use super::surface::{EngineMesh, SAME_NORMAL, Surface, normals as by_area, repair, same_normal};
use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};

/// The C corners of a mesh's faces, with their authored attributes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Corners {
    /// Vertex at each corner, C.
    pub vertices: Vec<usize>,
    /// Normals, C; 0 for a corner without a normal.
    pub normals: Option<Vec<[f64; 3]>>,
    /// Tangents and their handedness (last), C; 0 for a corner without a tangent.
    pub tangents: Option<Vec<[f64; 4]>>,
    /// Texture coordinates, C; v grows upward.
    pub uv: Option<Vec<[f64; 2]>>,
}

impl Corners {
    /// Joins the corners of a vertex into engine vertices, and counts the corners whose normal was repaired.
    ///
    /// Two corners of a vertex share an engine vertex if their texture coordinates are equal to the last bit and their
    /// directions are equal up to rounding. Engine vertices follow the order of the mesh's vertices; the copies of one
    /// vertex follow the order in which triangles name them. A vertex without a corner has one copy.
    ///
    /// A corner whose normal has no direction gets the normal of the faces around the vertex. With texture coordinates
    /// but no tangents, MikkTSpace computes tangents, which split vertices where the texture is mirrored.
    ///
    /// - `positions`: of the vertices, V.
    /// - `triangles`: corner indices, T.
    ///
    /// # Panics
    /// If a corner index is not below C, or a vertex index is not below V.
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
                Some(tangents(Textured { positions, vertices, normals, uv, triangles }))
            });
        let authored = Authored { normals, tangents, uv: self.uv.as_deref() };

        // For each vertex, the first corner of every copy; for each corner, its copy. Corners are places in `at`.
        let mut copies: Vec<Vec<usize>> = vec![Vec::new(); positions.len()];
        let mut copy_at = Vec::with_capacity(at.len());
        for (place, &corner) in at.iter().enumerate() {
            let own = &mut copies[self.vertices[corner]];
            let same = |&first: &usize| authored.agree((first, at[first]), (place, corner));
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
            normals: authored.normals.as_deref().map(|all| gather(all, &corner_of)),
            tangents: authored.tangents.as_deref().map(|all| gather(all, &place_of)),
            uv: authored.uv.map(|all| gather(all, &corner_of)),
        };
        (mesh, repaired)
    }
}

impl EngineMesh {
    /// Makes the engine vertices of a mesh from texture coordinates at the corners of triangles, 3T.
    pub fn of_corners(positions: &[[f64; 3]], triangles: &[[usize; 3]], uv: Vec<[f64; 2]>) -> Self {
        let vertices = triangles.as_flattened().to_vec();
        let places: Vec<usize> = (0..vertices.len()).collect();
        let corners = Corners { vertices, uv: Some(uv), ..Corners::default() };
        corners.engine_mesh(positions, places.as_chunks().0).0
    }

    /// Makes the engine vertices of a mesh from texture coordinates at its vertices, V.
    pub fn of_vertices(positions: &[[f64; 3]], triangles: &[[usize; 3]], uv: &[[f64; 2]]) -> Self {
        let of_corners = triangles.as_flattened().iter().map(|&vertex| uv[vertex]).collect();
        Self::of_corners(positions, triangles, of_corners)
    }

    /// Completes the attributes of engine vertices that are not to be split, and returns the number of repaired
    /// normals.
    ///
    /// A normal without a direction becomes the normal of the faces around its vertex. With texture coordinates but no
    /// tangents, each vertex gets the first MikkTSpace tangent among its corners.
    ///
    /// - `positions`, `triangles`: of the mesh that the vertices copy.
    pub fn complete(&mut self, positions: &[[f64; 3]], triangles: &[[usize; 3]]) -> usize {
        let own = self.normals.as_mut();
        let repaired = own.map_or(0, |own| repair(own, &self.copy_of, positions, triangles));
        if let Some(uv) = self.uv.as_deref().filter(|_| self.tangents.is_none()) {
            let normals = &Surface { positions, triangles, engine: Some(self) }.normals();
            let (vertices, triangles) = (&self.copy_of, &self.triangles);
            let found = tangents(Textured { positions, vertices, normals, uv, triangles });
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

/// Attributes that must agree for two corners to share an engine vertex.
struct Authored<'a> {
    /// Normal of each corner, C.
    normals: Option<Vec<[f64; 3]>>,
    /// Tangent of each corner of a triangle, 3T.
    tangents: Option<Vec<[f64; 4]>>,
    /// Texture coordinates of each corner, C.
    uv: Option<&'a [[f64; 2]]>,
}

impl Authored<'_> {
    /// Compares two corners, each given as (place among the triangles' corners, corner index).
    fn agree(&self, a: (usize, usize), b: (usize, usize)) -> bool {
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

fn gather<T: Copy + Default>(all: &[T], corners: &[Option<usize>]) -> Vec<T> {
    corners.iter().map(|corner| corner.map(|corner| all[corner]).unwrap_or_default()).collect()
}

/// Triangles with texture coordinates.
struct Textured<'a> {
    /// Positions of the vertices.
    positions: &'a [[f64; 3]],
    /// The vertex at each corner, C.
    vertices: &'a [usize],
    /// Normals of the corners, of length 1, C.
    normals: &'a [[f64; 3]],
    /// Texture coordinates of the corners, C.
    uv: &'a [[f64; 2]],
    /// Corners of each triangle, T.
    triangles: &'a [[usize; 3]],
}

/// Computes the tangent and handedness at each corner of the triangles, 3T; 0 where the texture has no direction.
fn tangents(mesh: Textured<'_>) -> Vec<[f64; 4]> {
    let mut faces = Faces { found: vec![[0.0; 4]; 3 * mesh.triangles.len()], mesh };
    let Textured { positions, normals, uv, .. } = &faces.mesh;
    let all = positions.as_flattened().iter().chain(uv.as_flattened());
    // The checks of the examples report numbers that are not finite.
    if all.chain(normals.as_flattened()).all(|&x| (x as f32).is_finite()) {
        // `Faces` returns no error, so neither can the generator.
        let _ = generate_tangents(&mut faces);
    }
    faces.found
}

struct Faces<'a> {
    mesh: Textured<'a>,
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

    /// Two triangles that share the edge from 0 to 2, and a vertex without a face.
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
    fn equal_corners_are_one_vertex_in_the_mesh_s_order() {
        let plain = split(corners());
        assert!(plain.is_plain());
        assert_eq!(plain.triangles, [[2, 0, 1], [0, 2, 4]]);
        let uv = [[1.0, 0.5], [0.0, 0.0], [1.0, 0.0], [0.0, 0.0], [1.0, 0.75], [0.0, 1.0]];
        let split = split(Corners { uv: Some(uv.to_vec()), ..corners() });
        // At vertex 0 the coordinates agree. The tangents differ there, because the seam starts at vertex 0.
        assert_eq!(split.copy_of, [0, 0, 1, 2, 2, 3, 4]);
        assert_eq!(split.triangles, [[3, 0, 2], [1, 4, 6]]);
        let expected = [uv[1], uv[3], uv[2], uv[0], uv[4], [0.0; 2], uv[5]];
        assert_eq!(split.uv.unwrap(), expected);
    }

    #[test]
    fn normals_split_a_vertex_unless_they_differ_by_rounding() {
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
    fn mirrored_texture_splits_a_vertex_by_its_tangents() {
        // A sheet whose halves share one picture: on both sides u grows away from the edge between 0 and 2.
        let uv = [[0.0, 1.0], [0.0, 0.0], [1.0, 0.0], [0.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
        let mesh = split(Corners { uv: Some(uv.to_vec()), ..corners() });
        assert_eq!(mesh.copy_of, [0, 0, 1, 2, 2, 3, 4]);
        assert_eq!(mesh.triangles, [[3, 0, 2], [1, 4, 6]]);
        let tangents = mesh.tangents.unwrap();
        assert_eq!(tangents[0][3], -tangents[1][3]);
        // The picture is mirrored on one triangle and upright on the other.
        let along = |copy: usize| nalgebra::Vector3::from_column_slice(&tangents[copy][..3]);
        assert!(along(0).dot(&nalgebra::Vector3::new(1.0, 0.0, 0.0)) > 0.5);
        assert!(along(1).dot(&nalgebra::Vector3::new(-1.0, 0.0, 0.0)) > 0.5);
    }

    #[test]
    fn authored_tangents_split_a_vertex_unless_zero() {
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

    const TRIANGLE: [[f64; 3]; 3] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

    fn tangents_of(uv: [[f64; 2]; 3]) -> Vec<[f64; 4]> {
        let normals = &[[0.0, 0.0, 1.0]; 3];
        let (vertices, triangles) = (&[0, 1, 2], &[[0, 1, 2]]);
        tangents(Textured { positions: &TRIANGLE, vertices, normals, uv: &uv, triangles })
    }

    #[test]
    fn tangents_point_along_u_and_mirrored_texture_flips_the_handedness() {
        assert_eq!(tangents_of([[0.0, 0.0], [0.5, 0.0], [0.0, 0.5]]), [[1.0, 0.0, 0.0, 1.0]; 3]);
        assert_eq!(tangents_of([[0.0, 0.0], [-0.5, 0.0], [0.0, 0.5]]), [[-1.0, 0.0, 0.0, -1.0]; 3]);
        // A quarter turn: v grows along -x.
        assert_eq!(tangents_of([[0.0, 0.0], [0.0, -0.5], [0.5, 0.0]]), [[0.0, 1.0, 0.0, 1.0]; 3]);
    }

    #[test]
    fn a_texture_without_area_gives_no_nan() {
        assert!(tangents_of([[0.5, 0.5]; 3]).iter().flatten().all(|x| x.is_finite()));
        assert_eq!(tangents_of([[0.0, f64::NAN], [1.0, 0.0], [0.0, 1e300]]), [[0.0; 4]; 3]);
    }
}
