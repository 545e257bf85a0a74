//! A panel of quads, seen in perspective as it turns, and rolled up along an arc.

use super::made::Made;
use super::paint::polygons;
use crate::page::colour::Colour;
use crate::views::set::{Element, Examples, Image, Layer, Parameter, View, ViewSet};

const SIZE: [usize; 2] = [192, 192];
/// Quads across and down.
const QUADS: [usize; 2] = [6, 4];
/// Where the eye is before the panel, of which half the width is 1.
const EYE: f64 = 5.0;
const PIXELS: f64 = 70.0;
const YAWS: [f64; 3] = [-40.0, 0.0, 40.0];
const PITCHES: [f64; 3] = [-25.0, 0.0, 25.0];
const BENDS: [f64; 3] = [0.0, 0.5, 1.0];
const COLOURS: [Colour; 4] =
    [[0xd9, 0x4f, 0x43], [0xf2, 0xe6, 0xcc], [0x35, 0x6a, 0x8c], [0xe8, 0xb0, 0x3a]];

/// Makes the set: views of a grid of parameters to learn from, and views between them.
pub(super) fn made() -> Made {
    let names = ["pitch", "yaw"].map(|name| Some(name.to_owned()));
    let [pitch, yaw] = names;
    let mut examples = Examples {
        name: "main".to_owned(),
        parameters: vec![
            Parameter::Rotation { angles: [pitch, yaw, None], order: None },
            Parameter::Scalar("bend".to_owned()),
        ],
        train: Vec::new(),
        test: Vec::new(),
    };
    let mut pictures = Vec::new();
    let grid = YAWS.iter().flat_map(|yaw| PITCHES.iter().map(move |pitch| (*yaw, *pitch)));
    for (number, (yaw, pitch, bend)) in
        grid.flat_map(|(yaw, pitch)| BENDS.map(|bend| (yaw, pitch, bend))).enumerate()
    {
        let mut own = view(yaw, pitch, bend);
        // A turned panel shows its picture well enough from the front and from both sides.
        if pitch == 0.0 && bend != 0.5 {
            let file = format!("view{number:02}.png");
            let known = own.known();
            let painted = |(quad, element): (usize, &Element)| {
                let (column, row) = (quad % QUADS[0], quad / QUADS[0]);
                let corners = element.points().iter().map(|&k| known[k]).collect();
                (COLOURS[(column + 3 * row) % COLOURS.len()], corners)
            };
            let painted: Vec<_> = elements().iter().enumerate().map(painted).collect();
            own.image = Some(Image::of_file(file.clone().into()));
            pictures.push((file, polygons(SIZE, &painted)));
        }
        examples.train.push(own);
    }
    for (yaw, pitch, bend) in
        [(-20.0, 12.0, 0.25), (20.0, -12.0, 0.75), (30.0, 18.0, 0.6), (-8.0, -20.0, 0.1)]
    {
        examples.test.push(view(yaw, pitch, bend));
    }
    let name = "panel".to_owned();
    let layer = Layer::whole(&name, examples.train[0].points.len(), elements());
    Made { set: ViewSet { name, size: SIZE, layers: vec![layer], maps: vec![examples] }, pictures }
}

fn elements() -> Vec<Element> {
    let across = QUADS[0] + 1;
    let quad = |place: usize| {
        let first = place / QUADS[0] * across + place % QUADS[0];
        Element::Quad([first, first + 1, first + across + 1, first + across])
    };
    (0..QUADS[0] * QUADS[1]).map(quad).collect()
}

fn view(yaw: f64, pitch: f64, bend: f64) -> View {
    let [across, down] = QUADS;
    let places = (0..=down).flat_map(|j| (0..=across).map(move |i| (i, j)));
    let point = |(i, j): (usize, usize)| {
        let (x, y) = (2.0 * i as f64 / across as f64 - 1.0, 1.2 * (0.5 - j as f64 / down as f64));
        // An arc of as much length as the flat panel: its ends come forward.
        let (x, z) = if bend == 0.0 {
            (x, 0.0)
        } else {
            ((x * bend).sin() / bend, (1.0 - (x * bend).cos()) / bend)
        };
        let ((s, c), (t, d)) = (yaw.to_radians().sin_cos(), pitch.to_radians().sin_cos());
        let (x, z) = (c * x + s * z, c * z - s * x);
        let (y, z) = (d * y - t * z, t * y + d * z);
        let nearer = PIXELS * EYE / (EYE - z);
        let middle = SIZE.map(|side| 0.5 * side as f64);
        ([middle[0] + nearer * x, middle[1] - nearer * y], -PIXELS * z)
    };
    let (points, depths): (Vec<[f64; 2]>, Vec<f64>) = places.map(point).unzip();
    View {
        values: [("yaw", yaw), ("pitch", pitch), ("bend", bend)]
            .map(|(name, value)| (name.to_owned(), value))
            .into(),
        visible: vec![true; points.len()],
        points: points.into_iter().map(Some).collect(),
        depths,
        image: None,
        layers: Vec::new(),
    }
}
