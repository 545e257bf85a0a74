//! `sinew check`: whether examples are good, before a training.

use crate::cli::bars::Bars;
use crate::cli::column::{longest, padded, wrapped};
use crate::cli::{Output, counted, input, printable};
use anyhow::Context;
use sinew_runtime::format::Space;
use sinew_trainer::check::coverage::Coverage;
use sinew_trainer::check::finding::{Severity, Topic, short};
use sinew_trainer::check::redundancy::Predicted;
use sinew_trainer::check::{Check, check};
use sinew_trainer::evaluate::{LBS, NOTHING, OWN_WEIGHTS};
use sinew_trainer::examples::Warning;
use sinew_trainer::space::written;
use std::fmt::Write;

/// Checks examples before a training, and says what to mend or add
///
/// It finds faults of mesh, skeleton and frames, shows how far the training poses reach, and names poses to add or to
/// leave out.
///
/// A warning is likely a mistake that costs accuracy, a note is worth knowing. Findings name frames,
/// joints, vertices and triangles by the numbers of the file, from 0 (frames by what it calls them, where it
/// does); quads count as two triangles.
/// Neither changes the exit status.
#[derive(clap::Args)]
#[command(after_help = "Errors are in % of the rest pose's diagonal. Held-out and extreme frames \
    are read for their poses alone.\n\
    The table: how many vertices follow each joint most, how far it turns from rest against its \
    parent about its main axis and beside it, how far it slides, in how many distinct poses, how many \
    held-out or extreme frames go beyond (by more than 15°), and what linear blend skinning leaves of \
    its vertices.\n\
    LBS, fitted: linear blend skinning by 4 weights a vertex, fitted to the training frames. Own weights: by \
    those that come with the mesh, all of them; a vertex without any takes its fitted ones.")]
pub(in crate::cli) struct Arguments {
    #[command(flatten)]
    input: input::ExampleArguments,
}

/// Joints in the table; `--json` has all.
const ROWS: usize = 16;
/// Columns of the longest joint name in the table, which then fits a terminal.
const NAME: usize = 30;

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let input = arguments.input.load_to_check(output)?;
    let source = arguments.input.named();
    let checked = check(&input.examples, &input.clips, &Bars::new(output)).context(source)?;
    // The check says itself what validation finds.
    let is_told = |warning: &&Warning| !output.quiet && !warning.is_of_validation();
    let told: Vec<&Warning> = input.warnings.iter().filter(is_told).collect();
    let text = format!(
        "{}\n{}",
        input::describe(&input.examples),
        describe(&checked, &input.examples.space, &told)
    );
    output.print(&checked, &text)
}

/// Describes a check of examples, of which so much was told before.
fn describe(check: &Check, space: &Space, told: &[&Warning]) -> String {
    let mut out = String::new();
    for (topic, title, facts) in [
        (Topic::Size, "size", size(check, space)),
        (Topic::Rest, "rest mesh", check.rest.describe()),
        (Topic::Faces, "faces", faces(check)),
        (Topic::Joints, "joints", String::new()),
        (Topic::Frames, "frames", String::new()),
    ] {
        section(&mut out, check, topic, title, &facts);
    }
    out = wrapped(&out) + &table(check) + &wrapped(&floor(check));
    if let Some(predicted) = &check.predicted {
        out += &wrapped(&poses(predicted));
    }
    out += "advice\n";
    for line in &check.advice {
        out += &wrapped(&format!("  {}", printable(line)));
    }
    if check.advice.is_empty() {
        out += match check.lbs.rms_percent > NOTHING {
            true => "  the poses are enough and none is superfluous\n",
            false => "  linear blend skinning gives these meshes: there is nothing to learn\n",
        };
    }
    let count =
        |severity| check.count(severity) + told.iter().filter(|w| w.severity() == severity).count();
    let [warnings, notes] = [Severity::Warning, Severity::Note].map(count);
    let _ = writeln!(
        out,
        "{}, {}, {}",
        counted(warnings, "warning", "warnings"),
        counted(notes, "note", "notes"),
        counted(check.advice.len(), "piece of advice", "pieces of advice")
    );
    out
}

fn section(out: &mut String, check: &Check, topic: Topic, title: &str, facts: &str) {
    let findings: Vec<_> =
        check.findings.iter().filter(|finding| finding.kind.topic() == topic).collect();
    if facts.is_empty() && findings.is_empty() {
        return;
    }
    let _ = writeln!(out, "{title}");
    if !facts.is_empty() {
        let _ = writeln!(out, "  {}", printable(facts));
    }
    for finding in findings {
        let severity = match finding.severity {
            Severity::Warning => "warning",
            Severity::Note => "note",
        };
        let _ = writeln!(out, "  {severity}: {}", printable(&finding.text));
    }
}

fn size(check: &Check, space: &Space) -> String {
    let size = &check.size;
    let [x, y, z] = size.extents.map(short);
    let mut out = format!("{x} x {y} x {z}, diagonal {}", short(size.diagonal));
    let _ = match (space.up, size.ground) {
        (Some(up), _) => write!(out, "; {} is up", up.name()),
        (None, Some(axis)) => {
            write!(out, "; it stands on {axis} = 0: if that is the floor, {axis} is up")
        }
        (None, None) => write!(out, "; longest along {}", size.longest),
    };
    match size.metres {
        Some(metres) => {
            let _ = write!(out, "; {} m long", short(metres));
        }
        None => size.units.iter().for_each(|(unit, metres)| {
            let _ = write!(out, "; {metres:.2} m long if in {unit}");
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

/// The joints, those whose skin LBS leaves furthest off first.
fn table(check: &Check) -> String {
    let mut rows: Vec<&Coverage> = check.joints.iter().collect();
    rows.sort_by(|a, b| b.lbs_percent.total_cmp(&a.lbs_percent));
    let columns = longest(rows.iter().take(ROWS).map(|row| &*row.joint), "joint".len(), NAME);
    let mm = check.lbs.rms_mm.map_or(String::new(), |_| format!(" {:>9}", "LBS, mm"));
    let mut out = format!(
        "{:<columns$} {:>8} {:>12} {:>6} {:>7} {:>6} {:>6} {:>8}{mm}\n",
        "joint", "vertices", "turns by", "beside", "slides", "poses", "beyond", "LBS, %"
    );
    for row in rows.iter().take(ROWS) {
        let [least, most] = row.twist;
        let slides = if row.slide_percent >= 0.05 {
            format!("{:.1} %", row.slide_percent)
        } else {
            "-".to_owned()
        };
        let mm = row.lbs_mm.map_or(String::new(), |mm| format!(" {:>9}", written(mm)));
        let _ = writeln!(
            out,
            "{} {:>8} {:>12} {:>5}° {:>7} {:>6} {:>6} {:>8.4}{mm}",
            padded(&row.joint, columns),
            row.vertices,
            format!("{least:.0} to {most:.0}°"),
            format!("{:.0}", row.swing),
            slides,
            row.distinct,
            row.beyond.len(),
            row.lbs_percent
        );
    }
    if rows.len() > ROWS {
        let _ = writeln!(out, "and {} more with less error", rows.len() - ROWS);
    }
    out
}

fn floor(check: &Check) -> String {
    let lbs = &check.lbs;
    let beside = |mm: Option<f64>| mm.map_or(String::new(), |mm| format!(" ({} mm)", written(mm)));
    let mut out = format!(
        "RMS error, training frames\n  {LBS}: {:.4} %{}",
        lbs.rms_percent,
        beside(lbs.rms_mm)
    );
    // Where LBS leaves nothing, none is worse than another.
    if lbs.rms_percent > NOTHING {
        let frames = lbs.frames.iter().map(|(frame, rms)| format!("{frame} ({rms:.2} %)"));
        let vertices = lbs.vertices.iter().map(|(vertex, rms)| format!("{vertex} ({rms:.2} %)"));
        let [frames, vertices] =
            [frames.collect(), vertices.collect()].map(|all: Vec<_>| all.join(", "));
        let _ = write!(out, "; worst in frames {}; at vertices {vertices}", printable(&frames));
    }
    out += "\n";
    if let Some(rms) = lbs.own_weights_percent {
        let _ = writeln!(out, "  {OWN_WEIGHTS}: {rms:.4} %{}", beside(lbs.own_weights_mm));
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
