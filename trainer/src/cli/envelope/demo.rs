//! `sinew demo` and `export-demo`: a character that needs no download, trained here or written for other programs.

use super::table;
use super::train;
use crate::cli::{Bars, Output, OutputFile, Report, Run, count, files, input};
use crate::envelope::FileSkins;
use crate::envelope::clean::Inliers;
use crate::evaluate::{Evaluation, Frames};
use crate::examples::demo::{DemoOptions, demo};
use crate::examples::{Clip, Examples, Split, npz};
use crate::export::{by_use, demo_glb};
use crate::formats::save_pc2;
use crate::progress::Silent;
use crate::report::comparison::{Comparison, NamedExamples, NamedModel};
use crate::report::{Page, PictureOptions};
use anyhow::bail;
use sinew_runtime::{Envelope, Model};
use std::path::{Path, PathBuf};

/// The demo has no inputs.
const NONE: [&Path; 0] = [];

/// Maximum number of positions in all frames together, 2.4 GB of positions.
const POSITIONS_MAX: usize = 100_000_000;

/// Trains, bakes and measures a generated arm; needs no input
///
/// The command generates a procedural arm, trains an envelope on it, bakes it, and measures the baked model on poses
/// that the training has not seen. A model of the other predictor with as many helpers is measured too: rotational
/// regression, where the method began, beside kernel maps.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  sinew demo --vertices 500 --poses 40 -o demo")]
pub(in crate::cli) struct Demo {
    /// Folder for examples (demo.npz, demo.json), model (demo.sinew) and report (report.html); made if needed
    /// [default: the report alone, in the system's temporary folder]
    #[arg(short, long, alias = "out", value_name = "DIR")]
    output: Option<PathBuf>,
    #[command(flatten)]
    size: SizeArguments,
    #[command(flatten)]
    fit: train::FitArguments,
}

/// Size of the arm.
#[derive(clap::Args)]
#[command(next_help_heading = "Generated arm")]
struct SizeArguments {
    /// Approximate number of vertices; at least 200 are made
    #[arg(long, value_name = "V", value_parser = count(1, POSITIONS_MAX), allow_negative_numbers = true)]
    #[arg(default_value_t = DemoOptions::default().vertices)]
    vertices: usize,
    /// Number of training poses
    #[arg(long, value_name = "N", value_parser = count(1, POSITIONS_MAX), allow_negative_numbers = true)]
    #[arg(default_value_t = DemoOptions::default().poses)]
    poses: usize,
    /// Number of held-out poses
    #[arg(long, value_name = "N", value_parser = count(1, POSITIONS_MAX), allow_negative_numbers = true)]
    #[arg(default_value_t = DemoOptions::default().held_out)]
    held_out: usize,
    /// Seed of the poses
    #[arg(long, default_value_t = DemoOptions::default().seed)]
    seed: u64,
}

impl SizeArguments {
    /// Generates the demo's examples.
    fn generate(&self, output: Output) -> anyhow::Result<Examples> {
        let &Self { vertices, poses, held_out, seed } = self;
        let positions = (poses + held_out).checked_mul(vertices);
        if positions.is_none_or(|positions| positions > POSITIONS_MAX) {
            bail!("--vertices x (--poses + --held-out): expected at most {POSITIONS_MAX}");
        }
        let _generating = Bars::busy(output, "generating");
        Ok(demo(&DemoOptions { vertices, poses, held_out, seed }))
    }
}

impl Run for Demo {
    fn run(&self, output: Output) -> anyhow::Result<Report> {
        let folder = self.output.as_deref();
        let model = folder.map(prepare).transpose()?;
        let page = match folder {
            Some(folder) => folder.join("report.html"),
            None => std::env::temp_dir().join("sinew-demo.html"),
        };
        let page_file = OutputFile::new(&page, NONE)?;
        let examples = self.size.generate(output)?;
        let train = |fit: &train::FitArguments| {
            let sound = Inliers::new(&examples, &Silent)?;
            fit.train(sound, "demo", FileSkins::Skins(Vec::new()), output)
        };
        let trained = train(&self.fit)?;
        let other = train(&self.fit.other(trained.report.chosen().proxies.max(1)))?;
        let described = format!("a procedural arm: {}", input::describe(&examples));
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
        Ok(Report::default()
            .json("report", &trained.report)
            .json("evaluation", &evaluations[0])
            .json("other", evaluations.get(1))
            .text(described)
            .text(fitted + &table::evaluations(&named) + &wrote)
            .text(format!("wrote its report: {}", page.display())))
    }
}

/// Measures two models and makes a page that shows their errors, without training other sizes.
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
        Ok(model.first::<Envelope>().map_or("", |envelope| envelope.predictor().name()))
    };
    let [model, other] = models;
    let file = NamedModel { name: name(model)?, bytes: model, skin: None };
    let mut comparison = Comparison::new(source, Some(Frames::Of(Split::HeldOut)), file)?;
    comparison.compare(NamedModel { name: name(other)?, bytes: other, skin: None })?;
    let page = Page { comparison: &comparison, options: PictureOptions::default(), sizes: false };
    Ok((page.html(&Silent)?, comparison.evaluations()))
}

/// Makes the folder, checks that its three files can be written, and returns the file of the model.
fn prepare(folder: &Path) -> anyhow::Result<OutputFile> {
    files::make_folder(folder)?;
    for examples in ["demo.npz", "demo.json"] {
        OutputFile::new(&folder.join(examples), NONE)?;
    }
    OutputFile::new(&folder.join("demo.sinew"), NONE)
}

/// Writes the demo's rig and meshes as an artist exports them
///
/// demo.glb holds the skeleton, the rest mesh with four LBS weights a vertex, and two animations at 30 frames a second:
/// train and held-out. demo.pc2 is a point cache of the arm's meshes in those frames, with the vertices of demo.glb in
/// order.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  sinew export-demo demo")]
pub(in crate::cli) struct ExportDemo {
    /// Folder for demo.glb and demo.pc2; made if needed
    folder: PathBuf,
    #[command(flatten)]
    size: SizeArguments,
}

impl Run for ExportDemo {
    fn run(&self, output: Output) -> anyhow::Result<Report> {
        let folder = &self.folder;
        files::make_folder(folder)?;
        let [glb, pc2] = ["demo.glb", "demo.pc2"].map(|name| folder.join(name));
        let target = OutputFile::new(&glb, NONE)?;
        OutputFile::new(&pc2, NONE)?;
        let (examples, clips) = by_use(self.size.generate(output)?);
        let bytes = demo_glb(&examples, &clips)?;
        save_pc2(&pc2, examples.vertex_len(), &examples.vertices)?;
        files::write(&[(&target, &bytes)])?;
        let command = format!(
            "sinew train {} --targets {} --hold-out-clip held-out -o demo.sinew",
            glb.display(),
            pc2.display()
        );
        Ok(Report::default()
            .text(format!("a procedural arm: {}", input::describe(&examples)))
            .text(format!(
                "wrote demo.glb (skeleton, LBS skin, animations) and demo.pc2 (meshes) to {}",
                folder.display()
            ))
            .json("files", [glb, pc2])
            .text(format!("next: {command}"))
            .json("next", command))
    }
}
