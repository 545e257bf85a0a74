//! Results as a person reads them.

use crate::cli::column::padded;
use crate::cli::counted;
use sinew_trainer::envelope::alike::{COEFFICIENTS_COST, SMALLER, UNSEEN};
use sinew_trainer::envelope::evaluate::{Confidence, Errors, Evaluation};
use sinew_trainer::envelope::rotational::Method;
use sinew_trainer::envelope::training_report::{CandidateReport, TrainingReport};
use sinew_trainer::space::written;

/// Describes the candidates, the choice and its errors on the training frames, of examples with this diagonal.
pub(super) fn report(report: &TrainingReport, diagonal_mm: Option<f64>) -> String {
    let length = |share: Option<f64>| share.zip(diagonal_mm).map(|(share, mm)| share * mm);
    let names = report.candidates.iter().map(|candidate| kind(candidate).len() + 1);
    let width = names.fold(22, usize::max);
    let [name, proxies, bytes, rms] = ["candidate", "proxies", "bytes", "cross-validated, %"];
    let mm = in_mm(diagonal_mm, "mm".to_owned());
    let mut out = format!("{name:<width$}{proxies:>8}{bytes:>12}{rms:>20}{mm}\n");
    let row = |candidate: &CandidateReport| (kind(candidate), candidate.proxies, candidate.bytes);
    for (index, candidate) in report.candidates.iter().enumerate() {
        // Several tries may end as one model.
        let is_repeated =
            report.candidates[..index].iter().any(|other| row(other) == row(candidate));
        if is_repeated && index != report.chosen {
            continue;
        }
        let mark = if index == report.chosen { " <- taken" } else { "" };
        let (bytes, rms) = match (candidate.bytes, candidate.validated_rms) {
            (Some(bytes), Some(rms)) => (bytes.to_string(), format!("{:.4}", 100.0 * rms)),
            _ => ("too many".to_owned(), "-".to_owned()),
        };
        let mm = length(candidate.validated_rms).map_or("-".to_owned(), written);
        let mm = in_mm(diagonal_mm, mm);
        let (name, proxies) = (kind(candidate), candidate.proxies);
        out += &format!("{name:<width$}{proxies:>8}{bytes:>12}{rms:>20}{mm}{mark}\n");
    }
    let best = report.candidates.iter().filter_map(|candidate| candidate.validated_rms);
    let best = best.min_by(f64::total_cmp).unwrap_or_default();
    let validated = report.chosen().validated_rms.unwrap_or_default();
    if validated > SMALLER * best.max(UNSEEN) {
        out += &format!(
            "the candidate with the least error lacks tangent coefficients, which make normals right: one\n\
             that has them is taken unless its error is {COEFFICIENTS_COST} times as large\n"
        );
    } else if validated > best {
        out += &format!(
            "errors within {:.0} %, or below {} %, are alike: the smallest file is taken, unrefined ones and\n\
             rotational ones last\n",
            100.0 * (SMALLER - 1.0),
            100.0 * UNSEEN
        );
    }
    let own = width + 20;
    let mm = in_mm(diagonal_mm, "mm".to_owned());
    out += &format!("{:<own$}{:>20}{mm}\n", "RMS error, training frames", "% of the diagonal");
    for (name, rms) in [
        ("LBS, 4 influences", report.lbs_rms),
        ("the model", report.training_rms),
        ("cross-validated", validated),
    ] {
        let mm = in_mm(diagonal_mm, length(Some(rms)).map_or(String::new(), written));
        out += &format!("{name:<own$}{:>20.4}{mm}\n", 100.0 * rms);
    }
    out
}

/// A cell of a column of millimetres, which a table has where the unit is known.
fn in_mm(diagonal_mm: Option<f64>, cell: String) -> String {
    diagonal_mm.map_or(String::new(), |_| format!("{cell:>12}"))
}

fn kind(candidate: &CandidateReport) -> String {
    let predictor = if candidate.proxies == 0 { "joints alone (LBS)" } else { candidate.predictor };
    let method = match candidate.method {
        Some(Method::Published) => ", as published",
        Some(Method::Unrefined) => ", unrefined",
        Some(Method::Refined) | None => "",
    };
    // What they buy are normals; said only of those that the budget left without.
    let bare = if candidate.tangent_coefficients { "" } else { ", cofactors" };
    format!("{predictor}{method}{bare}")
}

/// Describes a measurement, with LBS beside it.
pub(super) fn evaluation(evaluation: &Evaluation) -> String {
    let Evaluation { split, frames, vertices, diagonal, model_bytes, predictor, proxies, .. } =
        evaluation;
    let is_read = evaluation.read == Some(*frames);
    // What training has read is neither held out nor new, whatever was asked for.
    let of = if *split == "all" || is_read { String::new() } else { format!("{split} ") };
    let read = match evaluation.read {
        Some(_) if is_read => ", all of which training has read".to_owned(),
        Some(read) if read > 0 => format!(", of which training has read {read}"),
        Some(_) => ", none of which training has read".to_owned(),
        None => String::new(),
    };
    let mm = evaluation.diagonal_mm.map_or(String::new(), |mm| format!(" ({} mm)", written(mm)));
    let mut out =
        format!("{frames} {of}frames{read}; {vertices} vertices, diagonal {diagonal:.4}{mm}\n");
    let predictor = format!("{predictor}, {}", counted(*proxies, "proxy", "proxies"));
    let both = [("LBS, 4 influences", &evaluation.lbs), (&*predictor, &evaluation.errors)];
    let mut head = ["RMS", "p99", "max"].to_vec();
    if evaluation.diagonal_mm.is_some() {
        head.extend(["RMS, mm", "p99, mm", "max, mm"]);
    }
    out += &row("error, % of the diagonal", head.into_iter().map(str::to_owned));
    for (name, Errors { rms_percent, p99_percent, max_percent, millimetres, .. }) in both {
        let percents =
            [rms_percent, p99_percent, max_percent].map(|percent| format!("{percent:.4}"));
        let lengths = millimetres.map(|of| [of.rms_mm, of.p99_mm, of.max_mm].map(written));
        out += &row(name, percents.into_iter().chain(lengths.into_iter().flatten()));
    }
    for region in evaluation.regions.iter().filter(|region| region.kind == "mesh") {
        let percent = format!("{:.4}", region.rms_percent);
        // The length stands in the column of RMS lengths.
        let length = region.rms_mm.map(|mm| [String::new(), String::new(), written(mm)]);
        let cells = std::iter::once(percent).chain(length.into_iter().flatten());
        out += &row(&format!("  {}", region.name), cells);
    }
    out += &row("normals, degrees", ["RMS", "median", "p99"].into_iter().map(str::to_owned));
    for (name, e) in both {
        let angles = [e.normal_rms_degrees, e.normal_median_degrees, e.normal_p99_degrees];
        out += &row(name, angles.into_iter().map(|angle| format!("{angle:.2}")));
    }
    let share = evaluation.errors.share_of(&evaluation.lbs);
    let Confidence { mean, least } = evaluation.confidence;
    out += &format!("confidence in the poses: {mean:.3} on average, {least:.3} at the least\n");
    out += &format!("the model: {model_bytes} bytes");
    if let Some(share) = share {
        out += &format!(", {:.1} % of LBS's RMS error", 100.0 * share);
    }
    out + "\n"
}

/// A row of a measurement's tables.
fn row(name: &str, cells: impl Iterator<Item = String>) -> String {
    let cells = cells.map(|cell| format!("{cell:>11}")).collect::<String>();
    padded(name, 26) + &cells + "\n"
}
