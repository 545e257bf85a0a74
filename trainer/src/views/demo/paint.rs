//! Paints shapes in pictures, the nearest to the viewer last.

use crate::page::camera::Resolution;
use crate::page::colour::Colour;
use crate::page::picture::Picture;
use crate::views::set::cross;

/// Samples along each side of a pixel.
const SAMPLES: usize = 4;
/// Width of the border that the colours of polygons add around their outline, pixels.
const BLEED: usize = 2;

/// Makes a picture without covered pixels.
pub(super) fn empty([width, height]: [usize; 2]) -> Picture {
    let size = Resolution { width, height };
    Picture { size, rgba: vec![0; 4 * width * height] }
}

/// Paints the inside of a shape, with antialiased edges.
pub(super) fn fill(picture: &mut Picture, colour: Colour, inside: impl Fn([f64; 2]) -> bool) {
    for place in 0..picture.size.width * picture.size.height {
        let count = samples(picture.size, place).filter(|p| inside(*p)).count();
        if count > 0 {
            blend(&mut picture.rgba[4 * place..4 * place + 4], colour, count);
        }
    }
}

/// Makes a picture of convex polygons of any orientation, the nearest last.
///
/// A common edge of two polygons has no gap. Colours extend [`BLEED`] pixels beyond the outline, so that a drawn
/// element is not cut short by its picture.
pub(super) fn polygons(size: [usize; 2], all: &[(Colour, Vec<[f64; 2]>)]) -> Picture {
    let mut out = empty(size);
    for place in 0..size[0] * size[1] {
        let (mut sum, mut count) = ([0; 3], 0);
        for p in samples(out.size, place) {
            let Some((colour, _)) = all.iter().rfind(|(_, corners)| is_inside(corners, p)) else {
                continue;
            };
            sum.iter_mut().zip(colour).for_each(|(sum, c)| *sum += usize::from(*c));
            count += 1;
        }
        if count > 0 {
            let mean = sum.map(|sum| (sum as f64 / count as f64).round() as u8);
            out.rgba[4 * place..4 * place + 4].copy_from_slice(&[mean[0], mean[1], mean[2], 0xff]);
        }
    }
    (0..BLEED).for_each(|_| bleed(&mut out));
    out
}

/// Gives each pixel without coverage the mean colour of its covered neighbours.
fn bleed(picture: &mut Picture) {
    let Resolution { width, height } = picture.size;
    let before = picture.rgba.clone();
    for place in (0..width * height).filter(|place| before[4 * place + 3] == 0) {
        let (x, y) = (place % width, place / width);
        let about = |at: usize, most: usize| at.saturating_sub(1)..(at + 2).min(most);
        let all = about(y, height).flat_map(|y| about(x, width).map(move |x| 4 * (y * width + x)));
        let covered: Vec<usize> = all.filter(|at| before[at + 3] > 0).collect();
        if covered.is_empty() {
            continue;
        }
        for c in 0..4 {
            let sum: usize = covered.iter().map(|at| usize::from(before[at + c])).sum();
            picture.rgba[4 * place + c] = (sum / covered.len()) as u8;
        }
    }
}

fn is_inside(corners: &[[f64; 2]], p: [f64; 2]) -> bool {
    let turn = |at: usize| cross(corners[at], corners[(at + 1) % corners.len()], p);
    let all = || (0..corners.len()).map(turn);
    all().all(|turn| turn >= 0.0) || all().all(|turn| turn <= 0.0)
}

/// Lists the samples of a pixel.
fn samples(size: Resolution, place: usize) -> impl Iterator<Item = [f64; 2]> {
    let (x, y) = (place % size.width, place / size.width);
    let part = |offset: usize| (offset as f64 + 0.5) / SAMPLES as f64;
    (0..SAMPLES * SAMPLES)
        .map(move |s| [x as f64 + part(s % SAMPLES), y as f64 + part(s / SAMPLES)])
}

/// Blends a colour over a pixel of straight alpha. `count` is the number of covered samples.
fn blend(pixel: &mut [u8], colour: Colour, count: usize) {
    let share = count as f64 / (SAMPLES * SAMPLES) as f64;
    let below = f64::from(pixel[3]) / 255.0 * (1.0 - share);
    let alpha = share + below;
    for (byte, colour) in pixel.iter_mut().zip(colour) {
        *byte = ((f64::from(*byte) * below + f64::from(colour) * share) / alpha).round() as u8;
    }
    pixel[3] = (255.0 * alpha).round() as u8;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_seen_through_a_common_edge() {
        let (a, b) = ([200, 0, 0], [0, 100, 0]);
        let left = vec![[0.0, 0.0], [2.4, 0.0], [1.3, 4.0], [0.0, 4.0]];
        let right = vec![[2.4, 0.0], [4.0, 0.0], [4.0, 4.0], [1.3, 4.0]];
        let picture = polygons([4, 4], &[(a, left), (b, right)]);
        assert!(picture.rgba.chunks(4).all(|pixel| pixel[3] == 255));
        assert_eq!((picture.colour([0, 2]), picture.colour([3, 2])), (a, b));
        let [red, green, _] = picture.colour([2, 0]);
        assert!(red > 20 && green > 20, "{red} {green}");
    }

    #[test]
    fn colours_go_on_beyond_the_outline() {
        let square = vec![[3.0, 3.0], [5.0, 3.0], [5.0, 5.0], [3.0, 5.0]];
        let picture = polygons([8, 8], &[([9, 8, 7], square)]);
        for (place, pixel) in picture.rgba.chunks(4).enumerate() {
            let is_near = [place % 8, place / 8].iter().all(|at| (1..7).contains(at));
            assert_eq!(pixel, if is_near { [9, 8, 7, 255] } else { [0; 4] });
        }
    }
}
