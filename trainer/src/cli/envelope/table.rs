//! Tables of a training and of measurements.

use crate::cli::{counted, table};
use crate::envelope::choose::report::{CandidateReport, TrainingReport};
use crate::envelope::s3::Method;
use crate::evaluate::{Confidence, Errors, Evaluation, LBS, OWN_WEIGHTS, Region};
use crate::settings::{COEFFICIENTS_COST, TIED, UNSEEN};
use crate::space::written;

/// Writes the candidates, the choice and its errors on the training frames.
///
/// - `diagonal_mm`: diagonal of the rest mesh; `None` if the unit is not known.
pub(super) fn report(report: &TrainingReport, diagonal_mm: Option<f64>) -> String {
    let length = |share: Option<f64>| share.zip(diagonal_mm).map(|(share, mm)| share * mm);
    // Tables have a column of millimetres if the unit is known.
    let in_mm = |cell: String| diagonal_mm.map(|_| cell);
    let mut head = vec!["candidate", "helpers", "bytes", "cross-validated, %"];
    head.extend(diagonal_mm.map(|_| "mm"));
    head.push("");
    let row = |candidate: &CandidateReport| (kind(candidate), candidate.proxies, candidate.bytes);
    let mut rows = Vec::new();
    for (index, candidate) in report.candidates.iter().enumerate() {
        // Several attempts may end as one model.
        let is_repeated =
            report.candidates[..index].iter().any(|other| row(other) == row(candidate));
        if is_repeated && index != report.chosen {
            continue;
        }
        let (bytes, rms) = match (candidate.bytes, candidate.validated_rms) {
            (Some(bytes), Some(rms)) => (bytes.to_string(), format!("{:.4}", 100.0 * rms)),
            _ => ("-".to_owned(), "-".to_owned()),
        };
        let mut cells = vec![kind(candidate), candidate.proxies.to_string(), bytes, rms];
        cells.extend(in_mm(length(candidate.validated_rms).map_or("-".to_owned(), written)));
        cells.push(match candidate.bytes {
            _ if index == report.chosen => "<- taken".to_owned(),
            Some(_) => String::new(),
            None => "too many bytes".to_owned(),
        });
        rows.push(cells);
    }
    let mut out = table(&head, rows);
    let best = report.candidates.iter().filter_map(|candidate| candidate.validated_rms);
    let best = best.min_by(f64::total_cmp).unwrap_or_default();
    let validated = report.chosen().validated_rms.unwrap_or_default();
    if report.refused.is_some() {
        out += "helpers are worse than LBS on clips left out: LBS is taken\n";
    } else if validated > TIED * best.max(UNSEEN) {
        out += &format!(
            "the candidate with the least error lacks tangent coefficients, which make normals right: one\n\
             that has them is taken unless its error is {COEFFICIENTS_COST} times as large\n"
        );
    } else if validated > best {
        out += &format!(
            "errors within {:.0} %, or below {} %, are tied: the smallest file is taken\n",
            100.0 * (TIED - 1.0),
            100.0 * UNSEEN
        );
    }
    let mut head = vec!["RMS error, training frames", "% of the diagonal"];
    head.extend(diagonal_mm.map(|_| "mm"));
    let bones = (report.chosen().proxies > 0).then_some(report.bones);
    let errors = [
        (LBS, Some(report.lbs_rms)),
        (OWN_WEIGHTS, report.own_weights_rms),
        ("the model", Some(report.training_rms)),
        ("forecast: more of these clips", Some(report.same_clips_rms)),
        ("forecast: another clip", report.other_clip_rms),
        ("helpers as bones (TRS): change of the skin", bones.map(|bones| bones.rms)),
        ("the same, largest", bones.map(|bones| bones.largest)),
    ];
    let row = |(name, rms): (&str, Option<f64>)| {
        let mut cells = vec![name.to_owned(), format!("{:.4}", 100.0 * rms?)];
        cells.extend(length(rms).map(written));
        Some(cells)
    };
    out + &table(&head, errors.into_iter().filter_map(row).collect())
}

fn kind(candidate: &CandidateReport) -> String {
    let predictor = if candidate.proxies == 0 { "joints alone (LBS)" } else { candidate.predictor };
    let method = match candidate.method {
        Some(Method::Published) => ", as published",
        Some(Method::Unrefined) => ", unrefined",
        Some(Method::Refined) | None => "",
    };
    // Only a budget removes tangent coefficients, which make normals right.
    let bare = if candidate.tangent_coefficients { "" } else { ", cofactors" };
    format!("{predictor}{method}{bare}")
}

/// Writes the errors of one model, below those of the baselines.
pub(super) fn evaluation(evaluation: &Evaluation) -> String {
    evaluations(&[(fitted(evaluation), evaluation)])
}

/// Names a model in a table: its predictor and number of helpers.
pub(super) fn fitted(Evaluation { predictor, proxies, .. }: &Evaluation) -> String {
    format!("{predictor}, {}", counted(*proxies, "helper", "helpers"))
}

/// Writes the errors of named models on the same frames, below those of the baselines.
pub(super) fn evaluations(models: &[(String, &Evaluation)]) -> String {
    let Some((_, first)) = models.first() else { return String::new() };
    let own_weights = first.own_weights.as_ref().map(|own| (OWN_WEIGHTS, own));
    let baselines = std::iter::once((LBS, &first.lbs)).chain(own_weights);
    let mut head = ["error, % of the diagonal", "RMS", "p99", "max"].to_vec();
    if first.diagonal_mm.is_some() {
        head.extend(["RMS, mm", "p99, mm", "max, mm"]);
    }
    let mut rows: Vec<_> =
        baselines.clone().map(|(name, errors)| distances(name, errors)).collect();
    for (name, model) in models {
        rows.push(distances(name, &model.errors));
        rows.extend(model.regions.iter().filter(|region| region.kind == "mesh").map(of_mesh));
    }
    let own = models.iter().map(|(name, model)| (name.as_str(), &model.errors));
    let angles = baselines.chain(own).map(|(name, e)| {
        let angles = [e.normal_rms_degrees, e.normal_median_degrees, e.normal_p99_degrees];
        let cells = angles.into_iter().map(|angle| format!("{angle:.2}"));
        std::iter::once(name.to_owned()).chain(cells).collect()
    });
    let head_of_normals = ["normals, degrees", "RMS", "median", "p99"];
    let mut out = measured(first) + &table(&head, rows);
    out += &table(&head_of_normals, angles.collect());
    for (name, model) in models {
        let (name, indent) =
            if models.len() == 1 { ("the model", "") } else { (name.as_str(), "  ") };
        out += &format!("{name}: {} bytes", model.model_bytes);
        if let Some(share) = model.errors.share_of(&model.lbs) {
            out += &format!(", {:.1} % of LBS's RMS error", 100.0 * share);
        }
        let own_weights = model.own_weights.as_ref();
        if let Some(share) = own_weights.and_then(|own| model.errors.share_of(own)) {
            out += &format!(", {:.1} % of own weights'", 100.0 * share);
        }
        let Confidence { mean, least } = model.confidence;
        out += &format!(
            "\n{indent}confidence in the poses: {mean:.3} on average, {least:.3} at the least\n"
        );
    }
    out
}

/// Describes the measured frames.
fn measured(of: &Evaluation) -> String {
    let Evaluation { split, frames, vertices, diagonal, .. } = of;
    let is_read = of.read == Some(*frames);
    // Frames that training has read are neither held out nor new, whatever the split.
    let split = if *split == "all" || is_read { String::new() } else { format!("{split} ") };
    let read = match of.read {
        Some(_) if is_read => ", all of which training has read".to_owned(),
        Some(read) if read > 0 => format!(", of which training has read {read}"),
        Some(_) => ", none of which training has read".to_owned(),
        None => String::new(),
    };
    let mm = of.diagonal_mm.map_or(String::new(), |mm| format!(" ({} mm)", written(mm)));
    format!("{frames} {split}frames{read}; {vertices} vertices, diagonal {diagonal:.4}{mm}\n")
}

fn distances(name: &str, errors: &Errors) -> Vec<String> {
    let Errors { rms_percent, p99_percent, max_percent, millimetres, .. } = errors;
    let percents = [rms_percent, p99_percent, max_percent].map(|percent| format!("{percent:.4}"));
    let lengths = millimetres.iter().flat_map(|of| [of.rms_mm, of.p99_mm, of.max_mm].map(written));
    std::iter::once(name.to_owned()).chain(percents).chain(lengths).collect()
}

/// Returns the errors of a mesh of the character. Its length is in the column of RMS lengths.
fn of_mesh(region: &Region) -> Vec<String> {
    let mut cells = vec![format!("  {}", region.name), format!("{:.4}", region.rms_percent)];
    cells.extend(
        region.rms_mm.into_iter().flat_map(|mm| [String::new(), String::new(), written(mm)]),
    );
    cells
}
