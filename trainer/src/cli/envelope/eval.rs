//! `sinew eval`: the f32 runtime on the file's bytes against examples.

use super::measured::{SplitName, blame, refuse_forgotten_targets};
use super::table;
use super::train::percent;
use crate::cli::bars::Bars;
use crate::cli::files::{self, OutputFile};
use crate::cli::space::StatedSpace;
use crate::cli::{Output, input};
use anyhow::{Context, bail};
use sinew_trainer::evaluate::{Character, Evaluation, Frames, SkinnedFrame, TrainingRecord, skin};
use sinew_trainer::examples::Examples;
use std::path::PathBuf;

/// Measures a model on examples, beside linear blend skinning
///
/// It runs MODEL on the poses of EXAMPLES and measures the distance from their meshes, in % of the diagonal, and in
/// millimetres where MODEL or EXAMPLES have a unit.
///
/// The runtime evaluates the file's bytes in f32, as an engine would. Baselines are measured on
/// the same frames. "LBS, fitted" has 4 influences a vertex, as training fitted them. "own weights" is LBS by the
/// joint weights that come with the mesh, where EXAMPLES have any. EXAMPLES may be new poses alone: the model knows which
/// frames it was trained on. Normals are measured by their angle to the true
/// ones, the area-weighted mean of the true mesh's triangles, over the area of the rest pose. Examples in other axes or another unit than
/// the model's are converted, where both are known. Errors in % of the diagonal do not depend on them.
#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    /// A model that `sinew train` wrote
    model: PathBuf,
    #[command(flatten)]
    input: input::ExampleArguments,
    /// The skin to measure, whose mesh the examples' is [default: the model's first]
    #[arg(long, value_name = "NAME")]
    skin: Option<String>,
    /// Which frames [default: held-out; where none is held out, those that training has not read; where it has
    /// read all, those]
    #[arg(long, value_enum)]
    split: Option<SplitName>,
    /// Write the frames' skinned positions to OUT.npy, f32, frames x vertices x 3, in the model's axes
    /// and unit
    #[arg(long, value_name = "OUT.npy")]
    write_vertices: Option<PathBuf>,
    /// Write the frames' skinned normals to OUT.npy, f32, frames x vertices x 3, in the model's axes
    #[arg(long, value_name = "OUT.npy")]
    write_normals: Option<PathBuf>,
    /// Fail, after writing and printing what is measured, if the error is above so many % of the diagonal, RMS
    #[arg(long, value_name = "PERCENT", value_parser = percent, allow_negative_numbers = true)]
    fail_above: Option<f64>,
    #[command(flatten)]
    space: StatedSpace,
}

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let mut inputs = arguments.input.files();
    inputs.push(arguments.model.clone());
    let target =
        |file: &Option<PathBuf>| file.as_ref().map(|f| OutputFile::new(f, &inputs)).transpose();
    let (vertices, normals) =
        (target(&arguments.write_vertices)?, target(&arguments.write_normals)?);
    if let (Some(vertices), Some(normals)) = (&vertices, &normals)
        && vertices.is(normals)
    {
        bail!("cannot write {}: two outputs are one file", normals.named().display());
    }
    let model = input::read_model(&arguments.model)?;
    let loaded = arguments.input.load_to_measure(output)?;
    let input::LoadedInput { mut examples, clips, warnings } = loaded;
    arguments.space.say(&mut examples, &arguments.input.named())?;
    let skin = arguments.skin.as_deref();
    input::convert_to_model(&mut examples, &model, skin);
    let measuring = Bars::busy(output, "measuring");
    let blamed = |error| blame(error, &arguments.model, &arguments.input, (&examples, &clips));
    let character = Character::open(&model, skin, &examples).map_err(blamed)?;
    let told = TrainingRecord::of(&model, &character, &examples);
    let known = (&character, &told);
    refuse_forgotten_targets(&arguments.input, &warnings, known, &examples, output)?;
    let usual = || Frames::usual(&examples, &told);
    let frames = arguments.split.map_or_else(usual, SplitName::frames);
    let measured = (&character, model.len());
    let evaluation = Evaluation::of(measured, &told, &examples, frames).map_err(blamed)?;
    let mut written = Vec::new();
    for (target, attribute) in [
        (&vertices, SkinnedFrame::positions as fn(&SkinnedFrame) -> &[f32]),
        (&normals, SkinnedFrame::normals),
    ] {
        let Some(target) = target else { continue };
        let chosen = frames.of(&examples, &told);
        let bytes = skinned(&character, &examples, &chosen, attribute).context("cannot skin")?;
        written.push((target, bytes));
    }
    let written: Vec<_> = written.iter().map(|(target, bytes)| (*target, &bytes[..])).collect();
    files::write(&written)?;
    drop(measuring);
    output.print(&evaluation, &table::evaluation(&evaluation))?;
    let found = evaluation.errors.rms_percent;
    match arguments.fail_above {
        Some(most) if found > most => bail!(
            "{}: the error is {found:.4} %, above --fail-above {most}",
            arguments.model.display()
        ),
        _ => Ok(()),
    }
}

/// Skins frames, and writes one of their attributes into the bytes of an npy file.
fn skinned(
    character: &Character<'_>,
    examples: &Examples,
    frames: &[usize],
    attribute: fn(&SkinnedFrame) -> &[f32],
) -> anyhow::Result<Vec<u8>> {
    use npyz::WriterBuilder;
    let shape = [frames.len() as u64, examples.vertex_len() as u64, 3];
    let mut bytes = Vec::new();
    let mut writer =
        npyz::WriteOptions::new().default_dtype().shape(&shape).writer(&mut bytes).begin_nd()?;
    for &frame in frames {
        let skinned = skin(character, examples, frame)?;
        let copies: &[[f32; 3]] = attribute(&skinned).as_chunks().0;
        let own = examples.surface().of_first_copies(copies);
        writer.extend(own.into_iter().flatten())?;
    }
    writer.finish()?;
    Ok(bytes)
}
