//! Directions of the surface: normals and tangents.

use nalgebra::Vector3;

use super::Examples;

impl Examples {
    /// Computes the V unit normals of the rest pose, weighted by triangle area.
    ///
    /// A vertex without any area around it gets a zero normal.
    pub fn rest_normals(&self) -> Vec<[f64; 3]> {
        normals(&self.rest, &self.triangles)
    }

    /// Computes the V shares of the rest pose's area: of each triangle a third for each of its corners.
    pub fn rest_areas(&self) -> Vec<f64> {
        let mut areas = vec![0.0; self.vertex_len()];
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(|vertex| Vector3::from(self.rest[vertex]));
            let share = (b - a).cross(&(c - a)).norm() / 6.0;
            triangle.iter().for_each(|&vertex| areas[vertex] += share);
        }
        areas
    }

    /// Computes the V unit normals of frame `index`, as [`Examples::rest_normals`] does.
    ///
    /// # Panics
    /// If `index` is not a frame.
    pub fn posed_normals(&self, index: usize) -> Vec<[f64; 3]> {
        normals(self.frame(index), &self.triangles)
    }

    /// Computes the V tangents of the rest pose: a unit vector along growing u, orthogonal to the
    /// normal, and +1 or -1, by which normal x tangent must be multiplied to point along growing v.
    ///
    /// A vertex whose texture coordinates give no direction gets any unit vector orthogonal to its
    /// normal. `None` without texture coordinates.
    pub fn rest_tangents(&self) -> Option<Vec<[f64; 4]>> {
        Some(tangents(&self.rest, &self.triangles, self.uv.as_ref()?))
    }
}

/// Computes a mesh's tangents, as [`Examples::rest_tangents`] has them.
pub(crate) fn tangents(
    positions: &[[f64; 3]],
    triangles: &[[usize; 3]],
    uv: &[[f64; 2]],
) -> Vec<[f64; 4]> {
    let mut along = vec![[Vector3::zeros(); 2]; positions.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|vertex| Vector3::from(positions[vertex]));
        let [ta, tb, tc] = triangle.map(|vertex| uv[vertex]);
        let (e1, e2) = (b - a, c - a);
        let (u1, v1, u2, v2) = (tb[0] - ta[0], tb[1] - ta[1], tc[0] - ta[0], tc[1] - ta[1]);
        // Dividing by the texture's area would weight by its inverse: only the sign is needed,
        // and what remains grows with both areas.
        let sign = (u1 * v2 - u2 * v1).signum();
        let u = (e1 * v2 - e2 * v1) * sign;
        let v = (e2 * u1 - e1 * u2) * sign;
        for &vertex in triangle {
            along[vertex][0] += u;
            along[vertex][1] += v;
        }
    }
    let tangents = normals(positions, triangles).into_iter().zip(along).map(|(normal, [u, v])| {
        let normal = Vector3::from(normal);
        let flat = u - normal * normal.dot(&u);
        let tangent = match flat.try_normalize(1e-9 * u.norm()) {
            Some(tangent) => tangent,
            None => any_orthogonal(normal),
        };
        let handedness = if normal.cross(&tangent).dot(&v) < 0.0 { -1.0 } else { 1.0 };
        [tangent.x, tangent.y, tangent.z, handedness]
    });
    tangents.collect()
}

/// Computes a mesh's unit normals, weighted by triangle area; zero where there is no area.
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

fn any_orthogonal(normal: Vector3<f64>) -> Vector3<f64> {
    let axis = Vector3::ith(normal.iamin(), 1.0);
    normal.cross(&axis).try_normalize(0.0).unwrap_or(Vector3::x())
}

#[cfg(test)]
mod tests {
    use super::super::testing::triangle;

    #[test]
    fn normals_follow_the_winding() {
        let mut examples = triangle(1);
        assert_eq!(examples.rest_normals(), [[0.0, 0.0, 1.0]; 3]);
        assert_eq!(examples.posed_normals(0), [[0.0, 0.0, 1.0]; 3]);
        examples.triangles[0] = [0, 2, 1];
        assert_eq!(examples.rest_normals(), [[0.0, 0.0, -1.0]; 3]);
    }

    #[test]
    fn a_vertex_without_area_has_no_normal() {
        let mut examples = triangle(1);
        examples.triangles[0] = [0, 1, 1];
        assert_eq!(examples.rest_normals(), [[0.0; 3]; 3]);
    }

    #[test]
    fn areas_are_shared_out_among_the_corners() {
        let mut examples = triangle(1);
        examples.triangles.push([0, 2, 1]);
        // Half a square, twice.
        assert_eq!(examples.rest_areas(), [1.0 / 3.0; 3]);
        examples.triangles = vec![[0, 1, 1]];
        assert_eq!(examples.rest_areas(), [0.0; 3]);
    }

    #[test]
    fn tangents_point_along_u() {
        let mut examples = triangle(1);
        assert!(examples.rest_tangents().is_none());
        examples.uv = Some(vec![[0.0, 0.0], [0.5, 0.0], [0.0, 0.5]]);
        assert_eq!(examples.rest_tangents(), Some(vec![[1.0, 0.0, 0.0, 1.0]; 3]));
    }

    #[test]
    fn mirrored_texture_flips_the_handedness() {
        let mut examples = triangle(1);
        examples.uv = Some(vec![[0.0, 0.0], [-0.5, 0.0], [0.0, 0.5]]);
        assert_eq!(examples.rest_tangents(), Some(vec![[-1.0, 0.0, 0.0, -1.0]; 3]));
    }

    #[test]
    fn a_texture_without_area_still_gives_a_unit_tangent() {
        let mut examples = triangle(1);
        examples.uv = Some(vec![[0.5, 0.5]; 3]);
        for [x, y, z, w] in examples.rest_tangents().unwrap() {
            assert_eq!((x * x + y * y + z * z, z, w), (1.0, 0.0, 1.0));
        }
    }
}
