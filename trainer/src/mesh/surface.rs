//! A mesh at rest as an engine draws it: its vertices and their directions.

use super::EngineMesh;
use super::normals;
use nalgebra::Vector3;
use std::ops::Range;

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
}
