//! Frames whose meshes do not belong to their poses.

use super::finding::{Finding, FrameName, Kind, LISTED, Place, Severity, count, listed, runs};
use crate::envelope::clean::{Inliers, OutlierFrame};
use crate::examples::Clip;
use crate::space::beside;

/// Tells of frames that do not belong, and whether a fit leaves them out.
///
/// - `diagonal_mm`: of the rest mesh, where the unit is known.
pub(super) fn broken(sound: &Inliers, clips: &[Clip], diagonal_mm: Option<f64>) -> Finding {
    let Inliers { outliers, keeps_outliers, .. } = sound;
    let name = |of: &OutlierFrame| FrameName::new(clips, of.frame);
    let line = |of: &OutlierFrame| {
        let mm = beside(of.percent, diagonal_mm);
        let (percent, usual) = (of.percent, of.usual_percent);
        format!("{} (off by {percent:.2} % of the diagonal{mm}, {usual:.2} % is usual)", name(of))
    };
    let names: Vec<FrameName> = outliers.iter().map(name).collect();
    let all = match outliers.len() {
        0..=LISTED => String::new(),
        _ => format!("; all of them: {}", runs(&names).join(", ")),
    };
    let then = match keeps_outliers {
        true => "without them too few frames or no motion would be left, so training keeps them",
        false => "a training leaves out what is named here",
    };
    Finding {
        kind: Kind::Broken,
        severity: Severity::Warning,
        text: format!(
            "{} a mesh that does not belong to the pose, by what all others tell (a simulation that exploded, a mesh \
             that is moved, or of another frame); {then}: look, and mend or leave out yourself: frame {}{all}",
            count(outliers.len(), "frame has", "frames have"),
            listed(outliers.iter().map(line))
        ),
        places: names.into_iter().map(Place::Frame).collect(),
    }
}
