//! What `sinew inspect` says of envelopes and skins.

use crate::cli::column::{longest, padded};
use crate::cli::described::Described;
use crate::cli::{counted, printable};
use serde_json::{Value, json};
use sinew_runtime::format::PartKind;
use sinew_runtime::record::RecordCounts;
use sinew_runtime::{Envelope, Model, Skin};
use sinew_trainer::space::{millimetres, written};

/// Columns of the longest joint name: two of them, and a figure, fit a terminal.
const NAME: usize = 42;

/// Describes the envelopes of a file, its skins, and what it tells of their training.
pub(in crate::cli) fn describe(model: &Model<Vec<u8>>) -> Vec<Described> {
    let unit_mm = millimetres(&model.space());
    let envelopes = model.envelopes().map(|envelope| Described {
        part: envelope.part(),
        kind: PartKind::Envelope,
        name: envelope.name().to_owned(),
        text: of_envelope(&envelope, unit_mm),
        json: envelope_as_json(&envelope, unit_mm),
    });
    let skins = model.skins().map(|skin| Described {
        part: skin.part(),
        kind: PartKind::Skin,
        name: skin.name().to_owned(),
        text: of_skin(model, &skin),
        json: skin_as_json(&skin),
    });
    let records = model.records().map(|record| {
        let RecordCounts { frame_len, influence_len, .. } = record.counts();
        let lbs = if influence_len > 0 { ", and linear blend skinning fitted to them" } else { "" };
        Described {
            part: record.part(),
            kind: PartKind::Record,
            name: record.name().to_owned(),
            text: format!(
                "record of the training of \"{}\": {frame_len} frames{lbs}\n",
                printable(record.name())
            ),
            json: json!({
                "part": record.part(),
                "envelope": record.name(),
                "training_frames": frame_len,
                "lbs_influences": influence_len,
            }),
        }
    });
    envelopes.chain(skins).chain(records).collect()
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
    let coefficients = if skin.has_coefficients() { "tangent coefficients" } else { "cofactors" };
    if skin.envelope_part().is_some() {
        out += &format!("  normals by {coefficients}");
        if let Some(errors) = skin.normal_errors() {
            let [model, lbs] = errors.figures().map(f32::to_degrees);
            out += &format!(": off by {model:.2} °, LBS by {lbs:.2} °, RMS on the training frames");
        }
        out += "\n";
    }
    if skin.shape_len() > 0 {
        let element = skin.shape_element().name();
        out += &format!("  {} in {element}", counted(skin.shape_len(), "shape", "shapes"));
        if let Some(errors) = skin.shape_errors() {
            out += &format!(": off by {:.3e} at the most, {:.3e} RMS", errors.largest, errors.rms);
        }
        out += "\n";
    }
    for (name, vertices) in skin.ranges() {
        let name = printable(name);
        out += &format!("  {name}: vertices {} to {}\n", vertices.start, vertices.end);
    }
    out
}

fn of_envelope(envelope: &Envelope<'_>, unit_mm: Option<f64>) -> String {
    let mut out = format!(
        "envelope \"{}\", {}: {} joints, {}, a palette of {} transforms, {} bytes of scratch\n",
        printable(envelope.name()),
        envelope.predictor().name(),
        envelope.joint_len(),
        counted(envelope.proxy_len(), "proxy", "proxies"),
        envelope.palette_len(),
        4 * envelope.scratch_len(),
    );
    let certificate = envelope.certificate();
    out += &format!("diagonal of the rest mesh: {:.4} units\n", certificate.diagonal);
    out += &format!("{:<24}RMS error, % of the diagonal\n", "certificate");
    for (name, rms) in [
        ("training frames", Some(certificate.training_rms)),
        ("more of these clips", Some(certificate.same_clips_rms)),
        ("another clip", certificate.other_clip_rms),
        ("without its correction", Some(certificate.base_training_rms)),
        ("LBS, training frames", Some(certificate.lbs_training_rms)),
        ("rounding, bound", Some(certificate.correction_error)),
    ] {
        let Some(rms) = rms else { continue };
        let mm = unit_mm.map(|unit| format!("{:>12} mm", written(unit * f64::from(rms))));
        let percent = 100.0 * rms / certificate.diagonal;
        out += &format!("{name:<24}{percent:.4} %{}\n", mm.unwrap_or_default());
    }
    let joint_name = |joint| envelope.joint_name(joint).unwrap_or_default();
    let columns = longest((0..envelope.joint_len()).map(joint_name), 22, NAME) + 2;
    let column = |name: &str| padded(name, columns - 2) + "  ";
    out += &format!("{:<columns$}{:<columns$}{:>12}\n", "joint", "parent", "trained to");
    for joint in 0..envelope.joint_len() {
        let parent = column(envelope.parent(joint).map_or("-", joint_name));
        let range = envelope.pose_range(joint).unwrap_or_default().to_degrees();
        out += &format!("{}{parent}{range:>10.1} °\n", column(joint_name(joint)));
    }
    if envelope.group_len() > 0 {
        let [inputs, centres, rank, kernel] = ["inputs", "centres", "rank", "kernel"];
        out += &format!("{:<columns$}proxies{inputs:>8}{centres:>9}{rank:>6}  {kernel}\n", "group");
    }
    for group in envelope.groups() {
        let (inputs, centres, rank) = (group.input_len(), group.centre_len(), group.rank());
        let (name, proxies, kernel) =
            (column(joint_name(group.joint)), group.proxies.len(), group.kernel.name());
        out += &format!("{name}{proxies:>7}{inputs:>8}{centres:>9}{rank:>6}  {kernel}\n");
    }
    out
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
        "tangent_coefficients": skin.has_coefficients(),
        "mesh_hash": skin.mesh_hash(),
        "normal_errors": skin.normal_errors().map(|errors| {
            json!({ "model": errors.model, "lbs": errors.lbs })
        }),
        "ranges": ranges,
    })
}

fn envelope_as_json(envelope: &Envelope<'_>, unit_mm: Option<f64>) -> Value {
    let certificate = envelope.certificate();
    let joints: Vec<Value> = (0..envelope.joint_len())
        .map(|joint| {
            json!({
                "name": envelope.joint_name(joint),
                "parent": envelope.parent(joint),
                "range": envelope.pose_range(joint),
                "gap": envelope.pose_gap(joint),
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
    let mut errors = json!({
        "diagonal": certificate.diagonal,
        "training_rms": certificate.training_rms,
        "same_clips_rms": certificate.same_clips_rms,
        "lbs_training_rms": certificate.lbs_training_rms,
        "correction_error": certificate.correction_error,
        "base_training_rms": certificate.base_training_rms,
        "other_clip_rms": certificate.other_clip_rms,
    });
    if let (Some(unit), Value::Object(all)) = (unit_mm, &mut errors) {
        let length =
            |(key, value): (&String, &Value)| Some((format!("{key}_mm"), unit * value.as_f64()?));
        let lengths: Vec<_> = all.iter().filter_map(length).collect();
        all.extend(lengths.into_iter().map(|(key, length)| (key, json!(length))));
    }
    json!({
        "part": envelope.part(),
        "name": envelope.name(),
        "predictor": envelope.predictor().name(),
        "proxies": envelope.proxy_len(),
        "palette": envelope.palette_len(),
        "scratch_bytes": 4 * envelope.scratch_len(),
        "skeleton_hash": envelope.skeleton_hash(),
        "joints": joints,
        "groups": groups,
        "certificate": errors,
    })
}
