//! Errors by frame, as a table for other tools.

use super::comparison::Comparison;
use crate::evaluate::Millimetres;

/// Writes a row for each measured frame, under a row of names.
///
/// The first columns are `frame`, `number`, `clip`, `split` and `vertices`. A frame counts from 0; its number is that of
/// the source, or its place; its split is its use in the model's training. The model's columns follow: `rms`, `p99` and
/// `max` in % of the rest diagonal, `worst_vertex` and `confidence`. Where the unit is known, `rms_mm`, `p99_mm` and
/// `max_mm` follow. LBS, fitted, has these columns with `lbs_` before their names, without a confidence. Own weights have
/// them with `own_weights_`, where the mesh comes with any, and a second model with `other_`.
///
/// # Errors
/// Those of the writer.
pub fn by_frame(comparison: &Comparison<'_>) -> Result<Vec<u8>, csv::Error> {
    let series = comparison.series();
    let (baselines, models) = series.split_at(comparison.model_place());
    let baselines = baselines.iter().zip(["lbs_", "own_weights_"]);
    let mut models = models.iter().zip(["", "other_"]);
    // The model's own columns first.
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
            row.extend(
                [errors.rms_percent, errors.p99_percent, errors.max_percent].map(|e| e.to_string()),
            );
            row.push(frame.worst_vertex().to_string());
            row.extend(series.model().map(|_| frame.confidence.to_string()));
            if let Some(Millimetres { rms_mm, p99_mm, max_mm }) = errors.millimetres {
                row.extend([rms_mm, p99_mm, max_mm].map(|length| length.to_string()));
            }
        }
        writer.write_record(&row)?;
    }
    writer.into_inner().map_err(|error| error.into_error().into())
}
