//! A mesh at rest as an engine draws it: its vertices and their directions.

use super::engine::EngineMesh;
use super::normals::normals;
use nalgebra::Vector3;
use std::ops::Range;

/// A mesh of V vertices and the E that an engine has of it; where it has no others, they are the same.
#[derive(Clone, Copy, Debug)]
pub struct Surface<'a> {
    /// Positions, V.
    pub positions: &'a [[f64; 3]],
    /// Vertex numbers of each triangle, T.
    pub triangles: &'a [[usize; 3]],
    /// The engine's vertices, where they are others.
    pub engine: Option<&'a EngineMesh>,
}

impl<'a> Surface<'a> {
    /// Counts the engine's vertices, E.
    pub fn engine_len(&self) -> usize {
        self.engine.map_or(self.positions.len(), |engine| engine.copy_of.len())
    }

    /// Gives the vertex that one of the engine's is a copy of.
    pub fn copy_of(&self, engine_vertex: usize) -> usize {
        self.engine.map_or(engine_vertex, |engine| engine.copy_of[engine_vertex])
    }

    /// Gives each of the engine's vertices what its own vertex has: E of V.
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

    /// Gives each vertex what its first copy has: V of E.
    pub fn of_first_copies<T: Clone>(&self, all: &[T]) -> Vec<T> {
        self.first_copies().into_iter().map(|copy| all[copy].clone()).collect()
    }

    /// Gives the triangles by the engine's vertices, T.
    pub fn engine_triangles(&self) -> &'a [[usize; 3]] {
        self.engine.map_or(self.triangles, |engine| &engine.triangles)
    }

    /// Gives the engine's vertices that are copies of a range of vertices: both orders go mesh by mesh.
    pub fn engine_range(&self, range: &Range<usize>) -> Range<usize> {
        let below =
            |end: usize| (0..self.engine_len()).filter(|&copy| self.copy_of(copy) < end).count();
        below(range.start)..below(range.end)
    }

    /// Gives the authored normals, E.
    pub fn authored_normals(&self) -> Option<&'a [[f64; 3]]> {
        self.engine?.normals.as_deref()
    }

    /// Gives the texture coordinates, E.
    pub fn uv(&self) -> Option<&'a [[f64; 2]]> {
        self.engine?.uv.as_deref()
    }

    /// Gives the E unit normals: authored ones, or those of the vertices, weighted by triangle area, so that
    /// nothing shades where texture coordinates alone differ. A vertex without any area around it gets zero.
    pub fn normals(&self) -> Vec<[f64; 3]> {
        let welded = || self.copied(&normals(self.positions, self.triangles));
        self.authored_normals().map_or_else(welded, <[_]>::to_vec)
    }

    /// Gives each of the engine's vertices its share of the area: of each triangle a third for each corner.
    pub fn areas(&self) -> Vec<f64> {
        let mut areas = vec![0.0; self.engine_len()];
        for (corners, triangle) in self.engine_triangles().iter().zip(self.triangles) {
            let [a, b, c] = triangle.map(|vertex| Vector3::from(self.positions[vertex]));
            let share = (b - a).cross(&(c - a)).norm() / 6.0;
            corners.iter().for_each(|&vertex| areas[vertex] += share);
        }
        areas
    }

    /// Gives the E tangents: a unit vector along growing u, orthogonal to the normal, and +1 or -1, by which normal x
    /// tangent must be multiplied to point along growing v. `None` where there are none.
    ///
    /// A vertex whose texture coordinates give no direction gets any unit vector orthogonal to its normal.
    pub fn tangents(&self) -> Option<Vec<[f64; 4]>> {
        let given = self.engine?.tangents.as_ref()?;
        let square = |(&[x, y, z, hand], normal): (&[f64; 4], &[f64; 3])| {
            let tangent = orthogonal(&Vector3::new(x, y, z), normal);
            [tangent.x, tangent.y, tangent.z, if hand < 0.0 { -1.0 } else { 1.0 }]
        };
        Some(given.iter().zip(&self.normals()).map(square).collect())
    }
}

/// Takes off a direction what lies along a normal; any direction square to it where that leaves none.
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
        // Half a square, twice.
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
        // Without a direction, any.
        let [x, y, z, hand] = tangents[2];
        let (length, along) = (x * x + y * y + z * z, x * normal[0] + z * normal[2]);
        assert!((length - 1.0).abs() < 1e-15 && along.abs() < 1e-15 && hand == 1.0);
    }

    #[test]
    fn copies_share_what_their_vertex_has() {
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
