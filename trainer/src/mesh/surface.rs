//! A mesh at rest as an engine draws it: its vertices and their directions.

use nalgebra::Vector3;
use std::ops::Range;

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

/// A mesh of V vertices and its E engine vertices; without an [`EngineMesh`] both are the same vertices.
#[derive(Clone, Copy, Debug)]
pub struct Surface<'a> {
    /// Positions, V.
    pub positions: &'a [[f64; 3]],
    /// Vertex numbers of each triangle, T.
    pub triangles: &'a [[usize; 3]],
    /// Engine vertices, if they differ from the mesh's vertices.
    pub engine: Option<&'a EngineMesh>,
}

impl<'a> Surface<'a> {
    /// Counts the engine's vertices, E.
    pub fn engine_len(&self) -> usize {
        self.engine.map_or(self.positions.len(), |engine| engine.copy_of.len())
    }

    /// Returns the mesh vertex that an engine vertex copies.
    pub fn copy_of(&self, engine_vertex: usize) -> usize {
        self.engine.map_or(engine_vertex, |engine| engine.copy_of[engine_vertex])
    }

    /// Copies values of the mesh's vertices (V) to the engine vertices (E).
    pub fn copied<T: Clone>(&self, all: &[T]) -> Vec<T> {
        (0..self.engine_len()).map(|copy| all[self.copy_of(copy)].clone()).collect()
    }

    /// Lists the first copy of each vertex, V.
    pub fn first_copies(&self) -> Vec<usize> {
        let mut firsts = vec![0; self.positions.len()];
        for copy in (0..self.engine_len()).rev() {
            firsts[self.copy_of(copy)] = copy;
        }
        firsts
    }

    /// Picks each vertex's value (V) from its first copy (E).
    pub fn of_first_copies<T: Clone>(&self, all: &[T]) -> Vec<T> {
        self.first_copies().into_iter().map(|copy| all[copy].clone()).collect()
    }

    /// Returns the triangles as engine vertices, T.
    pub fn engine_triangles(&self) -> &'a [[usize; 3]] {
        self.engine.map_or(self.triangles, |engine| &engine.triangles)
    }

    /// Returns the engine vertices that copy a range of mesh vertices: both orders go mesh by mesh.
    pub fn engine_range(&self, range: &Range<usize>) -> Range<usize> {
        let below =
            |end: usize| (0..self.engine_len()).filter(|&copy| self.copy_of(copy) < end).count();
        below(range.start)..below(range.end)
    }

    /// Returns the authored normals, E.
    pub fn authored_normals(&self) -> Option<&'a [[f64; 3]]> {
        self.engine?.normals.as_deref()
    }

    /// Returns the texture coordinates, E.
    pub fn uv(&self) -> Option<&'a [[f64; 2]]> {
        self.engine?.uv.as_deref()
    }

    /// Returns the E unit normals: authored ones, or the vertices' normals, weighted by triangle area.
    ///
    /// Without authored normals, copies of a vertex share a normal, so a texture seam does not shade. A vertex without
    /// any area around it gets zero.
    pub fn normals(&self) -> Vec<[f64; 3]> {
        let welded = || self.copied(&normals(self.positions, self.triangles));
        self.authored_normals().map_or_else(welded, <[_]>::to_vec)
    }

    /// Returns the area of each engine vertex: a third of every triangle around it.
    pub fn areas(&self) -> Vec<f64> {
        let mut areas = vec![0.0; self.engine_len()];
        for (corners, triangle) in self.engine_triangles().iter().zip(self.triangles) {
            let [a, b, c] = triangle.map(|vertex| Vector3::from(self.positions[vertex]));
            let share = (b - a).cross(&(c - a)).norm() / 6.0;
            corners.iter().for_each(|&vertex| areas[vertex] += share);
        }
        areas
    }

    /// Returns the E tangents and their handedness; `None` if the mesh has none.
    ///
    /// A tangent is a unit vector along growing u, orthogonal to the normal. The handedness is +1 or -1: normal x
    /// tangent times the handedness points along growing v. A vertex whose texture coordinates give no direction gets
    /// any unit vector orthogonal to its normal.
    pub fn tangents(&self) -> Option<Vec<[f64; 4]>> {
        let given = self.engine?.tangents.as_ref()?;
        let square = |(&[x, y, z, hand], normal): (&[f64; 4], &[f64; 3])| {
            let tangent = orthogonal(&Vector3::new(x, y, z), normal);
            [tangent.x, tangent.y, tangent.z, if hand < 0.0 { -1.0 } else { 1.0 }]
        };
        Some(given.iter().zip(&self.normals()).map(square).collect())
    }
}

/// Removes the component of a direction along a normal; returns any orthogonal direction if nothing remains.
fn orthogonal(direction: &Vector3<f64>, normal: &[f64; 3]) -> Vector3<f64> {
    let normal = Vector3::from(*normal);
    let flat = direction - normal * normal.dot(direction);
    flat.try_normalize(1e-9 * direction.norm()).unwrap_or_else(|| {
        let axis = Vector3::ith(normal.iamin(), 1.0);
        normal.cross(&axis).try_normalize(0.0).unwrap_or(Vector3::x())
    })
}

/// Distance below which two unit normals count as equal: files round them.
pub(super) const SAME_NORMAL: f64 = 1e-3;

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
pub(super) fn repair(
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

    const POSITIONS: [[f64; 3]; 3] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

    fn surface<'a>(triangles: &'a [[usize; 3]], engine: Option<&'a EngineMesh>) -> Surface<'a> {
        Surface { positions: &POSITIONS, triangles, engine }
    }

    #[test]
    fn normals_follow_the_winding() {
        assert_eq!(surface(&[[0, 1, 2]], None).normals(), [[0.0, 0.0, 1.0]; 3]);
        assert_eq!(surface(&[[0, 2, 1]], None).normals(), [[0.0, 0.0, -1.0]; 3]);
    }

    #[test]
    fn a_vertex_without_area_has_no_normal() {
        assert_eq!(surface(&[[0, 1, 1]], None).normals(), [[0.0; 3]; 3]);
    }

    #[test]
    fn areas_are_shared_out_among_the_corners() {
        // Both triangles are half a square.
        assert_eq!(surface(&[[0, 1, 2], [0, 2, 1]], None).areas(), [1.0 / 3.0; 3]);
        assert_eq!(surface(&[[0, 1, 1]], None).areas(), [0.0; 3]);
    }

    #[test]
    fn tangents_are_made_square_to_the_normals() {
        let normal = [0.6, 0.0, 0.8];
        let engine = EngineMesh {
            copy_of: vec![0, 1, 2],
            triangles: vec![[0, 1, 2]],
            normals: Some(vec![normal; 3]),
            tangents: Some(vec![[2.0, 0.0, 0.0, -1.0], [2.0, 0.0, 0.0, 1.0], [0.0; 4]]),
            uv: None,
        };
        let triangles = [[0, 1, 2]];
        let surface = surface(&triangles, Some(&engine));
        assert_eq!(surface.normals(), [normal; 3]);
        let tangents = surface.tangents().unwrap();
        for ([x, y, z, hand], expected) in tangents[..2].iter().zip([-1.0, 1.0]) {
            let near = |a: f64, b: f64| (a - b).abs() < 1e-15;
            assert!(near(*x, 0.8) && *y == 0.0 && near(*z, -0.6) && *hand == expected);
        }
        // Without a direction, any orthogonal one.
        let [x, y, z, hand] = tangents[2];
        let (length, along) = (x * x + y * y + z * z, x * normal[0] + z * normal[2]);
        assert!((length - 1.0).abs() < 1e-15 && along.abs() < 1e-15 && hand == 1.0);
    }

    #[test]
    fn copies_share_the_values_of_their_vertex() {
        let engine = EngineMesh {
            copy_of: vec![0, 1, 1, 2],
            triangles: vec![[0, 1, 3], [0, 3, 2]],
            normals: None,
            tangents: None,
            uv: None,
        };
        let surface = surface(&[[0, 1, 2], [0, 2, 1]], Some(&engine));
        assert_eq!(surface.engine_len(), 4);
        assert_eq!(surface.copied(&["a", "b", "c"]), ["a", "b", "b", "c"]);
        assert_eq!(surface.first_copies(), [0, 1, 3]);
        assert_eq!(surface.of_first_copies(&[5, 6, 7, 8]), [5, 6, 8]);
        assert_eq!(surface.areas(), [1.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0, 1.0 / 3.0]);
        assert_eq!([0..1, 1..3, 2..3].map(|r| surface.engine_range(&r)), [0..1, 1..4, 3..4]);
    }

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
