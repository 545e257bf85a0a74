//! A figure drawn with a broad pen: its joints, its mask and its picture.

use super::paint::{empty, fill};
use crate::page::colour::Colour;
use crate::page::picture::Picture;
use crate::views::set::{JOINTS, segment_distance};

const SIZE: [usize; 2] = [240, 300];
/// Positions of [`JOINTS`], pixels.
const REST: [[f64; 2]; 16] = [
    [120.0, 175.0],
    [120.0, 170.0],
    [120.0, 105.0],
    [120.0, 60.0],
    [98.0, 108.0],
    [68.0, 130.0],
    [38.0, 150.0],
    [142.0, 108.0],
    [172.0, 130.0],
    [202.0, 150.0],
    [106.0, 178.0],
    [90.0, 222.0],
    [76.0, 266.0],
    [134.0, 178.0],
    [150.0, 222.0],
    [164.0, 266.0],
];
/// Half the width of the pen for the bone that ends at each joint, pixels. The bone of the hip is the body.
const PEN: [f64; 16] =
    [0.0, 20.0, 24.0, 9.0, 12.0, 10.0, 9.0, 12.0, 10.0, 9.0, 14.0, 13.0, 11.0, 14.0, 13.0, 11.0];
const HEAD: f64 = 27.0;
const OUTLINE: f64 = 3.0;
const INK: Colour = [0x2a, 0x2a, 0x33];
const SKIN: Colour = [0xf0, 0xb9, 0x8d];
const SHIRT: Colour = [0x3f, 0x7f, 0xbf];
const TROUSERS: Colour = [0x7a, 0x55, 0x3a];
const STRIPE: Colour = [0xf5, 0xd8, 0x4a];

/// Draws the figure: its description, and the pictures `texture.png` and `mask.png`.
pub(super) fn drawn() -> (String, Vec<(String, Picture)>) {
    let mut texture = empty(SIZE);
    let order = [12, 11, 15, 14, 10, 13, 6, 5, 9, 8, 4, 7, 1, 2, 3];
    for joint in order {
        bone(&mut texture, joint, PEN[joint] + OUTLINE, INK);
    }
    disc(&mut texture, [REST[3][0], REST[3][1] - 12.0], HEAD + OUTLINE, INK);
    for joint in order {
        bone(&mut texture, joint, PEN[joint], colour(joint));
    }
    for stripe in 0..4 {
        let y = 106.0 + 16.0 * f64::from(stripe);
        fill(&mut texture, STRIPE, |[px, py]| (px - 120.0).abs() < 19.0 && (py - y).abs() < 3.0);
    }
    let face = [REST[3][0], REST[3][1] - 12.0];
    disc(&mut texture, face, HEAD, SKIN);
    for side in [-1.0, 1.0] {
        disc(&mut texture, [face[0] + 10.0 * side, face[1] - 4.0], 3.5, INK);
    }
    fill(&mut texture, INK, |[x, y]| {
        let [x, y] = [x - face[0], y - face[1]];
        ((x * x + y * y).sqrt() - 15.0).abs() < 1.5 && y > 6.0
    });
    let mut mask = empty(SIZE);
    for (mask, drawn) in mask.rgba.chunks_mut(4).zip(texture.rgba.chunks(4)) {
        let grey = if drawn[3] >= 0x80 { 0xff } else { 0 };
        mask.copy_from_slice(&[grey, grey, grey, 0xff]);
    }
    let pictures = [("texture.png", texture), ("mask.png", mask)];
    (description(), pictures.map(|(name, picture)| (name.to_owned(), picture)).into())
}

fn description() -> String {
    let [width, height] = SIZE;
    let mut out = format!("height: {height}\nskeleton:\n");
    for ((name, parent), [x, y]) in JOINTS.iter().zip(REST) {
        let parent = parent.map_or("null", |parent| JOINTS[parent].0);
        out += &format!("- loc:\n  - {x}\n  - {y}\n  name: {name}\n  parent: {parent}\n");
    }
    out + &format!("width: {width}\n")
}

fn colour(joint: usize) -> Colour {
    match joint {
        10..=15 => TROUSERS,
        3 | 6 | 9 => SKIN,
        _ => SHIRT,
    }
}

fn bone(picture: &mut Picture, joint: usize, width: f64, colour: Colour) {
    let Some(parent) = JOINTS[joint].1 else { return };
    fill(picture, colour, |place| segment_distance(place, REST[parent], REST[joint]) <= width);
}

fn disc(picture: &mut Picture, [x, y]: [f64; 2], radius: f64, colour: Colour) {
    fill(picture, colour, |[px, py]| (px - x).hypot(py - y) <= radius);
}
