//! Advice: poses to add to the training, and poses to leave out.

use super::coverage::{Coverage, JointPair};
use super::finding::{count, listed, runs};
use super::redundancy::{Isolated, Predicted};
use super::thresholds::{ENOUGH_POSES, LARGE_BEND};
use crate::space::written;

/// Returns the advice, the most important first.
pub(super) fn advice(
    joints: &[Coverage],
    never_together: &[JointPair],
    predicted: Option<&Predicted>,
) -> Vec<String> {
    let of_all = [outside(joints), few(joints), together(never_together)];
    let of_poses = predicted.map(|predicted| [isolated(predicted), redundant(predicted)]);
    of_all.into_iter().chain(of_poses.into_iter().flatten()).flatten().collect()
}

/// Writes some words and the places that they are about; `None` without places.
fn advise(words: &str, places: Vec<String>) -> Option<String> {
    (!places.is_empty()).then(|| format!("{words}{}", listed(places)))
}

fn outside(joints: &[Coverage]) -> Option<String> {
    let mut worst: Vec<&Coverage> =
        joints.iter().filter(|joint| !joint.beyond.is_empty()).collect();
    worst.sort_by(|a, b| b.beyond[0].degrees.total_cmp(&a.beyond[0].degrees));
    let line = |joint: &&Coverage| {
        let Coverage { joint, beyond, .. } = joint;
        let (frames, worst) = (count(beyond.len(), "frame", "frames"), &beyond[0]);
        format!("{joint} ({frames}, frame {} by {:.0}°)", worst.frame, worst.degrees)
    };
    let words =
        "add training poses like the held-out or extreme frames that go beyond training, at ";
    advise(words, worst.iter().map(line).collect())
}

fn few(joints: &[Coverage]) -> Option<String> {
    let mut few: Vec<&Coverage> = joints
        .iter()
        .filter(|j| j.moves() && j.degrees > LARGE_BEND && j.distinct < ENOUGH_POSES)
        .collect();
    few.sort_by_key(|joint| joint.distinct);
    let line = |joint: &&Coverage| {
        let poses = count(joint.distinct, "pose", "poses");
        format!("{} ({poses} over {:.0}°)", joint.joint, joint.degrees)
    };
    advise("add poses in between for joints with few: ", few.iter().map(line).collect())
}

fn together(never_together: &[JointPair]) -> Option<String> {
    let line = |pair: &JointPair| format!("{} with {}", pair.joint, pair.parent);
    let words = "add poses that bend both joints where neighbours never bend together: ";
    advise(words, never_together.iter().map(line).collect())
}

fn isolated(predicted: &Predicted) -> Option<String> {
    let line = |isolated: &Isolated| {
        let Isolated { frame, joint, percent, mm } = isolated;
        let mm = mm.map_or(String::new(), |mm| format!(", {} mm,", written(mm)));
        format!("frame {frame} ({percent:.3} %{mm} off at {joint})")
    };
    let words = "add poses like these, which the others do not predict: ";
    advise(words, predicted.isolated.iter().map(line).collect())
}

fn redundant(predicted: &Predicted) -> Option<String> {
    let words = format!(
        "{} of {} may be left out together, as the others predict them (give them split 2 in \
         an .npz; whole clips are left out by --clip for the others): ",
        predicted.redundant.len(),
        predicted.describe_poses()
    );
    advise(&words, runs(&predicted.redundant))
}

#[cfg(test)]
mod tests {
    use super::super::finding::FrameName;
    use super::*;

    #[test]
    fn advice_states_how_to_leave_poses_out_and_the_number_of_poses() {
        let name = |frame| FrameName { frame, number: None, clip: None };
        let mut predicted = Predicted {
            poses: 4,
            compared: 4,
            lbs_percent: 1.0,
            expected_percent: 0.1,
            lbs_mm: None,
            expected_mm: None,
            enough: vec![name(0)],
            redundant: [3, 1, 2].map(name).into(),
            isolated: Vec::new(),
        };
        let how = "(give them split 2 in an .npz; whole clips are left out by --clip for the others): 1-3";
        let line = redundant(&predicted).unwrap();
        assert!(
            line.starts_with("3 of 4 training poses may be left out") && line.ends_with(how),
            "{line}"
        );
        predicted.isolated =
            vec![Isolated { frame: name(7), joint: "arm".into(), percent: 0.5, mm: Some(8.0) }];
        let line = isolated(&predicted).unwrap();
        assert!(line.ends_with("frame 7 (0.500 %, 8.000 mm, off at arm)"), "{line}");
        predicted.poses = 9;
        let line = redundant(&predicted).unwrap();
        assert!(
            line.starts_with("3 of the 4 training poses that were compared (of 9) may"),
            "{line}"
        );
    }
}
