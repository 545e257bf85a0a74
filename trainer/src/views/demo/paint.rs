//! Shapes in pictures: what is nearest to the viewer is painted last.

use crate::page::camera::Resolution;
use crate::page::colour::Colour;
use crate::page::picture::Picture;

/// Samples along each side of a pixel.
const SAMPLES: usize = 4;

/// Makes a picture in which nothing is covered.
pub(super) fn empty([width, height]: [usize; 2]) -> Picture {
    let size = Resolution { width, height };
    Picture { size, rgba: vec![0; 4 * width * height] }
}

/// Paints what a function tells to be inside, with softened edges.
pub(super) fn fill(picture: &mut Picture, colour: Colour, inside: impl Fn([f64; 2]) -> bool) {
    let Resolution { width, height } = picture.size;
    for place in 0..width * height {
        let (x, y) = (place % width, place / width);
        let sample = |s: usize| {
            let part = |offset: usize| (offset as f64 + 0.5) / SAMPLES as f64;
            [x as f64 + part(s % SAMPLES), y as f64 + part(s / SAMPLES)]
        };
        let count = (0..SAMPLES * SAMPLES).filter(|s| inside(sample(*s))).count();
        if count > 0 {
            over(&mut picture.rgba[4 * place..4 * place + 4], colour, count);
        }
    }
}

/// Paints a convex polygon, whichever way round.
pub(super) fn polygon(picture: &mut Picture, colour: Colour, corners: &[[f64; 2]]) {
    let turn = |at: usize, p: [f64; 2]| {
        let (a, b) = (corners[at], corners[(at + 1) % corners.len()]);
        (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
    };
    fill(picture, colour, |p| {
        let all = || (0..corners.len()).map(|at| turn(at, p));
        all().all(|turn| turn >= 0.0) || all().all(|turn| turn <= 0.0)
    });
}

/// Lays a colour over a pixel of straight alpha, for as many samples as it covers.
fn over(pixel: &mut [u8], colour: Colour, count: usize) {
    let share = count as f64 / (SAMPLES * SAMPLES) as f64;
    let below = f64::from(pixel[3]) / 255.0 * (1.0 - share);
    let alpha = share + below;
    for (byte, colour) in pixel.iter_mut().zip(colour) {
        *byte = ((f64::from(*byte) * below + f64::from(colour) * share) / alpha).round() as u8;
    }
    pixel[3] = (255.0 * alpha).round() as u8;
}
