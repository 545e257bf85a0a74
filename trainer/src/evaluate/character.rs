//! A model's envelope and one of its skins, as they were made for the examples' character.

use super::EvaluateError;
use crate::envelope::posed::rest;
use crate::examples::Examples;
use crate::numeric::affine::{apart, apart_unordered};
use sinew_runtime::format::Space;
use sinew_runtime::{Envelope, Model, Skin};

/// An envelope, and a skin that follows it.
#[derive(Clone, Copy, Debug)]
pub struct Character<'a> {
    /// What predicts the palette.
    pub envelope: Envelope<'a>,
    /// What follows it.
    pub skin: Skin<'a>,
    /// The space of both.
    pub space: Space,
}

/// Two rest meshes stand in one space within this share of the diagonal, RMS: other axes and units
/// are further apart, a sculpt that was changed since shows as an error like any other.
const SAME_SPACE: f64 = 0.05;
/// Vertices stand at the same places within this share of the diagonal, RMS: what single precision leaves.
const SAME_PLACES: f64 = 1e-4;

impl<'a> Character<'a> {
    /// Finds a skin of a model's, the first where no name is given, and what it follows.
    ///
    /// # Errors
    /// [`EvaluateError::Format`], [`EvaluateError::NoEnvelope`], [`EvaluateError::PaletteAlone`] and
    /// [`EvaluateError::NoSkin`].
    pub fn find(model: &'a [u8], skin: Option<&str>) -> Result<Self, EvaluateError> {
        let loaded = Model::from_bytes(model)?;
        let found = match skin {
            None => loaded.skin(),
            Some(name) => loaded.skin_named(name),
        };
        let Some(found) = found else {
            let has: Vec<&str> = loaded.skins().map(|skin| skin.name()).collect();
            return Err(match (skin, has.is_empty()) {
                (Some(name), false) => {
                    EvaluateError::NoSkin { name: name.to_owned(), has: has.join(", ") }
                }
                _ if loaded.envelope().is_some() => EvaluateError::PaletteAlone,
                _ => EvaluateError::NoEnvelope,
            });
        };
        // Views borrow the loaded model; what it found does not.
        let envelope = loaded.envelope_of(&found).and_then(|e| e.layout().open(model));
        let (envelope, skin) =
            envelope.zip(found.layout().open(model)).ok_or(EvaluateError::NoEnvelope)?;
        Ok(Self { envelope, skin, space: loaded.space() })
    }

    /// Finds a skin as [`Character::find`] does, and checks that it was made for the examples'
    /// character.
    ///
    /// # Errors
    /// Those of [`Character::find`], [`EvaluateError::Vertices`], [`EvaluateError::Joints`],
    /// [`EvaluateError::JointName`], [`EvaluateError::RestMesh`] and [`EvaluateError::VertexOrder`].
    pub fn open(
        model: &'a [u8],
        skin: Option<&str>,
        examples: &Examples,
    ) -> Result<Self, EvaluateError> {
        let character = Self::find(model, skin)?;
        let Self { envelope, skin, .. } = &character;
        let (expected, found) = (skin.vertex_len(), examples.surface().engine_len());
        if expected != found {
            return Err(EvaluateError::Vertices { expected, found });
        }
        let (expected, found) = (envelope.joint_len(), examples.joint_len());
        if expected != found {
            return Err(EvaluateError::Joints { expected, found });
        }
        for (joint, found) in examples.skeleton.names.iter().enumerate() {
            let expected = envelope.joint_name(joint).unwrap_or_default();
            if expected != found {
                let (expected, found) = (expected.to_owned(), found.clone());
                return Err(EvaluateError::JointName { joint, expected, found });
            }
        }
        let expected = examples.surface().copied(&examples.rest);
        let (found_rest, diagonal) = (rest(skin), examples.diagonal());
        let apart = apart(&found_rest, &expected);
        if apart > SAME_SPACE * diagonal {
            if apart_unordered(&found_rest, &expected) <= SAME_PLACES * diagonal {
                return Err(EvaluateError::VertexOrder);
            }
            return Err(EvaluateError::RestMesh { percent: 100.0 * apart / diagonal });
        }
        Ok(character)
    }
}
