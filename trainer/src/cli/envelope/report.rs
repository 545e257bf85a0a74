//! `sinew report`: the page that shows where the error is.

use super::measured::{SplitName, blame, refuse_forgotten_targets};
use super::table;
use crate::cli::bars::Bars;
use crate::cli::files::{self, OutputFile};
use crate::cli::space::StatedSpace;
use crate::cli::{Output, input};
use anyhow::{Context, bail};
use serde_json::json;
use sinew_trainer::evaluate::{Character, TrainingRecord};
use sinew_trainer::examples::Clip;
use sinew_trainer::report::comparison::{Comparison, NamedExamples, NamedModel};
use sinew_trainer::report::{Page, PictureOptions, outputs};
use std::path::{Path, PathBuf};

/// Writes a page that shows where the error of a model is
///
/// The page has pictures, charts and tables in one HTML file, in % of the diagonal, and in millimetres where MODEL or
/// EXAMPLES have a unit.
///
/// The page shows the worst pose beside the truth and the baselines of `sinew eval`, each shaded with the normals that
/// it has, maps of the error and of the normals' angle on the skin, errors by
/// frame, by joint and by size, the model's confidence, and what its predictor makes of the same
/// examples with fewer and with more proxies, for which it is trained again. Every number is measured
/// as `sinew eval` does. The page needs no network and no script. In the pictures the character stands
/// along the axis that --up or the examples' file names, else along z if it is longest along z, else
/// along y.
#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    /// A model that `sinew train` wrote
    model: PathBuf,
    #[command(flatten)]
    input: input::ExampleArguments,
    /// The skin to show, whose mesh the examples' is; of both models, where there are two [default:
    /// each model's first]
    #[arg(long, value_name = "NAME")]
    skin: Option<String>,
    /// Where to write the page
    #[arg(long, short = 'o', value_name = "REPORT.html")]
    output: PathBuf,
    /// Another model of the same character, to stand beside it in every table, chart and picture
    #[arg(long, value_name = "MODEL")]
    compare: Option<PathBuf>,
    /// Which frames [default: held-out; where none is held out, those that training has not read; where it has
    /// read all, those]
    #[arg(long, value_enum)]
    split: Option<SplitName>,
    /// Train nothing: leave out what fewer and more proxies would give
    #[arg(long)]
    quick: bool,
    /// Where the pictures are taken from, in degrees: about the up axis, and above the horizon
    /// [default: from before or behind, whichever side shows more of the error]
    #[arg(long, value_name = "AZIMUTH,ELEVATION", value_parser = view)]
    #[arg(allow_hyphen_values = true)]
    view: Option<(f64, f64)>,
    /// Write the errors of every frame to FILE: a row each, in % of the diagonal, and in millimetres where the
    /// unit is known
    #[arg(long, value_name = "FILE.csv")]
    csv: Option<PathBuf>,
    /// Write the rest mesh to FILE with each vertex's RMS error, in % of the diagonal, as `error`
    /// and as its colour
    #[arg(long, value_name = "FILE.ply")]
    ply: Option<PathBuf>,
    /// Write the measured frames to FILE as a moving picture: the truth, then linear blend skinning and the model in
    /// the colours of their errors
    #[arg(long, value_name = "FILE.gif")]
    gif: Option<PathBuf>,
    #[command(flatten)]
    space: StatedSpace,
}

/// Width of a moving picture, pixels.
const GIF_WIDTH: usize = 900;
/// Frames a second of a moving picture where clips have no one rate.
const SLOW: f64 = 10.0;

/// Parses two angles.
fn view(text: &str) -> Result<(f64, f64), String> {
    let angles: Option<Vec<f64>> = text.split(',').map(|angle| angle.trim().parse().ok()).collect();
    match angles.as_deref() {
        Some(&[azimuth, elevation]) if azimuth.is_finite() && elevation.abs() <= 90.0 => {
            Ok((azimuth, elevation))
        }
        _ => Err("expected AZIMUTH,ELEVATION in degrees, the latter from -90 to 90".to_owned()),
    }
}

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let targets = targets(arguments)?;
    let bytes = input::read_model(&arguments.model)?;
    let other = arguments.compare.as_deref().map(input::read_model).transpose()?;
    let loaded = arguments.input.load_to_measure(output)?;
    let input::LoadedInput { mut examples, clips, warnings } = loaded;
    arguments.space.say(&mut examples, &arguments.input.named())?;
    let skin = arguments.skin.as_deref();
    input::convert_to_model(&mut examples, &bytes, skin);
    let frames = arguments.split.map(SplitName::frames);
    let blamed = |error, model| blame(error, model, &arguments.input, (&examples, &clips));
    // What will be refused is refused before LBS is fitted.
    let character = Character::open(&bytes, skin, &examples);
    let character = character.map_err(|error| blamed(error, &arguments.model))?;
    let known = (&character, &TrainingRecord::of(&bytes, &character, &examples));
    refuse_forgotten_targets(&arguments.input, &warnings, known, &examples, output)?;
    let compared = arguments.compare.as_deref().zip(other.as_deref());
    if let Some((path, bytes)) = compared {
        Character::open(bytes, skin, &examples).map_err(|error| blamed(error, path))?;
    }
    let measuring = Bars::busy(output, "measuring");
    let names = names(&arguments.model, arguments.compare.as_deref());
    let [name, other_name] = &names;
    let files: Vec<String> = arguments.input.examples.iter().map(|file| file_name(file)).collect();
    let source_name = files.join(", ");
    let source = NamedExamples { examples: &examples, clips: &clips, name: &source_name };
    let file = NamedModel { name, bytes: &bytes, skin };
    let mut comparison =
        Comparison::new(source, frames, file).map_err(|error| blamed(error, &arguments.model))?;
    if let Some((path, bytes)) = compared {
        let file = NamedModel { name: other_name, bytes, skin };
        comparison.compare(file).map_err(|error| blamed(error, path))?;
    }
    drop(measuring);
    let options = PictureOptions { from: arguments.view, ..PictureOptions::default() };
    let page = Page { comparison: &comparison, options, sizes: !arguments.quick };
    let page = page.html(&Bars::new(output))?;
    let mut written = vec![(&targets.page, page.into_bytes())];
    if let Some(target) = &targets.csv {
        written.push((target, outputs::frames_csv(&comparison).context("cannot write the table")?));
    }
    if let Some(target) = &targets.ply {
        written.push((target, outputs::rest_mesh_ply(&comparison)));
    }
    if let Some(target) = &targets.gif {
        let options = PictureOptions { width: GIF_WIDTH, ..options };
        let fps = Clip::rate_of(&clips).unwrap_or(SLOW);
        // Below two hundredths browsers take ten.
        let hundredths = (100.0 / fps).round().clamp(2.0, 100.0) as u16;
        written.push((target, outputs::frames_gif(&comparison, &options, hundredths)?));
    }
    written.reverse();
    let files: Vec<_> = written.iter().map(|(target, bytes)| (*target, bytes.as_slice())).collect();
    files::write(&files)?;
    let evaluations = comparison.evaluations();
    let mut text = match &evaluations[..] {
        [one] => table::evaluation(one),
        several => table::evaluations(&Vec::from_iter(names.into_iter().zip(several))),
    };
    for (target, bytes) in files.iter().rev() {
        text += &format!("wrote {} ({} bytes)\n", target.named().display(), bytes.len());
    }
    output.print(&json!({ "model": evaluations[0], "compared": evaluations.get(1) }), &text)
}

struct OutputFiles {
    page: OutputFile,
    csv: Option<OutputFile>,
    ply: Option<OutputFile>,
    gif: Option<OutputFile>,
}

/// Tries every place to write to.
fn targets(arguments: &Arguments) -> anyhow::Result<OutputFiles> {
    let mut inputs = arguments.input.files();
    inputs.push(arguments.model.clone());
    inputs.extend(arguments.compare.clone());
    let target = |path: &PathBuf| OutputFile::new(path, &inputs);
    let page = target(&arguments.output)?.of_a_report()?;
    let csv = arguments.csv.as_ref().map(target).transpose()?;
    let ply = arguments.ply.as_ref().map(target).transpose()?;
    let gif = arguments.gif.as_ref().map(target).transpose()?;
    let all: Vec<&OutputFile> =
        std::iter::once(&page).chain(&csv).chain(&ply).chain(&gif).collect();
    for (number, one) in all.iter().enumerate() {
        if all[..number].iter().any(|other| other.is(one)) {
            bail!("cannot write {}: two outputs are one file", one.named().display());
        }
    }
    Ok(OutputFiles { page, csv, ply, gif })
}

/// What the page calls the models: their files' names, or their paths where those are the same.
fn names(model: &Path, other: Option<&Path>) -> [String; 2] {
    let other = other.unwrap_or(Path::new(""));
    let names = [model, other].map(file_name);
    if names[0] == names[1] { [model, other].map(|path| path.display().to_string()) } else { names }
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
