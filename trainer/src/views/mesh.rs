//! Vertices that follow points, and the elements between the vertices (METHOD §6.9).

use super::object::{KeyView, centred};
use super::set::{Covered, Element};
use crate::page::picture::Picture;
use nalgebra::{Complex, DMatrix, DVector};
use sinew_runtime::views::{Layer, Vertex as FileVertex, Views};
use std::collections::HashMap;

/// Smallest and largest number of cells along the longer side of a warped layer.
const CELLS: [f64; 2] = [2.0, 16.0];
/// Smallest side of a cell, pixels.
const CELL: f64 = 8.0;
/// Width over length below which points count as collinear.
const LINE: f64 = 1e-3;

/// A vertex: a place plus a sum of points, each times a complex weight that scales and turns the point.
#[derive(Clone, Debug, PartialEq)]
pub struct Vertex {
    /// Place without points, pixels.
    pub place: [f64; 2],
    /// Indices of points, and their weights.
    pub weights: Vec<(usize, Complex<f64>)>,
}

/// Vertices, and the elements of the layers between the vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// The V vertices.
    pub vertices: Vec<Vertex>,
    /// Elements of each layer. Their corners are indices of vertices.
    pub layers: Vec<Vec<Element>>,
}

impl Vertex {
    /// Makes a vertex that coincides with a point.
    pub fn of_point(point: usize) -> Self {
        Self { place: [0.0; 2], weights: vec![(point, Complex::ONE)] }
    }

    /// Returns the position of the vertex, pixels.
    pub fn at(&self, points: &[[f64; 2]]) -> [f64; 2] {
        let add = |sum: Complex<f64>, (point, weight): &(usize, Complex<f64>)| {
            sum + weight * complex(points[*point])
        };
        let found = self.weights.iter().fold(complex(self.place), add);
        [found.re, found.im]
    }
}

impl Mesh {
    /// Adds a layer of elements between points and fixed places. Fixed places have the indices from `point_len` on.
    pub fn add_elements(&mut self, elements: &[Element], point_len: usize, fixed: &[[f64; 2]]) {
        self.add_layer(elements, |point| match point.checked_sub(point_len) {
            None => Vertex::of_point(point),
            Some(number) => Vertex { place: fixed[number], weights: Vec::new() },
        });
    }

    /// Adds a layer of elements, and a vertex for each index in the elements.
    ///
    /// - `vertex`: makes the vertex of an index.
    pub(super) fn add_layer(&mut self, elements: &[Element], vertex: impl Fn(usize) -> Vertex) {
        let mut places: HashMap<usize, usize> = HashMap::new();
        let vertices = &mut self.vertices;
        let mut numbered = |at: usize| {
            *places.entry(at).or_insert_with(|| {
                vertices.push(vertex(at));
                vertices.len() - 1
            })
        };
        let own = elements.iter().map(|element| match *element {
            Element::Triangle(corners) => Element::Triangle(corners.map(&mut numbered)),
            Element::Quad(corners) => Element::Quad(corners.map(&mut numbered)),
        });
        let own = own.collect();
        self.layers.push(own);
    }

    /// Adds a layer that is warped as a whole. A grid covers the pictures of the layer in all key views. A thin plate
    /// spline between the points of the layer carries the vertices of the grid.
    ///
    /// - `layer`: index of the layer.
    /// - `points`: indices of the points of the layer; at least one.
    /// - `keys`: key views; at least one has a picture.
    pub fn add_warped(&mut self, layer: usize, points: &[usize], keys: &[KeyView]) {
        let pictured = keys.iter().filter_map(|key| Some((key, key.pictures[layer].as_ref()?)));
        // The view at rest: the first of the pictured views with the most visible points.
        let seen = |key: &KeyView| points.iter().filter(|&&point| key.visible[point]).count();
        let most = pictured.clone().map(|(key, _)| seen(key)).max();
        let Some((rest, _)) = pictured.clone().find(|(key, _)| Some(seen(key)) == most) else {
            self.layers.push(Vec::new());
            return;
        };
        let of = |key: &KeyView| -> Vec<[f64; 2]> {
            points.iter().map(|&point| key.points[point]).collect()
        };
        let own = of(rest);
        // Bounds of all pictures, moved back to rest.
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for (key, picture) in pictured.clone() {
            let back = Warp::new(&of(key));
            for place in outline(picture) {
                let found = back.moved(place, &own);
                for axis in 0..2 {
                    low[axis] = low[axis].min(found[axis]);
                    high[axis] = high[axis].max(found[axis]);
                }
            }
        }
        let longest = (0..2).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
        let cell = longest / (longest / CELL).clamp(CELLS[0], CELLS[1]).round();
        // One more cell on each side, because the inverse of a spline is not a spline.
        let counts = [0, 1].map(|axis| ((high[axis] - low[axis]) / cell).ceil() as usize + 2);
        let start =
            [0, 1].map(|axis| 0.5 * (low[axis] + high[axis]) - 0.5 * cell * counts[axis] as f64);
        let across = counts[0] + 1;
        let place = |at: usize| {
            [start[0] + cell * (at % across) as f64, start[1] + cell * (at / across) as f64]
        };
        let warp = Warp::new(&own);
        let all: Vec<Vertex> =
            (0..across * (counts[1] + 1)).map(|at| warp.vertex(place(at), points)).collect();
        // Places of the vertices in each picture's view, the covered pixels, and the corner of the picture.
        let views: Vec<(Vec<[f64; 2]>, Covered, [usize; 2])> = pictured
            .map(|(key, (picture, corner))| {
                let placed = all.iter().map(|vertex| vertex.at(&key.points)).collect();
                (placed, Covered::of(picture), *corner)
            })
            .collect();
        let mut elements = Vec::new();
        for (row, column) in (0..counts[1]).flat_map(|row| (0..counts[0]).map(move |c| (row, c))) {
            let first = row * across + column;
            let [a, b, c, d] = [first, first + 1, first + across + 1, first + across];
            let is_seen = views.iter().any(|(placed, covered, corner)| {
                let ring = [a, b, c, d].map(|at| placed[at]);
                // Bounds of the cell, plus one pixel.
                let own = |axis: usize| ring.map(|place| place[axis] - corner[axis] as f64);
                let least = |axis| own(axis).into_iter().fold(f64::INFINITY, f64::min);
                let most = |axis| own(axis).into_iter().fold(f64::NEG_INFINITY, f64::max);
                let low = [0, 1].map(|axis| least(axis).floor() - 1.0);
                covered.any(low, [0, 1].map(|axis| most(axis).ceil() + 1.0))
            });
            if is_seen {
                elements.extend([Element::Triangle([a, b, c]), Element::Triangle([a, c, d])]);
            }
        }
        self.add_layer(&elements, |at| all[at].clone());
    }

    /// Reads the mesh of a file.
    pub fn from_file(views: &Views<'_>) -> Self {
        let vertex = |vertex: FileVertex<'_>| Vertex {
            place: vertex.place().map(f64::from),
            weights: vertex
                .weights()
                .map(|(point, [a, b])| (point, Complex::new(a.into(), b.into())))
                .collect(),
        };
        let layer =
            |layer: Layer| (layer.first..layer.end).filter_map(|at| views.element(at)).collect();
        Self {
            vertices: (0..).map_while(|at| views.vertex(at)).map(vertex).collect(),
            layers: (0..).map_while(|at| views.layer(at)).map(layer).collect(),
        }
    }

    /// Returns the number of elements in all layers.
    pub fn element_len(&self) -> usize {
        self.layers.iter().map(Vec::len).sum()
    }

    /// Lists the neighbours of each element of all layers, by edge.
    pub fn neighbours(&self) -> Vec<[Option<usize>; 4]> {
        let mut sides: HashMap<[usize; 2], Vec<usize>> = HashMap::new();
        let elements: Vec<&Element> = self.layers.iter().flatten().collect();
        for (number, element) in elements.iter().enumerate() {
            edges(element).for_each(|edge| sides.entry(edge).or_default().push(number));
        }
        let own = |(number, element): (usize, &&Element)| {
            let mut out = [None; 4];
            for (out, edge) in out.iter_mut().zip(edges(element)) {
                *out = sides[&edge].iter().copied().find(|other| *other != number);
            }
            out
        };
        elements.iter().enumerate().map(own).collect()
    }
}

/// Lists the edges of an element, each by its ends in ascending order.
fn edges(element: &Element) -> impl Iterator<Item = [usize; 2]> {
    let vertices = element.vertices();
    let ends = vertices.iter().cycle().skip(1);
    vertices.iter().zip(ends).map(|(&a, &b)| [a.min(b), a.max(b)])
}

/// Warp that carries places along with points. Collinear points give a similarity, coinciding points give a shift, and
/// any other points give a thin plate spline.
struct Warp {
    rest: Vec<[f64; 2]>,
    centre: [f64; 2],
    /// Scale of distances, and the transposed inverse of the spline's system.
    spline: Option<(f64, DMatrix<f64>)>,
}

impl Warp {
    fn new(rest: &[[f64; 2]]) -> Self {
        let rest = rest.to_vec();
        let (n, centre) = (rest.len(), centred(&rest).1);
        let off = DMatrix::from_fn(n, 2, |i, axis| rest[i][axis] - centre[axis]);
        let sides = off.singular_values();
        if n < 3 || sides[1] <= LINE * sides[0] {
            return Self { rest, centre, spline: None };
        }
        let scale = sides[0] / (n as f64).sqrt();
        let system = DMatrix::from_fn(n + 3, n + 3, |i, j| match (i < n, j < n) {
            (true, true) => thin_plate(rest[i], rest[j], scale),
            (true, false) => [1.0, off[(i, 0)] / scale, off[(i, 1)] / scale][j - n],
            (false, true) => [1.0, off[(j, 0)] / scale, off[(j, 1)] / scale][i - n],
            (false, false) => 0.0,
        });
        let inverse = system.try_inverse();
        Self { rest, centre, spline: inverse.map(|inverse| (scale, inverse.transpose())) }
    }

    /// Makes the vertex at a place. `points` are the indices of the points in the object.
    fn vertex(&self, place: [f64; 2], points: &[usize]) -> Vertex {
        let (own, weights) = self.weights(place);
        let weights = points.iter().copied().zip(weights).filter(|(_, w)| *w != Complex::ZERO);
        Vertex { place: own, weights: weights.collect() }
    }

    /// Returns the new position of a place after the points moved.
    fn moved(&self, place: [f64; 2], points: &[[f64; 2]]) -> [f64; 2] {
        let numbers: Vec<usize> = (0..points.len()).collect();
        self.vertex(place, &numbers).at(points)
    }

    fn weights(&self, place: [f64; 2]) -> ([f64; 2], Vec<Complex<f64>>) {
        let (n, centre) = (self.rest.len(), self.centre);
        if let Some((scale, inverse)) = &self.spline {
            let [x, y] = [0, 1].map(|axis| (place[axis] - centre[axis]) / *scale);
            let own = DVector::from_fn(n + 3, |i, _| match i.checked_sub(n) {
                None => thin_plate(self.rest[i], place, *scale),
                Some(term) => [1.0, x, y][term],
            });
            let found = inverse * own;
            return ([0.0; 2], (0..n).map(|i| Complex::new(found[i], 0.0)).collect());
        }
        let arms: Vec<Complex<f64>> =
            self.rest.iter().map(|point| complex(*point) - complex(centre)).collect();
        let square: f64 = arms.iter().map(Complex::norm_sqr).sum();
        let off = complex(place) - complex(centre);
        let share = 1.0 / n as f64;
        if square > 0.0 {
            let own = arms.iter().map(|arm| off * arm.conj() / square + share).collect();
            return ([0.0; 2], own);
        }
        ([off.re, off.im], vec![Complex::new(share, 0.0); n])
    }
}

/// Returns r² log r of the scaled distance r.
fn thin_plate(a: [f64; 2], b: [f64; 2], scale: f64) -> f64 {
    let square = (0..2).map(|axis| ((a[axis] - b[axis]) / scale).powi(2)).sum::<f64>();
    if square > 0.0 { 0.5 * square * libm::log(square) } else { 0.0 }
}

fn complex([x, y]: [f64; 2]) -> Complex<f64> {
    Complex::new(x, y)
}

/// Lists the corners of the first and last covered pixel of each row.
fn outline((picture, [left, top]): &(Picture, [usize; 2])) -> Vec<[f64; 2]> {
    let rows = picture.rgba.chunks(4 * picture.size.width.max(1)).enumerate();
    let ends = |(row, pixels): (usize, &[u8])| {
        let covered = |pixel: &[u8]| pixel[3] > 0;
        let first = pixels.chunks(4).position(covered)?;
        let last = pixels.chunks(4).rposition(covered)?;
        let x = [first, last + 1].map(|column| (left + column) as f64);
        let y = [row, row + 1].map(|row| (top + row) as f64);
        Some([[x[0], y[0]], [x[1], y[0]], [x[0], y[1]], [x[1], y[1]]])
    };
    rows.filter_map(ends).flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::camera::Resolution;

    const POINTS: [[f64; 2]; 5] =
        [[10.0, 12.0], [40.0, 10.0], [44.0, 50.0], [8.0, 44.0], [25.0, 30.0]];

    fn far(a: [f64; 2], b: [f64; 2]) -> f64 {
        (0..2).map(|axis| (a[axis] - b[axis]).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn a_warp_meets_its_points_and_reproduces_affine_maps() {
        let warp = Warp::new(&POINTS);
        let moved = POINTS.map(|[x, y]| [x + 3.0 * (0.1 * y).sin(), y - 0.02 * x * x]);
        for (point, target) in POINTS.iter().zip(moved) {
            assert!(far(warp.moved(*point, &moved), target) < 1e-9);
        }
        let affine = |[x, y]: [f64; 2]| [1.5 * x - 0.25 * y + 7.0, 0.5 * x + 0.75 * y - 20.0];
        let moved = POINTS.map(affine);
        for place in [[0.0, 0.0], [30.0, 20.0], [90.0, -40.0]] {
            assert!(far(warp.moved(place, &moved), affine(place)) < 1e-9);
        }
    }

    #[test]
    fn two_points_turn_and_scale_their_surroundings_and_one_shifts_it() {
        let similar = |[x, y]: [f64; 2]| [-2.0 * y + 5.0, 2.0 * x - 1.0];
        for points in [vec![[1.0, 2.0], [9.0, 2.0]], vec![[1.0, 1.0], [3.0, 3.0], [8.0, 8.0]]] {
            let moved: Vec<_> = points.iter().copied().map(similar).collect();
            let found = Warp::new(&points).moved([4.0, 7.0], &moved);
            assert!(far(found, similar([4.0, 7.0])) < 1e-12);
        }
        let found = Warp::new(&[[3.0, 4.0]]).moved([5.0, 5.0], &[[13.0, 24.0]]);
        assert!(far(found, [15.0, 25.0]) < 1e-12);
    }

    #[test]
    fn a_grid_covers_the_pictures_of_every_view() {
        let disc = |centre: [f64; 2], radius: f64| {
            let size = Resolution { width: 64, height: 64 };
            let inside = |at: usize| {
                let off = [(at % 64) as f64 + 0.5 - centre[0], (at / 64) as f64 + 0.5 - centre[1]];
                off[0].hypot(off[1]) < radius
            };
            let rgba = (0..64 * 64).flat_map(|at| [9, 9, 9, if inside(at) { 255 } else { 0 }]);
            (Picture { size, rgba: rgba.collect() }, [0, 0])
        };
        let square = |centre: [f64; 2], half: f64| {
            [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
                .map(|[x, y]| [centre[0] + half * x, centre[1] + half * y])
        };
        let pictures = [disc([20.0, 20.0], 12.0), disc([40.0, 36.0], 20.0)];
        let points = [square([20.0, 20.0], 8.0), square([40.0, 36.0], 12.0)];
        let key = |k: usize| KeyView {
            name: String::new(),
            pictures: vec![Some(pictures[k].clone())],
            points: points[k].to_vec(),
            visible: vec![true; 4],
            deformation: None,
        };
        let mut mesh = Mesh::default();
        mesh.add_warped(0, &[0, 1, 2, 3], &[0, 1].map(key));
        for (view, (picture, _)) in points.iter().zip(&pictures) {
            let places: Vec<[f64; 2]> = mesh.vertices.iter().map(|v| v.at(view)).collect();
            let covers = |p: [f64; 2]| {
                mesh.layers[0].iter().any(|element| {
                    let ring: Vec<_> = element.vertices().iter().map(|&v| places[v]).collect();
                    (0..ring.len()).all(|i| {
                        let (a, b) = (ring[i], ring[(i + 1) % ring.len()]);
                        (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) >= -1e-9
                    })
                })
            };
            let shown = (0..64 * 64).filter(|at| picture.rgba[4 * at + 3] > 0);
            for at in shown {
                assert!(covers([(at % 64) as f64 + 0.5, (at / 64) as f64 + 0.5]), "{at}");
            }
        }
        // Elements of a grid share every edge except the outermost.
        let alone = mesh.neighbours().iter().flatten().filter(|other| other.is_none()).count();
        assert!(alone < 2 * mesh.element_len());
    }
}
