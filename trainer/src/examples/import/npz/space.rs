//! Axes, handedness and unit, as far as the file tells them.

use sinew_runtime::format::{Axis, Handedness, Space};

use super::{Archive, Sidecar};
use crate::examples::ExamplesError;

/// Reads the space: what the JSON says, else the arrays.
///
/// # Errors
/// Those of the arrays, [`ExamplesError::UnknownWord`] for what is no axis or handedness.
pub(super) fn read_space(archive: &mut Archive, sidecar: &Sidecar) -> Result<Space, ExamplesError> {
    let mut word = |array: &'static str, stated: &Option<String>| match stated {
        Some(word) => Ok(Some(word.clone())),
        None => archive.text(array),
    };
    let up = word("up", &sidecar.up)?.map(|word| axis("up", word)).transpose()?;
    let forward =
        word("forward", &sidecar.forward)?.map(|word| axis("forward", word)).transpose()?;
    let handedness = match word("handedness", &sidecar.handedness)?.as_deref() {
        None | Some("right") => Handedness::Right,
        Some("left") => Handedness::Left,
        Some(found) => {
            let (array, found) = ("handedness", found.to_owned());
            return Err(ExamplesError::UnknownWord { array, found, expected: "right or left" });
        }
    };
    let unit = sidecar.unit.map_or_else(|| archive.number("unit"), |unit| Ok(Some(unit)))?;
    Ok(Space { up, forward, handedness, unit: unit.map(|metres| metres as f32) })
}

fn axis(array: &'static str, found: String) -> Result<Axis, ExamplesError> {
    let named = Axis::ALL.into_iter().find(|axis| axis.name() == found);
    let expected = "x, -x, y, -y, z or -z";
    named.ok_or(ExamplesError::UnknownWord { array, found, expected })
}
