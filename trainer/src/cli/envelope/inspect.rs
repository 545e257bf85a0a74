//! `sinew inspect`: what a model file holds.

use crate::cli::{Output, input, printable, space, table};
use anyhow::Context;
use serde_json::{Value, json};
use sinew_runtime::format::{Element, PartKind, SectionKind};
use sinew_runtime::{Envelope, Model, Section, Skin};
use std::path::PathBuf;

/// Shows what MODEL holds: its parts (envelopes predict palettes, skins are meshes that follow them),
/// the axes and the unit of its numbers, its bytes by section, and its accuracy certificate.
#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    /// A model that `sinew train` wrote
    model: PathBuf,
}

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let bytes = input::read_model(&arguments.model)?;
    let model = Model::from_bytes(bytes).with_context(|| arguments.model.display().to_string())?;
    let len = model.as_bytes().len();
    let mut text = format!("{}: {len} bytes\n", arguments.model.display());
    text += &format!("space: {}\n", space::describe(&model.space()));
    model.envelopes().for_each(|envelope| text += &of_envelope(&envelope));
    model.skins().for_each(|skin| text += &of_skin(&model, &skin));
    let [section, part, element, bytes] = ["section", "part", "element", "bytes"];
    let names = part_names(&model);
    let width = names.iter().map(|name| name.chars().count()).max().unwrap_or(0).max(10) + 2;
    text += &format!("{section:<24}{part:<width$}{element:<8}{bytes:>12}\n");
    for section in model.sections() {
        let (kind, element) = (kind_name(&section), element_name(&section));
        let part = names.get(usize::from(section.row.part)).map_or("unknown", String::as_str);
        text += &format!("{kind:<24}{part:<width$}{element:<8}{:>12}\n", section.bytes.len());
    }
    text += &format!("{:<36}{:>12}\n", "head, tables and padding", around(&model));
    output.print(&as_json(&model), &text)
}

/// Counts the bytes that belong to no section.
fn around(model: &Model<Vec<u8>>) -> usize {
    let own: usize = model.sections().map(|section| section.bytes.len()).sum();
    model.as_bytes().len().saturating_sub(own)
}

/// Names the parts, each by its kind and its own name.
fn part_names(model: &Model<Vec<u8>>) -> Vec<String> {
    let kind = |row: sinew_runtime::format::PartRow| match PartKind::from_number(row.kind) {
        Some(kind) => kind.name().to_owned(),
        None => format!("unknown {}", row.kind),
    };
    let mut names: Vec<String> = model.parts().map(kind).collect();
    let envelopes = model.envelopes().map(|envelope| (envelope.part(), envelope.name()));
    let named: Vec<_> =
        envelopes.chain(model.skins().map(|skin| (skin.part(), skin.name()))).collect();
    for (part, name) in named {
        if let Some(whole) = names.get_mut(part) {
            *whole += &format!(" \"{}\"", printable(name));
        }
    }
    names
}

fn kind_name(section: &Section<'_>) -> String {
    SectionKind::from_number(section.row.kind)
        .map_or_else(|| format!("unknown {}", section.row.kind), |kind| kind.name().to_owned())
}

fn element_name(section: &Section<'_>) -> String {
    let known = Element::ALL.into_iter().find(|element| element.number() == section.row.element);
    known.map_or_else(
        || format!("unknown {}", section.row.element),
        |element| element.name().to_owned(),
    )
}

fn of_skin(model: &Model<Vec<u8>>, skin: &Skin<'_>) -> String {
    let follows = model.envelope_of(skin).map_or("follows no envelope".to_owned(), |envelope| {
        format!("follows envelope \"{}\"", printable(envelope.name()))
    });
    let mut out = format!(
        "skin \"{}\": {} vertices, {} influences a vertex, {}, {follows}\n",
        printable(skin.name()),
        skin.vertex_len(),
        skin.influence_len(),
        if skin.has_tangents() { "with tangents" } else { "without tangents" },
    );
    for (name, vertices) in skin.ranges() {
        let name = printable(name);
        out += &format!("  {name}: vertices {} to {}\n", vertices.start, vertices.end);
    }
    out
}

fn of_envelope(envelope: &Envelope<'_>) -> String {
    let mut out = format!(
        "envelope \"{}\", {}: {} joints, {}, a palette of {}, {} bytes of scratch\n",
        printable(envelope.name()),
        envelope.predictor().name(),
        envelope.joint_len(),
        table::count(envelope.proxy_len()),
        envelope.palette_len(),
        4 * envelope.scratch_len(),
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

fn as_json(model: &Model<Vec<u8>>) -> Value {
    let parts: Vec<Value> = model
        .parts()
        .map(|row| json!({ "kind": PartKind::from_number(row.kind).map(PartKind::name) }))
        .collect();
    let sections: Vec<Value> = model
        .sections()
        .map(|section| {
            json!({
                "kind": kind_name(&section),
                "part": section.row.part,
                "element": element_name(&section),
                "bytes": section.bytes.len(),
            })
        })
        .collect();
    json!({
        "bytes": model.as_bytes().len(),
        "space": space::as_json(&model.space()),
        "parts": parts,
        "envelopes": model.envelopes().map(|e| envelope_as_json(&e)).collect::<Vec<_>>(),
        "skins": model.skins().map(|skin| skin_as_json(&skin)).collect::<Vec<_>>(),
        "sections": sections,
        "other_bytes": around(model),
    })
}

fn skin_as_json(skin: &Skin<'_>) -> Value {
    let ranges: Vec<Value> = skin
        .ranges()
        .map(|(name, range)| json!({ "name": name, "start": range.start, "end": range.end }))
        .collect();
    json!({
        "part": skin.part(),
        "name": skin.name(),
        "envelope_part": skin.envelope_part(),
        "vertices": skin.vertex_len(),
        "influences": skin.influence_len(),
        "tangents": skin.has_tangents(),
        "ranges": ranges,
    })
}

fn envelope_as_json(envelope: &Envelope<'_>) -> Value {
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
        "part": envelope.part(),
        "name": envelope.name(),
        "predictor": envelope.predictor().name(),
        "proxies": envelope.proxy_len(),
        "palette": envelope.palette_len(),
        "scratch_bytes": 4 * envelope.scratch_len(),
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
}
