//! The measured frames as a moving picture.

use super::comparison::Comparison;
use super::pictures::{Paint, PictureOptions, Pictures, Shape};
use crate::evaluate::EvaluateError;
use crate::page::camera::Camera;
use crate::page::colour::Scale;
use crate::page::drawing::{Anchor, Drawing};
use crate::page::picture::{Gif, GifError};
use rayon::prelude::*;

/// Height of a line of text, pixels.
const LINE: f64 = 24.0;

/// A moving picture that could not be made.
#[derive(Debug, thiserror::Error)]
pub enum MovingError {
    /// A frame could not be skinned.
    #[error(transparent)]
    Evaluate(#[from] EvaluateError),
    /// A picture could not be encoded.
    #[error(transparent)]
    Gif(#[from] GifError),
}

/// Draws each measured frame: the truth, then each skin in the colours of its error, all on one scale and by one camera.
/// Returns the bytes of a GIF.
///
/// - `options`: the width is that of all of them side by side.
/// - `hundredths`: time of a frame, in hundredths of a second.
///
/// # Errors
/// Every [`MovingError`].
pub fn gif(
    comparison: &Comparison<'_>,
    options: &PictureOptions,
    hundredths: u16,
) -> Result<Vec<u8>, MovingError> {
    let series = comparison.series();
    let pictures = Pictures::new(comparison, options);
    let frames = comparison.measured_frames();
    let shapes = frames.par_iter().map(|&frame| pictures.frame(frame, &series));
    let shapes: Vec<Vec<Shape>> = shapes.collect::<Result<_, _>>()?;
    let width = options.width / (series.len() + 1);
    let all = shapes.iter().flatten().flat_map(|shape| &shape.positions);
    let camera = Camera::fit(&pictures.view, all, width);
    let errors = series.iter().map(|series| series.measured.errors());
    let errors: Vec<_> = errors.collect();
    let scale = Scale::of(errors.iter().map(|errors| &errors.max_percent));
    let captions = series.iter().zip(&errors);
    let captions =
        captions.map(|(series, own)| format!("{}: {:.3} %", series.name, own.rms_percent));
    let captions: Vec<String> = std::iter::once("truth".to_owned()).chain(captions).collect();
    let height = camera.size.height as f64;
    let drawn = shapes.par_iter().enumerate().map(|(place, shapes)| {
        let mut drawing = Drawing::new(width * shapes.len(), (height + LINE) as usize);
        for (column, (shape, caption)) in shapes.iter().zip(&captions).enumerate() {
            let own = column.checked_sub(1).map(|column| series[column].measured.percent_in(place));
            let paint = own.as_ref().map_or(Paint::Clay, |own| Paint::Heat(own, scale, ""));
            let left = (column * width) as f64;
            drawing.image([left, 0.0], pictures.draw(shape, &paint, &camera).on_white());
            let middle = left + 0.5 * width as f64;
            drawing.text([middle, height + 0.75 * LINE], Anchor::Middle, caption);
        }
        drawing.picture()
    });
    let mut gif = Gif::new(hundredths);
    for picture in drawn.collect::<Vec<_>>() {
        gif.add(&picture)?;
    }
    Ok(gif.finish()?)
}
