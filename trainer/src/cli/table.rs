//! Results as a person reads them.

use sinew_trainer::envelope::rotational::Report;
use sinew_trainer::evaluate::{Errors, Evaluation};

/// Prints how a model was fitted: the curve over the near-rigid fraction, and what was chosen.
pub(super) fn print_report(report: &Report, diagonal: f64, proxies: usize) {
    let percent = |rms: f64| 100.0 * rms / diagonal;
    println!("near-rigid vertices   cross-validated error, % of the diagonal");
    let first = report.trials.first().map(|trial| trial.choice.anchors);
    for trial in &report.trials {
        if Some(trial.choice.anchors) == first && trial.choice.refinement.is_none() {
            let share = 100.0 * trial.choice.near_rigid_fraction;
            match trial.rms {
                Some(rms) => println!("{share:>17.0} %   {:.4}", percent(rms)),
                None => println!("{share:>17.0} %   singular"),
            }
        }
    }
    let choice = &report.choice;
    let (gamma, mu) = (choice.anchors.near_rigid, choice.anchors.patch);
    let share = 100.0 * choice.near_rigid_fraction;
    let refinement =
        choice.refinement.map_or("none".to_owned(), |ridge| format!("ridge {ridge:e}"));
    println!("chosen: {share:.0} % near-rigid, anchors {gamma} and {mu}, refinement {refinement}");
    println!(
        "training error, % of the diagonal: LBS {:.4}, {proxies} proxies at best {:.4}, \
         predicted {:.4}, cross-validated {:.4}",
        percent(report.lbs_rms),
        percent(report.proxy_rms),
        percent(report.training_rms),
        percent(report.validated_rms),
    );
}

/// Prints a measurement beside LBS.
pub(super) fn print_evaluation(evaluation: &Evaluation) {
    let Evaluation { split, frames, vertices, diagonal, model_bytes, predictor, proxies, .. } =
        evaluation;
    println!("{frames} {split} frames of {vertices} vertices, diagonal {diagonal:.4}");
    println!(
        "{:<24}{:>10}{:>10}{:>10}{:>12}",
        "error, % of diagonal", "RMS", "p99", "max", "normals"
    );
    let row = |name: &str, e: &Errors| {
        println!(
            "{name:<24}{:>10.4}{:>10.4}{:>10.4}{:>10.2} °",
            e.rms_percent, e.p99_percent, e.max_percent, e.normal_rms_degrees
        );
    };
    row("LBS, 4 influences", &evaluation.lbs);
    row(&format!("{predictor}, {proxies} proxies"), &evaluation.errors);
    let share = evaluation.errors.rms / evaluation.lbs.rms;
    println!("the model leaves {:.1} % of LBS's error, in {model_bytes} bytes", 100.0 * share);
}
