//! Plays clips on a model: adds keys between frames, finds the weights of further meshes, and mirrors a left-handed
//! model.

use sinew_runtime::format::Handedness;
use std::mem::take;

use super::between::{Between, Key};
use super::mesh::FurtherMeshes;
use super::played::Played;
use crate::Error;
use crate::envelope::levels::Level;
use crate::examples::{Clip, Examples};
use crate::space::{Conversion, SpaceRequest};

/// Predicts every frame of the clips and, with `between`, the keys that the motion between frames needs. Returns the
/// played model, and its further meshes on the palette.
///
/// - `levels`: further meshes.
///
/// # Errors
/// The model is refused or belongs to another character, a clip cannot be played, a joint is not rigid, the runtime
/// refuses a frame, the model's space is impossible, or a further mesh does not lie on the model's skin.
pub(super) fn play<'a>(
    model: &'a [u8],
    skin: Option<&str>,
    examples: &Examples,
    clips: &[Clip],
    between: bool,
    levels: &[Level],
) -> Result<(Played<'a>, FurtherMeshes), Error> {
    let mut played = Played::new(model, skin, examples, clips)?;
    let diagonal = examples.diagonal();
    if between {
        played.carry(diagonal);
        fill(&mut played, diagonal, clips)?;
    }
    let hand = SpaceRequest { handedness: Some(Handedness::Right), ..SpaceRequest::default() };
    (played.space, played.mirror) = Conversion::to(played.space, &hand)?;
    let mut further = FurtherMeshes::new(&played, examples, levels)?;
    if let Some(mirror) = played.mirror {
        played.turn(&mirror);
        further.convert(&mirror);
    }
    played.carry(diagonal);
    Ok((played, further))
}

/// Adds keys where the motion of helpers is not even between keys.
fn fill(played: &mut Played<'_>, diagonal: f64, clips: &[Clip]) -> Result<(), Error> {
    let between = Between::new(played, diagonal);
    let (poses, curves) = (take(&mut played.poses), take(&mut played.curves));
    let mut known = poses.into_iter().zip(curves).zip(take(&mut played.palettes));
    for (times, clip) in played.times.iter_mut().zip(clips) {
        let keys = times.iter().zip(known.by_ref());
        let keys = keys
            .map(|(&time, ((pose, curves), palette))| Key { time, pose, curves, palette })
            .collect();
        let keys = between.refine(keys, clip.first)?;
        *times = keys.iter().map(|key| key.time).collect();
        for Key { pose, curves, palette, .. } in keys {
            played.poses.push(pose);
            played.curves.push(curves);
            played.palettes.push(palette);
        }
    }
    Ok(())
}
