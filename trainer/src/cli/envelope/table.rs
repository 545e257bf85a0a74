//! Results as a person reads them.

use crate::cli::column::padded;
use crate::cli::counted;
use sinew_trainer::envelope::alike::{COEFFICIENTS_COST, SMALLER, UNSEEN};
use sinew_trainer::envelope::evaluate::{Confidence, Errors, Evaluation};
use sinew_trainer::envelope::rotational::Method;
use sinew_trainer::envelope::training_report::{CandidateReport, TrainingReport};

/// Describes what was tried, what was taken, and how it does on the training frames.
pub(super) fn report(report: &TrainingReport) -> String {
    let [name, proxies, bytes, rms] =
        ["candidate", "proxies", "bytes", "cross-validated error, % of the diagonal"];
    let names = report.candidates.iter().map(|candidate| kind(candidate).len() + 1);
    let width = names.fold(22, usize::max);
    let mut out = format!("{name:<width$}{proxies:>8}{bytes:>12}   {rms}\n");
    for (index, candidate) in report.candidates.iter().enumerate() {
        let mark = if index == report.chosen { " <- taken" } else { "" };
        let (bytes, rms) = match (candidate.bytes, candidate.validated_rms) {
            (Some(bytes), Some(rms)) => (bytes.to_string(), format!("{:.4}", 100.0 * rms)),
            _ => ("too many".to_owned(), "-".to_owned()),
        };
        let (name, proxies) = (kind(candidate), candidate.proxies);
        out += &format!("{name:<width$}{proxies:>8}{bytes:>12}   {rms}{mark}\n");
    }
    let best = report.candidates.iter().filter_map(|candidate| candidate.validated_rms);
    let best = best.min_by(f64::total_cmp).unwrap_or_default();
    let validated = report.chosen().validated_rms.unwrap_or_default();
    if validated > SMALLER * best.max(UNSEEN) {
        out += &format!(
            "what errs least is without tangent coefficients, by which normals are right: it is taken where what has them \
             errs {COEFFICIENTS_COST} times as much\n"
        );
    } else if validated > best {
        out += &format!(
            "errors within {:.0} %, or below {} %, are alike: the smallest file is taken, unrefined ones and rotational ones last\n",
            100.0 * (SMALLER - 1.0),
            100.0 * UNSEEN
        );
    }
    out += "training frames       error, % of the diagonal\n";
    for (name, rms) in [
        ("LBS, 4 influences", report.lbs_rms),
        ("the model", report.training_rms),
        ("cross-validated", validated),
    ] {
        out += &format!("{name:<22}{:.4}\n", 100.0 * rms);
    }
    out
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
    let mut out =
        format!("{frames} {of}frames{read}; {vertices} vertices, diagonal {diagonal:.4}\n");
    let header = ["error, % of the diagonal", "RMS", "p99", "max", "normals, RMS", "median", "p99"];
    let [name, rms, p99, max, normals, median, normals_p99] = header;
    out += &format!(
        "{name:<26}{rms:>10}{p99:>10}{max:>10}{normals:>16}{median:>11}{normals_p99:>11}\n"
    );
    let predictor = format!("{predictor}, {}", counted(*proxies, "proxy", "proxies"));
    for (name, e) in [("LBS, 4 influences", &evaluation.lbs), (&predictor, &evaluation.errors)] {
        let Errors { rms_percent, p99_percent, max_percent, .. } = e;
        let Errors { normal_rms_degrees, normal_median_degrees, normal_p99_degrees, .. } = e;
        out += &format!(
            "{name:<26}{rms_percent:>10.4}{p99_percent:>10.4}{max_percent:>10.4}\
             {normal_rms_degrees:>14.2} °{normal_median_degrees:>9.2} °{normal_p99_degrees:>9.2} °\n"
        );
    }
    for region in evaluation.regions.iter().filter(|region| region.kind == "mesh") {
        let name = padded(&format!("  {}", region.name), 26);
        out += &format!("{name}{:>10.4}\n", region.rms_percent);
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
