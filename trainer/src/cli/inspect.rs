//! `sinew inspect`: what a model file holds.

use super::{Output, input, printable, table};
use anyhow::Context;
use serde_json::{Value, json};
use sinew_runtime::format::{PartKind, SectionKind};
use sinew_runtime::{Envelope, Model};
use std::path::PathBuf;

/// Shows the parts of MODEL, its bytes by section, and its accuracy certificate.
#[derive(clap::Args)]
pub(super) struct Arguments {
    /// A model that `sinew train` wrote
    model: PathBuf,
}

pub(super) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let bytes = input::read_model(&arguments.model)?;
    let model = Model::from_bytes(&bytes).with_context(|| arguments.model.display().to_string())?;
    let mut text = format!("{}: {} bytes\n", arguments.model.display(), bytes.len());
    if let Some(envelope) = model.envelope() {
        text += &describe(&envelope);
    }
    text += &format!("{:<24}{:<12}{:>12}\n", "section", "part", "bytes");
    for section in model.sections() {
        let (kind, part) = names(&model, section.row.kind, section.row.part);
        text += &format!("{kind:<24}{part:<12}{:>12}\n", section.bytes.len());
    }
    text += &format!("{:<36}{:>12}\n", "head, tables and padding", around(&model, bytes.len()));
    output.print(&as_json(&model, bytes.len()), &text)
}

/// Counts the bytes that belong to no section.
fn around(model: &Model<'_>, bytes: usize) -> usize {
    bytes.saturating_sub(model.sections().map(|section| section.bytes.len()).sum())
}

fn describe(envelope: &Envelope<'_>) -> String {
    let mut out = format!(
        "envelope \"{}\", {}: {} vertices, {} joints, {}, {} influences a vertex, {} bytes of \
         workspace\n",
        printable(envelope.name()),
        envelope.predictor().name(),
        envelope.vertex_len(),
        envelope.joint_len(),
        table::count(envelope.proxy_len()),
        envelope.influence_len(),
        4 * envelope.workspace_len(),
    );
    let certificate = envelope.certificate();
    out += &format!("certificate: RMS error, % of the diagonal {:.4}\n", certificate.diagonal);
    for (name, rms) in [
        ("training frames", certificate.training_rms),
        ("cross-validated", certificate.cross_validated_rms),
        ("LBS, training frames", certificate.lbs_training_rms),
        ("rounding, at the most", certificate.correction_error),
    ] {
        out += &format!("{name:<24}{:.4}\n", 100.0 * rms / certificate.diagonal);
    }
    let joint_name = |joint| printable(envelope.joint_name(joint).unwrap_or_default());
    let longest = (0..envelope.joint_len()).map(|joint| joint_name(joint).chars().count()).max();
    let width = longest.unwrap_or(0).max(22) + 2;
    out += &format!("{:<width$}{:<width$}{:>12}\n", "joint", "parent", "trained to");
    for joint in 0..envelope.joint_len() {
        let parent = envelope.parent(joint).map_or("-".to_owned(), joint_name);
        let range = envelope.pose_range(joint).unwrap_or_default().to_degrees();
        out += &format!("{:<width$}{parent:<width$}{range:>10.1} °\n", joint_name(joint));
    }
    if envelope.group_len() > 0 {
        let [inputs, centres, rank, kernel] = ["inputs", "centres", "rank", "kernel"];
        out += &format!("{:<width$}proxies{inputs:>8}{centres:>9}{rank:>6}  {kernel}\n", "group");
    }
    for group in envelope.groups() {
        let (inputs, centres, rank) = (group.input_len(), group.centre_len(), group.rank());
        let (name, proxies, kernel) =
            (joint_name(group.joint), group.proxies.len(), group.kernel.name());
        out += &format!("{name:<width$}{proxies:>7}{inputs:>8}{centres:>9}{rank:>6}  {kernel}\n");
    }
    out
}

fn as_json(model: &Model<'_>, bytes: usize) -> Value {
    let sections: Vec<Value> = model
        .sections()
        .map(|section| {
            let (kind, part) = names(model, section.row.kind, section.row.part);
            json!({ "kind": kind, "part": part, "bytes": section.bytes.len() })
        })
        .collect();
    let envelope = model.envelope().map(|envelope| {
        let certificate = envelope.certificate();
        let joints: Vec<Value> = (0..envelope.joint_len())
            .map(|joint| {
                json!({
                    "name": envelope.joint_name(joint),
                    "parent": envelope.parent(joint),
                    "range": envelope.pose_range(joint),
                })
            })
            .collect();
        let groups: Vec<Value> = envelope
            .groups()
            .map(|group| {
                json!({
                    "joint": group.joint,
                    "proxies": group.proxies.len(),
                    "kernel": group.kernel.name(),
                    "inputs": group.input_len(),
                    "centres": group.centre_len(),
                    "rank": group.rank(),
                })
            })
            .collect();
        json!({
            "name": envelope.name(),
            "predictor": envelope.predictor().name(),
            "vertices": envelope.vertex_len(),
            "proxies": envelope.proxy_len(),
            "influences": envelope.influence_len(),
            "workspace_bytes": 4 * envelope.workspace_len(),
            "joints": joints,
            "groups": groups,
            "certificate": {
                "diagonal": certificate.diagonal,
                "training_rms": certificate.training_rms,
                "cross_validated_rms": certificate.cross_validated_rms,
                "lbs_training_rms": certificate.lbs_training_rms,
                "correction_error": certificate.correction_error,
            },
        })
    });
    json!({
        "bytes": bytes,
        "envelope": envelope,
        "sections": sections,
        "other_bytes": around(model, bytes),
    })
}

fn names(model: &Model<'_>, kind: u16, part: u8) -> (String, String) {
    let section = SectionKind::from_number(kind)
        .map_or_else(|| format!("unknown {kind}"), |kind| kind.name().to_owned());
    let part = model.parts().nth(usize::from(part)).and_then(|row| PartKind::from_number(row.kind));
    (section, part.map_or_else(|| "unknown".to_owned(), |kind| kind.name().to_owned()))
}
