//! Elements over a view: made of its points, and checked in it.

use super::data::View;
use super::elements::Element;
use super::error::SetError;
use spade::{DelaunayTriangulation, Point2, Triangulation};
use std::cmp::Ordering;

/// Area, over the square of the longest side, below which an element has none.
const NO_AREA: f64 = 1e-6;

/// Makes Delaunay triangles of a view's visible points, and of places that are fixed, which are numbered after all points.
///
/// # Errors
/// [`SetError::Triangulation`]: two points are one, or all lie on a line.
pub fn triangulated(
    view: &View,
    fixed: &[[f64; 2]],
    named: &str,
) -> Result<Vec<Element>, SetError> {
    let wrong = |what: String| SetError::Triangulation { view: named.to_owned(), what };
    let len = view.points.len();
    let seen = (0..len).filter(|&k| view.visible[k]).chain(len..len + fixed.len());
    let seen: Vec<usize> = seen.collect();
    let known = [&view.known()[..], fixed].concat();
    let places = seen.iter().map(|&k| Point2::new(known[k][0], known[k][1])).collect();
    let mesh: DelaunayTriangulation<Point2<f64>> = DelaunayTriangulation::bulk_load_stable(places)
        .map_err(|error| wrong(error.to_string()))?;
    if mesh.num_vertices() != seen.len() {
        let mut sorted = seen.clone();
        sorted.sort_by(|&a, &b| known[a].partial_cmp(&known[b]).unwrap_or(Ordering::Equal));
        let pair = sorted.windows(2).find(|pair| known[pair[0]] == known[pair[1]]);
        let which = pair.map_or_else(String::new, |pair| format!(" {} and {}", pair[0], pair[1]));
        return Err(wrong(format!(
            "points{which} lie in one place; leave one out, or write \"elements\""
        )));
    }
    let corners = mesh.inner_faces().map(|face| face.vertices().map(|v| seen[v.fix().index()]));
    let elements: Vec<Element> = corners.map(Element::Triangle).collect();
    if elements.is_empty() { Err(wrong("they lie on a line".to_owned())) } else { Ok(elements) }
}

/// Checks elements in a key view: those whose points are all seen.
///
/// - `sources`: for each element its place in the file, where a polygon may become several.
///
/// # Errors
/// [`SetError::NoArea`], [`SetError::Concave`] and [`SetError::Crossed`].
pub(super) fn check_elements(
    elements: &[Element],
    sources: &[usize],
    view: &View,
    named: &str,
) -> Result<(), SetError> {
    let known = view.known();
    for (element, &source) in elements.iter().zip(sources) {
        let corners = element.points();
        if !corners.iter().all(|&k| view.visible[k]) {
            continue;
        }
        let at = |corner: usize| known[corners[corner % corners.len()]];
        let turns: Vec<f64> =
            (0..corners.len()).map(|c| cross(at(c), at(c + 1), at(c + 2))).collect();
        let longest = (0..corners.len()).map(|c| squared(at(c), at(c + 1))).fold(0.0, f64::max);
        let flat = |turn: &f64| turn.abs() <= NO_AREA * longest;
        let view = || named.to_owned();
        if turns.iter().all(flat) {
            let points = corners.to_vec();
            return Err(SetError::NoArea { element: source, points, view: view() });
        }
        let &Element::Quad(points) = element else { continue };
        // The way round in which most corners turn; 0 if edges cross.
        let way: f64 = turns.iter().map(|turn| turn.signum()).sum();
        let is_dent = |&c: &usize| flat(&turns[c]) || turns[c] * way <= 0.0;
        let dents: Vec<usize> = (0..4).filter(is_dent).collect();
        match dents[..] {
            [] => {}
            [turn] => {
                // A turn is that of the corner after it, from which a diagonal cuts the quad.
                let point = |after: usize| points[(turn + 1 + after) % 4];
                let triangles = [[0, 1, 2], [0, 2, 3]].map(|corners| corners.map(point));
                return Err(SetError::Concave { element: source, points, view: view(), triangles });
            }
            _ => return Err(SetError::Crossed { element: source, points, view: view() }),
        }
    }
    Ok(())
}

/// Returns twice the signed area of a triangle.
fn cross(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn squared(a: [f64; 2], b: [f64; 2]) -> f64 {
    (0..2).map(|axis| (a[axis] - b[axis]).powi(2)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

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
        // The triangles cover the quad, whichever corner is the dent, and however it turns.
        for turned in 0..4 {
            let mut corners = [0, 1, 2, 3];
            corners.rotate_left(turned);
            for corners in [corners, [corners[3], corners[2], corners[1], corners[0]]] {
                let quad = [Element::Quad(corners)];
                let refused = check_elements(&quad, &[5], &view(&dent), "view 1").unwrap_err();
                let SetError::Concave { triangles, .. } = refused else { panic!("{refused}") };
                let area = |[a, b, c]: [usize; 3]| cross(dent[a], dent[b], dent[c]);
                let areas = triangles.map(area);
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
}
