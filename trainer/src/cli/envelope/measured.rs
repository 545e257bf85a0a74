//! Which frames a command measures, and which file a failed measurement is about.

use crate::cli::{Output, input};
use anyhow::bail;
use clap::ValueEnum;
use sinew_trainer::evaluate::{Character, EvaluateError, Frames, NOTHING, TrainingRecord};
use sinew_trainer::examples::{Clip, Examples, Split, Warning};
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

/// Refuses meshes that a scene's own skinning makes, where training had others; tells of them elsewhere.
///
/// Training had them where it has read most frames: a scene of many influences leaves an error of LBS as well.
pub(in crate::cli) fn refuse_forgotten_targets(
    input: &input::ExampleArguments,
    warnings: &[Warning],
    (character, told): (&Character<'_>, &TrainingRecord),
    examples: &Examples,
    output: Output,
) -> anyhow::Result<()> {
    if !warnings.contains(&Warning::PlainSkin) {
        return Ok(());
    }
    let certificate = character.envelope.certificate();
    let lbs = 100.0 * certificate.lbs_training_rms / certificate.diagonal;
    let frames: Vec<usize> = (0..examples.frame_len()).collect();
    let read = told.read_len(&frames).unwrap_or(0);
    if f64::from(lbs) > NOTHING && 2 * read < frames.len() {
        bail!(
            "{}: no shapes move and no targets are given: the meshes are the scene's own linear blend skinning, and the \
             model has learned others; give those as --targets, as in training",
            input.named()
        );
    }
    output.warn(input.named(), Warning::PlainSkin);
    Ok(())
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
