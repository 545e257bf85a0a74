//! Outputs for other tools: errors by frame as CSV, errors by vertex as PLY, and the measured frames as a GIF.

use super::comparison::{Comparison, Series};
use super::pictures::{Paint, PictureOptions, Pictures, Shape};
use crate::Error;
use crate::evaluate::{Errors, Millimetres};
use crate::page::camera::Camera;
use crate::page::colour::Scale;
use crate::page::drawing::{Anchor, Drawing};
use crate::page::picture::Gif;
use rayon::prelude::*;

/// Writes CSV: a row of names, then a row for each measured frame.
///
/// The first columns are `frame`, `number`, `clip`, `split` and `vertices`. A frame counts from 0; its number is that
/// of the source, or the frame; its split is its use in the model's training. The model's columns follow: `rms`, `p99`
/// and `max` in % of the rest diagonal, `worst_vertex` and `confidence`. If the unit is known, `rms_mm`, `p99_mm` and
/// `max_mm` follow. Fitted LBS has the same columns with the prefix `lbs_`, without a confidence. Own weights, if the
/// mesh has any, have the prefix `own_weights_`, and a second model has `other_`.
///
/// # Errors
/// The errors of the writer.
pub fn frames_csv(comparison: &Comparison<'_>) -> Result<Vec<u8>, csv::Error> {
    let series = comparison.series();
    let (baselines, models) = series.split_at(comparison.model_place());
    let baselines = baselines.iter().zip(["lbs_", "own_weights_"]);
    let mut models = models.iter().zip(["", "other_"]);
    // The model's columns are first.
    let order: Vec<_> = models.next().into_iter().chain(baselines).chain(models).collect();
    let mut writer = csv::Writer::from_writer(Vec::new());
    let mut names = ["frame", "number", "clip", "split", "vertices"].map(str::to_owned).to_vec();
    for (series, prefix) in &order {
        names.extend(["rms", "p99", "max", "worst_vertex"].map(|name| format!("{prefix}{name}")));
        names.extend(series.model().map(|_| format!("{prefix}confidence")));
        if series.measured.diagonal_mm.is_some() {
            names.extend(["rms_mm", "p99_mm", "max_mm"].map(|name| format!("{prefix}{name}")));
        }
    }
    writer.write_record(&names)?;
    let (examples, source) = (comparison.source.examples, &comparison.source);
    for (place, frame) in comparison.measured_frames().into_iter().enumerate() {
        let clip = source.clip_of(frame).map_or("", |clip| source.clips[clip].name.as_str());
        let split = comparison.use_of(frame).name();
        let mut row = vec![frame.to_string(), source.number(frame).to_string()];
        row.extend([clip, split].map(str::to_owned));
        row.push(examples.vertex_len().to_string());
        for (series, _) in &order {
            let (errors, frame) =
                (series.measured.errors_in(place), &series.measured.frames[place]);
            let Errors { rms_percent, p99_percent, max_percent, millimetres, .. } = errors;
            row.extend([rms_percent, p99_percent, max_percent].map(|error| error.to_string()));
            row.push(frame.worst_vertex().to_string());
            row.extend(series.model().map(|_| frame.confidence.to_string()));
            if let Some(Millimetres { rms_mm, p99_mm, max_mm, .. }) = millimetres {
                row.extend([rms_mm, p99_mm, max_mm].map(|length| length.to_string()));
            }
        }
        writer.write_record(&row)?;
    }
    writer.into_inner().map_err(|error| error.into_error().into())
}

/// Writes the rest mesh as binary little-endian PLY. Each vertex has its position, the colour of its error, and
/// `error`: the RMS over the measured frames in % of the rest diagonal. Numbers are floats.
pub fn rest_mesh_ply(comparison: &Comparison<'_>) -> Vec<u8> {
    let examples = comparison.source.examples;
    let errors = comparison.model.measured.vertex_rms_percent();
    let scale = Scale::of(&errors);
    let mut out = format!(
        "ply\nformat binary_little_endian 1.0\n\
         comment error: RMS over {} frames ({}), % of the rest diagonal; colours up to {}\n\
         element vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\nproperty float error\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        comparison.model.measured.frames.len(),
        comparison.frames.name(),
        scale.most,
        examples.vertex_len(),
        examples.triangles.len()
    )
    .into_bytes();
    for (position, &error) in examples.rest.iter().zip(&errors) {
        position.iter().for_each(|x| out.extend((*x as f32).to_le_bytes()));
        out.extend(scale.colour(error));
        out.extend((error as f32).to_le_bytes());
    }
    for corners in &examples.triangles {
        out.push(3);
        corners.iter().for_each(|corner| out.extend((*corner as i32).to_le_bytes()));
    }
    out
}

/// Height of a line of text, in pixels.
const LINE: f64 = 24.0;

/// Draws each measured frame as a picture of a GIF: the truth, then each skin in the colours of its error. All use the
/// same scale and camera.
///
/// - `options`: the width is that of the pictures side by side.
/// - `hundredths`: duration of a frame, in hundredths of a second.
///
/// # Errors
/// The runtime refuses a frame, the pictures are too large for a GIF, or the encoder fails.
pub fn frames_gif(
    comparison: &Comparison<'_>,
    options: &PictureOptions,
    hundredths: u16,
) -> Result<Vec<u8>, Error> {
    let series = comparison.series();
    let pictures = Pictures::new(comparison, options);
    let frames = comparison.measured_frames();
    let shapes = frames.par_iter().map(|&frame| pictures.frame(frame, &series));
    let shapes: Vec<Vec<Shape>> = shapes.collect::<Result<_, _>>()?;
    let width = options.width / (series.len() + 1);
    let all = shapes.iter().flatten().flat_map(|shape| &shape.positions);
    let camera = Camera::fit(&pictures.view, all, width);
    let errors: Vec<_> = series.iter().map(|series| series.measured.errors()).collect();
    let scale = Scale::of(errors.iter().map(|errors| &errors.max_percent));
    let caption = |(series, own): (&Series<'_>, &Errors)| {
        format!("{}: {:.3} %", series.name, own.rms_percent)
    };
    let captions = series.iter().zip(&errors).map(caption);
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
    gif.finish()
}
