//! `sinew kernel eval` and `check`: a function at queries, and comparison with another solver.

use crate::cli::{ModelArgs, OfFile, Output, Report, Run, printable, table};
use crate::scattered::compat::{CaseReport, Cases, DEVIATION, RCOND};
use crate::scattered::model::{inputs_of, query_numbers};
use crate::scattered::problem::read_queries;
use anyhow::Context;
use serde_json::{Value, json};
use sinew_runtime::kernel::KernelMap;
use std::path::PathBuf;

/// Evaluates a function at queries, as an engine does
///
/// The runtime evaluates the function of MODEL in single precision.
///
/// QUERIES is JSON, rows of numbers (also as `queries`), or CSV whose columns have the inputs' names. The result is
/// CSV: a line for each query with the outputs and the confidence.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  sinew kernel eval wrist.sinew queries.json --jacobian")]
pub(in crate::cli) struct Eval {
    #[command(flatten)]
    model: ModelArgs,
    /// Places to evaluate: .json or .csv
    queries: PathBuf,
    /// Name of the function, if MODEL has several
    #[arg(long)]
    name: Option<String>,
    /// Print derivatives of the values by the query's numbers too
    #[arg(long)]
    jacobian: bool,
    /// Print the variance of the values too
    #[arg(long)]
    variance: bool,
}

impl Run for Eval {
    fn run(&self, _: Output) -> anyhow::Result<Report> {
        let model = self.model.load()?;
        let map = match &self.name {
            Some(name) => model.all::<KernelMap>().find(|map| map.name() == name.as_str()),
            None => model.all::<KernelMap>().next(),
        };
        let map = map.with_context(|| {
            let file = self.model.file.display();
            match &self.name {
                Some(name) => format!("{file}: it has no function \"{}\"", printable(name)),
                None => format!("{file}: it has no function; `sinew eval` evaluates envelopes"),
            }
        })?;
        let inputs = inputs_of(&map);
        let queries = read_queries(&self.queries, &inputs).of(&self.queries)?;
        let (mut results, mut csv) = (Vec::new(), String::new());
        for (row, query) in queries.iter().enumerate() {
            let at = || format!("{}: row {row}", self.queries.display());
            let query: Vec<f32> =
                query_numbers(&inputs, query).with_context(at)?.iter().map(|x| *x as f32).collect();
            let (result, numbers) = self.evaluate(&map, &query).with_context(at)?;
            results.push(result);
            csv += &numbers.iter().map(f32::to_string).collect::<Vec<_>>().join(",");
            csv += "\n";
        }
        let (values, row) = (map.counts().value_len as usize, map.query_len());
        let mut head = columns(&map);
        head.push("confidence".to_owned());
        if self.jacobian {
            let all = (0..values).flat_map(|value| (0..row).map(move |at| (value, at)));
            head.extend(all.map(|(value, at)| format!("d{value}/d{at}")));
        }
        if self.variance {
            head.extend((0..values).map(|value| format!("variance {value}")));
        }
        Ok(Report::default()
            .json("name", map.name())
            .json("columns", columns(&map))
            .json("results", results)
            .text(head.join(","))
            .text(csv))
    }
}

impl Eval {
    /// Evaluates a function at a query. Returns the result as JSON, and all its numbers.
    fn evaluate(&self, map: &KernelMap<'_>, query: &[f32]) -> anyhow::Result<(Value, Vec<f32>)> {
        let counts = map.counts();
        let values = counts.value_len as usize;
        let mut numbers = vec![0.0; map.result_len()];
        let mut scratch = vec![0.0; counts.scratch_len()];
        let confidence = map.evaluate(query, &mut scratch, &mut numbers)?;
        let mut result = json!({ "outputs": numbers, "confidence": confidence });
        numbers.push(confidence);
        if self.jacobian {
            let mut out = vec![0.0; values * query.len()];
            scratch.resize(counts.jacobian_scratch_len(), 0.0);
            map.jacobian(query, &mut scratch, &mut out)?;
            result["jacobian"] = json!(out.chunks(query.len().max(1)).collect::<Vec<_>>());
            numbers.extend(out);
        }
        if self.variance {
            let mut out = vec![0.0; values];
            scratch.resize(counts.variance_scratch_len(), 0.0);
            map.variance(query, &mut scratch, &mut out)
                .context("it holds no variance: train it with --variance")?;
            result["variance"] = json!(out);
            numbers.extend(out);
        }
        Ok((result, numbers))
    }
}

/// Compares this solver with cases of another solver
///
/// FILE has `cases`, each with `sites`, `values`, `queries`, `expected` and `options` with the names of SciPy's
/// RBFInterpolator.
///
/// The command fails if an output deviates by more than 1e-9 of its range although the system's reciprocal condition is
/// above 1e-10.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  sinew kernel check scipy.json")]
pub(in crate::cli) struct Check {
    /// Cases, as JSON
    file: PathBuf,
}

impl Run for Check {
    fn run(&self, _: Output) -> anyhow::Result<Report> {
        let text = std::fs::read(&self.file).of(&self.file)?;
        let found = Cases::read(&text).of(&self.file)?.check();
        let row = |case: &CaseReport| {
            let (figures, mark) = match (case.deviation, case.rcond) {
                (Some(deviation), Some(rcond)) => {
                    let mark = match (rcond > RCOND, deviation <= DEVIATION) {
                        (true, true) => "",
                        (true, false) => "<- too far",
                        (false, _) => "(ill-conditioned: not compared)",
                    };
                    ([deviation, rcond].map(|x| format!("{x:.1e}")), mark)
                }
                _ => (["-", "-"].map(str::to_owned), "skipped"),
            };
            let [deviation, rcond] = figures;
            vec![case.name.clone(), deviation, rcond, mark.to_owned()]
        };
        let skipped = found.cases.iter().filter_map(|case| {
            let why = case.skipped.as_deref()?;
            Some(printable(&format!("{} is skipped: {why}", case.name)) + "\n")
        });
        let rows = found.cases.iter().map(row).collect();
        let file = self.file.display();
        let failure = match found.failed {
            0 if found.passes() => None,
            0 => Some(format!("{file}: no case could be held")),
            failed => Some(format!("{file}: {failed} of {} cases are too far", found.held)),
        };
        let report = Report::of(&found)
            .text(table(&["case", "deviation", "rcond", ""], rows))
            .text(skipped.collect::<String>())
            .show("held", "cases compared", "")
            .text(format!("allowed deviation: {DEVIATION:.0e} of the range"))
            .show("failed", "cases too far", "")
            .show("ill_conditioned", "ill-conditioned", "")
            .show("skipped", "skipped", "");
        Ok(report.failing(failure))
    }
}

/// Returns the names of all output numbers.
pub(super) fn columns(map: &KernelMap<'_>) -> Vec<String> {
    let mut out = Vec::new();
    for (output, row) in map.outputs().enumerate() {
        let name = printable(map.output_name(output).unwrap_or_default());
        let parts: &[&str] = match row.kind.number_len() {
            1 => &[""],
            3 => &[".x", ".y", ".z"],
            _ => &[".x", ".y", ".z", ".w"],
        };
        out.extend(parts.iter().map(|part| format!("{name}{part}")));
    }
    out
}
