//! Upsamples images with one filter: columns, then rows, since C(x, y) = C(x) C(y) (METHOD §4).

use super::grid::{GridFilter, Shape};
use crate::{Error, ErrorKind};
use png::{BitDepth, ColorType, Decoder, DecodingError, Encoder, Transformations};
use std::fmt::Display;
use std::fs::File;
use std::io::{self, BufReader};
use std::path::Path;

/// Bisection steps: enough to exhaust the digits of f64.
const HALVINGS: usize = 60;

/// Pixels from the upper left, row by row, in the file's own numbers: sRGB stays sRGB. Colours are premultiplied by
/// alpha.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels per row.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Channels per pixel: grey or RGB, then alpha if [`Self::has_alpha`].
    pub channels: usize,
    /// Whether the last channel is alpha.
    pub has_alpha: bool,
    /// Largest channel value: 255 or 65535.
    pub most: f64,
    /// Channel values, height x width x channels.
    pub samples: Vec<f64>,
}

impl Image {
    /// Reads a PNG with 8 or 16 bits per channel. Palettes and smaller depths become 8 bits.
    ///
    /// # Errors
    /// If the file cannot be read or decoded. Names the file.
    pub fn read(file: &Path) -> Result<Self, Error> {
        Self::decode(file).map_err(|error| error.in_file(file))
    }

    fn decode(file: &Path) -> Result<Self, Error> {
        let opened = File::open(file)
            .map_err(|cause| Error::new(ErrorKind::Read, without_stop(&cause)).caused_by(cause))?;
        let mut decoder = Decoder::new(BufReader::new(opened));
        decoder.set_transformations(Transformations::EXPAND);
        let mut reader = decoder.read_info().map_err(undecoded)?;
        let len = reader.output_buffer_size().ok_or_else(|| Error::limit("it is too large"))?;
        let mut bytes = vec![0; len];
        let frame = reader.next_frame(&mut bytes).map_err(undecoded)?;
        bytes.truncate(frame.buffer_size());
        let (most, samples): (f64, Vec<f64>) = match frame.bit_depth {
            BitDepth::Sixteen => {
                let (pairs, _) = bytes.as_chunks();
                (65535.0, pairs.iter().map(|pair| u16::from_be_bytes(*pair).into()).collect())
            }
            _ => (255.0, bytes.iter().map(|byte| (*byte).into()).collect()),
        };
        let (channels, has_alpha) = match frame.color_type {
            ColorType::Grayscale => (1, false),
            ColorType::GrayscaleAlpha => (2, true),
            ColorType::Rgb => (3, false),
            ColorType::Rgba => (4, true),
            other @ ColorType::Indexed => {
                return Err(Error::unsupported(format!("{other:?} is not read")));
            }
        };
        let (width, height) = (frame.width as usize, frame.height as usize);
        let mut image = Self { width, height, channels, has_alpha, most, samples };
        image.scale_colours(|colour, share| colour * share);
        Ok(image)
    }

    /// Encodes a PNG: rounds channel values and clips them to the bit depth.
    ///
    /// # Errors
    /// Errors of the encoder.
    pub fn png(&self) -> Result<Vec<u8>, png::EncodingError> {
        let mut own = self.clone();
        let most = self.most;
        own.scale_colours(|colour, share| if share > 0.0 { colour / share } else { 0.0 });
        let numbers = own.samples.iter().map(|x| x.round().clamp(0.0, most));
        let is_wide = most > 255.0;
        let content: Vec<u8> = if is_wide {
            numbers.flat_map(|x| (x as u16).to_be_bytes()).collect()
        } else {
            numbers.map(|x| x as u8).collect()
        };
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes, self.width as u32, self.height as u32);
        encoder.set_color(match self.channels {
            1 => ColorType::Grayscale,
            2 => ColorType::GrayscaleAlpha,
            3 => ColorType::Rgb,
            _ => ColorType::Rgba,
        });
        encoder.set_depth(if is_wide { BitDepth::Sixteen } else { BitDepth::Eight });
        encoder.write_header()?.write_image_data(&content)?;
        Ok(bytes)
    }

    /// Upsamples the image; does not round or clip.
    ///
    /// # Errors
    /// If the image has fewer rows or columns than a window.
    pub fn finer(&self, filter: &GridFilter) -> Result<Self, Error> {
        let Self { width, height, channels, .. } = *self;
        let factor = filter.grid.factor;
        let columns = Shape { samples: height, lanes: width * channels };
        let tall = filter.apply(&self.samples, columns)?;
        let samples = filter.apply(&tall, Shape { samples: width, lanes: channels })?;
        Ok(Self { width: factor * width, height: factor * height, samples, ..self.clone() })
    }

    /// Clips values to the file's range and colours to their alpha, but keeps the mean of each box of `factor` x
    /// `factor` pixels. If a box needs clipping, all its values first move by one amount.
    ///
    /// # Errors
    /// If a side is not a multiple of `factor`.
    pub fn within(&self, factor: usize) -> Result<Self, Error> {
        let mut out = self.clone();
        let means = self.coarser(factor)?;
        let colours = self.channels - usize::from(self.has_alpha);
        // Alpha comes first, because it bounds the colours.
        for channel in (0..self.channels).rev() {
            let is_bound = self.has_alpha && channel < colours;
            for (place, mean) in
                means.samples.iter().enumerate().skip(channel).step_by(self.channels)
            {
                let pixel = place / self.channels;
                let (row, column) = (pixel / means.width * factor, pixel % means.width * factor);
                let at = |k: usize| {
                    ((row + k / factor) * self.width + column + k % factor) * self.channels
                };
                let own: Vec<[f64; 2]> = (0..factor * factor)
                    .map(|k| {
                        let most = if is_bound { out.samples[at(k) + colours] } else { self.most };
                        [out.samples[at(k) + channel], most]
                    })
                    .collect();
                for (k, kept) in clip_keeping_mean(&own, *mean).into_iter().enumerate() {
                    out.samples[at(k) + channel] = kept;
                }
            }
        }
        Ok(out)
    }

    /// Downsamples by averaging boxes of `factor` x `factor` pixels; does not round.
    ///
    /// # Errors
    /// If a side is not a multiple of `factor`.
    pub fn coarser(&self, factor: usize) -> Result<Self, Error> {
        let Self { width, height, channels, .. } = *self;
        for (what, found) in [("the width", width), ("the height", height)] {
            if factor == 0 || found % factor != 0 {
                return Err(Error::value(format!(
                    "{what}: expected a multiple of {factor}, found {found}"
                )));
            }
        }
        let (wide, tall) = (width / factor, height / factor);
        let mut samples = vec![0.0; wide * tall * channels];
        for (place, x) in self.samples.iter().enumerate() {
            let (pixel, channel) = (place / channels, place % channels);
            let (row, column) = (pixel / width / factor, pixel % width / factor);
            samples[(row * wide + column) * channels + channel] += x / (factor * factor) as f64;
        }
        Ok(Self { width: wide, height: tall, samples, ..self.clone() })
    }

    /// Applies `change` to every colour and its pixel's alpha, which is scaled to 0..1.
    fn scale_colours(&mut self, change: impl Fn(f64, f64) -> f64) {
        if !self.has_alpha {
            return;
        }
        let most = self.most;
        for pixel in self.samples.chunks_exact_mut(self.channels) {
            if let Some((alpha, colours)) = pixel.split_last_mut() {
                let share = alpha.clamp(0.0, most) / most;
                colours.iter_mut().for_each(|colour| *colour = change(*colour, share));
            }
        }
    }
}

/// Returns the error of a picture that cannot be decoded.
fn undecoded(cause: DecodingError) -> Error {
    let kind = match &cause {
        // A file that ends too early is damaged.
        DecodingError::IoError(error) if error.kind() != io::ErrorKind::UnexpectedEof => {
            ErrorKind::Read
        }
        DecodingError::LimitsExceeded => ErrorKind::Limit,
        _ => ErrorKind::Damaged,
    };
    Error::new(kind, without_stop(&cause)).caused_by(cause)
}

/// Formats an error without the full stop at its end.
fn without_stop(error: &impl Display) -> String {
    error.to_string().trim_end_matches('.').to_owned()
}

/// Clips `[number, greatest]` pairs to 0..greatest after a common offset. The offset restores the given mean, or the
/// nearest possible mean.
fn clip_keeping_mean(numbers: &[[f64; 2]], mean: f64) -> Vec<f64> {
    if numbers.iter().all(|[number, most]| (0.0..=*most).contains(number)) {
        return numbers.iter().map(|[number, _]| *number).collect();
    }
    let moved = |by: f64| numbers.iter().map(move |[number, most]| (number + by).clamp(0.0, *most));
    let sum = mean * numbers.len() as f64;
    // Over this bracket the clipped sum grows from its minimum to its maximum.
    let reach = numbers.iter().map(|[number, most]| number.abs() + most).fold(0.0, f64::max);
    let (mut low, mut high) = (-reach, reach);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if moved(middle).sum::<f64>() < sum { low = middle } else { high = middle }
    }
    moved(high).collect()
}

#[cfg(test)]
mod tests {
    use super::super::covariance::Covariance;
    use super::super::grid::{Grid, Sample};
    use super::super::kriging::Mean;
    use super::super::kriging::Process;
    use super::*;

    fn filter(factor: usize) -> GridFilter {
        let covariance = Covariance::OrnsteinUhlenbeck { length: 3.0 };
        let process = Process { covariance, mean: Mean::Constant, noise: 0.0 };
        let grid = Grid { factor, taps: 5, sample: Sample::Average };
        GridFilter::new(&process, grid).unwrap()
    }

    fn image(width: usize, height: usize) -> Image {
        let samples = (0..3 * width * height).map(|i| (37 * i * i % 251) as f64).collect();
        Image { width, height, channels: 3, has_alpha: false, most: 255.0, samples }
    }

    #[test]
    fn downsampling_inverts_upsampling() {
        let image = image(9, 7);
        for factor in 2..=4 {
            let fine = image.finer(&filter(factor)).unwrap();
            assert_eq!((fine.width, fine.height), (9 * factor, 7 * factor));
            let again = fine.coarser(factor).unwrap();
            assert_eq!((again.width, again.height), (9, 7));
            for (found, expected) in again.samples.iter().zip(&image.samples) {
                assert!((found - expected).abs() < 1e-10, "{found} {expected}");
            }
        }
    }

    /// Draws stripes like text: black on white, or white on transparent.
    fn drawn(has_alpha: bool) -> Image {
        let (width, height, channels) = (14, 11, if has_alpha { 4 } else { 3 });
        let number =
            |i: usize| if i / channels % 5 * (i / channels / 14 % 3) < 3 { 255.0 } else { 0.0 };
        let samples = (0..channels * width * height).map(number).collect();
        Image { width, height, channels, has_alpha, most: 255.0, samples }
    }

    #[test]
    fn clipping_keeps_the_mean_of_each_box() {
        for has_alpha in [false, true] {
            let image = drawn(has_alpha);
            for factor in 2..=4 {
                let fine = image.finer(&filter(factor)).unwrap();
                let held = |x: &f64| (0.0..=255.0).contains(x);
                assert!(!fine.samples.iter().all(held), "edges ring");
                let kept = fine.within(factor).unwrap();
                assert!(kept.samples.iter().all(held));
                for pixel in kept.samples.chunks(4).filter(|_| has_alpha) {
                    assert!(pixel[..3].iter().all(|colour| *colour <= pixel[3]), "{pixel:?}");
                }
                for (found, expected) in
                    kept.coarser(factor).unwrap().samples.iter().zip(&image.samples)
                {
                    assert!((found - expected).abs() < 1e-10, "{factor}: {found} {expected}");
                }
            }
        }
    }

    #[test]
    fn values_in_range_stay_and_clipping_moves_the_others() {
        assert_eq!(clip_keeping_mean(&[[3.0, 9.0], [0.0, 9.0]], 1.5), [3.0, 0.0]);
        // 12 clips to 9. The others rise by 1 to keep the mean.
        let found = clip_keeping_mean(&[[12.0, 9.0], [4.0, 9.0], [5.0, 9.0], [-1.0, 9.0]], 5.0);
        for (found, expected) in found.iter().zip([9.0, 5.0, 6.0, 0.0]) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
        assert_eq!(
            clip_keeping_mean(&[[12.0, 9.0], [11.0, 9.0]], 11.5),
            [9.0, 9.0],
            "no mean above the most"
        );
    }

    #[test]
    fn sides_that_boxes_do_not_fill_are_refused() {
        let wrong = image(9, 8).coarser(2).unwrap_err();
        assert_eq!(wrong.to_string(), "the width: expected a multiple of 2, found 9");
        let wrong = image(8, 9).coarser(2).unwrap_err();
        assert_eq!(wrong.to_string(), "the height: expected a multiple of 2, found 9");
        let short = image(9, 3).finer(&filter(2)).unwrap_err();
        assert_eq!(short.to_string(), "3 samples are fewer than a window's 5: take fewer taps");
    }
}
