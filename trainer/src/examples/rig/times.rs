//! When the frames of a clip are taken.

use super::ImportError;

/// How far steps between keys may differ, as a share of the first.
const UNEVEN: f64 = 0.01;

/// Gives the times in seconds at which a clip is sampled: the keys' own, merged, or `fps` a second
/// from the first key to the last.
///
/// # Errors
/// [`ImportError::UnevenKeys`] where the keys themselves are no even steps.
pub(in crate::examples) fn sample_times(
    clip: &str,
    mut keys: Vec<f64>,
    fps: Option<f64>,
) -> Result<Vec<f64>, ImportError> {
    keys.sort_by(f64::total_cmp);
    keys.dedup_by(|next, kept| *next - *kept < 1e-6);
    let (Some(&first), Some(&last)) = (keys.first(), keys.last()) else { return Ok(keys) };
    if let Some(fps) = fps {
        let steps = ((last - first) * fps + 1e-6).floor().max(0.0) as usize;
        return Ok((0..=steps).map(|step| first + step as f64 / fps).collect());
    }
    let usual = keys.get(1).map_or(0.0, |second| second - first);
    for pair in keys.windows(2) {
        let (at, step) = (pair[0], pair[1] - pair[0]);
        let apart = (step - usual).abs();
        if apart.is_nan() || apart > UNEVEN * usual {
            return Err(ImportError::UnevenKeys { clip: clip.to_owned(), at, step, usual });
        }
    }
    Ok(keys)
}
