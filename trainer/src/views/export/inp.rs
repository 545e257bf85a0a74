//! The container of Inochi2D: a tree as JSON, and textures behind it.

use super::error::GridError;
use serde_json::Value;

const MAGIC: &[u8; 8] = b"TRNSRTS\0";
const TEXTURES: &[u8; 8] = b"TEX_SECT";
/// Says that a texture is PNG.
const PNG: u8 = 0;

/// Writes a puppet and its textures, each PNG. Lengths have the higher byte first.
///
/// # Errors
/// [`GridError::Json`] and [`GridError::TooLarge`].
pub(super) fn container(puppet: &Value, textures: &[Vec<u8>]) -> Result<Vec<u8>, GridError> {
    let json = serde_json::to_vec(puppet)?;
    let mut out = Vec::new();
    out.extend(MAGIC);
    out.extend(length(json.len())?);
    out.extend(json);
    out.extend(TEXTURES);
    out.extend(length(textures.len())?);
    for texture in textures {
        out.extend(length(texture.len())?);
        out.push(PNG);
        out.extend(texture);
    }
    Ok(out)
}

fn length(len: usize) -> Result<[u8; 4], GridError> {
    u32::try_from(len).map(u32::to_be_bytes).map_err(|_| GridError::TooLarge(len))
}
