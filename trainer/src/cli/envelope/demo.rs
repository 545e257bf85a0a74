//! `sinew demo`: the whole way on a character that needs no download.

use super::table;
use super::train;
use crate::cli::bars::Bars;
use crate::cli::files::{self, OutputFile};
use crate::cli::{Output, input};
use anyhow::bail;
use serde_json::json;
use sinew_runtime::Model;
use sinew_trainer::envelope::FileSkins;
use sinew_trainer::envelope::clean::Inliers;
use sinew_trainer::evaluate::{Evaluation, Frames};
use sinew_trainer::examples::demo::{DemoOptions, demo};
use sinew_trainer::examples::{Clip, Examples, Split, npz};
use sinew_trainer::export::by_use;
use sinew_trainer::progress::Silent;
use sinew_trainer::report::comparison::{Comparison, NamedExamples, NamedModel};
use sinew_trainer::report::{Page, PictureOptions};
use std::path::{Path, PathBuf};

/// Most positions in all frames together: 2.4 GB of them.
const POSITIONS_MAX: usize = 100_000_000;

/// Trains, bakes and measures a generated arm; needs no input
///
/// Generates a procedural arm, trains an envelope on it, bakes it, and measures the baked model on
/// poses that the training has not seen. Beside it stands one of the other predictor with as many proxies: rotational
/// regression, which the method began with, beside kernel maps.
#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    #[command(flatten)]
    size: SizeArguments,
    #[command(flatten)]
    fit: train::FitArguments,
    /// Write the examples (demo.npz, demo.json), the model (demo.sinew) and the report (report.html) to DIR,
    /// which is made if it is not there [default: the report alone, into the system's temporary folder]
    #[arg(long, short = 'o', value_name = "DIR")]
    output: Option<PathBuf>,
}

/// What to generate.
#[derive(clap::Args)]
pub(in crate::cli) struct SizeArguments {
    /// Vertices of the arm, about; at least 200 are made
    #[arg(long, value_name = "V", value_parser = some, allow_negative_numbers = true)]
    #[arg(default_value_t = DemoOptions::default().vertices)]
    vertices: usize,
    /// Training poses
    #[arg(long, value_name = "N", value_parser = some, allow_negative_numbers = true)]
    #[arg(default_value_t = DemoOptions::default().poses)]
    poses: usize,
    /// Held-out poses
    #[arg(long, value_name = "N", value_parser = some, allow_negative_numbers = true)]
    #[arg(default_value_t = DemoOptions::default().held_out)]
    held_out: usize,
    /// Seed of the poses
    #[arg(long, default_value_t = DemoOptions::default().seed)]
    seed: u64,
}

impl SizeArguments {
    /// Generates the demo's examples.
    pub(in crate::cli) fn generate(&self, output: Output) -> anyhow::Result<Examples> {
        let &Self { vertices, poses, held_out, seed } = self;
        let positions = (poses + held_out).checked_mul(vertices);
        if positions.is_none_or(|positions| positions > POSITIONS_MAX) {
            bail!("--vertices x (--poses + --held-out): expected at most {POSITIONS_MAX}");
        }
        let _generating = Bars::busy(output, "generating");
        Ok(demo(&DemoOptions { vertices, poses, held_out, seed }))
    }
}

fn some(text: &str) -> Result<usize, String> {
    input::count(text, POSITIONS_MAX)
}

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let folder = arguments.output.as_deref();
    let model = folder.map(prepare).transpose()?;
    let page = match folder {
        Some(folder) => folder.join("report.html"),
        None => std::env::temp_dir().join("sinew-demo.html"),
    };
    let page_file = OutputFile::new(&page, &[])?;
    let examples = arguments.size.generate(output)?;
    let train = |fit: &train::FitArguments| {
        let sound = Inliers::new(&examples, &Silent)?;
        fit.train(sound, "demo", FileSkins::Skins(Vec::new()), output)
    };
    let trained = train(&arguments.fit)?;
    let other = train(&arguments.fit.other(trained.report.chosen().proxies.max(1)))?;
    let described = input::describe(&examples);
    let fitted = table::report(&trained.report, examples.diagonal_mm());
    let mut wrote = String::new();
    if let (Some(folder), Some(model)) = (folder, &model) {
        let clips = [Clip::regular("demo".to_owned(), 0, examples.frame_len())];
        npz::save_npz(&folder.join("demo.npz"), &examples, &clips)?;
        files::write(&[(model, &trained.model)])?;
        wrote = format!("wrote demo.npz, demo.json and demo.sinew to {}\n", folder.display());
    }
    let (html, evaluations) = report([&trained.model, &other.model], examples, output)?;
    files::write(&[(&page_file, html.as_bytes())])?;
    let named: Vec<_> = evaluations.iter().map(|of| (table::fitted(of), of)).collect();
    let text = format!(
        "a procedural arm: {described}\n{fitted}{}{wrote}wrote its report: {}\n",
        table::evaluations(&named),
        page.display()
    );
    let (evaluation, other) = (&evaluations[0], evaluations.get(1));
    let found = json!({ "report": trained.report, "evaluation": evaluation, "other": other });
    output.print(&found, &text)
}

/// Measures two models, and makes the page that shows where they err, without training other sizes.
fn report(
    models: [&[u8]; 2],
    examples: Examples,
    output: Output,
) -> anyhow::Result<(String, Vec<Evaluation>)> {
    let _measuring = Bars::busy(output, "measuring");
    let (examples, clips) = by_use(examples);
    let source = NamedExamples { examples: &examples, clips: &clips, name: "the demo's arm" };
    let name = |model: &[u8]| -> anyhow::Result<&str> {
        let model = Model::from_bytes(model)?;
        Ok(model.envelope().map_or("", |envelope| envelope.predictor().name()))
    };
    let [model, other] = models;
    let file = NamedModel { name: name(model)?, bytes: model, skin: None };
    let mut comparison = Comparison::new(source, Some(Frames::Of(Split::HeldOut)), file)?;
    comparison.compare(NamedModel { name: name(other)?, bytes: other, skin: None })?;
    let page = Page { comparison: &comparison, options: PictureOptions::default(), sizes: false };
    Ok((page.html(&Silent)?, comparison.evaluations()))
}

/// Makes the folder, tries the places of its three files, and gives that of the model.
fn prepare(folder: &Path) -> anyhow::Result<OutputFile> {
    files::make_folder(folder)?;
    for examples in ["demo.npz", "demo.json"] {
        OutputFile::new(&folder.join(examples), &[])?;
    }
    OutputFile::new(&folder.join("demo.sinew"), &[])
}
