//! `sinew train`: examples in, baked model out.

use super::levels::{self, AlsoArguments};
use super::{table, warnings};
use crate::cli::bars::Bars;
use crate::cli::files::{self, OutputFile};
use crate::cli::space::{self, StatedSpace, TargetSpace};
use crate::cli::{Output, input};
use anyhow::{Context, bail};
use clap::ValueEnum;
use serde_json::json;
use sinew_runtime::Limits;
use sinew_runtime::envelope;
use sinew_trainer::check::finding::Kind;
use sinew_trainer::check::judge;
use sinew_trainer::envelope::clean::Inliers;
use sinew_trainer::envelope::lbs::blend::CANDIDATES;
use sinew_trainer::envelope::levels::AddError;
use sinew_trainer::envelope::s3::{Method, ProxyCount};
use sinew_trainer::envelope::{FileSkins, Options, Predict, TrainError, Trained, train_on};
use sinew_trainer::examples::{Split, Warning};
use sinew_trainer::progress::Silent;
use sinew_trainer::settings::Settings;
use std::path::PathBuf;

/// Fits an envelope to example poses and bakes it into a model
///
/// Held-out and extreme frames are never read by the fit: every choice is made by cross-validation
/// inside the training frames. The same input gives the same bytes for any number of threads.
#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    #[command(flatten)]
    input: input::ExampleArguments,
    /// Where to write the model
    #[arg(long, short = 'o', value_name = "MODEL")]
    output: PathBuf,
    #[command(flatten)]
    fit: FitArguments,
    #[command(flatten)]
    meshes: MeshArguments,
    /// Write every choice, fold, candidate, score and input hash to FILE, as JSON
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Fail, and write nothing, if the forecast for more of these clips is above this RMS error, in % of the diagonal
    #[arg(long, value_name = "PERCENT", value_parser = percent, allow_negative_numbers = true)]
    fail_above: Option<f64>,
    #[command(flatten)]
    space: StatedSpace,
    #[command(flatten)]
    target: TargetSpace,
}

/// Which meshes a model holds.
#[derive(clap::Args, serde::Serialize)]
struct MeshArguments {
    #[command(flatten)]
    #[serde(flatten)]
    further: AlsoArguments,
    /// Leave the mesh out: a model of a palette alone, for an engine that keeps its own meshes with
    /// their weights
    #[arg(long, conflicts_with = "also")]
    no_skin: bool,
}

/// What a fit may be told.
#[derive(Clone, clap::Args, serde::Serialize)]
pub(in crate::cli) struct FitArguments {
    /// What predicts the palette from the pose [default: kernel]
    #[arg(long, value_enum)]
    predictor: Option<Predictor>,
    /// Number of proxies, or of helpers beside the joints [default: chosen by
    /// cross-validation, from half to twice the number of joints, or of 40 where that is greater]
    #[arg(long, value_name = "P", value_parser = proxies, allow_negative_numbers = true)]
    #[arg(conflicts_with = "max_error")]
    proxies: Option<usize>,
    /// Take so many proxies that they come this near to the training frames, RMS in % of the rest
    /// diagonal, when fitted to each frame; the prediction from the pose adds to that
    #[arg(long, value_name = "PERCENT", value_parser = percent, allow_negative_numbers = true)]
    max_error: Option<f64>,
    /// Most transforms of the palette a vertex follows
    #[arg(long, value_name = "K", value_parser = influences, allow_negative_numbers = true)]
    #[arg(default_value_t = Options::default().influences)]
    influences: usize,
    /// Leave out the refinement: rotational keeps the reconstruction that S3 gives, which has not been fitted to the
    /// training meshes
    #[arg(long)]
    unrefined: bool,
    /// Fit the rotational predictor as S3 publishes it, to the letter: W and u by alternation, scale and shear with a
    /// bias, near-rigid vertices by a threshold of their error under LBS, weights and transforms anew after every merge of
    /// proxies, no refinement. It is what the others are measured against; the rest pose is not exact, and half of the
    /// file's proxies carry the bias
    #[arg(long, conflicts_with = "unrefined")]
    published: bool,
    /// Most bytes of the model's file, as 300000, 300kB (of 1000) or 300KiB (of 1024); of them a mesh takes 60 a vertex with 4 influences, 16
    /// more with texture coordinates. 12 of these turn the normals rightly; where positions would
    /// else err half as much again, they are given up, and normals go by cofactors
    #[arg(long, value_name = "BYTES", value_parser = budget, allow_negative_numbers = true)]
    budget: Option<usize>,
}

#[derive(Clone, Copy, ValueEnum, serde::Serialize)]
#[serde(rename_all = "lowercase")]
enum Predictor {
    /// Rotational regression of key gradients, reduced Poisson reconstruction
    Rotational,
    /// The joints themselves, and helpers driven by local kernel maps where LBS errs
    #[value(alias = "auto")]
    Kernel,
}

impl Predictor {
    fn predict(self) -> Predict {
        match self {
            Self::Rotational => Predict::Only(envelope::Predictor::Rotational),
            Self::Kernel => Predict::Only(envelope::Predictor::Kernel),
        }
    }
}

/// Accepts what the runtime loads by default.
fn proxies(text: &str) -> Result<usize, String> {
    input::count(text, Limits::DEFAULT.proxies as usize)
}

/// Parses a number of bytes, with or without a unit.
fn budget(text: &str) -> Result<usize, String> {
    const UNITS: [(&str, usize); 6] = [
        ("KiB", 1 << 10),
        ("MiB", 1 << 20),
        ("kB", 1_000),
        ("KB", 1_000),
        ("MB", 1_000_000),
        ("B", 1),
    ];
    let most = Limits::DEFAULT.file_bytes as usize;
    let (number, unit) = UNITS
        .into_iter()
        .find_map(|(name, unit)| Some((text.strip_suffix(name)?, unit)))
        .unwrap_or((text, 1));
    let bytes = number.trim_end().parse::<usize>().ok().and_then(|number| number.checked_mul(unit));
    bytes.filter(|bytes| (1..=most).contains(bytes)).ok_or_else(|| {
        format!(
            "expected a whole number of bytes, kB, KiB, MB or MiB, up to {most} bytes, as 300kB"
        )
    })
}

fn influences(text: &str) -> Result<usize, String> {
    input::count(text, CANDIDATES)
}

pub(super) fn percent(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(percent) if percent > 0.0 && f64::is_finite(percent) => Ok(percent),
        _ => Err("expected a number of more than 0 %".to_owned()),
    }
}

impl FitArguments {
    /// The same for the other predictor, with so many proxies.
    pub(in crate::cli) fn other(&self, proxies: usize) -> Self {
        let is_rotational = self.published || matches!(self.predictor, Some(Predictor::Rotational));
        let other = if is_rotational { Predictor::Kernel } else { Predictor::Rotational };
        Self {
            predictor: Some(other),
            proxies: Some(proxies),
            max_error: None,
            published: false,
            budget: None,
            ..*self
        }
    }

    /// Fits an envelope to judged training frames of examples that came from `source`.
    pub(in crate::cli) fn train(
        &self,
        sound: Inliers<'_>,
        source: &str,
        meshes: FileSkins,
        output: Output,
    ) -> anyhow::Result<Trained> {
        let predictor = match (self.published, self.predictor) {
            (true, None | Some(Predictor::Rotational)) => Predict::Published,
            (true, _) => bail!("--published is a way to fit --predictor rotational, and no other"),
            (false, predictor) => predictor.unwrap_or(Predictor::Kernel).predict(),
        };
        let most = Method::Published.proxies_max();
        if self.published && self.proxies.is_some_and(|count| count > most) {
            bail!("--published: a file has room for {most} proxies, for each takes that of two")
        }
        let triangles = sound.training.examples.triangles.len();
        let proxies = match (self.max_error, self.proxies) {
            (Some(percent), _) => Some(ProxyCount::MaxError(percent / 100.0)),
            (None, Some(count)) if count > triangles => {
                bail!("--proxies: {source} has {triangles} triangles, {count} proxies are too many")
            }
            (None, count) => count.map(ProxyCount::Fixed),
        };
        let options = Options {
            predictor,
            proxies,
            influences: self.influences,
            refine: !self.unrefined,
            budget: self.budget,
            meshes,
            settings: Settings::default(),
        };
        train_on(sound, &options, &Bars::new(output)).map_err(|error| match error {
            // It names the further mesh, whose fault it is.
            TrainError::Level(AddError::Level(error)) => error.into(),
            error => anyhow::Error::new(error).context(source.to_owned()),
        })
    }
}

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let mut inputs = arguments.input.files();
    inputs.extend_from_slice(&arguments.meshes.further.also);
    let model = OutputFile::new(&arguments.output, &inputs)?.of_a_model()?;
    let record_file = arguments.record.as_ref().map(|file| OutputFile::new(file, &inputs));
    let record_file = record_file.transpose()?;
    if record_file.as_ref().is_some_and(|file| file.is(&model)) {
        bail!("cannot write {}: model and record are one file", arguments.output.display());
    }
    let mut hashes = arguments.input.hashes()?;
    let input::LoadedInput { mut examples, clips, warnings: told } =
        arguments.input.load_to_check(output)?;
    // The check says itself what validation finds.
    let own = told.iter().filter(|warning| !warning.is_of_validation());
    let mut said: Vec<String> = own.map(ToString::to_string).collect();
    let source = arguments.input.named();
    arguments.space.say(&mut examples, &source)?;
    let from = examples.space;
    let conversion = arguments.target.convert(&mut examples, &source)?;
    let further = &arguments.meshes.further;
    let also = &further.also;
    let meshes = match arguments.meshes.no_skin {
        true => FileSkins::PaletteAlone,
        false => {
            let levels = further.load(conversion.as_ref(), &examples.space, output)?;
            FileSkins::Skins(levels)
        }
    };
    further.check_names()?;
    hashes.extend(also.iter().map(|file| input::hash(file)).collect::<anyhow::Result<Vec<_>>>()?);
    let (checked, sound) = judge(&examples, &clips, &Silent).with_context(|| source.clone())?;
    // Kernel maps have no half turn at which they jump.
    let FitArguments { predictor, published, .. } = arguments.fit;
    let jumps = published || matches!(predictor, Some(Predictor::Rotational));
    let findings = checked.findings.iter().filter(warnings::is_told);
    for finding in findings.filter(|finding| jumps || finding.kind != Kind::HalfTurn) {
        output.warn(&source, &finding.text);
        said.push(finding.text.clone());
    }
    let trained = arguments.fit.train(sound, &source, meshes, output)?;
    let diagonal_mm = examples.diagonal_mm();
    levels::warn(&trained.levels, also, diagonal_mm, output);
    let lbs = 100.0 * trained.report.lbs_rms;
    let forecast = 100.0 * trained.report.same_clips_rms;
    let known = told.contains(&Warning::PlainSkin);
    if let Some(text) = warnings::no_gain(forecast, lbs, diagonal_mm, known) {
        output.warn(&source, &text);
        said.push(text);
    }
    if let Some(most) = arguments.fail_above.filter(|most| forecast > *most) {
        bail!(
            "{source}: the forecast for more of these clips is {forecast:.4} %, above --fail-above {most}: nothing was written"
        );
    }
    let is_left_out = |frame: &usize| trained.report.left_out.iter().any(|out| out.frame == *frame);
    let mut fitted_to = examples.frames_of(Split::Train);
    fitted_to.retain(|frame| !is_left_out(frame));
    let mut record = json!({
        "sinew": env!("CARGO_PKG_VERSION"),
        "inputs": hashes,
        "warnings": said,
        "vertices": examples.vertex_len(),
        "engine_vertices": examples.surface().engine_len(),
        "joints": examples.joint_len(),
        "hold_out": arguments.input.hold_out,
        "hold_out_clips": arguments.input.hold_out_clip,
        "fps": arguments.input.fps,
        "clip": arguments.input.clip,
        "training_frames": fitted_to,
        "held_out_frames": examples.frames_of(Split::HeldOut),
        "extreme_frames": examples.frames_of(Split::Extreme),
        "diagonal": examples.diagonal(),
        "ranges": examples.ranges.iter().map(|(name, range)| {
            json!({ "name": name, "start": range.start, "end": range.end })
        }).collect::<Vec<_>>(),
        "source_space": space::as_json(&from),
        "space": space::as_json(&examples.space),
        "options": arguments.fit,
        "meshes": arguments.meshes,
        "levels": levels::as_json(&trained.levels, diagonal_mm),
        "predictor": trained.report.chosen().predictor,
        "proxies": trained.report.chosen().proxies,
        "report": trained.report,
        "model_bytes": trained.model.len(),
    });
    if let Some(diagonal) = diagonal_mm {
        record["diagonal_mm"] = json!(diagonal);
        for (key, rms) in [
            ("lbs_rms_mm", Some(trained.report.lbs_rms)),
            ("own_weights_rms_mm", trained.report.own_weights_rms),
            ("training_rms_mm", Some(trained.report.training_rms)),
            ("same_clips_rms_mm", Some(trained.report.same_clips_rms)),
            ("other_clip_rms_mm", trained.report.other_clip_rms),
        ] {
            if let Some(rms) = rms {
                record[key] = json!(rms * diagonal);
            }
        }
    }
    // The model last, so that none ever stands without its record.
    let record_bytes = serde_json::to_vec_pretty(&record)?;
    let record_file = record_file.as_ref().map(|file| (file, record_bytes.as_slice()));
    let files: Vec<_> =
        record_file.into_iter().chain([(&model, trained.model.as_slice())]).collect();
    files::write(&files)?;
    let text = format!(
        "{}\n{}{}wrote {} ({} bytes)",
        input::describe(&examples),
        table::report(&trained.report, diagonal_mm),
        levels::table(&trained.levels, diagonal_mm),
        arguments.output.display(),
        trained.model.len()
    );
    output.print(&record, &text)
}

#[cfg(test)]
mod tests {
    use super::budget;

    #[test]
    fn sizes_have_units() {
        let read = |text: &str| budget(text).ok();
        for (text, bytes) in [
            ("300000", 300_000),
            ("300kB", 300_000),
            ("300 kB", 300_000),
            ("300KB", 300_000),
            ("2MB", 2_000_000),
            ("3KiB", 3072),
            ("1MiB", 1 << 20),
            ("7B", 7),
        ] {
            assert_eq!(read(text), Some(bytes), "{text}");
        }
        for text in ["", "kB", "0", "-1", "1e3", "3q", "3TB", "1.5MB", "99999999999999999999MB"] {
            assert_eq!(read(text), None, "{text}");
        }
    }
}
