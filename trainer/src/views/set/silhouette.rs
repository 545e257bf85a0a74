//! Triangles over the covered pixels of a picture.

use super::error::SetError;
use crate::page::picture::Picture;
use spade::{DelaunayTriangulation, Point2, Triangulation};

/// Parts of a side at which triangles are tested for coverage.
const PARTS: i32 = 8;

/// Triangles of nearly equal sides that cover a silhouette.
pub(super) struct Silhouette {
    /// Corners, pixels.
    pub(super) corners: Vec<[f64; 2]>,
    /// Triangles, by corners.
    pub(super) faces: Vec<[usize; 3]>,
}

impl Silhouette {
    /// Triangulates the covered pixels of a picture.
    ///
    /// - `across`: triangles' sides along the longer side of the picture.
    /// - `margin`: pixels around the coverage that triangles cover too.
    ///
    /// # Errors
    /// [`SetError::Empty`]: the picture covers nothing.
    pub(super) fn of(picture: &Picture, across: f64, margin: usize) -> Result<Self, SetError> {
        let [width, height] = [picture.size.width, picture.size.height];
        let step = width.max(height) as f64 / across;
        let sums = sums(picture);
        let covers = |[x, y]: [f64; 2]| {
            let near = |at: f64, len: usize| {
                let [low, high] = [at.floor() - margin as f64, at.floor() + 1.0 + margin as f64];
                [low, high].map(|end| end.clamp(0.0, len as f64) as usize)
            };
            let ([left, right], [top, bottom]) = (near(x, width), near(y, height));
            let sum = |x: usize, y: usize| sums[y * (width + 1) + x];
            sum(right, bottom) + sum(left, top) > sum(right, top) + sum(left, bottom)
        };
        let near = |[x, y]: [f64; 2]| {
            let offsets = (-4..=4).flat_map(|i| (-4..=4).map(move |j| [i, j].map(f64::from)));
            offsets.into_iter().any(|[i, j]| covers([x + 0.25 * step * i, y + 0.25 * step * j]))
        };
        let columns = (width as f64 / step) as usize + 3;
        let rows = (height as f64 / step) as usize + 3;
        let node = |place: usize| {
            let (i, j) = (place % columns, place / columns);
            // Every other row half a step aside: triangles of nearly equal sides.
            let aside = if j % 2 == 0 { -1.0 } else { -0.5 };
            [step * (i as f64 + aside), step * (j as f64 - 1.0)]
        };
        let nodes: Vec<[f64; 2]> = (0..columns * rows).map(node).filter(|at| near(*at)).collect();
        let places = nodes.iter().map(|[x, y]| Point2::new(*x, *y)).collect();
        let mesh: DelaunayTriangulation<Point2<f64>> =
            DelaunayTriangulation::bulk_load_stable(places).map_err(|error| {
                SetError::Triangulation { view: "the mask".to_owned(), what: error.to_string() }
            })?;
        let faces = mesh.inner_faces().map(|face| face.vertices().map(|v| v.fix().index()));
        let drawn = |face: &[usize; 3]| {
            let shares =
                (0..=PARTS).flat_map(|i| (0..=PARTS - i).map(move |j| [i, j, PARTS - i - j]));
            shares.into_iter().any(|shares| {
                covers([0, 1].map(|axis| {
                    let part = |k: usize| f64::from(shares[k]) / f64::from(PARTS);
                    (0..3).map(|k| part(k) * nodes[face[k]][axis]).sum()
                }))
            })
        };
        let faces: Vec<[usize; 3]> = faces.filter(drawn).collect();
        if faces.is_empty() {
            return Err(SetError::Empty("pixels in the mask"));
        }
        let mut used: Vec<usize> = faces.as_flattened().to_vec();
        used.sort_unstable();
        used.dedup();
        let corners = used.iter().map(|&node| nodes[node]).collect();
        let place = |node: &usize| used.binary_search(node).unwrap_or_default();
        let faces = faces.iter().map(|face| face.each_ref().map(place)).collect();
        Ok(Self { corners, faces })
    }
}

/// Counts the covered pixels of all rectangles from a picture's corner.
fn sums(picture: &Picture) -> Vec<u32> {
    let [width, height] = [picture.size.width, picture.size.height];
    let at = |x: usize, y: usize| y * (width + 1) + x;
    let mut sums = vec![0; (width + 1) * (height + 1)];
    for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
        let own = u32::from(picture.rgba[4 * (y * width + x) + 3] > 0);
        sums[at(x + 1, y + 1)] = own + sums[at(x, y + 1)] + sums[at(x + 1, y)] - sums[at(x, y)];
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::camera::Resolution;

    /// Whether triangles cover a place.
    fn covered(found: &Silhouette, p: [f64; 2]) -> bool {
        found.faces.iter().any(|face| {
            let ring = face.map(|corner| found.corners[corner]);
            let turn = |k: usize| {
                let (a, b) = (ring[k], ring[(k + 1) % 3]);
                (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
            };
            (0..3).all(|k| turn(k) > -1e-9) || (0..3).all(|k| turn(k) < 1e-9)
        })
    }

    #[test]
    fn lines_and_spots_are_covered_with_their_margin() {
        let size = Resolution { width: 90, height: 40 };
        // A line of one pixel, and a spot apart from it.
        let is_set = |x: usize, y: usize| (y == x / 3 && x < 80) || (x > 84 && y > 36);
        let rgba = (0..90 * 40).flat_map(|at| [0, 0, 0, u8::from(is_set(at % 90, at / 90))]);
        let picture = Picture { size, rgba: rgba.collect() };
        let found = Silhouette::of(&picture, 8.0, 3).unwrap();
        for (y, x) in (0..40).flat_map(|y| (0..90).map(move |x| (y, x))) {
            if is_set(x, y) {
                for off in [[-2.0, -2.0], [3.0, -2.0], [-2.0, 3.0], [3.0, 3.0]] {
                    assert!(covered(&found, [x as f64 + off[0], y as f64 + off[1]]), "{x} {y}");
                }
            }
        }
        assert!(!covered(&found, [10.0, 38.0]));
        let empty = Picture { size, rgba: vec![0; 4 * 90 * 40] };
        assert!(Silhouette::of(&empty, 8.0, 3).is_err());
    }
}
