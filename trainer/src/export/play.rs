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

/// A model, and the clips that it plays in an exported file.
#[derive(Clone, Copy)]
pub struct Playback<'a> {
    /// Bytes of a model's file.
    pub model: &'a [u8],
    /// Name of the exported skin; the model's first if `None`.
    pub skin: Option<&'a str>,
    /// The poses, and the mesh's triangles and texture coordinates.
    pub examples: &'a Examples,
    /// The clips of the frames.
    pub clips: &'a [Clip],
    /// Whether helpers get more keys between frames. Between frames the skin is then within 0.1 % of the diagonal of
    /// the model's skin.
    pub between: bool,
    /// Further meshes.
    pub levels: &'a [Level],
}

impl<'a> Playback<'a> {
    /// Predicts every frame of the clips, and the keys between frames. Returns the played model, and its further meshes
    /// on the palette.
    ///
    /// # Errors
    /// - The model is refused or belongs to another character, or its space is impossible.
    /// - A clip cannot be played, a joint is mirrored or hidden, or the runtime refuses a frame.
    /// - A further mesh does not lie on the model's skin.
    pub(super) fn play(&self) -> Result<(Played<'a>, FurtherMeshes), Error> {
        let Self { model, skin, examples, clips, between, levels } = *self;
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
