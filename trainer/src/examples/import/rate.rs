//! Whether clips keep one rate, as posed meshes do.

use super::error::ImportError;
use crate::formats::scene::{Clip, EVEN};

/// Checks that the frames of every clip follow each other at one rate, as those of a point cache do.
///
/// # Errors
/// [`ImportError::UnevenKeys`] with the step that differs most.
pub(super) fn check_even(clips: &[Clip]) -> Result<(), ImportError> {
    for clip in clips {
        let steps = || clip.times.windows(2).map(|pair| pair[1] - pair[0]);
        let mut sorted: Vec<f64> = steps().collect();
        sorted.sort_by(f64::total_cmp);
        let Some(&usual) = sorted.get(sorted.len() / 2) else { continue };
        let worst = steps()
            .enumerate()
            .max_by(|(_, a), (_, b)| (a - usual).abs().total_cmp(&(b - usual).abs()));
        let Some((frame, step)) = worst else { continue };
        if (step - usual).abs() > EVEN * usual {
            let (clip, at) = (clip.name.clone(), clip.times[frame]);
            return Err(ImportError::UnevenKeys { clip, at, step, usual });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_uneven_step_is_named() {
        let clip = |times: &[f64]| Clip {
            name: "run".into(),
            first: 0,
            times: times.to_vec(),
            numbers: None,
        };
        assert!(check_even(&[clip(&[0.0, 0.1, 0.2, 0.3]), clip(&[0.0]), clip(&[])]).is_ok());
        let error = check_even(&[clip(&[0.0, 0.1, 0.2, 0.4, 0.5])]).unwrap_err();
        let ImportError::UnevenKeys { clip, at, step, usual } = error else { panic!("{error}") };
        assert_eq!((clip.as_str(), at), ("run", 0.2));
        assert!((step - 0.2).abs() < 1e-12 && (usual - 0.1).abs() < 1e-12);
    }
}
