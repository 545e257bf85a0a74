//! The matrix as Markdown, and as a page in one file.

use super::table::{Column, Matrix, Row, grouped, ratio};
use std::fmt::Write;

const STYLE: &str = include_str!("style.css");

/// Returns a Markdown table of every backend, device and stage, with the failures below.
pub fn markdown(matrix: &Matrix) -> String {
    let mut out = String::from(
        "| backend | device | stage | cases | bits differing | largest deviation |\n\
         |---|---|---|--:|--:|--:|\n",
    );
    let mut failures = String::new();
    for column in &matrix.backends {
        let device = table_cell(&format!("{}, {}", column.device, column.driver));
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
                let failure = table_cell(failure);
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

/// Returns the page.
pub fn page(matrix: &Matrix) -> String {
    let verdict = if matrix.holds() {
        "Every stage is within its tolerance on every device."
    } else {
        "<b class=\"fails\">Not every stage holds.</b>"
    };
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n\
         <title>Conformance of Sinew {version}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <main>\n<h1>Conformance of Sinew {version}</h1>\n\
         <p class=\"under\">{models} models, {poses} poses; {kernels} kernels, {queries} queries</p>\n\
         <p class=\"verdict\">{verdict}</p>\n{table}{failures}{legend}</main>\n</body>\n</html>\n",
        version = matrix.version,
        models = matrix.model_len,
        poses = grouped(matrix.pose_len),
        kernels = matrix.kernel_len,
        queries = grouped(matrix.query_len),
        table = table(&matrix.backends),
        failures = failures(&matrix.backends),
        legend = LEGEND,
    )
}

const LEGEND: &str = "<section>\n<h2>How to read it</h2>\n\
    <p>A cell is a stage on a device. The large figure is the largest deviation from the f64 oracle \
    in units of the tolerance: 1 is the most that IEEE arithmetic, or on GPUs the precision that \
    Vulkan and WGSL promise, can explain. The line under it counts the values whose bits are not \
    those of the CPU on the same inputs, of all that were compared.</p>\n\
    <p>Each stage runs alone, on inputs that the CPU has made; <i>whole</i> goes from a pose to \
    palettes, confidences and the skin; <i>kernel</i> from a query to outputs and their confidence.</p>\n</section>\n";

/// Returns the table: a row for each stage, a column for each device.
fn table(columns: &[Column]) -> String {
    let mut stages: Vec<&str> = Vec::new();
    for row in columns.iter().flat_map(|column| &column.stages) {
        if !stages.contains(&row.stage) {
            stages.push(row.stage);
        }
    }
    let mut out = String::from("<div class=\"wide\"><table>\n<thead><tr><th></th>");
    for Column { api, device, driver, .. } in columns {
        let (device, driver) = (text(device), text(driver));
        let _ = write!(out, "<th scope=\"col\"><b>{api}</b>{device}<br>{driver}</th>");
    }
    out += "</tr></thead>\n<tbody>\n";
    for stage in stages {
        let _ = write!(out, "<tr><th scope=\"row\">{stage}</th>");
        for column in columns {
            let row = column.stages.iter().find(|row| row.stage == stage);
            out += &row.map_or_else(|| "<td></td>".to_owned(), cell);
        }
        out += "</tr>\n";
    }
    out + "</tbody>\n</table></div>\n"
}

fn cell(row: &Row) -> String {
    let class = match row {
        Row { failure: Some(_), .. } => "fails",
        Row { differing: 0, .. } => "same",
        _ => "holds",
    };
    let cases = grouped(row.cases);
    let bits = match row.differing {
        0 => format!("none of {cases} differs"),
        differing => format!("{} of {cases} differ", grouped(differing)),
    };
    format!("<td class=\"{class}\"><b>{}</b>{bits}</td>", ratio(row.worst))
}

fn failures(columns: &[Column]) -> String {
    let mut out = String::new();
    for column in columns {
        for row in &column.stages {
            if let Some(failure) = &row.failure {
                let (device, failure) = (text(&column.device), text(failure));
                let (api, stage) = (column.api, row.stage);
                let _ = writeln!(out, "<li><b>{api}, {device}, {stage}</b>: {failure}</li>");
            }
        }
    }
    if out.is_empty() { out } else { format!("<h2>What fails</h2>\n<ul>\n{out}</ul>\n") }
}

/// Escapes text for HTML: names come from drivers and may hold anything.
fn text(text: &str) -> String {
    text.chars().fold(String::new(), |mut out, character| {
        match character {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            c if c.is_control() => out.extend(c.escape_default()),
            c => out.push(c),
        }
        out
    })
}

/// Escapes text for a Markdown cell: names come from drivers.
fn table_cell(text: &str) -> String {
    text.replace('|', "\\|").replace(['\n', '\r'], " ")
}
