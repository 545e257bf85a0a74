//! `sinew views demo`, `train` and `transfer`: sets to try, and objects from views.

use super::input::SetArguments;
use crate::bake::bake;
use crate::cli::files::{write, wrote};
use crate::cli::{OfFile, Output, OutputFile, Report, Run, counted, load, printable, table};
use crate::views::control::control;
use crate::views::demo;
use crate::views::fit::{Candidate, Choice, FitOptions};
use crate::views::model::parts;
use crate::views::set::{ViewSet, as_json, read_instance};
use crate::views::train::{Trained, train};
use crate::views::transfer::transfer;
use anyhow::bail;
use sinew_runtime::Views;
use sinew_runtime::format::Space;
use std::path::{Path, PathBuf};

/// Writes sets of views to try; needs no input
///
/// The sets are a drawn figure of 16 joints that walks and jumps, a panel in perspective that bends, and a head that
/// turns all the way round.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  sinew views demo demo")]
pub(in crate::cli) struct Demo {
    /// Folder to write to; made if needed
    folder: PathBuf,
}

impl Run for Demo {
    fn run(&self, _: Output) -> anyhow::Result<Report> {
        let folder = &self.folder;
        let sets = demo::write(folder).of(folder)?;
        let described = |set: &ViewSet| {
            let maps: Vec<_> = set.maps.iter().map(|map| &map.name).collect();
            let views: usize = set.maps.iter().map(|map| map.train.len()).sum();
            Report::default()
                .figure("name", "set", printable(&set.name), "")
                .shown("maps", "motions", &maps, maps.len().to_string())
                .figure("views", "views", views, "")
                .figure("key_views", "key views", set.key_views().len(), "")
                .figure("points", "points", set.point_len(), "")
                .figure("elements", "elements", set.element_len(), "")
        };
        let wrote = format!("wrote views.json of each set to {}", folder.display());
        Ok(Report::default().list("sets", sets.iter().map(described)).text(wrote))
    }
}

/// Learns all views between given views, and bakes them into a file
///
/// VIEWS is JSON: `image_size`, and the views under `train`. A view has `points` in pixels, parameters by name (angles
/// end in `_deg`), and, if it is a key view, an `image`: PNG, or layers as OpenRaster or PSD. With `"points": "auto"`
/// the views need no points. `sinew views demo` writes sets to try, and VIEWS.md describes the format.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  sinew views train demo/head/views.json -o head.sinew")]
pub(in crate::cli) struct Train {
    #[command(flatten)]
    set: SetArguments,
    /// File to write
    #[arg(short, long, alias = "out", value_name = "MODEL", required_unless_present = "pixels")]
    output: Option<PathBuf>,
    /// Meet the points of every view, even if another fit predicts left-out views better
    #[arg(long)]
    exact: bool,
    /// Negative control: print the PSNR of networks over pixels beside that of the model, and write no file
    ///
    /// The networks predict test views, or each key view from the others. A network over Fourier transforms gives the
    /// same pictures.
    #[arg(long, conflicts_with_all = ["output", "points_output"])]
    pixels: bool,
    /// Write the set with all its points, including proposed points, for you to correct: JSON, beside VIEWS
    #[arg(long, alias = "points-out", value_name = "JSON")]
    points_output: Option<PathBuf>,
}

impl Run for Train {
    fn run(&self, _: Output) -> anyhow::Result<Report> {
        let file = self.set.views.as_path();
        let options = FitOptions { exact: self.exact };
        let Some(out) = &self.output else { return run_control(&self.set, options) };
        let target = OutputFile::new(out, [file])?.of_a_model()?;
        let points = self.points_output.as_deref().map(|path| points_file(path, file, &target));
        let points = points.transpose()?;
        let set = self.set.read()?;
        let Trained { model, choices } = train(&set, options).of(file)?;
        let bytes = bake(Space::default(), &parts(&model)?)?;
        let folder = file.parent().unwrap_or(Path::new(""));
        let points = points.map(|points| (points, as_json(&set, folder).to_string()));
        let points = points.as_ref().map(|(points, json)| (points, json.as_bytes()));
        let files: Vec<_> = [(&target, bytes.as_slice())].into_iter().chain(points).collect();
        write(&files)?;
        let maps = model.maps.iter().zip(&choices).map(|(map, choice)| {
            Report::new(described(&map.name, choice))
                .json("name", &map.name)
                .json("choice", choice)
                .text(chosen("points", &choice.points))
                .text(chosen("depths", &choice.depths))
                .text(chosen("visibility", &choice.visibility))
        });
        let report = Report::default()
            .figure("name", "object", &model.name, "")
            .figure("points", "points", model.point_len, "")
            .figure("elements", "elements", model.mesh.element_len(), "")
            .figure("key_views", "key views", model.keys.len(), "")
            .list("maps", maps)
            .figure("rms", "points at the views, RMS", model.fit.rms, "px")
            .wrote(&target, &bytes);
        Ok(points.into_iter().fold(report, |report, (file, bytes)| report.text(wrote(file, bytes))))
    }
}

/// Checks the file for the set with its points. The set's pictures are named relative to the folder of the views.
fn points_file(path: &Path, views: &Path, model: &OutputFile) -> anyhow::Result<OutputFile> {
    let points = OutputFile::new(path, [views])?.ending_in(&["json"])?;
    let (own, other) = (path.display(), views.display());
    if points.is(model) {
        bail!("{own}: the model and the set are one file");
    }
    if std::path::absolute(path)?.parent() != std::path::absolute(views)?.parent() {
        bail!("{own}: expected a file beside {other}, since pictures are named from there");
    }
    Ok(points)
}

/// Names a map and its inputs.
fn described(name: &str, choice: &Choice) -> String {
    let named = |input: &String| {
        let names = input.split(',').map(str::trim).filter(|name| !name.is_empty());
        printable(&names.collect::<Vec<_>>().join(", "))
    };
    let inputs: Vec<String> = choice.inputs.iter().map(named).collect();
    format!("map \"{}\" of {}", printable(name), inputs.join("; "))
}

fn chosen(outputs: &str, candidate: &Candidate) -> String {
    let kernel = candidate.kernel.map(|width| format!(" and kernel {}", width.kernel.name()));
    let left_out = match candidate.left_out {
        Some(rms) => format!("views left out {rms:.2e}"),
        None => "too few views to leave one out".to_owned(),
    };
    format!("{outputs}: {}{}, {left_out}", candidate.polynomial, kernel.unwrap_or_default())
}

/// Compares the PSNR of networks over pixels with that of control points and warping.
///
/// # Errors
/// The views cannot be read or fitted.
fn run_control(set: &SetArguments, options: FitOptions) -> anyhow::Result<Report> {
    let found = control(&set.read()?, options).of(&set.views)?;
    let [one, many] = match found.is_left_out {
        true => ["key view, left out", "key views, each left out"],
        false => ["test view", "test views"],
    };
    let figure = |psnr: Option<f64>| psnr.map_or_else(String::new, |psnr| format!("{psnr:.2} dB"));
    let rows = found
        .rows
        .iter()
        .map(|row| vec![row.name.clone(), figure(row.psnr), figure(row.psnr_opaque)]);
    let views = counted(found.views, one, many);
    Ok(Report::default()
        .text("negative control: networks over pixels (S1, appendix 2); no file is written")
        .text(table(&[&views, "whole pictures", "where opaque"], rows.collect()))
        .text("a network over Fourier transforms gives the same pictures: both are linear")
        .json("negative_control", &found))
}

/// Lends the motion of one object to another of its class
///
/// The other object needs a picture, and its points in one or more of the key views of PROTOTYPE.
///
/// INSTANCE is JSON with a list `views`. Each view has the name of a key view as `view`, an `image` and `points`. If
/// PROTOTYPE has layers, a view may have `layers` in place of `image`: a picture for each layer by its name. `sinew
/// views drive` and `pin` take the points of the instance.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  sinew views transfer figure.sinew sister.json -o sister.sinew")]
pub(in crate::cli) struct Transfer {
    /// Model that `sinew views train` wrote
    prototype: PathBuf,
    /// The other object
    instance: PathBuf,
    /// File to write
    #[arg(short, long, alias = "out", value_name = "MODEL")]
    output: PathBuf,
    /// Scale the motion by the size of the object over that of its prototype
    #[arg(long)]
    by_size: bool,
}

impl Run for Transfer {
    fn run(&self, _: Output) -> anyhow::Result<Report> {
        let Self { prototype, instance, output: out, by_size } = self;
        let target = OutputFile::new(out, [prototype, instance])?.of_a_model()?;
        let model = load(prototype)?;
        let object = model.first::<Views>();
        let layers = (0..).map_while(|layer| object.as_ref()?.layer_name(layer));
        let views = read_instance(instance, &layers.collect::<Vec<_>>()).of(instance)?;
        let name = instance.file_stem().map(|stem| stem.to_string_lossy()).unwrap_or_default();
        let made = transfer(&model, &name, &views, *by_size).of(instance)?;
        let bytes = bake(Space::default(), &parts(&made)?)?;
        Report::default()
            .figure("maps", "maps", made.maps.len(), "")
            .figure("key_views", "key views", made.keys.len(), "")
            .write(&target, &bytes)
    }
}
