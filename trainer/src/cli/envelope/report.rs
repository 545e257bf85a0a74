//! `sinew report`: a page that shows the error of a model, with pictures.

use super::eval::MeasuredArgs;
use super::table;
use crate::cli::{Bars, Output, OutputFile, Report, Run, StatedSpace, files};
use crate::evaluate::Character;
use crate::examples::{Clip, Loaded};
use crate::report::comparison::{Comparison, NamedExamples, NamedModel};
use crate::report::{Page, PictureOptions, outputs};
use anyhow::Context;
use std::path::{Path, PathBuf};

/// Writes a page that shows where the error of a model is
///
/// The page has pictures, charts and tables in one HTML file, in % of the diagonal, and in millimetres if MODEL or
/// EXAMPLES have a unit.
///
/// The page shows the worst pose beside the truth and the baselines of `sinew eval`, each shaded with its own normals.
/// It shows maps of the error and of the angle of the normals on the skin; errors by frame, by joint and by size; and
/// the model's confidence. It trains the model's predictor again with fewer and with more helpers, and shows their
/// errors. Every number is measured as by `sinew eval`. The page needs no network and no script. In the pictures the
/// character stands along the axis of --up or of the examples' file, else along z if it is longest along z, else along
/// y.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  sinew report model.sinew walk.npz -o report.html --quick")]
pub(in crate::cli) struct ReportArgs {
    /// Page to write
    #[arg(short, long, alias = "out", value_name = "REPORT.html")]
    output: PathBuf,
    /// Another model of the character, to compare in every table, chart and picture
    #[arg(long, value_name = "MODEL")]
    compare: Option<PathBuf>,
    /// Train nothing: leave out the errors of fewer and more helpers
    #[arg(long)]
    quick: bool,
    /// Direction of the camera in degrees: about the up axis, and above the horizon [default: front or back, whichever
    /// shows more of the error]
    #[arg(long, value_name = "AZIMUTH,ELEVATION", value_parser = view)]
    #[arg(allow_hyphen_values = true)]
    view: Option<(f64, f64)>,
    /// Write the errors of every frame, a row each: % of the diagonal, and millimetres if the unit is known
    #[arg(long, value_name = "FILE.csv")]
    csv: Option<PathBuf>,
    /// Write the rest mesh with each vertex's RMS error in % of the diagonal, as `error` and as its colour
    #[arg(long, value_name = "FILE.ply")]
    ply: Option<PathBuf>,
    /// Write the measured frames as a moving picture: the truth, then linear blend skinning and the model in the
    /// colours of their errors
    #[arg(long, value_name = "FILE.gif")]
    gif: Option<PathBuf>,
    #[command(flatten)]
    measured: MeasuredArgs,
    #[command(flatten)]
    space: StatedSpace,
}

/// Width of a moving picture, pixels.
const GIF_WIDTH: usize = 900;
/// Frames a second of a moving picture if clips have different rates.
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

impl Run for ReportArgs {
    fn run(&self, output: Output) -> anyhow::Result<Report> {
        let measured = &self.measured;
        let mut inputs = measured.input.files();
        inputs.push(measured.model.file.clone());
        inputs.extend(self.compare.clone());
        let page_file = OutputFile::new(&self.output, &inputs)?.of_a_report()?;
        let target =
            |file: &Option<PathBuf>| file.as_ref().map(|f| OutputFile::new(f, &inputs)).transpose();
        let [csv_file, ply_file, gif_file] =
            [target(&self.csv)?, target(&self.ply)?, target(&self.gif)?];
        let further = [csv_file.as_ref(), ply_file.as_ref(), gif_file.as_ref()];
        files::refuse_same(&[&[Some(&page_file)], &further[..]].concat())?;
        let bytes = files::read_model(&measured.model.file)?;
        let other = self.compare.as_deref().map(files::read_model).transpose()?;
        let loaded = measured.load(&bytes, &self.space, output)?;
        let Loaded { examples, clips, .. } = &loaded;
        let skin = measured.skin.as_deref();
        let blamed = |error, model| measured.blame(error, model, clips);
        // Errors of the models are found before LBS is fitted.
        let (_, recorded) = measured.open(&bytes, &loaded, output)?;
        let compared = self.compare.as_deref().zip(other.as_deref());
        if let Some((path, bytes)) = compared {
            Character::open(bytes, skin, examples).map_err(|error| blamed(error, path))?;
        }
        let measuring = Bars::busy(output, "measuring");
        let names = names(&measured.model.file, self.compare.as_deref());
        let [name, other_name] = &names;
        let files: Vec<String> =
            measured.input.examples.iter().map(|file| file_name(file)).collect();
        let source_name = files.join(", ");
        let source = NamedExamples { examples, clips, name: &source_name };
        let file = NamedModel { name, bytes: &bytes, skin };
        let frames = measured.frames(&recorded, &loaded)?;
        let mut comparison = Comparison::new(source, Some(frames), file)
            .map_err(|error| blamed(error, &measured.model.file))?;
        if let Some((path, bytes)) = compared {
            let file = NamedModel { name: other_name, bytes, skin };
            comparison.compare(file).map_err(|error| blamed(error, path))?;
        }
        drop(measuring);
        let options = PictureOptions { from: self.view, ..PictureOptions::default() };
        let page = Page { comparison: &comparison, options, sizes: !self.quick };
        let page = page.html(&Bars::new(output))?;
        let mut written = vec![(&page_file, page.into_bytes())];
        if let Some(target) = &csv_file {
            let rows = outputs::frames_csv(&comparison).context("cannot write the table")?;
            written.push((target, rows));
        }
        if let Some(target) = &ply_file {
            written.push((target, outputs::rest_mesh_ply(&comparison)));
        }
        if let Some(target) = &gif_file {
            let options = PictureOptions { width: GIF_WIDTH, ..options };
            let fps = Clip::rate_of(clips).unwrap_or(SLOW);
            // Browsers show delays below two hundredths as ten.
            let hundredths = (100.0 / fps).round().clamp(2.0, 100.0) as u16;
            written.push((target, outputs::frames_gif(&comparison, &options, hundredths)?));
        }
        let files: Vec<_> =
            written.iter().rev().map(|(target, bytes)| (*target, bytes.as_slice())).collect();
        files::write(&files)?;
        let evaluations = comparison.evaluations();
        let table = match &evaluations[..] {
            [one] => table::evaluation(one),
            several => table::evaluations(&Vec::from_iter(names.into_iter().zip(several))),
        };
        let report = Report::default()
            .json("model", &evaluations[0])
            .json("compared", evaluations.get(1))
            .text(table);
        Ok(files
            .iter()
            .rev()
            .fold(report, |report, (target, bytes)| report.text(files::wrote(target, bytes))))
    }
}

/// Names the models for the page: by their files, or by their paths if the files have one name.
fn names(model: &Path, other: Option<&Path>) -> [String; 2] {
    let other = other.unwrap_or(Path::new(""));
    let names = [model, other].map(file_name);
    if names[0] == names[1] { [model, other].map(|path| path.display().to_string()) } else { names }
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
