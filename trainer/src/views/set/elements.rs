//! Makes and checks elements: triangles between the points of a view, and over the covered pixels of a picture. A pixel
//! is covered if its alpha is above 0.

use super::data::{Element, View};
use crate::Error;
use crate::page::camera::Resolution;
use crate::page::picture::Picture;
use spade::{DelaunayTriangulation, Point2, Triangulation};
use std::cmp::Ordering;

/// Area below which an element counts as flat, over the square of its longest side.
const NO_AREA: f64 = 1e-6;

/// Makes the error of points that cannot be triangulated.
pub(super) fn not_triangulated(named: &str, what: &str) -> Error {
    Error::fit(format!("the points of {named} cannot be triangulated: {what}"))
}

/// Triangulates the visible points of a view and fixed places (Delaunay). Fixed places have the indices after all
/// points.
///
/// # Errors
/// [`ErrorKind::Fit`](crate::ErrorKind::Fit): two points coincide, or all points are collinear.
pub fn triangulated(view: &View, fixed: &[[f64; 2]], named: &str) -> Result<Vec<Element>, Error> {
    let len = view.points.len();
    let seen = (0..len).filter(|&k| view.visible[k]).chain(len..len + fixed.len());
    let seen: Vec<usize> = seen.collect();
    let known = [&view.known()[..], fixed].concat();
    let places = seen.iter().map(|&k| Point2::new(known[k][0], known[k][1])).collect();
    let mesh: DelaunayTriangulation<Point2<f64>> = DelaunayTriangulation::bulk_load_stable(places)
        .map_err(|error| not_triangulated(named, &error.to_string()))?;
    if mesh.num_vertices() != seen.len() {
        let mut sorted = seen.clone();
        sorted.sort_by(|&a, &b| known[a].partial_cmp(&known[b]).unwrap_or(Ordering::Equal));
        let pair = sorted.windows(2).find(|pair| known[pair[0]] == known[pair[1]]);
        let which = pair.map_or_else(String::new, |pair| format!(" {} and {}", pair[0], pair[1]));
        let what = format!("points{which} lie in one place; leave one out, or write \"elements\"");
        return Err(not_triangulated(named, &what));
    }
    let corners = mesh.inner_faces().map(|face| face.vertices().map(|v| seen[v.fix().index()]));
    let elements: Vec<Element> = corners.map(Element::Triangle).collect();
    if elements.is_empty() {
        return Err(not_triangulated(named, "they lie on a line"));
    }
    Ok(elements)
}

/// Checks the elements whose points are all visible in a key view.
///
/// - `sources`: index in the file of each element's polygon. A polygon can become several elements.
///
/// # Errors
/// [`ErrorKind::Value`](crate::ErrorKind::Value): an element or one of its triangles has no area; a quad is not convex,
/// or its edges cross.
pub(super) fn check_elements(
    elements: &[Element],
    sources: &[usize],
    view: &View,
    named: &str,
) -> Result<(), Error> {
    let known = view.known();
    for (element, &source) in elements.iter().zip(sources) {
        let corners = element.vertices();
        if !corners.iter().all(|&k| view.visible[k]) {
            continue;
        }
        let at = |corner: usize| known[corners[corner % corners.len()]];
        let turns: Vec<f64> =
            (0..corners.len()).map(|c| cross(at(c), at(c + 1), at(c + 2))).collect();
        let longest = (0..corners.len()).map(|c| squared(at(c), at(c + 1))).fold(0.0, f64::max);
        let flat = |turn: &f64| turn.abs() <= NO_AREA * longest;
        if turns.iter().all(flat) {
            return Err(Error::value(format!(
                "element {source}: points {corners:?} have no area in {named}: move one, mark one as not visible, or leave them out"
            )));
        }
        let &Element::Quad(points) = element else { continue };
        // Sign of the turn of most corners; 0 if edges cross.
        let way: f64 = turns.iter().map(|turn| turn.signum()).sum();
        let is_dent = |&c: &usize| flat(&turns[c]) || turns[c] * way <= 0.0;
        let dents: Vec<usize> = (0..4).filter(is_dent).collect();
        match dents[..] {
            [] => {}
            [turn] => {
                // The turn at index `turn` belongs to the next corner. A diagonal from that corner splits the quad.
                let point = |after: usize| points[(turn + 1 + after) % 4];
                let [first, second] = [[0, 1, 2], [0, 2, 3]].map(|corners| corners.map(point));
                return Err(Error::value(format!(
                    "element {source}: quad {points:?} is not convex in {named}: write {first:?}, {second:?} in its place"
                )));
            }
            _ => {
                return Err(Error::value(format!(
                    "element {source}: edges of quad {points:?} cross in {named}: list its points in turn, or write two triangles in its place"
                )));
            }
        }
    }
    Ok(())
}

/// Returns twice the signed area of a triangle.
pub(in crate::views) fn cross(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn squared(a: [f64; 2], b: [f64; 2]) -> f64 {
    (0..2).map(|axis| (a[axis] - b[axis]).powi(2)).sum()
}

/// Number of parts of a side, at which triangles are tested for coverage.
const PARTS: i32 = 8;

/// Triangles of nearly equal sides that cover a silhouette.
pub(super) struct Silhouette {
    /// Corners, pixels.
    pub(super) corners: Vec<[f64; 2]>,
    /// Triangles, by indices of corners.
    pub(super) faces: Vec<[usize; 3]>,
}

impl Silhouette {
    /// Triangulates the covered pixels of a picture.
    ///
    /// - `across`: number of triangle sides along the longer side of the picture.
    /// - `margin`: pixels around the coverage that triangles must cover, too.
    ///
    /// # Errors
    /// [`ErrorKind::Missing`](crate::ErrorKind::Missing): the picture has no covered pixels.
    pub(super) fn of(picture: &Picture, across: f64, margin: usize) -> Result<Self, Error> {
        let [width, height] = [picture.size.width, picture.size.height];
        let step = width.max(height) as f64 / across;
        let covered = Covered::of(picture);
        let covers = |place: [f64; 2]| {
            let low = place.map(|at| at.floor() - margin as f64);
            covered.any(low, place.map(|at| at.floor() + 1.0 + margin as f64))
        };
        let near = |[x, y]: [f64; 2]| {
            let offsets = (-4..=4).flat_map(|i| (-4..=4).map(move |j| [i, j].map(f64::from)));
            offsets.into_iter().any(|[i, j]| covers([x + 0.25 * step * i, y + 0.25 * step * j]))
        };
        let columns = (width as f64 / step) as usize + 3;
        let rows = (height as f64 / step) as usize + 3;
        let node = |place: usize| {
            let (i, j) = (place % columns, place / columns);
            // Every second row is shifted by half a step, for triangles of nearly equal sides.
            let aside = if j % 2 == 0 { -1.0 } else { -0.5 };
            [step * (i as f64 + aside), step * (j as f64 - 1.0)]
        };
        let nodes: Vec<[f64; 2]> = (0..columns * rows).map(node).filter(|at| near(*at)).collect();
        let places = nodes.iter().map(|[x, y]| Point2::new(*x, *y)).collect();
        let mesh: DelaunayTriangulation<Point2<f64>> =
            DelaunayTriangulation::bulk_load_stable(places)
                .map_err(|error| not_triangulated("the mask", &error.to_string()))?;
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
            return Err(Error::missing("there are no pixels in the mask"));
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

/// Crops a picture to its covered pixels plus `border` pixels, and returns the position of the corner. `None` if the
/// picture has no covered pixels.
pub(in crate::views) fn cropped(whole: &Picture, border: usize) -> Option<(Picture, [usize; 2])> {
    let [width, height] = [whole.size.width, whole.size.height];
    let covers = |x: usize, y: usize| whole.rgba[4 * (y * width + x) + 3] > 0;
    let mut rows = (0..height).filter(|&y| (0..width).any(|x| covers(x, y)));
    let (top, bottom) = (rows.next()?, rows.next_back());
    let bottom = bottom.unwrap_or(top);
    let mut columns = (0..width).filter(|&x| (top..=bottom).any(|y| covers(x, y)));
    let (left, right) = (columns.next()?, columns.next_back());
    let right = right.unwrap_or(left);
    let [left, top] = [left, top].map(|first| first.saturating_sub(border));
    let [right, bottom] = [(right + 1 + border).min(width), (bottom + 1 + border).min(height)];
    let rgba = (top..bottom)
        .flat_map(|y| whole.rgba[4 * (y * width + left)..4 * (y * width + right)].iter().copied());
    let size = Resolution { width: right - left, height: bottom - top };
    Some((Picture { size, rgba: rgba.collect() }, [left, top]))
}

/// Summed-area table of the covered pixels of a picture.
pub(in crate::views) struct Covered {
    size: [usize; 2],
    sums: Vec<u32>,
}

impl Covered {
    /// Counts the covered pixels of a picture.
    pub(in crate::views) fn of(picture: &Picture) -> Self {
        let [width, height] = [picture.size.width, picture.size.height];
        let at = |x: usize, y: usize| y * (width + 1) + x;
        let mut sums = vec![0; (width + 1) * (height + 1)];
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            let own = u32::from(picture.rgba[4 * (y * width + x) + 3] > 0);
            sums[at(x + 1, y + 1)] = own + sums[at(x, y + 1)] + sums[at(x + 1, y)] - sums[at(x, y)];
        }
        Self { size: [width, height], sums }
    }

    /// Whether some pixel of a rectangle is covered.
    ///
    /// - `low`, `high`: corners of the rectangle between pixels, whole numbers. Pixels outside the picture are not
    ///   covered.
    pub(in crate::views) fn any(&self, low: [f64; 2], high: [f64; 2]) -> bool {
        let within = |place: [f64; 2]| {
            [0, 1].map(|axis| place[axis].clamp(0.0, self.size[axis] as f64) as usize)
        };
        let ([left, top], [right, bottom]) = (within(low), within(high));
        let sum = |x: usize, y: usize| self.sums[y * (self.size[0] + 1) + x];
        sum(right, bottom) + sum(left, top) > sum(right, top) + sum(left, bottom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::camera::Resolution;

    fn view(points: &[[f64; 2]]) -> View {
        View {
            values: Default::default(),
            points: points.iter().copied().map(Some).collect(),
            visible: vec![true; points.len()],
            depths: Vec::new(),
            image: None,
            layers: Vec::new(),
        }
    }

    const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]];

    #[test]
    fn triangles_of_points_cover_their_hull_once() {
        let mut points = SQUARE.to_vec();
        points.extend([[1.0, 2.0], [2.5, 1.5], [3.0, 3.2]]);
        let found = triangulated(&view(&points), &[], "view 0").unwrap();
        let area = |element: &Element| match *element {
            Element::Triangle([a, b, c]) => 0.5 * cross(points[a], points[b], points[c]).abs(),
            Element::Quad(_) => 0.0,
        };
        assert!((found.iter().map(area).sum::<f64>() - 16.0).abs() < 1e-12);
        let line = [[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]];
        let refused = triangulated(&view(&line), &[], "view 3").unwrap_err().to_string();
        assert_eq!(refused, "the points of view 3 cannot be triangulated: they lie on a line");
        let twice = [SQUARE[0], SQUARE[1], SQUARE[2], SQUARE[1]];
        let refused = triangulated(&view(&twice), &[], "view 3").unwrap_err().to_string();
        assert!(refused.contains(": points 1 and 3 lie in one place; leave one out"), "{refused}");
    }

    #[test]
    fn flat_and_concave_elements_are_named() {
        let dent = [[0.0, 0.0], [4.0, 0.0], [1.0, 1.0], [0.0, 4.0]];
        let quad = [Element::Quad([0, 1, 2, 3])];
        assert!(check_elements(&quad, &[5], &view(&SQUARE), "view 1").is_ok());
        let said = |quad: &[Element], points: &[[f64; 2]]| {
            check_elements(quad, &[5], &view(points), "view 1").unwrap_err().to_string()
        };
        assert_eq!(
            said(&quad, &dent),
            "element 5: quad [0, 1, 2, 3] is not convex in view 1: write [2, 3, 0], [2, 0, 1] in its place"
        );
        // The triangles cover the quad, for a dent at any corner and for both orientations.
        for turned in 0..4 {
            let mut corners = [0, 1, 2, 3];
            corners.rotate_left(turned);
            for corners in [corners, [corners[3], corners[2], corners[1], corners[0]]] {
                let quad = [Element::Quad(corners)];
                let refused = check_elements(&quad, &[5], &view(&dent), "view 1").unwrap_err();
                let (_, written) = refused.message().split_once(": write ").unwrap();
                let numbers = written.split(|char: char| !char.is_ascii_digit());
                let numbers: Vec<usize> = numbers.filter_map(|own| own.parse().ok()).collect();
                let (triangles, _) = numbers.as_chunks::<3>();
                assert_eq!(triangles.len(), 2, "{refused}");
                let area = |[a, b, c]: [usize; 3]| cross(dent[a], dent[b], dent[c]);
                let areas = [triangles[0], triangles[1]].map(area);
                assert!(
                    areas[0] * areas[1] > 0.0 && (areas[0] + areas[1]).abs() == 8.0,
                    "{triangles:?}"
                );
            }
        }
        let crossed = [Element::Quad([0, 2, 1, 3])];
        assert!(said(&crossed, &SQUARE).starts_with("element 5: edges of quad [0, 2, 1, 3] cross"));
        let flat = [[0.0, 0.0], [2.0, 2.0], [4.0, 4.0], [0.0, 4.0]];
        let elements = [Element::Triangle([1, 2, 3]), Element::Triangle([0, 1, 2])];
        let refused = check_elements(&elements, &[0, 3], &view(&flat), "view 1").unwrap_err();
        assert!(
            refused.to_string().starts_with("element 3: points [0, 1, 2] have no area in view 1")
        );
        let mut hidden = view(&flat);
        hidden.visible[1] = false;
        assert!(check_elements(&elements, &[0, 3], &hidden, "view 1").is_ok(), "not seen");
    }

    /// Whether triangles cover a place.
    fn covered(found: &Silhouette, p: [f64; 2]) -> bool {
        found.faces.iter().any(|face| {
            let ring = face.map(|corner| found.corners[corner]);
            let turn = |k: usize| cross(ring[k], ring[(k + 1) % 3], p);
            (0..3).all(|k| turn(k) > -1e-9) || (0..3).all(|k| turn(k) < 1e-9)
        })
    }

    #[test]
    fn lines_and_spots_are_covered_with_their_margin() {
        let size = Resolution { width: 90, height: 40 };
        // A line one pixel wide, and a separate spot.
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
