//! The times at which a clip is sampled.

use super::error::SceneError;
use super::sampling::Sampling;

/// Keys nearer than this, in seconds, are one: files hold times in single precision.
pub(super) const SAME: f64 = 1e-5;
/// Steps between keys are even while they differ by less than this share.
pub(crate) const EVEN: f64 = 0.01;
/// Most frames of a clip: ten hours at thirty a second.
const FRAMES_MAX: f64 = 1_080_000.0;

/// Chooses the times at which the clip `name` is sampled, in seconds, ascending: its keys, of which
/// `keys` holds those of every channel in any order, or as many a second as asked for.
///
/// # Errors
/// [`SceneError::KeyTimes`] for keys that are not finite or reach too far.
pub(in crate::formats) fn sample_times(
    name: &str,
    mut keys: Vec<f64>,
    sampling: &Sampling<'_>,
) -> Result<Vec<f64>, SceneError> {
    keys.sort_by(f64::total_cmp);
    keys.dedup_by(|next, kept| *next - *kept < SAME);
    let (first, last) = match (keys.first(), keys.last()) {
        (Some(&first), Some(&last)) => (first, last),
        _ => return Ok(keys),
    };
    let Some(fps) = sampling.fps else {
        let finite = first.is_finite() && last.is_finite();
        return if finite { Ok(keys) } else { Err(SceneError::KeyTimes { clip: name.to_owned() }) };
    };
    let frames = ((last - first) * fps + EVEN).floor();
    // Not finite keys fail here too.
    if !(0.0..FRAMES_MAX).contains(&frames) {
        return Err(SceneError::KeyTimes { clip: name.to_owned() });
    }
    Ok((0..=frames as usize).map(|frame| (first + frame as f64 / fps).min(last)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(keys: &[f64], fps: Option<f64>) -> Result<Vec<f64>, SceneError> {
        sample_times(
            "walk",
            keys.to_vec(),
            &Sampling { fps, clips: &[], shapes: true, still: false, played: false },
        )
    }

    #[test]
    fn keys_of_all_channels_are_joined() {
        let found = sample(&[0.5, 0.0, 1.0, 0.5 + 1e-7, 0.0], None).unwrap();
        assert_eq!(found, [0.0, 0.5, 1.0]);
        assert!(sample(&[], None).unwrap().is_empty());
    }

    #[test]
    fn a_rate_reaches_from_the_first_key_to_the_last() {
        assert_eq!(sample(&[1.0, 2.0], Some(4.0)).unwrap(), [1.0, 1.25, 1.5, 1.75, 2.0]);
        assert_eq!(sample(&[1.0, 1.9], Some(4.0)).unwrap(), [1.0, 1.25, 1.5, 1.75]);
        assert_eq!(sample(&[3.0], Some(4.0)).unwrap(), [3.0]);
        // A third of a second does not divide a clip of single-precision keys evenly.
        let keys = [0.0, f64::from(1.0_f32 / 3.0), f64::from(2.0_f32 / 3.0)];
        assert_eq!(sample(&keys, Some(3.0)).unwrap().len(), 3);
    }

    #[test]
    fn times_without_end_are_refused() {
        for keys in [[0.0, f64::INFINITY], [0.0, f64::NAN], [f64::NEG_INFINITY, 0.0]] {
            assert!(matches!(sample(&keys, None), Err(SceneError::KeyTimes { .. })));
            assert!(matches!(sample(&keys, Some(30.0)), Err(SceneError::KeyTimes { .. })));
        }
        assert!(matches!(sample(&[0.0, 1e30], Some(30.0)), Err(SceneError::KeyTimes { .. })));
    }
}
