//! `sinew check`: faults and gaps of examples, before a training.

use crate::check::coverage::{Coverage, CurveCoverage};
use crate::check::finding::{Severity, Topic, short};
use crate::check::redundancy::Predicted;
use crate::check::{Check, check};
use crate::cli::report::wrapped;
use crate::cli::{Bars, Output, Report, Run, counted, input, printable, table};
use crate::evaluate::{LBS, NEGLIGIBLE_PERCENT, OWN_WEIGHTS};
use crate::examples::Warning;
use crate::space::written;
use anyhow::Context;
use sinew_runtime::format::Space;

/// Checks examples before a training, and says what to mend or add
///
/// The check finds faults of mesh, skeleton and frames, shows how far the training poses reach, and names poses to add
/// or to leave out.
///
/// A warning is likely a mistake that costs accuracy; a note is good to know. Neither changes the exit status. Findings
/// name joints, vertices and triangles by their numbers in the file, from 0, and frames by the file's own numbers if it
/// has them. Quads count as two triangles.
#[derive(clap::Args)]
#[command(
    after_help = "Errors are in % of the rest pose's diagonal. Of held-out and extreme frames, \
    only the poses are read.\n\
    The table: number of vertices that follow each joint most; rotation from rest against its parent, about the main \
    axis and beside it; slide; factors of length, if a joint stretches; number of distinct poses; number of held-out or \
    extreme frames beyond them by more than 15°; error of linear blend skinning at its vertices.\n\
    The table of curves: range; number of distinct values; number of held-out or extreme frames beyond the range by more \
    than a tenth of it; share of the motion beyond linear blend skinning that a line in this curve alone explains.\n\
    LBS, fitted: linear blend skinning with 4 weights a vertex, fitted to the training frames. Own weights: all weights \
    that come with the mesh; a vertex without weights takes the fitted ones.\n\n\
    Example:\n  sinew check walk.glb --targets walk.abc"
)]
pub(in crate::cli) struct CheckArgs {
    #[command(flatten)]
    input: input::ExampleArguments,
}

/// Maximum number of joints, and of curves, in the tables; `--json` has all.
const ROWS: usize = 16;

impl Run for CheckArgs {
    fn run(&self, output: Output) -> anyhow::Result<Report> {
        // The check reports the findings of validation itself.
        let input = self.input.load(output, |warning| !warning.is_of_validation())?;
        let source = self.input.named();
        let checked = check(&input.examples, &input.clips, &Bars::new(output)).context(source)?;
        let is_printed = |warning: &&Warning| !output.quiet && !warning.is_of_validation();
        let printed: Vec<&Warning> = input.warnings.iter().filter(is_printed).collect();
        let text = describe(&checked, &input.examples.space, &printed);
        Ok(Report::of(&checked).text(input::describe(&input.examples)).text(text))
    }
}

/// Describes a check. The count of warnings includes those that were printed before.
fn describe(check: &Check, space: &Space, printed: &[&Warning]) -> String {
    let mut out = String::new();
    for (topic, title, facts) in [
        (Topic::Size, "size", size(check, space)),
        (Topic::Rest, "rest mesh", check.rest.describe()),
        (Topic::Faces, "faces", faces(check)),
        (Topic::Joints, "joints", String::new()),
        (Topic::Frames, "frames", String::new()),
    ] {
        out += &section(check, topic, title, &facts);
    }
    out = wrapped(&out) + &joints(check) + &curves(check) + &wrapped(&errors(check));
    if let Some(predicted) = &check.predicted {
        out += &wrapped(&poses(predicted));
    }
    out += "advice\n";
    for line in &check.advice {
        out += &wrapped(&format!("  {}", printable(line)));
    }
    if check.advice.is_empty() {
        out += match check.lbs.rms_percent > NEGLIGIBLE_PERCENT {
            true => "  the poses are enough and none is superfluous\n",
            false => "  linear blend skinning gives these meshes: there is nothing to learn\n",
        };
    }
    let count = |severity| {
        check.count(severity) + printed.iter().filter(|w| w.severity() == severity).count()
    };
    let [warnings, notes] = [Severity::Warning, Severity::Note].map(count);
    out + &format!(
        "{}, {}, {}\n",
        counted(warnings, "warning", "warnings"),
        counted(notes, "note", "notes"),
        counted(check.advice.len(), "piece of advice", "pieces of advice")
    )
}

/// Writes the facts and findings of a topic, under its title.
fn section(check: &Check, topic: Topic, title: &str, facts: &str) -> String {
    let findings = check.findings.iter().filter(|finding| finding.kind.topic() == topic);
    let findings = findings.map(|finding| match finding.severity {
        Severity::Warning => format!("warning: {}", finding.text),
        Severity::Note => format!("note: {}", finding.text),
    });
    let facts = Some(facts.to_owned()).filter(|facts| !facts.is_empty());
    let lines = facts.into_iter().chain(findings);
    let lines: String = lines.map(|line| format!("  {}\n", printable(&line))).collect();
    if lines.is_empty() { lines } else { format!("{title}\n{lines}") }
}

fn size(check: &Check, space: &Space) -> String {
    let size = &check.size;
    let [x, y, z] = size.extents.map(short);
    let mut out = format!("{x} x {y} x {z}, diagonal {}", short(size.diagonal));
    out += &match (space.up, size.ground) {
        (Some(up), _) => format!("; {} is up", up.name()),
        (None, Some(axis)) => {
            format!("; it stands on {axis} = 0: if that is the floor, {axis} is up")
        }
        (None, None) => format!("; longest along {}", size.longest),
    };
    match size.metres {
        Some(metres) => out += &format!("; {} m long", short(metres)),
        None => size.units.iter().for_each(|(unit, metres)| {
            out += &format!("; {metres:.2} m long if in {unit}");
        }),
    }
    out
}

fn faces(check: &Check) -> String {
    let faces = &check.faces;
    format!(
        "{}, {} edges, of them {} at a border",
        counted(faces.pieces, "piece", "pieces"),
        faces.edges,
        faces.border_edges
    )
}

/// Writes the table of joints, beginning with the largest errors of LBS.
fn joints(check: &Check) -> String {
    if check.joints.is_empty() {
        return String::new();
    }
    let mut rows: Vec<&Coverage> = check.joints.iter().collect();
    rows.sort_by(|a, b| b.lbs_percent.total_cmp(&a.lbs_percent));
    let stretches = check.joints.iter().any(|joint| joint.stretch != [1.0, 1.0]);
    let mut head = ["joint", "vertices", "turns by", "beside", "slides"].to_vec();
    head.extend(stretches.then_some("stretches"));
    head.extend(["poses", "beyond", "LBS, %"]);
    head.extend(check.lbs.rms_mm.map(|_| "LBS, mm"));
    let cells = |row: &&Coverage| {
        let [least, most] = row.twist;
        let slides = match row.slide_percent >= 0.05 {
            true => format!("{:.1} %", row.slide_percent),
            false => "-".to_owned(),
        };
        let mut cells = vec![
            row.joint.clone(),
            row.vertices.to_string(),
            format!("{least:.0} to {most:.0}°"),
            format!("{:.0}°", row.swing),
            slides,
        ];
        cells.extend(stretches.then(|| match row.stretch {
            [1.0, 1.0] => "-".to_owned(),
            [least, most] => format!("{least:.2} to {most:.2}"),
        }));
        cells.extend([row.distinct.to_string(), row.beyond.len().to_string()]);
        cells.push(format!("{:.4}", row.lbs_percent));
        cells.extend(row.lbs_mm.map(written));
        cells
    };
    let mut out = table(&head, rows.iter().take(ROWS).map(cells).collect());
    if rows.len() > ROWS {
        out += &format!("and {} more with less error\n", rows.len() - ROWS);
    }
    out
}

/// Writes the table of curves, beginning with the curves that explain most.
fn curves(check: &Check) -> String {
    if check.curves.is_empty() {
        return String::new();
    }
    let mut rows: Vec<&CurveCoverage> = check.curves.iter().collect();
    rows.sort_by(|a, b| b.explained_percent.total_cmp(&a.explained_percent));
    let cells = |row: &&CurveCoverage| {
        let [least, most] = row.range;
        vec![
            row.curve.clone(),
            format!("{least:.2} to {most:.2}"),
            row.distinct.to_string(),
            row.beyond.to_string(),
            format!("{:.1} %", row.explained_percent),
        ]
    };
    let head = ["curve", "range", "values", "beyond", "explains"];
    let mut out = table(&head, rows.iter().take(ROWS).map(cells).collect());
    if rows.len() > ROWS {
        out += &format!("and {} more that explain less\n", rows.len() - ROWS);
    }
    out
}

/// Writes the errors of LBS and of the mesh's own weights.
fn errors(check: &Check) -> String {
    let lbs = &check.lbs;
    let beside = |mm: Option<f64>| mm.map_or(String::new(), |mm| format!(" ({} mm)", written(mm)));
    let mut out = format!(
        "RMS error, training frames\n  {LBS}: {:.4} %{}",
        lbs.rms_percent,
        beside(lbs.rms_mm)
    );
    // Without an error of LBS, no frame is worse than another.
    if lbs.rms_percent > NEGLIGIBLE_PERCENT {
        let frames = lbs.frames.iter().map(|(frame, rms)| format!("{frame} ({rms:.2} %)"));
        let vertices = lbs.vertices.iter().map(|(vertex, rms)| format!("{vertex} ({rms:.2} %)"));
        let [frames, vertices] =
            [frames.collect(), vertices.collect()].map(|all: Vec<_>| all.join(", "));
        out += &format!("; worst in frames {}; at vertices {vertices}", printable(&frames));
    }
    out += "\n";
    if let Some(rms) = lbs.own_weights_percent {
        out += &format!("  {OWN_WEIGHTS}: {rms:.4} %{}\n", beside(lbs.own_weights_mm));
    }
    out
}

fn poses(predicted: &Predicted) -> String {
    let Predicted { lbs_percent, expected_percent, expected_mm, enough, .. } = predicted;
    let mm = expected_mm.map_or(String::new(), |mm| format!(" ({} mm)", written(mm)));
    format!(
        "poses\n  each block of frames is predicted by the others to {expected_percent:.4} %{mm}, {:.1} % of \
         the error of LBS; {} of {} predict the rest\n",
        100.0 * expected_percent / lbs_percent,
        enough.len(),
        predicted.describe_poses()
    )
}
