//! Section of trainings with more and fewer proxies.

use super::errors::{ERROR_HEADS, error_cells, legend};
use crate::evaluate::Errors;
use crate::page::chart::{Chart, Range};
use crate::page::html::{below, grouped, paragraph, percent, table, text};
use crate::report::comparison::Comparison;
use crate::report::sizes::{Outcome, Sizes};
use crate::{Error, ErrorKind};

const SIZE: (f64, f64) = (550.0, 250.0);

/// Charts and a table of trainings with several numbers of proxies, and the times of their steps.
pub(super) fn errors(comparison: &Comparison<'_>, sizes: &Result<Sizes, Error>) -> String {
    let predictor = comparison.model.character.envelope.predictor().name();
    let sizes = match sizes {
        Err(error) => {
            let needs = " This section needs the training frames of the model among the examples.";
            let why = if error.kind() == ErrorKind::Fit { needs } else { "" };
            return paragraph(&format!(
                "On these examples {predictor} cannot be trained: {}.{why}",
                text(&error.to_string())
            ));
        }
        Ok(sizes) if sizes.trials.is_empty() => {
            return paragraph("The model has no helpers: its palette is the joints alone.");
        }
        Ok(sizes) => sizes,
    };
    let outcomes: Vec<&Outcome> =
        sizes.trials.iter().filter_map(|(_, outcome)| outcome.as_ref().ok()).collect();
    let seen = match sizes.seen {
        true => {
            "They were trained on the measured frames, because the model has read no others: on these frames the error falls \
             with every helper. The forecast shows the gain in new poses."
        }
        false => "They have not read the measured frames.",
    };
    paragraph(&format!(
        "The predictor of {}, <b>{predictor}</b>, with other numbers of helpers: each trained on the training frames of \
         the model, as train does with --predictor {predictor} and no further options, and measured on the frames above. \
         {seen}",
        text(comparison.model.file.name)
    )) + &charts(comparison, &outcomes)
        + &trials(comparison, sizes)
        + &times(sizes, &outcomes)
}

fn charts(comparison: &Comparison<'_>, outcomes: &[&Outcome]) -> String {
    if outcomes.is_empty() {
        return String::new();
    }
    let other = comparison.other.as_ref().filter(|other| other.character.envelope.proxy_len() > 0);
    let other = other.map(|other| {
        let proxies = other.character.envelope.proxy_len() as f64;
        let kilobytes = other.file.bytes.len() as f64 / 1000.0;
        [(proxies, other.measured.errors().rms_percent), (proxies, kilobytes)]
    });
    let counts = outcomes.iter().map(|o| o.proxies as f64).chain(other.map(|of| of[0].0));
    let along = || Range::log(counts.clone());
    let of = |value: fn(&Outcome) -> f64| -> Vec<(f64, f64)> {
        outcomes.iter().map(|o| (o.proxies as f64, value(o))).collect()
    };
    let baselines = comparison.baseline_series();
    let baselines = baselines.iter().map(|own| (own.class, own.measured.errors().rms_percent));
    let baselines: Vec<_> = baselines.collect();
    let rms = of(|o| o.errors.rms_percent);
    let forecast = of(|o| o.forecast_percent);
    let every = rms.iter().chain(&forecast).map(|point| point.1);
    let every = every.chain(baselines.iter().map(|baseline| baseline.1));
    let every = every.chain(other.map(|of| of[0].1));
    let mut errors = Chart::new(SIZE, along(), Range::log(every));
    errors.sides("helpers (logarithmic)", "RMS error, % (logarithmic)");
    if let (Some(first), Some(last)) = (rms.first(), rms.last()) {
        for &(class, rms) in &baselines {
            errors.line(class, &[(first.0, rms), (last.0, rms)]);
        }
    }
    errors.line("model dashed", &forecast);
    errors.line("model", &rms);
    errors.dots("model", &rms);
    let bytes = of(|o| o.bytes as f64 / 1000.0);
    let every = bytes.iter().chain(other.as_ref().map(|of| &of[1]));
    let most = every.map(|point| point.1).fold(0.0, f64::max);
    let mut size = Chart::new(SIZE, along(), Range::linear(0.0, 1.1 * most));
    size.sides("helpers (logarithmic)", "file, kB");
    size.line("model", &bytes);
    size.dots("model", &bytes);
    for (chart, place) in [(&mut errors, 0), (&mut size, 1)] {
        other.iter().for_each(|of| chart.dots("other", &of[place..=place]));
        outcomes.iter().for_each(|o| chart.mark(o.proxies as f64, &o.proxies.to_string()));
    }
    legend(&comparison.series())
        + "<div class=\"pair\">"
        + &errors.finish("RMS error against the number of helpers")
        + &size.finish("size of the file against the number of helpers")
        + "</div>\n"
        + &paragraph("Dashed: forecast for more of the training clips.")
}

fn trials(comparison: &Comparison<'_>, sizes: &Sizes) -> String {
    let head = [&["helpers"][..], &ERROR_HEADS, &["forecast", "file", "training"]].concat();
    let row = |name: String, errors: &Errors, forecast: f64, bytes: usize, seconds: String| {
        let mut row = vec![name];
        row.extend(error_cells(errors));
        let forecast = format!("{} %{}", percent(forecast), below(comparison.mm(forecast)));
        row.extend([forecast, format!("{} B", grouped(bytes)), seconds]);
        row
    };
    let trial = |(proxies, outcome): &(usize, Result<Outcome, Error>)| match outcome {
        Ok(of) => {
            let seconds = format!("{:.1} s", of.seconds);
            row(of.proxies.to_string(), &of.errors, of.forecast_percent, of.bytes, seconds)
        }
        Err(error) => vec![proxies.to_string(), text(&error.to_string())],
    };
    let other = comparison.other.as_ref().map(|other| {
        let name = format!("{} ({})", other.character.envelope.proxy_len(), text(other.file.name));
        let certificate = other.character.envelope.certificate();
        let forecast = 100.0 * f64::from(certificate.same_clips_rms / certificate.diagonal);
        let (errors, bytes) = (other.measured.errors(), other.file.bytes.len());
        row(name, &errors, forecast, bytes, String::new())
    });
    let rows: Vec<_> = sizes.trials.iter().map(trial).chain(other).collect();
    table(&head, &rows)
}

fn times(sizes: &Sizes, outcomes: &[&Outcome]) -> String {
    let mut names: Vec<&str> = Vec::new();
    for (name, _) in outcomes.iter().flat_map(|outcome| &outcome.steps) {
        if !names.contains(name) {
            names.push(name);
        }
    }
    let mut head = vec!["seconds of each step".to_owned()];
    head.extend(outcomes.iter().map(|o| format!("{} helpers", o.proxies)));
    let row = |name: &&str| {
        let mut row = vec![text(name)];
        row.extend(outcomes.iter().map(|outcome| {
            let step = outcome.steps.iter().find(|step| step.0 == *name);
            step.map_or(String::new(), |step| format!("{:.2}", step.1))
        }));
        row
    };
    let rows: Vec<_> = names.iter().map(row).collect();
    table(&head, &rows)
        + &paragraph(&format!(
            "Wall-clock time of this machine. Before them, and once for all: {:.2} s to read the \
             frames and to fit LBS.",
            sizes.shared_seconds
        ))
}
