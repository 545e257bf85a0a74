//! `sinew views train`: from views to an object in a file.

use super::input::SetArguments;
use super::pixels;
use crate::cli::files::{OutputFile, ending, write};
use crate::cli::{Output, counted, printable};
use anyhow::{Context, bail};
use serde_json::json;
use sinew_runtime::format::Space;
use sinew_trainer::bake::bake;
use sinew_trainer::views::bake::parts;
use sinew_trainer::views::fit::{Candidate, Choice, FitOptions};
use sinew_trainer::views::set::as_json;
use sinew_trainer::views::train::{Trained, train};
use std::path::{Path, PathBuf};

/// Learns every view between some views, and bakes it into a file
///
/// VIEWS is JSON: `image_size`, and under `train` a view each, with its `points` in pixels, its parameters by name
/// (angles end in `_deg`), and, of key views, its `image`: PNG, or layers as OpenRaster or PSD. With
/// `"points": "auto"` points are proposed, and views have none. `sinew views demo` writes some sets to look at,
/// VIEWS.md says the rest.
#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    #[command(flatten)]
    set: SetArguments,
    /// The file to write
    #[arg(short, long, value_name = "MODEL", required_unless_present = "pixels")]
    out: Option<PathBuf>,
    /// Meets the points of every view, also where that is not what predicts left-out views best
    #[arg(long)]
    exact: bool,
    /// Negative control: prints the PSNR of networks over pixels beside that of the model, and writes no file. It predicts
    /// test views, or each key view from the others. A network over Fourier transforms gives the same pictures
    #[arg(long, conflicts_with_all = ["out", "points_out"])]
    pixels: bool,
    /// Writes the set with all its points, proposed ones among them, for you to correct: JSON, beside VIEWS
    #[arg(long, value_name = "JSON")]
    points_out: Option<PathBuf>,
}

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let file = arguments.set.file();
    let options = FitOptions { exact: arguments.exact };
    let Some(out) = &arguments.out else { return pixels::run(&arguments.set, options, output) };
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

/// Checks the place for the set with its points, whose pictures are named from the folder of the views.
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
