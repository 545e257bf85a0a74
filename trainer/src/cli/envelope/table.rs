//! Results as a person reads them.

use crate::cli::column::padded;
use crate::cli::counted;
use sinew_trainer::envelope::choose::report::{CandidateReport, TrainingReport};
use sinew_trainer::envelope::s3::Method;
use sinew_trainer::evaluate::{Confidence, Errors, Evaluation, LBS, OWN_WEIGHTS, Region};
use sinew_trainer::settings::{COEFFICIENTS_COST, TIED, UNSEEN};
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
    if validated > TIED * best.max(UNSEEN) {
        out += &format!(
            "the candidate with the least error lacks tangent coefficients, which make normals right: one\n\
             that has them is taken unless its error is {COEFFICIENTS_COST} times as large\n"
        );
    } else if validated > best {
        out += &format!(
            "errors within {:.0} %, or below {} %, are alike: the smallest file is taken\n",
            100.0 * (TIED - 1.0),
            100.0 * UNSEEN
        );
    }
    let own = width + 20;
    let mm = in_mm(diagonal_mm, "mm".to_owned());
    out += &format!("{:<own$}{:>20}{mm}\n", "RMS error, training frames", "% of the diagonal");
    let baselines = [(LBS, Some(report.lbs_rms)), (OWN_WEIGHTS, report.own_weights_rms)];
    let model = [
        ("the model", Some(report.training_rms)),
        ("forecast: more of these clips", Some(report.same_clips_rms)),
        ("forecast: another clip", report.other_clip_rms),
    ];
    for (name, rms) in baselines.into_iter().chain(model) {
        let Some(rms) = rms else { continue };
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

/// Describes a measurement of one model, with the baselines beside it.
pub(super) fn evaluation(evaluation: &Evaluation) -> String {
    evaluations(&[(fitted(evaluation), evaluation)])
}

/// What a model is, in a table: its predictor and how many proxies it has.
pub(super) fn fitted(Evaluation { predictor, proxies, .. }: &Evaluation) -> String {
    format!("{predictor}, {}", counted(*proxies, "proxy", "proxies"))
}

/// Describes measurements of models on the same frames, each with its name, and the baselines before them.
pub(super) fn evaluations(models: &[(String, &Evaluation)]) -> String {
    let Some((_, first)) = models.first() else { return String::new() };
    let Evaluation { split, frames, vertices, diagonal, .. } = first;
    let is_read = first.read == Some(*frames);
    // What training has read is neither held out nor new, whatever was asked for.
    let of = if *split == "all" || is_read { String::new() } else { format!("{split} ") };
    let read = match first.read {
        Some(_) if is_read => ", all of which training has read".to_owned(),
        Some(read) if read > 0 => format!(", of which training has read {read}"),
        Some(_) => ", none of which training has read".to_owned(),
        None => String::new(),
    };
    let mm = first.diagonal_mm.map_or(String::new(), |mm| format!(" ({} mm)", written(mm)));
    let mut out =
        format!("{frames} {of}frames{read}; {vertices} vertices, diagonal {diagonal:.4}{mm}\n");
    let width = models.iter().map(|(name, _)| name.chars().count() + 1).fold(26, usize::max);
    let row = |name: &str, cells: &[String]| {
        let cells = cells.iter().map(|cell| format!("{cell:>11}")).collect::<String>();
        padded(name, width) + &cells + "\n"
    };
    let distances = |name: &str, of: &Errors| {
        let Errors { rms_percent, p99_percent, max_percent, millimetres, .. } = of;
        let percents = [rms_percent, p99_percent, max_percent];
        let mut cells = percents.map(|percent| format!("{percent:.4}")).to_vec();
        cells.extend(
            millimetres.iter().flat_map(|of| [of.rms_mm, of.p99_mm, of.max_mm].map(written)),
        );
        row(name, &cells)
    };
    let of_mesh = |region: &Region| {
        let mut cells = vec![format!("{:.4}", region.rms_percent)];
        // The length stands in the column of RMS lengths.
        cells.extend(
            region.rms_mm.into_iter().flat_map(|mm| [String::new(), String::new(), written(mm)]),
        );
        row(&format!("  {}", region.name), &cells)
    };
    let mut head = ["RMS", "p99", "max"].to_vec();
    if first.diagonal_mm.is_some() {
        head.extend(["RMS, mm", "p99, mm", "max, mm"]);
    }
    out += &row("error, % of the diagonal", &Vec::from_iter(head.into_iter().map(str::to_owned)));
    let own_weights = first.own_weights.as_ref().map(|own| (OWN_WEIGHTS, own));
    let baselines = std::iter::once((LBS, &first.lbs)).chain(own_weights);
    out.extend(baselines.clone().map(|(name, errors)| distances(name, errors)));
    for (name, model) in models {
        out += &distances(name, &model.errors);
        out.extend(model.regions.iter().filter(|region| region.kind == "mesh").map(of_mesh));
    }
    out += &row("normals, degrees", &["RMS", "median", "p99"].map(str::to_owned));
    let own = models.iter().map(|(name, model)| (name.as_str(), &model.errors));
    for (name, e) in baselines.chain(own) {
        let angles = [e.normal_rms_degrees, e.normal_median_degrees, e.normal_p99_degrees];
        out += &row(name, &angles.map(|angle| format!("{angle:.2}")));
    }
    for (name, model) in models {
        let (name, under) =
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
            "\n{under}confidence in the poses: {mean:.3} on average, {least:.3} at the least\n"
        );
    }
    out
}
