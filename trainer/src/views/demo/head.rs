//! A head that turns all the way round: what faces away is not seen.

use super::made::Made;
use super::paint::polygons;
use crate::page::colour::Colour;
use crate::page::picture::Picture;
use crate::views::set::{Element, Examples, Image, Layer, Parameter, View, ViewSet};
use std::f64::consts::{PI, TAU};

const SIZE: [usize; 2] = [160, 192];
/// Quads around and from top to bottom.
const QUADS: [usize; 2] = [16, 8];
/// Views around, of which every other one has a picture.
const VIEWS: usize = 24;
/// Cosine of the angle to the eye from which on a quad is too thin for a picture, and not seen.
const THIN: f64 = 0.15;
/// Half the width, the height and the depth, pixels.
const RADII: [f64; 3] = [56.0, 78.0, 66.0];
/// Where the eye is, pixels before the middle.
const EYE: f64 = 600.0;
const SKIN: [Colour; 2] = [[0xf0, 0xb9, 0x8d], [0xe2, 0xa6, 0x79]];
const HAIR: [Colour; 2] = [[0x5b, 0x3a, 0x24], [0x6d, 0x47, 0x2d]];
const EYES: Colour = [0x2a, 0x4a, 0x7a];
const MOUTH: Colour = [0xb5, 0x3b, 0x3b];

/// Makes the set: views all around to learn from, and those half-way between to measure with.
pub(super) fn made() -> Made {
    let mut examples = Examples {
        name: "main".to_owned(),
        parameters: vec![Parameter::Rotation {
            angles: [None, Some("yaw".to_owned()), None],
            order: None,
        }],
        train: Vec::new(),
        test: Vec::new(),
    };
    let mut pictures = Vec::new();
    let step = 360.0 / VIEWS as f64;
    for number in 0..VIEWS {
        let yaw = step * number as f64;
        let mut own = view(yaw);
        if number % 2 == 0 {
            let file = format!("view{:02}.png", number / 2);
            own.image = Some(Image::of_file(file.clone().into()));
            pictures.push((file, picture(&own)));
        }
        examples.train.push(own);
        examples.test.push(view(yaw + 0.5 * step));
    }
    let name = "head".to_owned();
    let layer = Layer::whole(&name, examples.train[0].points.len(), elements());
    Made { set: ViewSet { name, size: SIZE, layers: vec![layer], maps: vec![examples] }, pictures }
}

fn elements() -> Vec<Element> {
    let [around, down] = QUADS;
    let quad = |place: usize| {
        let (column, row) = (place % around, place / around);
        let next = (column + 1) % around;
        let at = |column: usize, row: usize| row * around + column;
        Element::Quad([at(column, row), at(next, row), at(next, row + 1), at(column, row + 1)])
    };
    (0..around * (down - 1)).map(quad).collect()
}

fn picture(view: &View) -> Picture {
    let (known, depths) = (view.known(), &view.depths);
    let mut painted = Vec::new();
    for (quad, element) in elements().iter().enumerate() {
        if facing(element, &known, depths) > 0.0 {
            let corners = element.points().iter().map(|&k| known[k]).collect();
            painted.push((colour(quad), corners));
        }
    }
    polygons(SIZE, &painted)
}

/// Returns the cosine of the angle from the eye to where an element looks, that of its diagonals' plane.
fn facing(element: &Element, points: &[[f64; 2]], depths: &[f64]) -> f64 {
    let &[a, b, c, d] = element.points() else { return 0.0 };
    let between = |from: usize, to: usize| {
        let apart = |axis: usize| points[to][axis] - points[from][axis];
        [apart(0), apart(1), depths[to] - depths[from]]
    };
    let (u, v) = (between(a, c), between(b, d));
    let normal = [0, 1, 2].map(|axis| {
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        u[next] * v[last] - u[last] * v[next]
    });
    normal[2] / normal.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn colour(quad: usize) -> Colour {
    let (column, row) = (quad % QUADS[0], quad / QUADS[0]);
    let front = column.min(QUADS[0] - 1 - column);
    let shade = (column + row) % 2;
    match (front, row) {
        (1, 2) => EYES,
        (0, 5) => MOUTH,
        (0..=3, 1..) => SKIN[shade],
        (4, 2..) => SKIN[shade],
        _ if row < 5 => HAIR[shade],
        _ => SKIN[shade],
    }
}

/// A view at a yaw: the ring's first point is in front, where z is large. What a quad that faces the eye has as a corner is
/// seen, so that hardly a quad of the outline is missing.
fn view(yaw: f64) -> View {
    let [around, down] = QUADS;
    let (s, c) = yaw.to_radians().sin_cos();
    let places = (0..down).flat_map(|j| (0..around).map(move |i| (i, j)));
    let point = |(i, j): (usize, usize)| {
        let theta = PI * (j as f64 + 0.5) / down as f64;
        let phi = TAU * i as f64 / around as f64;
        let unit = [theta.sin() * phi.sin(), theta.cos(), theta.sin() * phi.cos()];
        let [x, y, z] = [0, 1, 2].map(|axis| RADII[axis] * unit[axis]);
        let (x, z) = (c * x + s * z, c * z - s * x);
        let nearer = EYE / (EYE - z);
        ([0.5 * SIZE[0] as f64 + nearer * x, 0.5 * SIZE[1] as f64 - nearer * y], -z)
    };
    let (points, depths): (Vec<[f64; 2]>, Vec<f64>) = places.map(point).unzip();
    let mut visible = vec![false; points.len()];
    for element in elements().iter().filter(|own| facing(own, &points, &depths) > THIN) {
        element.points().iter().for_each(|&k| visible[k] = true);
    }
    View {
        values: [("yaw".to_owned(), yaw)].into(),
        points: points.into_iter().map(Some).collect(),
        visible,
        depths,
        image: None,
        layers: Vec::new(),
    }
}
