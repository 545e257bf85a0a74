//! A model file held against views, by the runtime.
//! Peak over RMS error of pictures, dB.

use super::player::{PlayError, Player, multiplied};
use super::set::{SetError, View, ViewSet};
use crate::page::picture::Picture;
use serde::Serialize;
use sinew_runtime::Model;

/// What a file is off by: points in pixels.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Measured {
    /// Of the points, where the views know some.
    #[serde(flatten)]
    pub points: Option<MeasuredPoints>,
    /// Peak over RMS error of whole pictures, RGBA times alpha, dB; none where views have none. Infinite, which JSON has
    /// as null, where nothing is off.
    pub psnr: Option<f64>,
    /// The same over the pixels that are opaque in what is drawn.
    pub psnr_opaque: Option<f64>,
    /// Whether the views are those that the file was trained on: the set has no others.
    pub is_training: bool,
    /// Elements that were drawn turned over.
    pub flipped: usize,
    /// Views.
    pub views: usize,
}

/// What points are off by, in pixels.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct MeasuredPoints {
    /// RMS over known points.
    pub rms: f64,
    /// The most.
    pub max: f64,
    /// Share of points whose visibility is right, in views that know some.
    pub visibility: f64,
}

/// What cannot be measured.
#[derive(Debug, thiserror::Error)]
pub enum EvaluateError {
    /// A view cannot be shown.
    #[error("\"{map}\", view {view}: {error}")]
    Play {
        /// The motion.
        map: String,
        /// The view.
        view: usize,
        /// Why.
        error: PlayError,
    },
    /// A picture cannot be read.
    #[error(transparent)]
    Set(#[from] SetError),
    /// The file is of another object.
    #[error("the file has {file} points, the views {views}")]
    Points {
        /// Of the file.
        file: usize,
        /// Of the views.
        views: usize,
    },
}

/// Measures a file on a set: on its views to measure with if it has some, else on those to learn from.
///
/// # Errors
/// [`EvaluateError`].
pub fn evaluate(model: &Model<Vec<u8>>, set: &ViewSet) -> Result<Measured, EvaluateError> {
    let is_tested = set.maps.iter().any(|map| !map.test.is_empty());
    let (mut squares, mut most, mut known) = (0.0, 0.0f64, 0u32);
    let (mut right, mut marks, mut flipped, mut count) = (0, 0, 0, 0);
    // Of all pixels, and of those that are opaque.
    let mut off = [PictureError::default(); 2];
    for examples in &set.maps {
        let wrong =
            |view| move |error| EvaluateError::Play { map: examples.name.clone(), view, error };
        let views: &[View] = if is_tested { &examples.test } else { &examples.train };
        for (number, view) in views.iter().enumerate() {
            let player = Player::new(model, Some(&examples.name)).map_err(wrong(number))?;
            let file = player.views().point_len();
            if file != view.points.len() {
                return Err(EvaluateError::Points { file, views: view.points.len() });
            }
            let played = player.play(&view.values).map_err(wrong(number))?;
            for ([x, y, _], point) in played.points.iter().zip(&view.points) {
                let Some(point) = point else { continue };
                let square =
                    (f64::from(*x) - point[0]).powi(2) + (f64::from(*y) - point[1]).powi(2);
                (squares, most, known) = (squares + square, most.max(square), known + 1);
            }
            // Nothing is known where all points are proposed.
            if view.points.iter().any(Option::is_some) {
                let seen = played.visibility.iter().map(|x| *x > 0.5);
                let marked = seen.zip(view.seen()).filter_map(|(own, seen)| Some(own == seen?));
                let marked: Vec<bool> = marked.collect();
                right += marked.iter().filter(|is_right| **is_right).count();
                marks += marked.len();
            }
            count += 1;
            let (picture, drawn) = player.draw(&played).map_err(wrong(number))?;
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

/// Squares of errors of bytes, added up picture by picture.
#[derive(Clone, Copy, Debug, Default)]
pub struct PictureError {
    squares: f64,
    count: usize,
}

impl PictureError {
    /// Adds pixels: numbers from 0 to 255, as many of each.
    pub fn add(&mut self, truth: &[u8], found: &[u8]) {
        let apart = truth.iter().zip(found).map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2));
        self.squares += apart.sum::<f64>();
        self.count += truth.len();
    }

    /// Returns the PSNR in dB, infinite where nothing is off; `None` where nothing was added.
    pub fn psnr(&self) -> Option<f64> {
        let error = self.squares / self.count as f64;
        (self.count > 0).then(|| 20.0 * 255.0f64.log10() - 10.0 * error.log10())
    }
}

/// Adds a picture's errors to those of whole pictures, and to those of the pixels that are opaque in the drawn picture.
///
/// - `drawn`: the picture that says which pixels are opaque.
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
        // Squares of 51 and 0 over four numbers: a mean of 25.5 squared.
        error.add(&[0, 100], &[51, 100]);
        assert!((error.psnr().unwrap() - 20.0).abs() < 1e-12);
    }
}
