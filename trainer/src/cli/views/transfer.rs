//! `sinew views transfer`: one object's motion for another.

use super::input::load;
use crate::cli::files::{OutputFile, write};
use crate::cli::{Output, counted};
use anyhow::Context;
use serde_json::json;
use sinew_runtime::format::Space;
use sinew_trainer::bake::bake;
use sinew_trainer::views::bake::parts;
use sinew_trainer::views::set::read_instance;
use sinew_trainer::views::transfer::transfer;
use std::path::PathBuf;

/// Lends the motion of one object to another of its class
///
/// The other object needs a picture, and its points in one or more of the key views of PROTOTYPE.
///
/// INSTANCE is JSON: under `views` each has a key view's name as `view`, its `image` and its `points`. In place of `image`
/// an instance of a PROTOTYPE in layers has `layers`, a picture for each by the layer's name. `sinew views drive` and `pin`
/// take the points of the instance.
#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    /// A file that `sinew views train` wrote
    prototype: PathBuf,
    /// The other object
    instance: PathBuf,
    /// The file to write
    #[arg(short, long, value_name = "MODEL")]
    out: PathBuf,
    /// Moves as far as it is large, and not as far as its prototype
    #[arg(long)]
    by_size: bool,
}

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let Arguments { prototype, instance, out, by_size } = arguments;
    let target = OutputFile::new(out, &[prototype.clone(), instance.clone()])?.of_a_model()?;
    let model = load(prototype)?;
    let about = || instance.display().to_string();
    let object = model.views();
    let layers = (0..).map_while(|layer| object.as_ref()?.layer_name(layer));
    let views = read_instance(instance, &layers.collect::<Vec<_>>()).with_context(about)?;
    let name = instance.file_stem().map(|stem| stem.to_string_lossy()).unwrap_or_default();
    let made = transfer(&model, &name, &views, *by_size).with_context(about)?;
    let bytes = bake(Space::default(), &parts(&made)?)?;
    write(&[(&target, &bytes)])?;
    let text = format!(
        "{}: {}, {}, {} bytes\n",
        target.named().display(),
        counted(made.maps.len(), "map", "maps"),
        counted(made.keys.len(), "key view", "key views"),
        bytes.len()
    );
    output.print(&json!({ "bytes": bytes.len(), "key_views": made.keys.len() }), &text)
}
