//! `sinew views demo`, `train` and `transfer`: sets to try, and objects from views.

use super::input::{SetArguments, load};
use crate::cli::files::{OutputFile, ending, write};
use crate::cli::{Output, counted, printable};
use anyhow::{Context, bail};
use serde_json::{Value, json};
use sinew_runtime::format::Space;
use sinew_trainer::bake::bake;
use sinew_trainer::views::control::control;
use sinew_trainer::views::demo;
use sinew_trainer::views::fit::{Candidate, Choice, FitOptions};
use sinew_trainer::views::model::parts;
use sinew_trainer::views::set::{ViewSet, as_json, read_instance};
use sinew_trainer::views::train::{Trained, train};
use sinew_trainer::views::transfer::transfer;
use std::path::{Path, PathBuf};

/// Writes sets of views to try; needs no input
///
/// The sets are a drawn figure of 16 joints that walks and jumps, a panel in perspective that bends, and a head that
/// turns all the way round.
#[derive(clap::Args)]
pub(in crate::cli) struct Demo {
    /// The folder to write to; it is created if needed
    folder: PathBuf,
}

pub(in crate::cli) fn write_demo(arguments: &Demo, output: Output) -> anyhow::Result<()> {
    let folder = &arguments.folder;
    let sets = demo::write(folder).with_context(|| folder.display().to_string())?;
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
    output.print(&json!({ "sets": sets.iter().map(described_set).collect::<Vec<_>>() }), &text)
}

fn described_set(set: &ViewSet) -> Value {
    json!({
        "name": printable(&set.name),
        "maps": set.maps.iter().map(|map| &map.name).collect::<Vec<_>>(),
        "points": set.point_len(),
        "elements": set.element_len(),
        "key_views": set.key_views().len(),
    })
}

/// Learns all views between given views, and bakes them into a file
///
/// VIEWS is JSON: `image_size`, and the views under `train`. A view has `points` in pixels, parameters by name (angles
/// end in `_deg`), and, if it is a key view, an `image`: PNG, or layers as OpenRaster or PSD. With `"points": "auto"`
/// the views need no points. `sinew views demo` writes sets to try, and VIEWS.md describes the format.
#[derive(clap::Args)]
pub(in crate::cli) struct Train {
    #[command(flatten)]
    set: SetArguments,
    /// The file to write
    #[arg(short, long, value_name = "MODEL", required_unless_present = "pixels")]
    out: Option<PathBuf>,
    /// Meets the points of every view, even if another fit predicts left-out views better
    #[arg(long)]
    exact: bool,
    /// Negative control: prints the PSNR of networks over pixels beside that of the model, and writes no file. It
    /// predicts test views, or each key view from the others. A network over Fourier transforms gives the same pictures
    #[arg(long, conflicts_with_all = ["out", "points_out"])]
    pixels: bool,
    /// Writes the set with all its points, including proposed points, for you to correct: JSON, beside VIEWS
    #[arg(long, value_name = "JSON")]
    points_out: Option<PathBuf>,
}

pub(in crate::cli) fn train_set(arguments: &Train, output: Output) -> anyhow::Result<()> {
    let file = arguments.set.file();
    let options = FitOptions { exact: arguments.exact };
    let Some(out) = &arguments.out else { return run_control(&arguments.set, options, output) };
    let target = OutputFile::new(out, &[file.to_owned()])?.of_a_model()?;
    let points = arguments.points_out.as_deref().map(|path| points_file(path, file, &target));
    let points = points.transpose()?;
    let set = arguments.set.read()?;
    let Trained { model, choices } =
        train(&set, options).with_context(|| file.display().to_string())?;
    let bytes = bake(Space::default(), &parts(&model)?)?;
    let points = points.map(|points| (points, as_json(&set, folder(file)).to_string()));
    let mut files: Vec<(&OutputFile, &[u8])> = vec![(&target, &bytes)];
    files.extend(points.as_ref().map(|(points, json)| (points, json.as_bytes())));
    write(&files)?;
    let mut text = format!(
        "{}: {}, {}, {}\n",
        printable(&model.name),
        counted(model.point_len, "point", "points"),
        counted(model.mesh.element_len(), "element", "elements"),
        counted(model.keys.len(), "key view", "key views"),
    );
    for (map, choice) in model.maps.iter().zip(&choices) {
        text += &described(&map.name, choice);
    }
    text += &format!("{:<36}{:>12.3e}\n", "points at the views, RMS pixels", model.fit.rms);
    text += &format!("{}: {} bytes\n", target.named().display(), bytes.len());
    if let Some((points, json)) = &points {
        text += &format!("{}: {} bytes\n", points.named().display(), json.len());
    }
    let maps: Vec<_> = model.maps.iter().map(|map| &map.name).zip(&choices).collect();
    let json = json!({
        "bytes": bytes.len(),
        "points": model.point_len,
        "elements": model.mesh.element_len(),
        "key_views": model.keys.len(),
        "rms": model.fit.rms,
        "maps": maps.iter().map(|(name, choice)| json!({ "name": name, "choice": choice })).collect::<Vec<_>>(),
    });
    output.print(&json, &text)
}

/// Checks the file for the set with its points. The set's pictures are named relative to the folder of the views.
fn points_file(path: &Path, views: &Path, model: &OutputFile) -> anyhow::Result<OutputFile> {
    let points = OutputFile::new(path, &[views.to_owned()])?;
    ending(path, &["json"])?;
    if points.is(model) {
        bail!("{}: the model and the set are one file", path.display());
    }
    let [own, other] = [std::path::absolute(path)?, std::path::absolute(views)?];
    if own.parent() != other.parent() {
        bail!(
            "{}: expected a file beside {}, since pictures are named from there",
            path.display(),
            views.display()
        );
    }
    Ok(points)
}

/// Returns the folder of a file.
fn folder(file: &Path) -> &Path {
    file.parent().unwrap_or(Path::new(""))
}

fn described(name: &str, choice: &Choice) -> String {
    let named = |input: &String| {
        let names = input.split(',').map(str::trim).filter(|name| !name.is_empty());
        printable(&names.collect::<Vec<_>>().join(", "))
    };
    let inputs: Vec<String> = choice.inputs.iter().map(named).collect();
    let mut out = format!("map \"{}\" of {}\n", printable(name), inputs.join("; "));
    for (what, candidate) in
        [("points", choice.points), ("depths", choice.depths), ("visibility", choice.visibility)]
    {
        out += &format!("  {what:<14}{}\n", chosen(&candidate));
    }
    out
}

fn chosen(candidate: &Candidate) -> String {
    let mut out = candidate.polynomial.to_owned();
    if let Some(width) = candidate.kernel {
        out += &format!(" and kernel {}", width.kernel.name());
    }
    match candidate.left_out {
        Some(rms) => out + &format!(", views left out {rms:.2e}"),
        None => out + ", too few views to leave one out",
    }
}

/// Prints the PSNR of networks over pixels beside that of control points and warping.
///
/// # Errors
/// Views that cannot be read or taken.
fn run_control(set: &SetArguments, options: FitOptions, output: Output) -> anyhow::Result<()> {
    let about = || set.file().display().to_string();
    let found = control(&set.read()?, options).with_context(about)?;
    let [one, many] = match found.is_left_out {
        true => ["key view, left out", "key views, each left out"],
        false => ["test view", "test views"],
    };
    let figure = |psnr: Option<f64>| psnr.map_or_else(String::new, |psnr| format!("{psnr:.2} dB"));
    let mut text =
        "negative control: networks over pixels (S1, appendix 2); no file is written\n".to_owned();
    let mut line = |name: &str, whole: &str, opaque: &str| {
        text += &format!("{name:<40}{whole:>14}{opaque:>14}\n");
    };
    line(&counted(found.views, one, many), "whole pictures", "where opaque");
    for row in &found.rows {
        line(&row.name, &figure(row.psnr), &figure(row.psnr_opaque));
    }
    text += "a network over Fourier transforms gives the same pictures: both are linear\n";
    output.print(&json!({ "negative_control": found }), &text)
}

/// Lends the motion of one object to another of its class
///
/// The other object needs a picture, and its points in one or more of the key views of PROTOTYPE.
///
/// INSTANCE is JSON with a list `views`. Each view has the name of a key view as `view`, an `image` and `points`. If
/// PROTOTYPE has layers, a view may have `layers` in place of `image`: a picture for each layer by its name. `sinew
/// views drive` and `pin` take the points of the instance.
#[derive(clap::Args)]
pub(in crate::cli) struct Transfer {
    /// A file that `sinew views train` wrote
    prototype: PathBuf,
    /// The other object
    instance: PathBuf,
    /// The file to write
    #[arg(short, long, value_name = "MODEL")]
    out: PathBuf,
    /// Scales the motion by the size of the object over that of its prototype
    #[arg(long)]
    by_size: bool,
}

pub(in crate::cli) fn transfer_motion(arguments: &Transfer, output: Output) -> anyhow::Result<()> {
    let Transfer { prototype, instance, out, by_size } = arguments;
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
