//! What `sinew inspect` says of functions.

use crate::cli::column::{longest, padded};
use crate::cli::described::Described;
use crate::cli::{counted, printable};
use serde_json::{Value, json};
use sinew_runtime::Model;
use sinew_runtime::format::PartKind;
use sinew_runtime::kernel::{KernelMap, OutputKind, OutputRow};

/// Columns of the longest name of an input or output.
const NAME: usize = 38;

/// Describes the functions of a file.
pub(in crate::cli) fn describe(model: &Model<Vec<u8>>) -> Vec<Described> {
    let described = |map: KernelMap<'_>| Described {
        part: map.part(),
        kind: PartKind::Kernel,
        name: map.name().to_owned(),
        text: as_text(&map),
        json: as_json(&map),
    };
    model.kernels().map(described).collect()
}

fn as_text(map: &KernelMap<'_>) -> String {
    let (counts, rule, fit) = (map.counts(), map.rule(), map.fit());
    let centres = counted(counts.centre_len as usize, "centre", "centres");
    let terms = counted(counts.term_len as usize, "polynomial term", "polynomial terms");
    let mut out = format!(
        "kernel \"{}\": {}, {centres}, {terms}{}, {} outside, {} bytes of scratch\n",
        printable(map.name()),
        rule.kernel.name(),
        if counts.metric_len > 0 { ", a metric" } else { "" },
        rule.query.name(),
        4 * counts.scratch_len(),
    );
    let mut names: Vec<[String; 2]> = Vec::new();
    for (input, row) in map.inputs().enumerate() {
        let name = printable(map.input_name(input).unwrap_or_default());
        let [x, y, z] = row.axis;
        let axis = if row.axis == [0.0; 3] { String::new() } else { format!(" of {x} {y} {z}") };
        names.push([format!("input {name}"), format!("{}{axis}", row.kind.name())]);
    }
    for (output, row) in map.outputs().enumerate() {
        let name = printable(map.output_name(output).unwrap_or_default());
        names.push([format!("output {name}"), format!("{}{}", row.kind.name(), kept(&row))]);
    }
    let columns = longest(names.iter().map(|[name, _]| &**name), 24, NAME) + 2;
    let padded = |name: &str| padded(name, columns - 2);
    names.iter().for_each(|[name, what]| out += &format!("  {}  {what}\n", padded(name)));
    for (name, figure) in [
        ("left at the samples, RMS", fit.rms_residual),
        ("samples left out, RMS", fit.left_out_rms),
        ("f32 may be off by, at worst", fit.rounding_error),
    ] {
        out += &format!("  {name:<columns$}  {figure:.3e}\n");
    }
    out
}

/// Says what keeps an output back.
fn kept(row: &OutputRow) -> String {
    let (low, high) = row.range;
    let free = row.kind != OutputKind::Scalar || (low, high) == (f32::MIN, f32::MAX);
    let range = if free { String::new() } else { format!(" from {low} to {high}") };
    let share = if row.is_marked { ", a share of a sum" } else { "" };
    range + share
}

fn as_json(map: &KernelMap<'_>) -> Value {
    let (counts, rule, fit) = (map.counts(), map.rule(), map.fit());
    let input = |(input, row): (usize, sinew_runtime::kernel::InputRow)| {
        json!({
            "name": map.input_name(input),
            "kind": row.kind.name(),
            "axis": (row.axis != [0.0; 3]).then_some(row.axis),
        })
    };
    let output = |(output, row): (usize, OutputRow)| {
        let is_scalar = row.kind == OutputKind::Scalar;
        json!({
            "name": map.output_name(output),
            "kind": row.kind.name(),
            "range": is_scalar.then_some([row.range.0, row.range.1]),
            "normalised": row.is_marked,
        })
    };
    json!({
        "part": map.part(),
        "name": map.name(),
        "kernel": rule.kernel.name(),
        "outside": rule.query.name(),
        "normalise": rule.normalise.name(),
        "centres": counts.centre_len,
        "terms": counts.term_len,
        "metric_rows": counts.metric_len,
        "query_numbers": map.query_len(),
        "result_numbers": map.result_len(),
        "scratch_bytes": 4 * counts.scratch_len(),
        "inputs": map.inputs().enumerate().map(input).collect::<Vec<_>>(),
        "outputs": map.outputs().enumerate().map(output).collect::<Vec<_>>(),
        "fit": {
            "rms_residual": fit.rms_residual,
            "left_out_rms": fit.left_out_rms,
            "rounding_error": fit.rounding_error,
            "reciprocal_condition": fit.reciprocal_condition,
        },
    })
}
