//! `sinew eval`: the f32 runtime on the file's bytes against examples.

use super::{Output, input, print_json, table};
use anyhow::Context;
use clap::ValueEnum;
use sinew_trainer::bake::write_atomically;
use sinew_trainer::evaluate::{Frames, evaluate, open, skin};
use sinew_trainer::examples::{Examples, Split};
use std::path::{Path, PathBuf};

/// Runs MODEL on the poses of EXAMPLES and measures its distance from their meshes.
///
/// The runtime evaluates the file's bytes in f32, as an engine would. LBS with 4 influences, fitted
/// on the training frames, is measured on the same frames.
#[derive(clap::Args)]
pub(super) struct Arguments {
    /// A model that `sinew train` wrote
    model: PathBuf,
    #[command(flatten)]
    input: input::Arguments,
    /// Which frames
    #[arg(long, value_enum, default_value_t = SplitName::HeldOut)]
    split: SplitName,
    /// Write the frames' skinned positions to OUT.npy, f32, frames x vertices x 3
    #[arg(long, value_name = "OUT.npy")]
    write_vertices: Option<PathBuf>,
}

#[derive(Clone, Copy, ValueEnum)]
enum SplitName {
    Train,
    HeldOut,
    Extreme,
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
    let model = input::read_model(&arguments.model)?;
    let examples = arguments.input.load(output)?;
    let frames = arguments.split.frames();
    let evaluation = evaluate(&model, &examples, frames)
        .with_context(|| arguments.model.display().to_string())?;
    if let Some(path) = &arguments.write_vertices {
        write_vertices(path, &model, &examples, frames)?;
    }
    if output.json {
        return print_json(&evaluation);
    }
    table::print_evaluation(&evaluation);
    Ok(())
}

fn write_vertices(
    path: &Path,
    model: &[u8],
    examples: &Examples,
    frames: Frames,
) -> anyhow::Result<()> {
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
    write_atomically(path, &bytes).with_context(|| format!("cannot write {}", path.display()))
}
