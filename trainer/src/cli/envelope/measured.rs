//! Which frames a command measures, and which file a failed measurement is about.

use crate::cli::input;
use clap::ValueEnum;
use sinew_trainer::envelope::evaluate::{EvaluateError, Frames};
use sinew_trainer::examples::{Clip, Examples, Split};
use std::path::Path;

/// Frames by their use.
#[derive(Clone, Copy, ValueEnum)]
pub(in crate::cli) enum SplitName {
    /// Those that the fit reads
    Train,
    /// Those that the fit never reads
    HeldOut,
    /// Those that training has not read, by what the model tells
    New,
    /// Those beyond the range of motion of the training frames
    Extreme,
    /// All three
    All,
}

impl SplitName {
    pub(in crate::cli) fn frames(self) -> Frames {
        match self {
            SplitName::Train => Frames::Of(Split::Train),
            SplitName::HeldOut => Frames::Of(Split::HeldOut),
            SplitName::Extreme => Frames::Of(Split::Extreme),
            SplitName::New => Frames::New,
            SplitName::All => Frames::All,
        }
    }
}

/// Names the file that an error is about.
pub(in crate::cli) fn blame(
    error: EvaluateError,
    model: &Path,
    input: &input::ExampleArguments,
    (examples, clips): (&Examples, &[Clip]),
) -> anyhow::Error {
    let source = input.named();
    let at_fault = match &error {
        EvaluateError::NoFrames { split } => {
            let hint = if input.hold_out.is_none() && *split == Split::HeldOut.name() {
                "; see --split and --hold-out"
            } else {
                ""
            };
            return anyhow::anyhow!(
                "{source}: {error}: {}{hint}",
                input::describe_frames(examples)
            );
        }
        EvaluateError::Frame(_) | EvaluateError::Examples(_) => source,
        _ => model.display().to_string(),
    };
    anyhow::Error::new(error.called(clips)).context(at_fault)
}
