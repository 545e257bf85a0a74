//! Whether most meshes stand elsewhere than their joints: one of the two lacks the root's motion.

use super::context::{Context, worst_first};
use super::finding::{Finding, Kind, Severity, count};
use crate::envelope::clean::rigid_offsets;
use crate::envelope::lbs::training::Residuals;

/// Share of a frame's squared error that is left where its mesh is put back, where most frames bend LBS.
const LEFT: f64 = 0.25;

/// Tells of most training frames that their meshes stand elsewhere; of fewer the others tell ([`super::broken`]).
pub(super) fn elsewhere(context: &Context<'_>) -> Option<Finding> {
    let Context { training, residuals, dominant, .. } = context;
    let offsets = rigid_offsets(Residuals { training, residuals, dominant });
    let places = (0..offsets.len()).filter(|&pose| offsets[pose].is_offset(LEFT));
    let worst = worst_first(places, |pose| offsets[pose].distance);
    if 2 * worst.len() < offsets.len() {
        return None;
    }
    let farthest = *worst.first()?;
    Some(Finding {
        kind: Kind::Elsewhere,
        severity: Severity::Warning,
        text: format!(
            "{} of {} a mesh that stands elsewhere than the joints, as a whole, by up to {} in frame \
             {}: as if the root moved in the meshes or in the joints alone, all stood in another place, or the meshes were of \
             other frames; nothing below is to be trusted until they go together",
            worst.len(),
            count(offsets.len(), "training frame has", "training frames have"),
            context.length(offsets[farthest].distance),
            context.frame(farthest)
        ),
        places: context.frames(worst.iter().copied()),
    })
}
