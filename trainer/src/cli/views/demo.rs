//! `sinew views demo`: sets of views to try.

use crate::cli::{Output, counted, printable};
use anyhow::Context;
use serde_json::{Value, json};
use sinew_trainer::views::demo::write;
use sinew_trainer::views::set::ViewSet;
use std::path::PathBuf;

/// Writes sets of views to try; needs no input
///
/// They are a drawn figure of 16 joints that walks and jumps, a panel in perspective that bends, and a head that turns
/// all the way round.
#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    /// The folder to write to; it is made where it is not there
    folder: PathBuf,
}

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let folder = &arguments.folder;
    let sets = write(folder).with_context(|| folder.display().to_string())?;
    let mut text = String::new();
    for set in &sets {
        let views: usize = set.maps.iter().map(|map| map.train.len()).sum();
        text += &format!(
            "{}: {}, {}, {}, {}\n",
            folder.join(&set.name).join("views.json").display(),
            counted(set.maps.len(), "motion", "motions"),
            counted(views, "view", "views"),
            counted(set.point_len(), "point", "points"),
            counted(set.element_len(), "element", "elements"),
        );
    }
    output.print(&json!({ "sets": sets.iter().map(as_json).collect::<Vec<_>>() }), &text)
}

fn as_json(set: &ViewSet) -> Value {
    json!({
        "name": printable(&set.name),
        "maps": set.maps.iter().map(|map| &map.name).collect::<Vec<_>>(),
        "points": set.point_len(),
        "elements": set.element_len(),
        "key_views": set.key_views().len(),
    })
}
