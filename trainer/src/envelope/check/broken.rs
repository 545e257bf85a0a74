//! Frames whose meshes do not belong to their poses.

use super::finding::{Finding, FrameName, Kind, Place, Severity, count, listed};
use crate::envelope::predicted::LeftOut;
use crate::examples::Clip;

/// Tells of frames that a fit leaves out.
pub(super) fn broken(left_out: &[LeftOut], clips: &[Clip]) -> Finding {
    let name = |out: &LeftOut| FrameName::new(clips, out.frame);
    let line = |out: &LeftOut| format!("{} ({:.0} times what is usual)", name(out), out.times);
    Finding {
        kind: Kind::Broken,
        severity: Severity::Warning,
        text: format!(
            "{} a mesh that does not belong to the pose, by what all others tell (a simulation that exploded, a mesh \
             that is moved, or of another frame); a training leaves them out: look at them, and mend them or leave them \
             out yourself: frame {}",
            count(left_out.len(), "frame has", "frames have"),
            listed(left_out.iter().map(line))
        ),
        places: left_out.iter().map(|out| Place::Frame(name(out))).collect(),
    }
}
