//! A panel and a head of quads, seen in perspective as they turn.

use super::paint::polygons;
use crate::page::colour::Colour;
use crate::page::picture::Picture;
use crate::views::set::{Element, Examples, Image, Layer, Parameter, View, ViewSet};
use std::f64::consts::{PI, TAU};

/// Width and height of the panel's pictures, pixels.
const PANEL_SIZE: [usize; 2] = [192, 192];
/// Quads of the panel, across and down.
const PANEL_QUADS: [usize; 2] = [6, 4];
/// Distance from the eye to the panel. Half the panel's width is 1.
const PANEL_EYE: f64 = 5.0;
/// Pixels of half the panel's width.
const PANEL_PIXELS: f64 = 70.0;
const YAWS: [f64; 3] = [-40.0, 0.0, 40.0];
const PITCHES: [f64; 3] = [-25.0, 0.0, 25.0];
const BENDS: [f64; 3] = [0.0, 0.5, 1.0];
const PANEL_COLOURS: [Colour; 4] =
    [[0xd9, 0x4f, 0x43], [0xf2, 0xe6, 0xcc], [0x35, 0x6a, 0x8c], [0xe8, 0xb0, 0x3a]];

/// Width and height of the head's pictures, pixels.
const HEAD_SIZE: [usize; 2] = [160, 192];
/// Quads of the head, around and from top to bottom.
const HEAD_QUADS: [usize; 2] = [16, 8];
/// Training views around the head. Every second view has a picture.
const HEAD_VIEWS: usize = 24;
/// Smallest cosine of the angle between the normal of a quad and the eye, for which the quad shows its points. Quads at
/// steeper angles are too narrow for a picture.
const GRAZING: f64 = 0.15;
/// Half the head's width, height and depth, pixels.
const RADII: [f64; 3] = [56.0, 78.0, 66.0];
/// Distance from the eye to the middle of the head, pixels.
const HEAD_EYE: f64 = 600.0;
const SKIN: [Colour; 2] = [[0xf0, 0xb9, 0x8d], [0xe2, 0xa6, 0x79]];
const HAIR: [Colour; 2] = [[0x5b, 0x3a, 0x24], [0x6d, 0x47, 0x2d]];
const EYES: Colour = [0x2a, 0x4a, 0x7a];
const MOUTH: Colour = [0xb5, 0x3b, 0x3b];

/// A set with its pictures, each with the file name that the set uses.
pub(super) type Made = (ViewSet, Vec<(String, Picture)>);

/// Makes the panel, which is rolled up along an arc: training views on a grid of parameters, test views between them.
pub(super) fn panel() -> Made {
    let [pitch, yaw] = ["pitch", "yaw"].map(|name| Some(name.to_owned()));
    let parameters = vec![
        Parameter::Rotation { angles: [pitch, yaw, None], order: None },
        Parameter::Scalar("bend".to_owned()),
    ];
    let elements = quads(PANEL_QUADS, PANEL_QUADS[0] + 1);
    let (mut train, mut pictures) = (Vec::new(), Vec::new());
    let grid = YAWS.iter().flat_map(|yaw| PITCHES.iter().map(move |pitch| (*yaw, *pitch)));
    for (number, (yaw, pitch, bend)) in
        grid.flat_map(|(yaw, pitch)| BENDS.map(|bend| (yaw, pitch, bend))).enumerate()
    {
        let mut own = panel_view(yaw, pitch, bend);
        // Pictures from the front and from both sides are enough for a panel that turns.
        if pitch == 0.0 && bend != 0.5 {
            let file = format!("view{number:02}.png");
            own.image = Some(Image::of_file(file.clone().into()));
            pictures.push((file, panel_picture(&own, &elements)));
        }
        train.push(own);
    }
    let test = [(-20.0, 12.0, 0.25), (20.0, -12.0, 0.75), (30.0, 18.0, 0.6), (-8.0, -20.0, 0.1)];
    let test = test.map(|(yaw, pitch, bend)| panel_view(yaw, pitch, bend)).into();
    let examples = Examples { name: "main".to_owned(), parameters, train, test };
    made("panel", PANEL_SIZE, elements, examples, pictures)
}

/// Makes the head, which turns all the way round: training views all around, test views halfway between them.
pub(super) fn head() -> Made {
    let angles = [None, Some("yaw".to_owned()), None];
    let parameters = vec![Parameter::Rotation { angles, order: None }];
    let elements = quads([HEAD_QUADS[0], HEAD_QUADS[1] - 1], HEAD_QUADS[0]);
    let (mut train, mut test, mut pictures) = (Vec::new(), Vec::new(), Vec::new());
    let step = 360.0 / HEAD_VIEWS as f64;
    for number in 0..HEAD_VIEWS {
        let yaw = step * number as f64;
        let mut own = head_view(yaw, &elements);
        if number % 2 == 0 {
            let file = format!("view{:02}.png", number / 2);
            own.image = Some(Image::of_file(file.clone().into()));
            pictures.push((file, head_picture(&own, &elements)));
        }
        train.push(own);
        test.push(head_view(yaw + 0.5 * step, &elements));
    }
    let examples = Examples { name: "main".to_owned(), parameters, train, test };
    made("head", HEAD_SIZE, elements, examples, pictures)
}

/// Makes a set of one layer and one motion.
fn made(
    name: &str,
    size: [usize; 2],
    elements: Vec<Element>,
    examples: Examples,
    pictures: Vec<(String, Picture)>,
) -> Made {
    let layer = Layer::whole(name, examples.train[0].points.len(), elements);
    let (name, layers) = (name.to_owned(), vec![layer]);
    (ViewSet { name, size, layers, maps: vec![examples] }, pictures)
}

/// Makes a grid of quads over rows of points. Rows of as many quads as points close around.
///
/// - `points`: number of points in a row.
fn quads([across, down]: [usize; 2], points: usize) -> Vec<Element> {
    let quad = |place: usize| {
        let (column, row) = (place % across, place / across);
        let at = |column: usize, row: usize| row * points + column % points;
        Element::Quad([
            at(column, row),
            at(column + 1, row),
            at(column + 1, row + 1),
            at(column, row + 1),
        ])
    };
    (0..across * down).map(quad).collect()
}

fn panel_picture(view: &View, elements: &[Element]) -> Picture {
    let known = view.known();
    let painted = |(quad, element): (usize, &Element)| {
        let (column, row) = (quad % PANEL_QUADS[0], quad / PANEL_QUADS[0]);
        let corners = element.vertices().iter().map(|&k| known[k]).collect();
        (PANEL_COLOURS[(column + 3 * row) % PANEL_COLOURS.len()], corners)
    };
    polygons(PANEL_SIZE, &elements.iter().enumerate().map(painted).collect::<Vec<_>>())
}

fn panel_view(yaw: f64, pitch: f64, bend: f64) -> View {
    let [across, down] = PANEL_QUADS;
    let places = (0..=down).flat_map(|j| (0..=across).map(move |i| (i, j)));
    let point = |(i, j): (usize, usize)| {
        let (x, y) = (2.0 * i as f64 / across as f64 - 1.0, 1.2 * (0.5 - j as f64 / down as f64));
        // The arc is as long as the flat panel. Its ends come forward.
        let (x, z) = if bend == 0.0 {
            (x, 0.0)
        } else {
            ((x * bend).sin() / bend, (1.0 - (x * bend).cos()) / bend)
        };
        let ((s, c), (t, d)) = (yaw.to_radians().sin_cos(), pitch.to_radians().sin_cos());
        let (x, z) = (c * x + s * z, c * z - s * x);
        let (y, z) = (d * y - t * z, t * y + d * z);
        let nearer = PANEL_PIXELS * PANEL_EYE / (PANEL_EYE - z);
        let middle = PANEL_SIZE.map(|side| 0.5 * side as f64);
        ([middle[0] + nearer * x, middle[1] - nearer * y], -PANEL_PIXELS * z)
    };
    let (points, depths): (Vec<[f64; 2]>, Vec<f64>) = places.map(point).unzip();
    let values = [("yaw", yaw), ("pitch", pitch), ("bend", bend)];
    let values = values.map(|(name, value)| (name.to_owned(), value)).into();
    View { depths, ..View::of_points(values, points) }
}

fn head_picture(view: &View, elements: &[Element]) -> Picture {
    let (known, depths) = (view.known(), &view.depths);
    let mut painted = Vec::new();
    for (quad, element) in elements.iter().enumerate() {
        if facing(element, &known, depths) > 0.0 {
            let corners = element.vertices().iter().map(|&k| known[k]).collect();
            painted.push((head_colour(quad), corners));
        }
    }
    polygons(HEAD_SIZE, &painted)
}

/// Returns the cosine of the angle between the direction to the eye and the normal of a quad's diagonals.
fn facing(element: &Element, points: &[[f64; 2]], depths: &[f64]) -> f64 {
    let &[a, b, c, d] = element.vertices() else { return 0.0 };
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

fn head_colour(quad: usize) -> Colour {
    let (column, row) = (quad % HEAD_QUADS[0], quad / HEAD_QUADS[0]);
    let front = column.min(HEAD_QUADS[0] - 1 - column);
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

/// Makes a view at a yaw, degrees. The first point of each ring is in front, where z is large.
///
/// All corners of a quad that faces the eye are visible, so that hardly a quad of the outline is missing.
fn head_view(yaw: f64, elements: &[Element]) -> View {
    let [around, down] = HEAD_QUADS;
    let (s, c) = yaw.to_radians().sin_cos();
    let places = (0..down).flat_map(|j| (0..around).map(move |i| (i, j)));
    let point = |(i, j): (usize, usize)| {
        let theta = PI * (j as f64 + 0.5) / down as f64;
        let phi = TAU * i as f64 / around as f64;
        let unit = [theta.sin() * phi.sin(), theta.cos(), theta.sin() * phi.cos()];
        let [x, y, z] = [0, 1, 2].map(|axis| RADII[axis] * unit[axis]);
        let (x, z) = (c * x + s * z, c * z - s * x);
        let nearer = HEAD_EYE / (HEAD_EYE - z);
        let middle = HEAD_SIZE.map(|side| 0.5 * side as f64);
        ([middle[0] + nearer * x, middle[1] - nearer * y], -z)
    };
    let (points, depths): (Vec<[f64; 2]>, Vec<f64>) = places.map(point).unzip();
    let mut visible = vec![false; points.len()];
    for element in elements.iter().filter(|own| facing(own, &points, &depths) > GRAZING) {
        element.vertices().iter().for_each(|&k| visible[k] = true);
    }
    View { visible, depths, ..View::of_points([("yaw".to_owned(), yaw)].into(), points) }
}
