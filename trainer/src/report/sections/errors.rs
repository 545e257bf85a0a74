//! Sections of errors: accuracy, errors by joint, and a histogram; and cells and legends that all sections share.

use crate::evaluate::{Errors, LBS, OWN_WEIGHTS};
use crate::numeric::columns::largest;
use crate::page::chart::{Chart, Range, bars};
use crate::page::html::{below, grouped, paragraph, percent, table, text};
use crate::report::comparison::{Comparison, Series};

/// A table of the errors of each series, with the model's confidence, palette and file size.
pub(super) fn accuracy(comparison: &Comparison<'_>) -> String {
    let head = [&[""][..], &ERROR_HEADS, &["confidence", "palette", "file"]].concat();
    let row = |series: &Series<'_>| {
        let mut row = vec![text(series.name)];
        row.extend(error_cells(&series.measured.errors()));
        row.extend(match series.model() {
            None => ["", "", ""].map(str::to_owned),
            Some(model) => {
                let envelope = &model.character.envelope;
                let proxies = match envelope.proxy_len() {
                    0 => "joints alone".to_owned(),
                    count => format!("{}, {count} helpers", envelope.predictor().name()),
                };
                let bytes = format!("{} B", grouped(model.file.bytes.len()));
                [format!("{:.3}", series.measured.confidence().mean), proxies, bytes]
            }
        });
        row
    };
    let rows: Vec<_> = comparison.series().iter().map(row).collect();
    let own_weights = match comparison.baselines.own_weights {
        Some(_) => format!(
            " \u{201c}{OWN_WEIGHTS}\u{201d} is linear blend skinning with all of the mesh's own joint weights; a \
             vertex without own weights uses its fitted weights."
        ),
        None => String::new(),
    };
    table(&head, &rows)
        + &paragraph(&format!(
            "Errors are distances of vertices from their positions in the examples, in % of the diagonal \
             of the rest pose's box; 99 % of the errors are below the figure in that column. Normals are \
             compared by angle with the true normals, the area-weighted mean of the true mesh's triangles, \
             and are weighted by the area of the rest pose. \
             \u{201c}{LBS}\u{201d} is linear blend skinning with 4 influences a vertex, fitted to the same \
             training frames.{own_weights} Normals of linear blend skinning are by cofactors."
        ))
}

/// A table with a row for each joint with vertices, the model's largest error first: vertices, errors, the model's worst
/// frame, and bars. Each vertex counts for the joint that it follows most in LBS.
pub(super) fn by_joint(comparison: &Comparison<'_>) -> String {
    let (examples, measured) = (comparison.source.examples, &comparison.model.measured);
    let series = comparison.series();
    let mut vertices = vec![Vec::new(); examples.joint_len()];
    for vertex in 0..examples.vertex_len() {
        let strongest = comparison.baselines.lbs.baseline.weights.strongest(vertex);
        vertices[strongest.unwrap_or(examples.skeleton.root())].push(vertex);
    }
    // The vertices of each joint, and the RMS error of each series on them.
    let rms = |own: &[usize]| -> Vec<f64> {
        series.iter().map(|series| series.measured.rms_percent_of(own)).collect()
    };
    let joints = vertices.iter().enumerate().filter(|(_, own)| !own.is_empty());
    let mut joints: Vec<_> = joints.map(|(joint, own)| (joint, own, rms(own))).collect();
    let model = comparison.model_place();
    joints.sort_by(|a, b| b.2[model].total_cmp(&a.2[model]));
    let most = joints.iter().flat_map(|joint| &joint.2).copied().fold(0.0, f64::max);
    let mut head = vec!["joint".to_owned(), "vertices".to_owned()];
    head.extend(series.iter().map(rms_head));
    head.extend(["worst frame", "there, %", ""].map(str::to_owned));
    let row = |(joint, own, rms): &(usize, &Vec<usize>, Vec<f64>)| {
        let mut row = vec![text(&examples.skeleton.names[*joint]), grouped(own.len())];
        row.extend(rms.iter().map(|rms| length(comparison, *rms)));
        let places = 0..measured.frames.len();
        let there: Vec<f64> = places.map(|place| measured.rms_percent_in(place, own)).collect();
        let worst = largest(&there);
        row.push(comparison.source.number(measured.frames[worst].frame).to_string());
        row.push(length(comparison, there[worst]));
        let values = series.iter().zip(rms);
        let values: Vec<_> = values.map(|(series, rms)| (series.class, *rms)).collect();
        row.push(bars(&values, most));
        row
    };
    let rows: Vec<_> = joints.iter().map(row).collect();
    paragraph(
        "RMS over the measured frames. Each vertex counts for the joint that it follows most in LBS; \
         the worst frame is the model's on those vertices.",
    ) + &legend(&series)
        + &table(&head, &rows)
}

/// Bins in a decade.
const BINS: f64 = 10.0;
/// Decades below the largest error; the first bin also counts smaller errors.
const DECADES: f64 = 5.0;

/// A histogram of the errors of every vertex in every frame.
pub(super) fn histogram(comparison: &Comparison<'_>) -> String {
    let series = comparison.series();
    let most = series.iter().map(|s| s.measured.errors().max_percent).fold(0.0, f64::max);
    if most == 0.0 {
        return paragraph("There is no error.");
    }
    let last = (BINS * most.log10()).floor();
    let first = last - BINS * DECADES + 1.0;
    let bins = (last - first) as usize + 1;
    let shares = |Series { measured, .. }: &Series<'_>| -> Vec<f64> {
        let mut counts = vec![0_usize; bins];
        for error in (0..measured.frames.len()).flat_map(|place| measured.percent_in(place)) {
            // An error of 0 is in the first bin.
            let bin = ((BINS * error.log10()).floor() - first).max(0.0) as usize;
            counts[bin.min(bins - 1)] += 1;
        }
        let all = counts.iter().sum::<usize>() as f64;
        counts.iter().map(|&count| 100.0 * count as f64 / all).collect()
    };
    let shares: Vec<Vec<f64>> = series.iter().map(shares).collect();
    let edge = |bin: usize| 10_f64.powf((first + bin as f64) / BINS);
    let highest = shares.iter().flatten().copied().fold(0.0, f64::max);
    let (along, up) = (Range::between(edge(0), edge(bins)), Range::linear(0.0, 1.05 * highest));
    let mut chart = Chart::new((1130.0, 260.0), along, up);
    chart.sides("error, % of the diagonal (logarithmic)", "share of the vertices, %");
    chart.numbers();
    for (series, shares) in series.iter().zip(&shares) {
        let step = |(bin, share): (usize, &f64)| [(edge(bin), *share), (edge(bin + 1), *share)];
        let steps: Vec<_> = shares.iter().enumerate().flat_map(step).collect();
        chart.area(series.class, &steps);
        chart.line(series.class, &steps);
    }
    paragraph("All vertices in all measured frames; the first bar also counts smaller errors.")
        + &legend(&series)
        + &chart.finish("histogram of the errors of all vertices")
}

/// Formats RMS, 99th percentile and largest error, then RMS, median and 99th percentile of the normals' angles, as
/// cells.
pub(super) fn error_cells(errors: &Errors) -> [String; 6] {
    let Errors { rms_percent, p99_percent, max_percent, millimetres, .. } = *errors;
    let lengths = millimetres.map(|of| [of.rms_mm, of.p99_mm, of.max_mm]);
    let Errors { normal_rms_degrees, normal_median_degrees, normal_p99_degrees, .. } = *errors;
    let [rms, p99, max] = [(rms_percent, 0), (p99_percent, 1), (max_percent, 2)]
        .map(|(own, place)| format!("{} %{}", percent(own), below(lengths.map(|all| all[place]))));
    let angles = [normal_rms_degrees, normal_median_degrees, normal_p99_degrees];
    let [normals, median, normals_p99] = angles.map(|angle| format!("{angle:.2}°"));
    [rms, p99, max, normals, median, normals_p99]
}

/// Headings of the cells of [`error_cells`].
pub(super) const ERROR_HEADS: [&str; 6] =
    ["RMS", "99 %", "largest", "normals, RMS", "median", "99 %"];

/// Heads a column of a series in %.
pub(super) fn rms_head(series: &Series<'_>) -> String {
    format!("{}, %", text(series.name))
}

/// Formats a length in % of the diagonal as a cell of a column in %, with millimetres below.
pub(super) fn length(comparison: &Comparison<'_>, own: f64) -> String {
    percent(own) + &below(comparison.mm(own))
}

/// The legend of some series.
pub(super) fn legend(series: &[Series<'_>]) -> String {
    let entries: Vec<_> = series.iter().map(|series| (series.class, series.name)).collect();
    crate::page::chart::legend(&entries)
}
