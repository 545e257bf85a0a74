//! `sinew kernel eval`: a function at queries.

use crate::cli::{Output, input, printable};
use anyhow::Context;
use serde_json::{Value, json};
use sinew_runtime::Model;
use sinew_runtime::kernel::KernelMap;
use sinew_trainer::scattered::model::{inputs_of, query_numbers};
use sinew_trainer::scattered::problem::read_queries;
use std::path::PathBuf;

/// Evaluates a function at queries, as an engine does
///
/// The runtime evaluates the function of MODEL in single precision.
///
/// QUERIES is JSON, rows of numbers (also as `queries`), or CSV whose columns have the inputs' names.
/// The result is CSV: a line a query, the outputs and the confidence.
#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    /// A file that `sinew kernel train` wrote
    model: PathBuf,
    /// Where to evaluate: .json or .csv
    queries: PathBuf,
    /// Name of the function, where MODEL has several
    #[arg(long)]
    name: Option<String>,
    /// Also the derivatives of the values by a query's numbers
    #[arg(long)]
    jacobian: bool,
    /// Also the variance of the values
    #[arg(long)]
    variance: bool,
}

/// What the function gives at a query.
struct Answer {
    numbers: Vec<f32>,
    confidence: f32,
    jacobian: Option<Vec<f32>>,
    variance: Option<Vec<f32>>,
}

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let about = || arguments.model.display().to_string();
    let model = Model::from_bytes(input::read_model(&arguments.model)?).with_context(about)?;
    let map = match &arguments.name {
        Some(name) => model.kernels().find(|map| map.name() == name.as_str()),
        None => model.kernels().next(),
    };
    let map = map.with_context(|| match &arguments.name {
        Some(name) => format!("{}: it has no function \"{}\"", about(), printable(name)),
        None => format!("{}: it has no function; `sinew eval` evaluates envelopes", about()),
    })?;
    let inputs = inputs_of(&map);
    let said = || arguments.queries.display().to_string();
    let queries = read_queries(&arguments.queries, &inputs).with_context(said)?;
    let mut answers = Vec::with_capacity(queries.len());
    for (row, query) in queries.iter().enumerate() {
        let at = || format!("{}: row {row}", said());
        let numbers: Vec<f32> =
            query_numbers(&inputs, query).with_context(at)?.iter().map(|x| *x as f32).collect();
        answers.push(answer(&map, &numbers, arguments).with_context(at)?);
    }
    output.print(&as_json(&map, &answers), &as_csv(&map, &answers))
}

fn answer(map: &KernelMap<'_>, query: &[f32], asked: &Arguments) -> anyhow::Result<Answer> {
    let counts = map.counts();
    let values = counts.value_len as usize;
    let mut numbers = vec![0.0; map.result_len()];
    let mut scratch = vec![0.0; counts.scratch_len()];
    let confidence = map.evaluate(query, &mut scratch, &mut numbers)?;
    let mut jacobian = None;
    if asked.jacobian {
        let mut out = vec![0.0; values * query.len()];
        scratch.resize(counts.jacobian_scratch_len(), 0.0);
        map.jacobian(query, &mut scratch, &mut out)?;
        jacobian = Some(out);
    }
    let mut variance = None;
    if asked.variance {
        let mut out = vec![0.0; values];
        scratch.resize(counts.variance_scratch_len(), 0.0);
        map.variance(query, &mut scratch, &mut out)
            .context("it holds no variance: train it with --variance")?;
        variance = Some(out);
    }
    Ok(Answer { numbers, confidence, jacobian, variance })
}

/// Names the numbers of all outputs.
fn columns(map: &KernelMap<'_>) -> Vec<String> {
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

fn as_csv(map: &KernelMap<'_>, answers: &[Answer]) -> String {
    let mut head = columns(map);
    head.push("confidence".to_owned());
    if let Some(first) = answers.first() {
        let row = map.query_len().max(1);
        let jacobian = first.jacobian.iter().flatten().enumerate();
        head.extend(jacobian.map(|(at, _)| format!("d{}/d{}", at / row, at % row)));
        let variance = first.variance.iter().flatten().enumerate();
        head.extend(variance.map(|(at, _)| format!("variance {at}")));
    }
    let mut out = head.join(",") + "\n";
    for Answer { numbers, confidence, jacobian, variance } in answers {
        let all = numbers.iter().chain([confidence]);
        let all = all.chain(jacobian.iter().flatten()).chain(variance.iter().flatten());
        out += &(all.map(f32::to_string).collect::<Vec<_>>().join(",") + "\n");
    }
    out
}

fn as_json(map: &KernelMap<'_>, answers: &[Answer]) -> Value {
    let row = map.query_len().max(1);
    let answer = |answer: &Answer| {
        let mut out = json!({ "outputs": answer.numbers, "confidence": answer.confidence });
        if let Some(jacobian) = &answer.jacobian {
            out["jacobian"] = json!(jacobian.chunks(row).collect::<Vec<_>>());
        }
        if let Some(variance) = &answer.variance {
            out["variance"] = json!(variance);
        }
        out
    };
    json!({
        "name": map.name(),
        "columns": columns(map),
        "results": answers.iter().map(answer).collect::<Vec<_>>(),
    })
}
