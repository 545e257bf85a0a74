//! Whether clips, and vertices, have the order in which the meshes have them.

use super::finding::{Finding, FrameName, Kind, Place, Severity};
use crate::examples::{Clip, Examples, PosedClips, is_shuffled};

/// Tells of vertices in another order, of meshes that lie apart from the joints and that nothing has put right.
pub(super) fn of_vertices(examples: &Examples) -> Option<Finding> {
    let Examples { rest, transforms, vertices: posed, .. } = examples;
    is_shuffled(rest, transforms, posed).then(|| Finding {
        kind: Kind::VertexOrder,
        severity: Severity::Warning,
        text: "the posed meshes have the vertices of the rest mesh in another order: export both from one mesh; \
               nothing below is to be trusted until they are"
            .to_owned(),
        places: Vec::new(),
    })
}

/// Tells of clips in another order.
pub(super) fn of_clips(examples: &Examples, clips: &[Clip]) -> Option<Finding> {
    let Examples { rest, transforms, vertices: posed, .. } = examples;
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
