//! `sinew check`: whether examples are good, before a training.

use crate::cli::bars::Bars;
use crate::cli::column::{padded, width};
use crate::cli::{Output, counted, input, printable};
use anyhow::Context;
use sinew_trainer::envelope::check::coverage::Coverage;
use sinew_trainer::envelope::check::finding::{Severity, Topic, short};
use sinew_trainer::envelope::check::thin::Predicted;
use sinew_trainer::envelope::check::{Check, check};
use sinew_trainer::examples::Warning;
use std::fmt::Write;

/// Tells whether EXAMPLES are good: what is wrong with mesh, skeleton and frames, how far the
/// training poses reach, and which poses to add or to leave out.
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
    its vertices.")]
pub(in crate::cli) struct Arguments {
    #[command(flatten)]
    input: input::ExampleArguments,
}

/// Joints in the table; `--json` has all.
const ROWS: usize = 16;

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let input = arguments.input.load(output)?;
    let source = arguments.input.named();
    let checked = check(&input.examples, &input.clips, &Bars::new(output)).context(source)?;
    let told: &[Warning] = if output.quiet { &[] } else { &input.warnings };
    let text = format!("{}\n{}", input::describe(&input.examples), describe(&checked, told));
    output.print(&checked, &text)
}

/// Describes a check of examples, of which so much was told before.
fn describe(check: &Check, told: &[Warning]) -> String {
    let mut out = String::new();
    for (subject, title, facts) in [
        (Topic::Size, "size", size(check)),
        (Topic::Rest, "rest mesh", check.rest.describe()),
        (Topic::Faces, "faces", faces(check)),
        (Topic::Joints, "joints", String::new()),
        (Topic::Frames, "frames", String::new()),
    ] {
        section(&mut out, check, subject, title, &facts);
    }
    out += &table(&check.joints);
    out += &floor(check);
    if let Some(predicted) = &check.predicted {
        out += &poses(predicted);
    }
    out += "advice\n";
    for line in &check.advice {
        let _ = writeln!(out, "  {}", printable(line));
    }
    if check.advice.is_empty() {
        out += "  the poses are enough and none is superfluous\n";
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

fn section(out: &mut String, check: &Check, subject: Topic, title: &str, facts: &str) {
    let findings: Vec<_> =
        check.findings.iter().filter(|finding| finding.kind.subject() == subject).collect();
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

fn size(check: &Check) -> String {
    let size = &check.size;
    let [x, y, z] = size.extents.map(short);
    let mut out = format!("{x} x {y} x {z}, diagonal {}", short(size.diagonal));
    match size.ground {
        Some(axis) => {
            let _ = write!(out, "; it stands on {axis} = 0: if that is the floor, {axis} is up");
        }
        None => {
            let _ = write!(out, "; longest along {}", size.longest);
        }
    }
    for (unit, metres) in &size.units {
        let _ = write!(out, "; {metres:.2} m long if in {unit}");
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
fn table(joints: &[Coverage]) -> String {
    let mut rows: Vec<&Coverage> = joints.iter().collect();
    rows.sort_by(|a, b| b.lbs_percent.total_cmp(&a.lbs_percent));
    let longest = rows.iter().take(ROWS).map(|row| width(&row.joint)).max().unwrap_or(0);
    let columns = longest.max("joint".len());
    let mut out = format!(
        "{:<columns$}  {:>8} {:>14} {:>8} {:>8} {:>7} {:>8} {:>8}\n",
        "joint", "vertices", "turns by", "beside", "slides", "poses", "beyond", "LBS, %"
    );
    for row in rows.iter().take(ROWS) {
        let [least, most] = row.twist;
        let slides = if row.slide_percent >= 0.05 {
            format!("{:.1} %", row.slide_percent)
        } else {
            "-".to_owned()
        };
        let _ = writeln!(
            out,
            "{}  {:>8} {:>14} {:>7}° {:>8} {:>7} {:>8} {:>8.4}",
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
    let list = |items: Vec<String>| items.join(", ");
    let frames = lbs.frames.iter().map(|(frame, rms)| format!("{frame} ({rms:.2})")).collect();
    let vertices = lbs.vertices.iter().map(|(vertex, rms)| format!("{vertex} ({rms:.2})"));
    let painted = lbs.painted_percent.map(|rms| {
        format!("  {rms:.4} % by the joint weights that come with the mesh, as they are\n")
    });
    format!(
        "LBS, 4 influences, training frames\n  {:.4} %; worst in frames {}; at vertices {}\n{}",
        lbs.rms_percent,
        printable(&list(frames)),
        list(vertices.collect()),
        painted.unwrap_or_default()
    )
}

fn poses(predicted: &Predicted) -> String {
    let Predicted { lbs_percent, expected_percent, enough, .. } = predicted;
    format!(
        "poses\n  frames are predicted by those of other blocks to {expected_percent:.4} %, {:.1} % of \
         what LBS leaves; {} of {} predict the rest\n",
        100.0 * expected_percent / lbs_percent,
        enough.len(),
        predicted.of_compared()
    )
}
