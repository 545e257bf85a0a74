//! `sinew eval`: errors of the f32 runtime, on the file's bytes, against examples.

use super::table;
use crate::cli::{
    Bars, ModelArgs, Output, OutputFile, POSITIVE, Report, Run, StatedSpace, files, input, named,
    number,
};
use crate::evaluate::{
    Character, Evaluation, Frames, NEGLIGIBLE_PERCENT, SkinnedFrame, TrainingRecord, skin,
};
use crate::examples::{Clip, Examples, Loaded, Split, Warning, numbered};
use crate::{Error, ErrorKind};
use anyhow::{Context, bail};
use std::path::{Path, PathBuf};

/// Measures a model on examples, beside linear blend skinning
///
/// The command runs MODEL on the poses of EXAMPLES and measures the distance from their meshes, in % of the diagonal,
/// and in millimetres if MODEL or EXAMPLES have a unit.
///
/// The runtime evaluates the file's bytes in f32, as in an engine. Baselines are measured on the same frames. "LBS,
/// fitted" has 4 influences a vertex, as training fitted them. "own weights" is LBS by the joint weights that come with
/// the mesh, if EXAMPLES have any. EXAMPLES may hold new poses only: the model records its training frames. Normals are
/// measured by their angle to the true normals, which are area-weighted means of the true mesh's triangles, over the
/// area of the rest pose. Examples in other axes or another unit are converted to those of the model, if both are
/// known. Errors in % of the diagonal do not depend on the axes or the unit.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  sinew eval model.sinew walk.npz --split all")]
pub(in crate::cli) struct Eval {
    /// Write the frames' skinned positions: f32, frames x vertices x 3, in the model's axes and unit
    #[arg(long, value_name = "OUT.npy")]
    write_vertices: Option<PathBuf>,
    /// Write the frames' skinned normals: f32, frames x vertices x 3, in the model's axes
    #[arg(long, value_name = "OUT.npy")]
    write_normals: Option<PathBuf>,
    /// Fail, after printing, if the RMS error is above this share of the diagonal, in %
    #[arg(long, value_name = "PERCENT", value_parser = number(POSITIVE, " %"), allow_negative_numbers = true)]
    fail_above: Option<f64>,
    #[command(flatten)]
    measured: MeasuredArgs,
    #[command(flatten)]
    space: StatedSpace,
}

/// Model, examples and frames of a measurement.
#[derive(clap::Args)]
pub(super) struct MeasuredArgs {
    #[command(flatten)]
    pub(super) model: ModelArgs,
    /// Skin whose mesh the examples have [default: the model's first]
    #[arg(long, value_name = "NAME")]
    pub(super) skin: Option<String>,
    /// Frames to measure [default: held-out, else new, else all]
    ///
    /// The fit reads `train` frames and never `held-out` frames. `new` frames are frames that training has not read, as
    /// recorded in the model. `extreme` frames are beyond the range of motion of the training frames.
    #[arg(long, value_parser = named(SPLITS))]
    pub(super) split: Option<Frames>,
    #[command(flatten)]
    pub(super) input: input::ExampleArguments,
}

/// Frames by their use.
const SPLITS: [(&str, Frames); 5] = [
    ("train", Frames::Of(Split::Train)),
    ("held-out", Frames::Of(Split::HeldOut)),
    ("new", Frames::New),
    ("extreme", Frames::Of(Split::Extreme)),
    ("all", Frames::All),
];

impl MeasuredArgs {
    /// Loads the examples, in the space of a model.
    pub(super) fn load(
        &self,
        model: &[u8],
        space: &StatedSpace,
        output: Output,
    ) -> anyhow::Result<Loaded> {
        // Meshes of a scene's own skinning are reported below.
        let mut loaded = self.input.load(output, |warning| *warning != Warning::PlainSkin)?;
        space.set(&mut loaded.examples, self.input.named())?;
        input::convert_to_model(&mut loaded.examples, model, self.skin.as_deref());
        Ok(loaded)
    }

    /// Opens the model and the record of its training. Refuses meshes of a scene's own skinning if training had other
    /// meshes; warns of them otherwise.
    ///
    /// Training had such meshes if it has read most frames: a scene of many influences leaves an error of LBS too.
    pub(super) fn open<'a>(
        &self,
        model: &'a [u8],
        Loaded { examples, clips, warnings }: &Loaded,
        output: Output,
    ) -> anyhow::Result<(Character<'a>, TrainingRecord)> {
        let character = Character::open(model, self.skin.as_deref(), examples)
            .map_err(|error| self.blame(error, &self.model.file, clips))?;
        let recorded = TrainingRecord::of(model, &character, examples);
        if !warnings.contains(&Warning::PlainSkin) {
            return Ok((character, recorded));
        }
        let certificate = character.envelope.certificate();
        let lbs = 100.0 * certificate.lbs_training_rms / certificate.diagonal;
        let frames: Vec<usize> = (0..examples.frame_len()).collect();
        let read = recorded.read_len(&frames).unwrap_or(0);
        if f64::from(lbs) > NEGLIGIBLE_PERCENT && 2 * read < frames.len() {
            bail!(
                "{}: no shapes move and no targets are given: the meshes are the scene's own linear blend skinning, and \
                 the model has learned others; give those as --targets, as in training",
                self.input.named()
            );
        }
        output.warn(self.input.named(), Warning::PlainSkin);
        Ok((character, recorded))
    }

    /// Chooses the frames to measure.
    ///
    /// # Errors
    /// There are none, or a joint is not rigid in one of them.
    pub(super) fn frames(
        &self,
        recorded: &TrainingRecord,
        Loaded { examples, clips, .. }: &Loaded,
    ) -> anyhow::Result<Frames> {
        let source = self.input.named();
        let frames = self.split.unwrap_or_else(|| Frames::default_for(examples, recorded));
        match frames.measurable(examples, recorded) {
            Ok(_) => Ok(frames),
            Err(error) if error.kind() == ErrorKind::Missing => {
                let is_held_out = frames == Frames::Of(Split::HeldOut);
                let is_hinted = self.input.hold_out.is_none() && is_held_out;
                let hint = if is_hinted { "; see --split and --hold-out" } else { "" };
                bail!("{source}: {error}: {}{hint}", input::describe_frames(examples))
            }
            Err(error) => Err(numbered(error, clips).in_file(source).into()),
        }
    }

    /// Adds the name of the file that an error is about: the examples for a frame, else the model.
    pub(super) fn blame(&self, error: Error, model: &Path, clips: &[Clip]) -> Error {
        match error.frame() {
            Some(_) => numbered(error, clips).in_file(self.input.named()),
            None => error.in_file(model),
        }
    }
}

impl Run for Eval {
    fn run(&self, output: Output) -> anyhow::Result<Report> {
        let measured = &self.measured;
        let mut inputs = measured.input.files();
        inputs.push(measured.model.file.clone());
        let target =
            |file: &Option<PathBuf>| file.as_ref().map(|f| OutputFile::new(f, &inputs)).transpose();
        let (vertices, normals) = (target(&self.write_vertices)?, target(&self.write_normals)?);
        files::refuse_same(&[vertices.as_ref(), normals.as_ref()])?;
        let model = files::read_model(&measured.model.file)?;
        let loaded = measured.load(&model, &self.space, output)?;
        let measuring = Bars::busy(output, "measuring");
        let (character, recorded) = measured.open(&model, &loaded, output)?;
        let frames = measured.frames(&recorded, &loaded)?;
        let Loaded { examples, clips, .. } = &loaded;
        let evaluation = Evaluation::of((&character, model.len()), &recorded, examples, frames)
            .map_err(|error| measured.blame(error, &measured.model.file, clips))?;
        let chosen = frames.of(examples, &recorded);
        let mut written = Vec::new();
        for (target, attribute) in [
            (&vertices, (|frame| frame.positions) as fn(SkinnedFrame) -> Vec<f32>),
            (&normals, |frame| frame.normals),
        ] {
            let Some(target) = target else { continue };
            let bytes = skinned(&character, examples, &chosen, attribute).context("cannot skin")?;
            written.push((target, bytes));
        }
        let written: Vec<_> = written.iter().map(|(target, bytes)| (*target, &bytes[..])).collect();
        files::write(&written)?;
        drop(measuring);
        let found = evaluation.errors.rms_percent;
        let failure = self.fail_above.filter(|most| found > *most).map(|most| {
            let model = measured.model.file.display();
            format!("{model}: the error is {found:.4} %, above --fail-above {most}")
        });
        let report = Report::of(&evaluation).text(table::evaluation(&evaluation));
        Ok(report.failing(failure))
    }
}

/// Skins frames, and writes one of their attributes as an npy file.
fn skinned(
    character: &Character<'_>,
    examples: &Examples,
    frames: &[usize],
    attribute: fn(SkinnedFrame) -> Vec<f32>,
) -> anyhow::Result<Vec<u8>> {
    use npyz::WriterBuilder;
    let shape = [frames.len() as u64, examples.vertex_len() as u64, 3];
    let mut bytes = Vec::new();
    let mut writer =
        npyz::WriteOptions::new().default_dtype().shape(&shape).writer(&mut bytes).begin_nd()?;
    for &frame in frames {
        let values = attribute(skin(character, examples, frame)?);
        let own = examples.surface().of_first_copies(values.as_chunks::<3>().0);
        writer.extend(own.into_iter().flatten())?;
    }
    writer.finish()?;
    Ok(bytes)
}
