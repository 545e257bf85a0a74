//! Whether clips, and vertices, have the order in which the meshes have them.

use super::finding::{Finding, FrameName, Kind, Place, Severity};
use crate::examples::{Clip, Examples, PosedClips, is_shuffled};

/// Tells of clips in another order; and, of meshes that lie `apart` from the joints and nothing has put right, of
/// vertices in another order.
pub(super) fn order(examples: &Examples, clips: &[Clip], apart: bool) -> Option<Finding> {
    let Examples { rest, transforms, vertices: posed, .. } = examples;
    if apart && is_shuffled(rest, transforms, posed) {
        return Some(Finding {
            kind: Kind::VertexOrder,
            severity: Severity::Warning,
            text: "the posed meshes have the vertices of the rest mesh in another order: export both from one mesh; \
                   nothing below is to be trusted until they are"
                .to_owned(),
            places: Vec::new(),
        });
    }
    let lens: Vec<usize> = clips.iter().map(|clip| clip.times.len()).collect();
    let given = PosedClips { rest, transforms, posed, lens: &lens, placed: true };
    let order = given.order()?;
    let [other, here] = order.percent;
    let names: Vec<&str> = order.clips.iter().map(|&clip| clips[clip].name.as_str()).collect();
    Some(Finding {
        kind: Kind::ClipOrder,
        severity: Severity::Warning,
        text: format!(
            "the meshes fit the clips in another order, {}: vertices are then {other:.2} % of the diagonal from where \
             one joint carries them, {here:.2} % as they are",
            names.join(", ")
        ),
        places: clips.iter().map(|clip| Place::Frame(FrameName::new(clips, clip.first))).collect(),
    })
}
