//! Peak over RMS error of pictures, dB.

use crate::page::picture::Picture;

/// Squares of errors of bytes, added up picture by picture.
#[derive(Clone, Copy, Debug, Default)]
pub struct PictureError {
    squares: f64,
    count: usize,
}

impl PictureError {
    /// Adds pixels: numbers from 0 to 255, as many of each.
    pub fn add(&mut self, truth: &[u8], found: &[u8]) {
        let apart = truth.iter().zip(found).map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2));
        self.squares += apart.sum::<f64>();
        self.count += truth.len();
    }

    /// Returns the PSNR in dB, infinite where nothing is off; `None` where nothing was added.
    pub fn psnr(&self) -> Option<f64> {
        let error = self.squares / self.count as f64;
        (self.count > 0).then(|| 20.0 * 255.0f64.log10() - 10.0 * error.log10())
    }
}

/// Adds a picture's errors to those of whole pictures, and to those of the pixels that are opaque in the drawn picture.
///
/// - `drawn`: the picture that says which pixels are opaque.
pub(super) fn add_picture(
    [whole, opaque]: &mut [PictureError; 2],
    truth: &Picture,
    found: &[u8],
    drawn: &Picture,
) {
    whole.add(&truth.rgba, found);
    let pixels = truth.rgba.chunks(4).zip(found.chunks(4)).zip(drawn.rgba.chunks(4));
    let pixels = pixels.filter(|(_, drawn)| drawn[3] == u8::MAX);
    pixels.for_each(|((truth, found), _)| opaque.add(truth, found));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tenth_of_the_peak_is_twenty_decibels() {
        let mut error = PictureError::default();
        assert_eq!(error.psnr(), None);
        error.add(&[7, 9], &[7, 9]);
        assert_eq!(error.psnr(), Some(f64::INFINITY));
        // Squares of 51 and 0 over four numbers: a mean of 25.5 squared.
        error.add(&[0, 100], &[51, 100]);
        assert!((error.psnr().unwrap() - 20.0).abs() < 1e-12);
    }
}
