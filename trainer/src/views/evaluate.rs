//! Comparison of a model file with views, by the runtime.

use super::player::{Player, multiplied};
use super::set::{View, ViewSet};
use crate::Error;
use crate::page::picture::Picture;
use serde::Serialize;
use sinew_runtime::Model;

/// Errors of a file on a set of views.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Measured {
    /// Errors of the points; `None` if the views have no known points.
    #[serde(flatten)]
    pub points: Option<MeasuredPoints>,
    /// PSNR of whole pictures, RGBA times alpha, dB. `None` if the views have no pictures. Infinite without an error,
    /// which JSON writes as null.
    pub psnr: Option<f64>,
    /// PSNR over the pixels that are opaque in the drawn picture, dB.
    pub psnr_opaque: Option<f64>,
    /// Whether the measured views are the training views, because the set has no test views.
    pub is_training: bool,
    /// Number of elements that were drawn turned over.
    pub flipped: usize,
    /// Number of views.
    pub views: usize,
}

/// Errors of points, pixels.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct MeasuredPoints {
    /// RMS error of the known points.
    pub rms: f64,
    /// Largest error.
    pub max: f64,
    /// Share of points with the right visibility, in views with known points.
    pub visibility: f64,
}

/// Measures a file on the test views of a set, or on the training views if the set has no test views.
///
/// # Errors
/// The file has no map of a motion, or another number of points than the views; a view cannot be drawn; or a picture
/// cannot be read or is damaged.
pub fn evaluate(model: &Model<Vec<u8>>, set: &ViewSet) -> Result<Measured, Error> {
    let is_tested = set.maps.iter().any(|map| !map.test.is_empty());
    let (mut squares, mut most, mut known) = (0.0, 0.0f64, 0u32);
    let (mut right, mut marks, mut flipped, mut count) = (0, 0usize, 0, 0);
    // Errors of all pixels, and of the opaque pixels.
    let mut off = [PictureError::default(); 2];
    for examples in &set.maps {
        let views: &[View] = if is_tested { &examples.test } else { &examples.train };
        for (number, view) in views.iter().enumerate() {
            let map = &examples.name;
            let wrong = |error: Error| error.within(format_args!("\"{map}\", view {number}"));
            let player = Player::new(model, Some(map)).map_err(wrong)?;
            let (file, views) = (player.views().point_len(), view.points.len());
            if file != views {
                let text = format!("the file has {file} points, the views {views}");
                return Err(Error::mismatch(text));
            }
            let played = player.play(&view.values).map_err(wrong)?;
            for ([x, y, _], point) in played.points.iter().zip(&view.points) {
                let Some(point) = point else { continue };
                let square =
                    (f64::from(*x) - point[0]).powi(2) + (f64::from(*y) - point[1]).powi(2);
                (squares, most, known) = (squares + square, most.max(square), known + 1);
            }
            // Views whose points are all proposed have no known visibility.
            if view.points.iter().any(Option::is_some) {
                for (own, seen) in played.visibility.iter().zip(view.seen()) {
                    let Some(seen) = seen else { continue };
                    (right, marks) = (right + usize::from((*own > 0.5) == seen), marks + 1);
                }
            }
            count += 1;
            let (picture, drawn) = player.draw(&played).map_err(wrong)?;
            flipped += drawn.flipped_len;
            if let Some(image) = &view.image {
                let truth = multiplied(&image.load(player.size())?);
                add_picture(&mut off, &truth, &picture.rgba, &picture);
            }
        }
    }
    let [psnr, psnr_opaque] = off.map(|off| off.psnr());
    let points = (known > 0).then(|| MeasuredPoints {
        rms: (squares / f64::from(known)).sqrt(),
        max: most.sqrt(),
        visibility: right as f64 / marks as f64,
    });
    Ok(Measured { points, psnr, psnr_opaque, is_training: !is_tested, flipped, views: count })
}

/// Sum of squared errors of bytes over pictures.
#[derive(Clone, Copy, Debug, Default)]
pub struct PictureError {
    squares: f64,
    count: usize,
}

impl PictureError {
    /// Adds pixels: two slices of equal length with bytes.
    pub fn add(&mut self, truth: &[u8], found: &[u8]) {
        let apart = truth.iter().zip(found).map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2));
        self.squares += apart.sum::<f64>();
        self.count += truth.len();
    }

    /// Returns the PSNR in dB: infinite without an error, `None` without pixels.
    pub fn psnr(&self) -> Option<f64> {
        let error = self.squares / self.count as f64;
        (self.count > 0).then(|| 20.0 * 255.0f64.log10() - 10.0 * error.log10())
    }
}

/// Adds the errors of a picture: all pixels to `whole`, and the opaque pixels of the drawn picture to `opaque`.
///
/// - `drawn`: the picture whose alpha decides which pixels are opaque.
pub(super) fn add_picture(
    [whole, opaque]: &mut [PictureError; 2],
    truth: &Picture,
    found: &[u8],
    drawn: &Picture,
) {
    whole.add(&truth.rgba, found);
    let pixels = truth.rgba.chunks(4).zip(found.chunks(4)).zip(drawn.rgba.chunks(4));
    let pixels = pixels.filter(|(_, drawn)| drawn[3] == u8::MAX);
    pixels.for_each(|((truth, found), _)| opaque.add(truth, found));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tenth_of_the_peak_is_twenty_decibels() {
        let mut error = PictureError::default();
        assert_eq!(error.psnr(), None);
        error.add(&[7, 9], &[7, 9]);
        assert_eq!(error.psnr(), Some(f64::INFINITY));
        // The squares of 51 and 0 over four numbers have a mean of 25.5 squared.
        error.add(&[0, 100], &[51, 100]);
        assert!((error.psnr().unwrap() - 20.0).abs() < 1e-12);
    }
}
