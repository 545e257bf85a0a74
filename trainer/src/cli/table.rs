//! Results as a person reads them.

use sinew_trainer::envelope::rotational::Report;
use sinew_trainer::evaluate::{Errors, Evaluation};

/// Describes how a model was fitted: the curve over the near-rigid fraction, and what was chosen.
pub(super) fn report(report: &Report, proxies: usize) -> String {
    let mut out = "near-rigid vertices   cross-validated error, % of the diagonal\n".to_owned();
    let first = report.trials.first().map(|trial| trial.choice.anchors);
    for trial in &report.trials {
        if Some(trial.choice.anchors) == first && trial.choice.refinement.is_none() {
            let share = 100.0 * trial.choice.near_rigid_fraction;
            let score =
                trial.rms.map_or("singular".to_owned(), |rms| format!("{:.4}", 100.0 * rms));
            out += &format!("{share:>17.0} %   {score}\n");
        }
    }
    let choice = &report.choice;
    let (near_rigid, patch) = (choice.anchors.near_rigid, choice.anchors.patch);
    let share = 100.0 * choice.near_rigid_fraction;
    let refinement =
        choice.refinement.map_or("no refinement".to_owned(), |r| format!("refinement ridge {r:e}"));
    out += &format!(
        "chosen: {share:.0} % near-rigid, anchor of the near-rigid {near_rigid}, of the patches \
         {patch:e}, {refinement}\n"
    );
    out += "training frames                   error, % of the diagonal\n";
    for (name, rms) in [
        ("LBS, 4 influences".to_owned(), report.lbs_rms),
        (format!("{} fitted to each frame", count(proxies)), report.proxy_rms),
        ("predicted from the pose".to_owned(), report.training_rms),
        ("predicted, cross-validated".to_owned(), report.validated_rms),
    ] {
        out += &format!("{name:<34}{:.4}\n", 100.0 * rms);
    }
    out
}

/// Describes a measurement, with LBS beside it.
pub(super) fn evaluation(evaluation: &Evaluation) -> String {
    let Evaluation { split, frames, vertices, diagonal, model_bytes, predictor, proxies, .. } =
        evaluation;
    let of = if *split == "all" { String::new() } else { format!("{split} ") };
    let mut out = format!("{frames} {of}frames of {vertices} vertices, diagonal {diagonal:.4}\n");
    let header = ["error, % of the diagonal", "RMS", "p99", "max", "normals"];
    let [name, rms, p99, max, normals] = header;
    out += &format!("{name:<26}{rms:>10}{p99:>10}{max:>10}{normals:>12}\n");
    let predictor = format!("{predictor}, {}", count(*proxies));
    for (name, e) in [("LBS, 4 influences", &evaluation.lbs), (&predictor, &evaluation.errors)] {
        let Errors { rms_percent, p99_percent, max_percent, normal_rms_degrees, .. } = e;
        out += &format!(
            "{name:<26}{rms_percent:>10.4}{p99_percent:>10.4}{max_percent:>10.4}\
             {normal_rms_degrees:>10.2} °\n"
        );
    }
    let share = 100.0 * evaluation.errors.rms / evaluation.lbs.rms;
    out += &format!("the model: {model_bytes} bytes");
    if share.is_finite() {
        out += &format!(", {share:.1} % of LBS's RMS error");
    }
    out + "\n"
}

/// Counts proxies.
pub(super) fn count(proxies: usize) -> String {
    if proxies == 1 { "1 proxy".to_owned() } else { format!("{proxies} proxies") }
}
