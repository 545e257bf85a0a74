//! The matrix as Markdown.

use super::table::{Matrix, grouped, ratio};
use std::fmt::Write;

/// Writes a table of every backend, device and stage, and what failed under it.
pub fn markdown(matrix: &Matrix) -> String {
    let mut out = String::from(
        "| backend | device | stage | cases | bits differing | largest deviation |\n\
         |---|---|---|--:|--:|--:|\n",
    );
    let mut failures = String::new();
    for column in &matrix.backends {
        let device = cell(&format!("{}, {}", column.device, column.driver));
        for row in &column.stages {
            let mark = if row.failure.is_some() { " **fails**" } else { "" };
            let _ = writeln!(
                out,
                "| {} | {device} | {} | {} | {} | {}{mark} |",
                column.api,
                row.stage,
                grouped(row.cases),
                grouped(row.differing),
                ratio(row.worst)
            );
            if let Some(failure) = &row.failure {
                let failure = cell(failure);
                let _ = writeln!(failures, "- {}, {device}, {}: {failure}", column.api, row.stage);
            }
        }
    }
    let _ = writeln!(
        out,
        "\n{} models, {} poses; {} kernels, {} queries. Bits are compared with the CPU's; deviations from the f64 oracle, in \
         units of the tolerance: beyond 1 a stage fails.",
        matrix.model_len,
        grouped(matrix.pose_len),
        matrix.kernel_len,
        grouped(matrix.query_len)
    );
    if !failures.is_empty() {
        out += "\n";
        out += &failures;
    }
    out
}

/// Text that cannot end a cell: names come from drivers.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace(['\n', '\r'], " ")
}
