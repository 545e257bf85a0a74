//! `sinew inspect`: what a model file holds.

use super::{Output, input, print_json};
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
    if output.json {
        return print_json(&as_json(&model, bytes.len()));
    }
    println!("{}: {} bytes", arguments.model.display(), bytes.len());
    if let Some(envelope) = model.envelope() {
        print_envelope(&envelope);
    }
    println!("{:<24}{:<12}{:>12}", "section", "part", "bytes");
    for section in model.sections() {
        let (kind, part) = names(&model, section.row.kind, section.row.part);
        println!("{kind:<24}{part:<12}{:>12}", section.bytes.len());
    }
    Ok(())
}

fn print_envelope(envelope: &Envelope<'_>) {
    println!(
        "envelope \"{}\": {} vertices, {} joints, {} proxies, {} influences a vertex, {} bytes of \
         workspace",
        envelope.name(),
        envelope.vertex_len(),
        envelope.joint_len(),
        envelope.proxy_len(),
        envelope.influence_len(),
        4 * envelope.workspace_len(),
    );
    let certificate = envelope.certificate();
    let percent = |rms: f32| 100.0 * rms / certificate.diagonal;
    println!(
        "certificate, RMS in % of the diagonal {}: training {:.4}, cross-validated {:.4}, LBS on \
         the training frames {:.4}",
        certificate.diagonal,
        percent(certificate.training_rms),
        percent(certificate.cross_validated_rms),
        percent(certificate.lbs_training_rms),
    );
    println!("{:<24}{:<24}{:>12}", "joint", "parent", "trained to");
    for joint in 0..envelope.joint_len() {
        let parent = envelope.parent(joint).and_then(|p| envelope.joint_name(p));
        println!(
            "{:<24}{:<24}{:>10.1} °",
            envelope.joint_name(joint).unwrap_or_default(),
            parent.unwrap_or("-"),
            envelope.pose_range(joint).unwrap_or_default().to_degrees(),
        );
    }
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
        json!({
            "name": envelope.name(),
            "vertices": envelope.vertex_len(),
            "proxies": envelope.proxy_len(),
            "influences": envelope.influence_len(),
            "workspace_bytes": 4 * envelope.workspace_len(),
            "joints": joints,
            "certificate": {
                "diagonal": certificate.diagonal,
                "training_rms": certificate.training_rms,
                "cross_validated_rms": certificate.cross_validated_rms,
                "lbs_training_rms": certificate.lbs_training_rms,
            },
        })
    });
    json!({ "bytes": bytes, "envelope": envelope, "sections": sections })
}

fn names(model: &Model<'_>, kind: u16, part: u8) -> (String, String) {
    let section = SectionKind::from_number(kind)
        .map_or_else(|| format!("unknown {kind}"), |kind| kind.name().to_owned());
    let part = model.parts().nth(usize::from(part)).and_then(|row| PartKind::from_number(row.kind));
    (section, part.map_or_else(|| "unknown".to_owned(), |kind| kind.name().to_owned()))
}
