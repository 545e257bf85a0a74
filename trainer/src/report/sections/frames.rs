//! Sections of errors and confidence by frame.

use super::errors::{legend, length, rms_head};
use crate::evaluate::{Measured, least_confident_joint};
use crate::examples::Split;
use crate::page::chart::{Chart, Range};
use crate::page::html::{paragraph, table, text};
use crate::report::comparison::{Comparison, Series};

/// Size of a chart, in pixels.
const SIZE: (f64, f64) = (1130.0, 290.0);
/// Rows of the table of the worst frames.
const WORST: usize = 8;
/// Largest confidence that prints as less than 1.
const CERTAIN: f64 = 0.9995;
/// Lower ends of the ranges of confidence in the table of errors by confidence.
const RANGES: [f64; 5] = [0.95, 0.8, 0.5, 0.2, 0.0];

/// A chart of each frame's RMS error, and a table of the frames with the model's largest errors.
pub(super) fn errors(comparison: &Comparison<'_>) -> String {
    let count = comparison.model.measured.frames.len();
    let series = comparison.series();
    let of = |series: &Series<'_>| -> Vec<f64> {
        (0..count).map(|place| series.measured.errors_in(place).rms_percent).collect()
    };
    let rms: Vec<Vec<f64>> = series.iter().map(of).collect();
    let mut chart = Chart::new(SIZE, along(count), Range::log(rms.iter().flatten().copied()));
    bands(&mut chart, comparison);
    chart.sides("frame", "RMS error, % of the diagonal (logarithmic)");
    for (series, rms) in series.iter().zip(&rms) {
        lines(&mut chart, comparison, series.class, rms);
    }
    for (place, frame) in comparison.measured_frames().into_iter().enumerate() {
        let of = |(series, rms): (&Series<'_>, &Vec<f64>)| {
            format!("{} {}", series.name, comparison.length(rms[place]))
        };
        let at: Vec<String> = series.iter().zip(&rms).map(of).collect();
        let label = comparison.source.label(frame);
        chart.tooltip(cell(place), &format!("{label}: {}", at.join(", ")));
    }
    legend(&series)
        + &chart.finish("RMS error of each skin in each frame")
        + &worst(comparison, &series, &rms)
}

/// A chart and tables of the confidence, unless the model is certain of all frames.
pub(super) fn confidence(comparison: &Comparison<'_>) -> String {
    let doubtful = |s: &Series<'_>| s.model().is_some() && s.measured.confidence().least < CERTAIN;
    let series: Vec<_> = comparison.series().into_iter().filter(doubtful).collect();
    if series.is_empty() {
        let models = if comparison.other.is_some() { "Both models are" } else { "The model is" };
        return paragraph(&format!(
            "{models} certain of every measured pose: none is far from those of the training."
        ));
    }
    let count = comparison.model.measured.frames.len();
    let mut chart = Chart::new((SIZE.0, 190.0), along(count), Range::linear(0.0, 1.0));
    bands(&mut chart, comparison);
    chart.sides("frame", "confidence");
    let mut rows = Vec::new();
    for series in &series {
        let confidence: Vec<f64> = series.measured.frames.iter().map(|f| f.confidence).collect();
        lines(&mut chart, comparison, series.class, &confidence);
        let mut least: Vec<usize> = (0..count).filter(|&p| confidence[p] < CERTAIN).collect();
        least.sort_by(|&a, &b| confidence[a].total_cmp(&confidence[b]));
        rows.extend(least.iter().take(WORST).map(|&place| {
            let frame = series.measured.frames[place].frame;
            let rms = length(comparison, series.measured.errors_in(place).rms_percent);
            let examples = comparison.source.examples;
            let joint = series
                .model()
                .and_then(|model| least_confident_joint(&model.character, examples, frame));
            vec![
                text(&comparison.source.label(frame)),
                text(series.name),
                format!("{:.3}", confidence[place]),
                text(joint.unwrap_or_default()),
                rms,
            ]
        }));
    }
    let head = ["least confident", "model", "confidence", "least sure at", "RMS, %"];
    paragraph(
        "The model's confidence in a pose: 1 near the poses of the training, 0 far from them, where its \
         kernel maps have faded.",
    ) + &legend(&series)
        + &chart.finish("confidence in each frame")
        + &table(&head, &rows)
        + &by_confidence(comparison, &series)
}

/// A table of the frames in each range of confidence, with the RMS errors of the model and the baselines.
fn by_confidence(comparison: &Comparison<'_>, series: &[Series<'_>]) -> String {
    let rms = |measured: &Measured, places: &[usize]| {
        let squares = places.iter().map(|&place| measured.errors_in(place).rms_percent.powi(2));
        length(comparison, (squares.sum::<f64>() / places.len() as f64).sqrt())
    };
    let baselines = comparison.baseline_series();
    let mut rows = Vec::new();
    for series in series {
        let mut below = f64::INFINITY;
        for from in RANGES {
            let is_in = |confidence: f64| (from..below).contains(&confidence);
            let frames = series.measured.frames.iter().enumerate();
            let own: Vec<usize> =
                frames.filter(|(_, f)| is_in(f.confidence)).map(|(place, _)| place).collect();
            let range = format!("{from} to {}", below.min(1.0));
            below = from;
            if own.is_empty() {
                continue;
            }
            let mut row = vec![range, text(series.name), own.len().to_string()];
            row.push(rms(series.measured, &own));
            row.extend(baselines.iter().map(|baseline| rms(baseline.measured, &own)));
            rows.push(row);
        }
    }
    let mut head = ["confidence", "model", "frames", "RMS, %"].map(str::to_owned).to_vec();
    head.extend(baselines.iter().map(|baseline| format!("{}, %", baseline.name)));
    paragraph(
        "Errors by confidence: the RMS error of the model and of linear blend skinning in the frames of each range of \
         confidence.",
    ) + &table(&head, &rows)
}

/// The horizontal axis: one unit for each frame.
fn along(count: usize) -> Range {
    Range::linear(0.0, count as f64)
}

fn cell(place: usize) -> (f64, f64) {
    (place as f64, place as f64 + 1.0)
}

/// Draws a line for each run of consecutive frames.
fn lines(chart: &mut Chart, comparison: &Comparison<'_>, class: &str, values: &[f64]) {
    let frames = comparison.measured_frames();
    let clip_of = |frame| comparison.source.clip_of(frame);
    let mut points = (0..).zip(values).map(|(place, value)| (f64::from(place) + 0.5, *value));
    for run in frames.chunk_by(|&a, &b| b == a + 1 && clip_of(a) == clip_of(b)) {
        let points: Vec<_> = points.by_ref().take(run.len()).collect();
        chart.line(class, &points);
    }
}

/// Marks held-out and extreme frames if other frames are measured too, marks clips if there are several, and writes
/// frame numbers.
fn bands(chart: &mut Chart, comparison: &Comparison<'_>) {
    let (frames, source) = (comparison.measured_frames(), &comparison.source);
    let split = |frame: usize| comparison.use_of(frame);
    if frames.iter().any(|&frame| split(frame) != split(frames[0])) {
        for (range, of) in runs(&frames, split) {
            if of != Split::Train {
                chart.band(of.name(), range, of.name());
            }
        }
    }
    if source.clips.len() > 1 {
        for (range, clip) in runs(&frames, |frame| source.clip_of(frame)) {
            chart.band("clip", range, clip.map_or("", |clip| source.clips[clip].name.as_str()));
        }
    }
    let step =
        [1, 2, 5, 10, 20, 50, 100, 200, 500].into_iter().find(|step| frames.len() / step <= 15);
    for place in (0..frames.len()).step_by(step.unwrap_or(frames.len() / 10)) {
        chart.mark(place as f64 + 0.5, &source.number(frames[place]).to_string());
    }
}

/// Groups frames into runs with the same value.
fn runs<T: PartialEq>(frames: &[usize], of: impl Fn(usize) -> T) -> Vec<((f64, f64), T)> {
    let mut runs: Vec<((f64, f64), T)> = Vec::new();
    for (place, &frame) in frames.iter().enumerate() {
        let (value, (from, to)) = (of(frame), cell(place));
        match runs.last_mut() {
            Some((range, last)) if *last == value => range.1 = to,
            _ => runs.push(((from, to), value)),
        }
    }
    runs
}

fn worst(comparison: &Comparison<'_>, series: &[Series<'_>], rms: &[Vec<f64>]) -> String {
    let own = &rms[comparison.model_place()];
    let mut order: Vec<usize> = (0..own.len()).collect();
    order.sort_by(|&a, &b| own[b].total_cmp(&own[a]));
    let mut head = vec!["worst frames".to_owned(), "use".to_owned()];
    head.extend(series.iter().map(rms_head));
    head.extend(["largest, %", "at vertex", "confidence"].map(str::to_owned));
    let row = |&place: &usize| {
        let frame = &comparison.model.measured.frames[place];
        let split = comparison.use_of(frame.frame).name();
        let mut row = vec![text(&comparison.source.label(frame.frame)), split.to_owned()];
        row.extend(rms.iter().map(|rms| length(comparison, rms[place])));
        row.push(length(comparison, comparison.model.measured.errors_in(place).max_percent));
        row.push(frame.worst_vertex().to_string());
        row.push(format!("{:.3}", frame.confidence));
        row
    };
    let rows: Vec<_> = order.iter().take(WORST).map(row).collect();
    table(&head, &rows)
}
