//! How often frames count in a fit.

use super::validate::same;
use super::{Examples, ExamplesError};

/// Most times that a frame may count.
const MOST: f64 = 100.0;

impl Examples {
    /// Lets frames count as if they stood there so many times: N whole numbers from 1 to 100.
    ///
    /// # Errors
    /// [`ExamplesError::Mismatch`] for another count than N, [`ExamplesError::FrameWeight`] for a number that is none of
    /// these.
    pub fn repeat(&mut self, numbers: &[f64]) -> Result<(), ExamplesError> {
        same("frames", "vertices", self.frame_len(), "frame_weights", numbers.len())?;
        let is_whole = |number: &f64| number.fract() == 0.0 && (1.0..=MOST).contains(number);
        if let Some(frame) = numbers.iter().position(|number| !is_whole(number)) {
            let (number, most) = (numbers[frame], MOST);
            return Err(ExamplesError::FrameWeight { frame: frame as i64, number, most });
        }
        self.frame_weights = Some(numbers.iter().map(|&number| number as u8).collect());
        Ok(())
    }

    /// Lists frames, each as often as it counts.
    pub fn repeated(&self, frames: &[usize]) -> Vec<usize> {
        let weight = |frame: usize| self.frame_weights.as_ref().map_or(1, |all| all[frame].into());
        frames.iter().flat_map(|&frame| std::iter::repeat_n(frame, weight(frame))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::triangle;
    use super::*;

    #[test]
    fn frames_stand_as_often_as_they_count() {
        let mut examples = triangle(4);
        assert_eq!(examples.repeated(&[1, 2]), [1, 2]);
        examples.repeat(&[1.0, 3.0, 1.0, 2.0]).unwrap();
        assert_eq!(examples.repeated(&[0, 1, 3]), [0, 1, 1, 1, 3, 3]);
    }

    #[test]
    fn what_is_no_weight_is_refused_by_its_frame() {
        for bad in [0.0, -1.0, 1.5, 101.0, f64::NAN, f64::INFINITY] {
            let found = triangle(3).repeat(&[1.0, bad, 1.0]);
            assert!(matches!(found, Err(ExamplesError::FrameWeight { frame: 1, .. })), "{bad}");
        }
        let short = triangle(3).repeat(&[1.0]).unwrap_err().to_string();
        assert!(short.contains("frame_weights"), "{short}");
    }
}
