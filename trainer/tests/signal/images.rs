//! Images, 8-bit sRGB over one grey, reduced by boxes of two and enlarged again: by us and by three
//! resamplers.

use super::common::process;
use models::shared;
use sinew_trainer::signal::choose::of_images;
use sinew_trainer::signal::grid::{Grid, GridFilter, Sample};
use sinew_trainer::signal::image::Image;
use sinew_trainer::signal::kriging::Mean;
use std::f64::consts::PI;

/// Grey behind the images.
const GREY: f64 = 128.0;
/// Pixels at each side that are not compared.
const BORDER: usize = 6;

/// A kernel of a resampler, and its radius.
type Resampler = (&'static str, fn(f64) -> f64, usize);

const RESAMPLERS: [Resampler; 3] =
    [("Catmull-Rom", catmull_rom, 2), ("Lanczos3", lanczos3, 3), ("Spline36", spline36, 3)];

fn catmull_rom(x: f64) -> f64 {
    let x = x.abs();
    if x < 1.0 {
        (1.5 * x - 2.5) * x * x + 1.0
    } else if x < 2.0 {
        ((-0.5 * x + 2.5) * x - 4.0) * x + 2.0
    } else {
        0.0
    }
}

fn lanczos3(x: f64) -> f64 {
    let sinc = |x: f64| if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) };
    if x.abs() < 3.0 { sinc(x) * sinc(x / 3.0) } else { 0.0 }
}

fn spline36(x: f64) -> f64 {
    let x = x.abs();
    if x < 1.0 {
        ((13.0 / 11.0 * x - 453.0 / 209.0) * x - 3.0 / 209.0) * x + 1.0
    } else if x < 2.0 {
        let x = x - 1.0;
        ((-6.0 / 11.0 * x + 270.0 / 209.0) * x - 156.0 / 209.0) * x
    } else if x < 3.0 {
        let x = x - 2.0;
        ((1.0 / 11.0 * x - 45.0 / 209.0) * x + 26.0 / 209.0) * x
    } else {
        0.0
    }
}

/// Doubles the columns, each pixel at its centre, then transposes the image.
fn columns(image: &Image, (_, kernel, reach): Resampler) -> Image {
    let Image { width, height, channels, .. } = *image;
    let mut samples = vec![0.0; 2 * image.samples.len()];
    for out in 0..2 * height {
        let place = (out as f64 + 0.5) / 2.0 - 0.5;
        let first = place.floor() as i64 - reach as i64 + 1;
        let taps: Vec<(usize, f64)> = (first..first + 2 * reach as i64)
            .map(|row| (row.clamp(0, height as i64 - 1) as usize, kernel(place - row as f64)))
            .collect();
        let all: f64 = taps.iter().map(|(_, weight)| weight).sum();
        for column in 0..width {
            for channel in 0..channels {
                let of = |row: usize| image.samples[(row * width + column) * channels + channel];
                let sum: f64 = taps.iter().map(|(row, weight)| weight * of(*row)).sum();
                samples[(column * 2 * height + out) * channels + channel] = sum / all;
            }
        }
    }
    Image { width: 2 * height, height: width, samples, ..image.clone() }
}

fn resampled(image: &Image, by: Resampler) -> Image {
    columns(&columns(image, by), by)
}

fn rounded(mut image: Image) -> Image {
    image.samples.iter_mut().for_each(|x| *x = x.round().clamp(0.0, 255.0));
    image
}

/// Returns the PSNR of a rounded image, in dB.
fn psnr(truth: &Image, found: Image) -> f64 {
    let found = rounded(found);
    assert_eq!((truth.width, truth.height), (found.width, found.height));
    let (mut sum, mut count) = (0.0, 0);
    for (place, (a, b)) in truth.samples.iter().zip(&found.samples).enumerate() {
        let pixel = place / truth.channels;
        let is_inside = |at: usize, side: usize| (BORDER..side - BORDER).contains(&at);
        if is_inside(pixel % truth.width, truth.width)
            && is_inside(pixel / truth.width, truth.height)
        {
            sum += (a - b).powi(2);
            count += 1;
        }
    }
    10.0 * (255.0 * 255.0 / (sum / f64::from(count))).log10()
}

/// Composes an image with alpha over the grey.
fn on_grey(image: &Image) -> Image {
    assert!(image.has_alpha && image.channels == 4, "colours are covered already");
    let pixel = |pixel: &[f64]| [0, 1, 2].map(|c| pixel[c] + GREY * (1.0 - pixel[3] / 255.0));
    let samples = image.samples.chunks(4).flat_map(pixel).collect();
    rounded(Image { channels: 3, has_alpha: false, samples, ..image.clone() })
}

/// Makes rings about the centre whose frequency grows to `frequency` cycles per pixel at the sides.
fn zone_plate(frequency: f64) -> Image {
    let side = 256;
    let at = |i: usize| i as f64 - 127.5;
    let ring = |i: usize| {
        let square = at(i % side).powi(2) + at(i / side).powi(2);
        127.5 + 127.5 * (PI * frequency / 128.0 * square).cos()
    };
    let samples = (0..side * side).flat_map(|i| [ring(i); 3]).collect();
    let has_alpha = false;
    rounded(Image { width: side, height: side, channels: 3, has_alpha, most: 255.0, samples })
}

/// Returns our filter for an image, with the choices of `auto`.
fn filter() -> GridFilter {
    let grid =
        Grid { factor: 2, taps: sinew_trainer::signal::choose::TAPS, sample: Sample::Average };
    GridFilter::new(&process(of_images(), Mean::Constant), grid).unwrap()
}

/// Compares one image: our PSNR, then the PSNR of the three resamplers, in dB.
fn compared(truth: &Image, filter: &GridFilter) -> [f64; 4] {
    let coarse = rounded(truth.coarser(2).unwrap());
    let fine = coarse.finer(filter).unwrap();
    let again = fine.coarser(2).unwrap();
    for (found, expected) in again.samples.iter().zip(&coarse.samples) {
        assert!((found - expected).abs() < 1e-10, "averages give the input back");
    }
    let [a, b, c] = RESAMPLERS.map(|by| psnr(truth, resampled(&coarse, by)));
    [psnr(truth, fine), a, b, c]
}

#[test]
fn faces_are_better_than_by_three_resamplers() {
    let Some(folder) = shared("ict-views") else { return };
    let mut files: Vec<_> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|file| file.extension().is_some_and(|ending| ending == "png"));
    files.sort();
    assert_eq!(files.len(), 27);
    let filter = filter();
    let rows: Vec<[f64; 4]> =
        files.iter().map(|file| compared(&on_grey(&Image::read(file).unwrap()), &filter)).collect();
    let mean = |k: usize| rows.iter().map(|row| row[k]).sum::<f64>() / rows.len() as f64;
    println!("mean PSNR, dB: ours {:.3}", mean(0));
    for (k, ((name, ..), bar)) in RESAMPLERS.iter().zip([0.5, 0.2, 0.2]).enumerate() {
        let least = rows.iter().map(|row| row[0] - row[k + 1]).fold(f64::INFINITY, f64::min);
        println!(
            "{name}: {:.3}, by {:+.3}, on the worst image {least:+.3}",
            mean(k + 1),
            mean(0) - mean(k + 1)
        );
        assert!(mean(0) >= mean(k + 1) + bar, "{name}");
        assert!(least >= 0.0, "{name}: {least}");
    }
}

#[test]
fn a_zone_plate_is_better_up_to_the_resolution_of_the_coarse_grid() {
    let filter = filter();
    for frequency in [0.2, 0.25] {
        let [own, others @ ..] = compared(&zone_plate(frequency), &filter);
        println!("zone plate to {frequency}: ours {own:.2}, {others:.2?}");
        for (other, bar) in others.into_iter().zip([0.5, 0.2, 0.2]) {
            assert!(own >= other + bar, "{frequency}: {own} {other}");
        }
    }
    // At higher frequencies, every resampler shows false rings.
    let [own, others @ ..] = compared(&zone_plate(0.5), &filter);
    println!("zone plate to 0.5: ours {own:.2}, {others:.2?}");
    assert!(others.iter().all(|other| (own - other).abs() < 0.1));
}

#[test]
fn the_three_resamplers_are_themselves() {
    for (name, kernel, reach) in RESAMPLERS {
        for i in 0..=reach {
            let expected = if i == 0 { 1.0 } else { 0.0 };
            assert!((kernel(i as f64) - expected).abs() < 1e-12, "{name} {i}");
        }
        let sum: f64 = (-3..4).map(|i| kernel(0.25 + f64::from(i))).sum();
        assert!((sum - 1.0).abs() < 0.01, "{name} {sum}");
    }
    let (own, other) = (zone_plate(0.1), zone_plate(0.2));
    assert_eq!(psnr(&own, own.clone()), f64::INFINITY);
    assert!(psnr(&own, other) < 20.0);
}
