//! `sinew train`: examples in, baked model out.

use super::levels::{self, AlsoArguments};
use super::table;
use crate::check::finding::{Finding, Kind, Severity};
use crate::check::judge;
use crate::cli::arguments::TargetSpace;
use crate::cli::{
    Bars, Output, OutputFile, POSITIVE, Report, Run, StatedSpace, count, counted, files, input,
    number, space_as_json,
};
use crate::envelope::choose::report::TrainingReport;
use crate::envelope::clean::Inliers;
use crate::envelope::lbs::blend::CANDIDATES;
use crate::envelope::levels::check_places;
use crate::envelope::s3::{Method, ProxyCount};
use crate::envelope::{FileSkins, Options, Predict, Trained, train_on};
use crate::evaluate::NEGLIGIBLE_PERCENT;
use crate::examples::{Loaded, Split, Warning};
use crate::progress::Silent;
use crate::settings::{Settings, TIED, UNSEEN};
use crate::space::beside;
use anyhow::{Context, bail};
use clap::ValueEnum;
use serde_json::json;
use sinew_runtime::{Limits, envelope};
use std::path::PathBuf;

/// Fits an envelope to example poses and bakes it into a model
///
/// The fit never reads held-out and extreme frames: every choice is made by cross-validation inside the training
/// frames. Equal input gives equal bytes for any number of threads.
#[derive(clap::Args)]
#[command(
    after_help = "Example:\n  sinew train walk.glb --targets walk.abc --hold-out 0.25 -o model.sinew"
)]
pub(in crate::cli) struct Train {
    /// Model to write
    #[arg(short, long, alias = "out", value_name = "MODEL")]
    output: PathBuf,
    /// Write every choice, fold, candidate, score and input hash as JSON
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Fail, and write nothing, if the forecast for more of these clips is above this RMS error in % of the diagonal
    #[arg(long, value_name = "PERCENT", value_parser = number(POSITIVE, " %"), allow_negative_numbers = true)]
    fail_above: Option<f64>,
    #[command(flatten)]
    input: input::ExampleArguments,
    #[command(flatten)]
    fit: FitArguments,
    #[command(flatten)]
    meshes: MeshArguments,
    #[command(flatten)]
    space: StatedSpace,
    #[command(flatten)]
    target: TargetSpace,
}

/// Meshes of the model.
#[derive(clap::Args, serde::Serialize)]
#[command(next_help_heading = "Meshes")]
struct MeshArguments {
    /// Leave the mesh out: the model predicts a palette, for an engine that keeps its own meshes and weights
    #[arg(long, conflicts_with = "also")]
    no_skin: bool,
    #[command(flatten)]
    #[serde(flatten)]
    further: AlsoArguments,
}

/// Options of a fit.
#[derive(Clone, clap::Args, serde::Serialize)]
#[command(next_help_heading = "Fit")]
pub(in crate::cli) struct FitArguments {
    /// Predictor of the palette from the pose [default: kernel]
    #[arg(long, value_enum)]
    predictor: Option<Predictor>,
    /// Number of helpers [default: chosen by cross-validation, from half to twice the number of joints or of 40,
    /// whichever is greater]
    #[arg(long = "helpers", alias = "proxies", value_name = "P", allow_negative_numbers = true)]
    #[arg(value_parser = count(1, Limits::DEFAULT.proxies as usize), conflicts_with = "max_error")]
    proxies: Option<usize>,
    /// Transforms of helpers: affine, or trs for engines whose bones hold translation, rotation and scale, or rigid
    #[arg(long, value_enum, default_value_t = HelperKind::Affine, value_name = "KIND")]
    helper_kind: HelperKind,
    /// Take enough helpers to come this near to the training frames when fitted to each frame, RMS in % of the rest
    /// diagonal; the prediction from the pose adds to this error
    #[arg(long, value_name = "PERCENT", value_parser = number(POSITIVE, " %"), allow_negative_numbers = true)]
    max_error: Option<f64>,
    /// Maximum number of palette transforms that a vertex follows
    #[arg(long, value_name = "K", value_parser = count(1, CANDIDATES), allow_negative_numbers = true)]
    #[arg(default_value_t = Options::default().influences)]
    influences: usize,
    /// Leave out the refinement: rotational keeps the reconstruction of S3, not fitted to the training meshes
    #[arg(long)]
    unrefined: bool,
    /// Fit the rotational predictor exactly as published in S3, as a reference for the others
    ///
    /// W and u are fitted by alternation, scale and shear with a bias. Vertices are near-rigid below a threshold of
    /// their error under LBS. Every merge of helpers fits weights and transforms anew, and there is no refinement. The
    /// rest pose is not exact, and half of the file's helpers carry the bias.
    #[arg(long, conflicts_with = "unrefined")]
    published: bool,
    /// Maximum size of the model's file, as 300000, 300kB (of 1000) or 300KiB (of 1024)
    ///
    /// A mesh takes 60 bytes a vertex with 4 influences, and 16 more with texture coordinates. 12 of these make the
    /// normals right. If positions had half as much error again, these 12 are left out, and normals go by cofactors.
    #[arg(long, value_name = "BYTES", value_parser = budget, allow_negative_numbers = true)]
    budget: Option<usize>,
}

#[derive(Clone, Copy, ValueEnum, serde::Serialize)]
#[serde(rename_all = "lowercase")]
enum Predictor {
    /// Rotational regression of key gradients, reduced Poisson reconstruction
    Rotational,
    /// The joints themselves, and helpers driven by local kernel maps where LBS has an error
    #[value(alias = "auto")]
    Kernel,
}

#[derive(Clone, Copy, PartialEq, ValueEnum, serde::Serialize)]
#[serde(rename_all = "lowercase")]
enum HelperKind {
    /// Any affine transform: the smallest error
    Affine,
    /// Translation, rotation and scale along the model's axes at rest
    Trs,
    /// Translation and rotation
    Rigid,
}

impl HelperKind {
    fn kind(self) -> envelope::HelperKind {
        match self {
            Self::Affine => envelope::HelperKind::Affine,
            Self::Trs => envelope::HelperKind::Trs,
            Self::Rigid => envelope::HelperKind::Rigid,
        }
    }
}

impl Predictor {
    fn predict(self) -> Predict {
        match self {
            Self::Rotational => Predict::Only(envelope::Predictor::Rotational),
            Self::Kernel => Predict::Only(envelope::Predictor::Kernel),
        }
    }
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

impl FitArguments {
    /// Returns the options for the other predictor, with a number of helpers.
    pub(super) fn other(&self, proxies: usize) -> Self {
        let is_rotational = self.published || matches!(self.predictor, Some(Predictor::Rotational));
        let other = if is_rotational { Predictor::Kernel } else { Predictor::Rotational };
        Self {
            predictor: Some(other),
            proxies: Some(proxies),
            max_error: None,
            helper_kind: HelperKind::Affine,
            published: false,
            budget: None,
            ..*self
        }
    }

    /// Fits an envelope to the training frames of examples from `source`.
    pub(super) fn train(
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
            bail!(
                "--published: a file has room for {most} helpers, since each takes the room of two"
            )
        }
        let examples = sound.training.examples;
        let triangles = examples.triangles.len();
        let proxies = match (self.max_error, self.proxies) {
            (Some(percent), _) => Some(ProxyCount::MaxError(percent / 100.0)),
            (None, Some(count)) if count > triangles => {
                bail!("--helpers: {source} has {triangles} triangles, {count} helpers are too many")
            }
            (None, count) => count.map(ProxyCount::Fixed),
        };
        let options = Options {
            predictor,
            proxies,
            helper_kind: self.helper_kind.kind(),
            influences: self.influences,
            refine: !self.unrefined,
            budget: self.budget,
            meshes,
            settings: Settings::default(),
        };
        if let FileSkins::Skins(further) = &options.meshes {
            // Checked here, because a later error would get the name of the examples.
            check_places(further, examples)?;
        }
        let trained = train_on(sound, &options, &Bars::new(output));
        Ok(trained.map_err(|error| error.in_file(source))?)
    }
}

impl Run for Train {
    fn run(&self, output: Output) -> anyhow::Result<Report> {
        let further = &self.meshes.further;
        let also = &further.also;
        let mut inputs = self.input.files();
        inputs.extend_from_slice(also);
        let model = OutputFile::new(&self.output, &inputs)?.of_a_model()?;
        let record_file = self.record.as_ref().map(|file| OutputFile::new(file, &inputs));
        let record_file = record_file.transpose()?;
        if record_file.as_ref().is_some_and(|file| file.is(&model)) {
            bail!("cannot write {}: model and record are one file", self.output.display());
        }
        let mut hashes = self.input.hashes()?;
        // The check reports the findings of validation itself.
        let loaded = self.input.load(output, |warning| !warning.is_of_validation())?;
        let Loaded { mut examples, clips, warnings } = loaded;
        let own = warnings.iter().filter(|warning| !warning.is_of_validation());
        let mut recorded: Vec<String> = own.map(ToString::to_string).collect();
        let source = self.input.named();
        self.space.set(&mut examples, &source)?;
        let from = examples.space;
        let conversion = self.target.convert(&mut examples, &source)?;
        let meshes = match self.meshes.no_skin {
            true => FileSkins::PaletteAlone,
            false => {
                FileSkins::Skins(further.load(conversion.as_ref(), &examples.space, output)?)
            }
        };
        further.check_names()?;
        for file in also {
            hashes.push(input::hash(file)?);
        }
        let (checked, sound) = judge(&examples, &clips, &Silent).with_context(|| source.clone())?;
        // Kernel maps do not jump at half turns.
        let FitArguments { predictor, published, .. } = self.fit;
        let jumps = published || matches!(predictor, Some(Predictor::Rotational));
        let findings = checked.findings.iter().filter(|finding| is_printed(finding));
        for finding in findings.filter(|finding| jumps || finding.kind != Kind::HalfTurn) {
            output.warn(&source, &finding.text);
            recorded.push(finding.text.clone());
        }
        if jumps && !examples.curve_names.is_empty() {
            let curves = counted(examples.curve_names.len(), "curve", "curves");
            let text =
                format!("the predictor rotational follows joints alone and leaves out {curves}");
            output.warn(&source, &text);
            recorded.push(text);
        }
        let Trained { model: bytes, report, levels } =
            self.fit.train(sound, &source, meshes, output)?;
        let diagonal_mm = examples.diagonal_mm();
        levels::warn(&levels, also, diagonal_mm, output);
        let (lbs, forecast) = (100.0 * report.lbs_rms, 100.0 * report.same_clips_rms);
        let is_known = warnings.contains(&Warning::PlainSkin);
        let warning = refused(&report).or_else(|| no_gain(forecast, lbs, diagonal_mm, is_known));
        if let Some(text) = warning {
            output.warn(&source, &text);
            recorded.push(text);
        }
        if let Some(most) = self.fail_above.filter(|most| forecast > *most) {
            bail!(
                "{source}: the forecast for more of these clips is {forecast:.4} %, above --fail-above {most}: \
                 nothing was written"
            );
        }
        let is_left_out = |frame: &usize| report.left_out.iter().any(|out| out.frame == *frame);
        let mut fitted_to = examples.frames_of(Split::Train);
        fitted_to.retain(|frame| !is_left_out(frame));
        let ranges = examples
            .ranges
            .iter()
            .map(|(name, range)| json!({ "name": name, "start": range.start, "end": range.end }));
        let mut record = Report::default()
            .json("sinew", env!("CARGO_PKG_VERSION"))
            .json("inputs", hashes)
            .json("warnings", recorded)
            .json("vertices", examples.vertex_len())
            .json("engine_vertices", examples.surface().engine_len())
            .json("joints", examples.joint_len())
            .json("hold_out", self.input.hold_out)
            .json("hold_out_clips", &self.input.hold_out_clip)
            .json("fps", self.input.fps)
            .json("clip", &self.input.clip)
            .json("training_frames", fitted_to)
            .json("held_out_frames", examples.frames_of(Split::HeldOut))
            .json("extreme_frames", examples.frames_of(Split::Extreme))
            .json("diagonal", examples.diagonal())
            .json("ranges", ranges.collect::<Vec<_>>())
            .json("source_space", space_as_json(&from))
            .json("space", space_as_json(&examples.space))
            .json("options", &self.fit)
            .json("meshes", &self.meshes)
            .json("predictor", report.chosen().predictor)
            .json("proxies", report.chosen().proxies)
            .json("report", &report)
            .json("model_bytes", bytes.len())
            .text(input::describe(&examples))
            .text(table::report(&report, diagonal_mm))
            .list("levels", levels::report(&levels, diagonal_mm))
            .text(files::wrote(&model, &bytes));
        if let Some(diagonal) = diagonal_mm {
            record = record.json("diagonal_mm", diagonal);
            for (key, rms) in [
                ("lbs_rms_mm", Some(report.lbs_rms)),
                ("own_weights_rms_mm", report.own_weights_rms),
                ("training_rms_mm", Some(report.training_rms)),
                ("same_clips_rms_mm", Some(report.same_clips_rms)),
                ("other_clip_rms_mm", report.other_clip_rms),
            ] {
                record = rms.into_iter().fold(record, |out, rms| out.json(key, rms * diagonal));
            }
        }
        // The record first, so that no model is without its record.
        let record_bytes = serde_json::to_vec_pretty(&record.as_json())?;
        let record_file = record_file.as_ref().map(|file| (file, record_bytes.as_slice()));
        let files: Vec<_> = record_file.into_iter().chain([(&model, bytes.as_slice())]).collect();
        files::write(&files)?;
        Ok(record)
    }
}

/// Share of LBS's error above which a model is hardly better.
const HARDLY: f64 = 0.9;

/// Returns whether a training prints a finding of the check: a warning, or triangles that the fit leaves out. Examples
/// of one pose or too far from the origin are refused by an error instead.
fn is_printed(finding: &Finding) -> bool {
    match finding.kind {
        Kind::OnePose | Kind::TooFar => false,
        Kind::NoArea => true,
        _ => finding.severity == Severity::Warning,
    }
}

/// Returns a warning of helpers that lose to LBS on other clips.
fn refused(report: &TrainingReport) -> Option<String> {
    let refused = report.refused?;
    let (percent, helpers) =
        (100.0 * refused.other_clip_rms, report.candidates[refused.candidate].proxies);
    Some(format!(
        "helpers are worse than linear blend skinning on clips left out, off by {percent:.4} % of the diagonal, so the \
         model has none: the pose does not explain the skin. Give the curves that move it, or more clips; \
         `--helpers {helpers}` keeps the helpers"
    ))
}

/// Returns a warning if a model gains nothing over LBS.
///
/// - `forecast`, `lbs`: forecast for more of these clips, and error of LBS, in % of the diagonal.
/// - `is_known`: whether an earlier warning said that LBS has no error.
fn no_gain(forecast: f64, lbs: f64, diagonal_mm: Option<f64>, is_known: bool) -> Option<String> {
    match lbs <= NEGLIGIBLE_PERCENT {
        true if !is_known => Some(nothing(lbs)),
        _ if forecast > NEGLIGIBLE_PERCENT => hardly(forecast, lbs, diagonal_mm),
        _ => None,
    }
}

/// Warns that LBS has no error to learn from.
///
/// - `lbs`: error of LBS in % of the diagonal.
fn nothing(lbs: f64) -> String {
    format!(
        "linear blend skinning gives these meshes to within {lbs:.6} % of the diagonal: there is nothing to learn, and \
         skinning alone does as well; give meshes of muscles, a simulation or correctives"
    )
}

/// Warns if a model is hardly better than LBS, no better, or worse. Errors are in % of the diagonal.
fn hardly(forecast: f64, lbs: f64, diagonal_mm: Option<f64>) -> Option<String> {
    if forecast <= HARDLY * lbs {
        return None;
    }
    let [own, of_lbs] =
        [forecast, lbs].map(|percent| format!("{percent:.4} %{}", beside(percent, diagonal_mm)));
    let is_tied = forecast <= TIED * lbs && lbs <= TIED * forecast;
    let (how, figures) = match own == of_lbs {
        true => ("no better", format!("both are off by {own} of the diagonal")),
        false => {
            let how = if is_tied {
                "no better"
            } else if forecast > lbs {
                "worse"
            } else {
                "hardly better"
            };
            (how, format!("it is off by {own} of the diagonal, linear blend skinning by {of_lbs}"))
        }
    };
    let then = match lbs <= 100.0 * UNSEEN && is_tied {
        true => "skinning alone does as well, and nobody sees so small an error",
        false => "`sinew check` shows the gaps of the examples",
    };
    Some(format!(
        "the model is {how} than linear blend skinning on poses that it has not seen: {figures}; {then}"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

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

    #[test]
    fn equal_figures_are_not_called_worse() {
        let warning = |validated, lbs| hardly(validated, lbs, None).unwrap();
        let tie = warning(0.002_012, 0.001_998);
        assert!(
            tie.contains("is no better than linear") && tie.contains("both are off by 0.0020 % of"),
            "{tie}"
        );
        assert!(tie.contains("skinning alone does as well"), "{tie}");
        let tie = warning(0.5004, 0.5);
        assert!(
            tie.contains("no better") && tie.contains("0.5004 %") && tie.contains("by 0.5000 %"),
            "{tie}"
        );
        assert!(
            warning(0.6, 0.5).contains("is worse than")
                && warning(0.46, 0.5).contains("hardly better than")
        );
        assert_eq!(hardly(0.4, 0.5, None), None);
        let known = hardly(0.6, 0.5, Some(2000.0)).unwrap();
        assert!(
            known.contains("0.6000 % (12.000 mm)") && known.contains("0.5000 % (10.000 mm)"),
            "{known}"
        );
        let warning = |lbs, known| no_gain(0.5, lbs, None, known).unwrap();
        assert!(
            warning(0.0, false).contains("nothing to learn")
                && warning(0.0, true).contains("worse")
        );
        assert_eq!(no_gain(0.0, 0.0, None, true), None);
    }
}
