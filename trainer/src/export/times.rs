//! The times of an animation's keys, and which values hold between them.

use super::error::ExportError;
use crate::examples::Clip;
use crate::formats::gltf::write::{ChannelKeys, NodeIndex, Track, before_jumps};

/// Values of a key are those of the one before where they differ by no more than single precision makes of them, in units
/// of the largest, or of 1.
const HELD: f32 = 4e-6;

/// Rounds the times of a clip's frames.
pub(super) fn key_times(clip: &Clip) -> Result<Vec<f32>, ExportError> {
    let name = || clip.name.clone();
    if clip.times.is_empty() {
        return Err(ExportError::NoFrames { clip: format!("clip {} has none", name()) });
    }
    let times: Vec<f32> = clip.times.iter().map(|&time| time as f32).collect();
    let bad = (0..times.len()).find(|&key| {
        let after = key == 0 || times[key] > times[key - 1];
        !(after && times[key] >= 0.0 && times[key].is_finite())
    });
    match bad {
        Some(frame) => Err(ExportError::Times { clip: name(), frame, time: clip.times[frame] }),
        None => Ok(times),
    }
}

/// Makes the track of a joint: of a clip that jumps, one whose values hold wherever it does not jump keeps its steps.
pub(super) fn track(node: NodeIndex, keys: ChannelKeys, times: &[f32]) -> Track {
    let holds = match &keys {
        ChannelKeys::Translation(keys) | ChannelKeys::Scale(keys) => hold(keys, times),
        ChannelKeys::Rotation(keys) => hold(keys, times),
        ChannelKeys::Weights(keys) => hold(keys, times),
    };
    Track { node, keys, holds }
}

fn hold<const N: usize>(keys: &[[f32; N]], times: &[f32]) -> bool {
    let jumps: Vec<usize> = before_jumps(times).collect();
    let largest = keys.as_flattened().iter().fold(1.0, |most: f32, x| most.max(x.abs()));
    let is_held = |key: usize| {
        let pairs = keys[key].iter().zip(&keys[key + 1]);
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) <= HELD * largest
    };
    let is_jump = |key: &usize| jumps.binary_search(key).is_ok();
    !jumps.is_empty() && (1..keys.len()).map(|key| key - 1).filter(|k| !is_jump(k)).all(is_held)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_joint_keeps_its_steps_where_it_only_jumps() {
        let before = 1.0_f32.next_down();
        let times = [0.0, before, 1.0, 2.0];
        let holds = |values: [f32; 4], times: &[f32]| {
            let keys = values.map(|x| [x, 5.0, 0.0]).to_vec();
            track(0, ChannelKeys::Translation(keys), times).holds
        };
        assert!(holds([1.0, 1.0, 3.0, 3.0], &times));
        // Single precision rounds.
        assert!(holds([1.0, 1.000_001, 3.0, 3.0], &times));
        assert!(!holds([1.0, 1.0, 3.0, 3.1], &times));
        assert!(!holds([1.0, 1.1, 3.0, 3.0], &times));
        // Without a jump a joint at rest is linear, as all are.
        assert!(!holds([1.0; 4], &[0.0, 0.5, 1.0, 2.0]));
    }
}
