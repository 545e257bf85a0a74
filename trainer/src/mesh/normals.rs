//! Normals of a mesh by the area of its triangles.

use nalgebra::Vector3;

/// Unit normals this near are one: files round them.
pub(super) const SAME_NORMAL: f64 = 1e-3;

/// Tells whether two unit normals are one but for rounding.
pub(crate) fn same_normal(a: &[f64; 3], b: &[f64; 3]) -> bool {
    (Vector3::from(*a) - Vector3::from(*b)).norm() <= SAME_NORMAL
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

/// Brings authored normals, each of a vertex, to length 1. One that has no direction, or is not finite, becomes what
/// the triangles around its vertex give; counts those.
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

/// Brings a direction to length 1; `None` where it has none.
fn unit(direction: [f64; 3]) -> Option<[f64; 3]> {
    let direction = Vector3::from(direction).try_normalize(0.0)?;
    direction.iter().all(|x| x.is_finite()).then(|| direction.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_without_direction_become_the_trainer_s_own() {
        let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let mut authored = [[0.0; 3], [f64::NAN, 0.0, 1.0], [0.0, 3.0, 4.0], [f64::INFINITY; 3]];
        let repaired = repair(&mut authored, &[0, 1, 2, 2], &positions, &[[0, 1, 2]]);
        let own = [0.0, 0.0, 1.0];
        assert_eq!((repaired, authored), (3, [own, own, [0.0, 0.6, 0.8], own]));
    }
}
