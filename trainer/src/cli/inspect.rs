//! `sinew inspect`: what a model file holds.

use super::column::{longest, padded};
use super::described::Described;
use super::{Output, envelope, face, input, kernel, printable, signal, space, views};
use anyhow::Context;
use serde_json::{Value, json};
use sinew_runtime::format::{Element, PartKind, PartRow, SectionKind};
use sinew_runtime::{Model, Section};
use std::path::PathBuf;

/// Columns of the longest name of a part, which fit a terminal with the others.
const NAME: usize = 54;

/// Shows the parts, figures and bytes of a model file
///
/// Envelopes predict palettes. Skins are meshes that follow them. Kernels are functions of scattered data. Priors
/// say how the shapes of a face go together. Views are pictures and the pictures between them. Filters make signals
/// finer. Records hold the training of an envelope. It also shows the axes and the unit of the numbers.
#[derive(clap::Args)]
pub(super) struct Arguments {
    /// A model that `sinew train` wrote, `sinew kernel train`, `sinew face train`, `sinew views train` or
    /// `sinew signal train`
    model: PathBuf,
}

pub(super) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let bytes = input::read_model(&arguments.model)?;
    let model = Model::from_bytes(bytes).with_context(|| arguments.model.display().to_string())?;
    let mut described = envelope::describe(&model);
    described.extend(kernel::describe(&model));
    described.extend(face::describe(&model));
    described.extend(views::describe(&model));
    described.extend(signal::describe(&model));
    let len = model.as_bytes().len();
    let mut text = format!("{}: {len} bytes\n", arguments.model.display());
    text += &format!("space: {}\n", space::describe(&model.space()));
    described.iter().for_each(|part| text += &part.text);
    let [section, part, element, bytes] = ["section", "part", "element", "bytes"];
    let names = part_names(&model, &described);
    let columns = longest(names.iter().map(String::as_str), 10, NAME) + 2;
    text += &format!("{section:<24}{part:<columns$}{element:<8}{bytes:>12}\n");
    for section in model.sections() {
        let (kind, element) = (kind_name(&section), element_name(&section));
        let part = names.get(usize::from(section.row.part)).map_or("unknown", String::as_str);
        let part = padded(part, columns - 2);
        text += &format!("{kind:<24}{part}  {element:<8}{:>12}\n", section.bytes.len());
    }
    text += &format!("{:<36}{:>12}\n", "head, tables and padding", around(&model));
    output.print(&as_json(&model, &described), &text)
}

/// Counts the bytes that belong to no section.
fn around(model: &Model<Vec<u8>>) -> usize {
    let own: usize = model.sections().map(|section| section.bytes.len()).sum();
    model.as_bytes().len().saturating_sub(own)
}

/// Names the parts, each by its kind and its own name.
fn part_names(model: &Model<Vec<u8>>, described: &[Described]) -> Vec<String> {
    let kind = |row: PartRow| match PartKind::from_number(row.kind) {
        Some(kind) => kind.name().to_owned(),
        None => format!("unknown {}", row.kind),
    };
    let mut names: Vec<String> = model.parts().map(kind).collect();
    for Described { part, name, .. } in described {
        if let Some(whole) = names.get_mut(*part) {
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

fn as_json(model: &Model<Vec<u8>>, described: &[Described]) -> Value {
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
    let of = |kind: PartKind| -> Vec<&Value> {
        described.iter().filter(|part| part.kind == kind).map(|part| &part.json).collect()
    };
    json!({
        "bytes": model.as_bytes().len(),
        "space": space::as_json(&model.space()),
        "parts": parts,
        "envelopes": of(PartKind::Envelope),
        "skins": of(PartKind::Skin),
        "kernels": of(PartKind::Kernel),
        "priors": of(PartKind::Prior),
        "views": of(PartKind::Views),
        "filters": of(PartKind::Filter),
        "records": of(PartKind::Record),
        "sections": sections,
        "other_bytes": around(model),
    })
}
