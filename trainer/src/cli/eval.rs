//! `sinew eval`: the f32 runtime on the file's bytes against examples.

use super::bars::Bars;
use super::files::{self, Target};
use super::{Output, input, table};
use anyhow::Context;
use clap::ValueEnum;
use sinew_trainer::evaluate::{EvaluateError, Frames, evaluate, open, skin};
use sinew_trainer::examples::{Examples, Split};
use std::path::PathBuf;

/// Runs MODEL on the poses of EXAMPLES and measures its distance from their meshes.
///
/// The runtime evaluates the file's bytes in f32, as an engine would. LBS with 4 influences, fitted
/// on the training frames, is measured on the same frames.
#[derive(clap::Args)]
pub(super) struct Arguments {
    /// A model that `sinew train` wrote
    model: PathBuf,
    #[command(flatten)]
    input: input::ExampleArguments,
    /// Which frames
    #[arg(long, value_enum, default_value_t = SplitName::HeldOut)]
    split: SplitName,
    /// Write the frames' skinned positions to OUT.npy, f32, frames x vertices x 3
    #[arg(long, value_name = "OUT.npy")]
    write_vertices: Option<PathBuf>,
}

#[derive(Clone, Copy, ValueEnum)]
enum SplitName {
    /// Those that the fit reads
    Train,
    /// Those that the fit never reads
    HeldOut,
    /// Those beyond the range of motion of the training frames
    Extreme,
    /// All three
    All,
}

impl SplitName {
    fn frames(self) -> Frames {
        match self {
            SplitName::Train => Frames::Of(Split::Train),
            SplitName::HeldOut => Frames::Of(Split::HeldOut),
            SplitName::Extreme => Frames::Of(Split::Extreme),
            SplitName::All => Frames::All,
        }
    }
}

pub(super) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let mut inputs = arguments.input.files();
    inputs.push(arguments.model.clone());
    let vertices = arguments.write_vertices.as_ref().map(|file| Target::new(file, &inputs));
    let vertices = vertices.transpose()?;
    let model = input::read_model(&arguments.model)?;
    let examples = arguments.input.load(output)?.examples;
    let frames = arguments.split.frames();
    let measuring = Bars::busy(output, "measuring");
    let evaluation =
        evaluate(&model, &examples, frames).map_err(|error| blame(error, arguments, &examples))?;
    if let Some(target) = &vertices {
        let bytes = skinned(&model, &examples, frames).context("cannot skin")?;
        files::write(&[(target, &bytes)])?;
    }
    drop(measuring);
    output.print(&evaluation, &table::evaluation(&evaluation))
}

/// Names the file that an error is about.
fn blame(error: EvaluateError, arguments: &Arguments, examples: &Examples) -> anyhow::Error {
    let source = arguments.input.examples.display();
    let at_fault = match &error {
        EvaluateError::NoFrames { .. } => {
            let hint = if arguments.input.hold_out.is_none()
                && arguments.split.frames() == Frames::Of(Split::HeldOut)
            {
                "; see --split and --hold-out"
            } else {
                ""
            };
            return anyhow::anyhow!(
                "{source}: {error}: {}{hint}",
                input::describe_frames(examples)
            );
        }
        EvaluateError::Frame { .. } | EvaluateError::Examples(_) => source,
        _ => arguments.model.display(),
    };
    let at_fault = at_fault.to_string();
    anyhow::Error::new(error).context(at_fault)
}

/// Skins frames into the bytes of an npy file.
fn skinned(model: &[u8], examples: &Examples, frames: Frames) -> anyhow::Result<Vec<u8>> {
    use npyz::WriterBuilder;
    let envelope = open(model, examples)?;
    let chosen = frames.of(examples);
    let shape = [chosen.len() as u64, examples.vertex_len() as u64, 3];
    let mut bytes = Vec::new();
    let mut writer =
        npyz::WriteOptions::new().default_dtype().shape(&shape).writer(&mut bytes).begin_nd()?;
    for frame in chosen {
        writer.extend(skin(&envelope, examples, frame)?.positions().iter().copied())?;
    }
    writer.finish()?;
    Ok(bytes)
}
