//! Plots a curve with its samples and a band of two standard deviations.

use crate::numeric::columns::ends;
use crate::page::colour::Colour;
use crate::page::drawing::{Anchor, Drawing};
use crate::page::picture::Picture;

/// Size of the plot area, and margins left, right, above and below; pixels.
const FIELD: [usize; 2] = [800, 320];
const MARGIN: [usize; 4] = [72, 20, 32, 40];
const BAND: Colour = [0xf6, 0xd5, 0xda];
const CURVE: Colour = [0xbd, 0x2b, 0x44];
const PAPER: Colour = [0xff; 3];
/// Half-width of the band, in standard deviations.
const DEVIATIONS: f64 = 2.0;

/// Contents of a plot.
pub struct SignalPlot {
    /// Title above the plot.
    pub title: String,
    /// Places along the curve, ascending.
    pub places: Vec<f64>,
    /// Curve's value at each place.
    pub values: Vec<f64>,
    /// Standard deviation at each place.
    pub deviations: Vec<f64>,
    /// Samples: place and value.
    pub samples: Vec<[f64; 2]>,
    /// Averages: start, end and value.
    pub boxes: Vec<[f64; 3]>,
}

impl SignalPlot {
    /// Draws the plot.
    pub fn draw(&self) -> Drawing {
        let [left, right, above, below] = MARGIN;
        let [width, height] = FIELD;
        let corner = [left as f64, above as f64];
        let mut out = Drawing::new(left + width + right, above + height + below);
        let [x, y] = self.ranges();
        let place = |at: [f64; 2]| {
            let share = [(at[0] - x[0]) / (x[1] - x[0]), (at[1] - y[0]) / (y[1] - y[0])];
            [corner[0] + share[0] * width as f64, corner[1] + (1.0 - share[1]) * height as f64]
        };
        out.image(corner, self.band(x, |value| place([0.0, value])[1] - corner[1]));
        let points = self.places.iter().zip(&self.values);
        out.line(points.map(|(at, value)| place([*at, *value])).collect(), 1.8, CURVE);
        for &[from, to, value] in &self.boxes {
            out.line(vec![place([from, value]), place([to, value])], 3.0, [0x22; 3]);
        }
        // Denser dots would overlap.
        if self.samples.len() <= width / 4 {
            self.samples.iter().for_each(|at| out.dot(place(*at), 3.5, PAPER));
        }
        out.frame(corner, [width as f64, height as f64]);
        let (foot, end) = (corner[1] + height as f64, corner[0] + width as f64);
        out.text([corner[0], corner[1] - 10.0], Anchor::Start, &self.title);
        out.text([corner[0], foot + 18.0], Anchor::Start, &short(x[0]));
        out.text([end, foot + 18.0], Anchor::End, &short(x[1]));
        out.text([corner[0] - 6.0, foot], Anchor::End, &short(y[0]));
        out.text([corner[0] - 6.0, corner[1] + 12.0], Anchor::End, &short(y[1]));
        out
    }

    /// Paints the band column by column.
    ///
    /// - `down`: maps a value to rows from the top.
    fn band(&self, [low, high]: [f64; 2], down: impl Fn(f64) -> f64) -> Picture {
        let [width, height] = FIELD;
        let mut picture = Picture::filled(width, height, PAPER);
        for column in 0..width {
            let at = low + (high - low) * (column as f64 + 0.5) / width as f64;
            let next = self.places.partition_point(|place| *place < at);
            let (Some(value), Some(deviation)) =
                (self.between(&self.values, next, at), self.between(&self.deviations, next, at))
            else {
                continue;
            };
            let [top, foot] = [1.0, -1.0].map(|side| down(value + side * DEVIATIONS * deviation));
            let rows =
                top.clamp(0.0, height as f64) as usize..foot.clamp(0.0, height as f64) as usize;
            rows.for_each(|row| picture.set([column, row], BAND));
        }
        picture
    }

    /// Interpolates between two places; `None` outside the curve.
    fn between(&self, numbers: &[f64], next: usize, at: f64) -> Option<f64> {
        let before = next.checked_sub(1)?;
        let [from, to] = [*self.places.get(before)?, *self.places.get(next)?];
        let share = (at - from) / (to - from);
        Some(numbers.get(before)? * (1.0 - share) + numbers.get(next)? * share)
    }

    /// Returns the ranges of x and y. They show the whole curve and the samples within; a wide band may be cut.
    fn ranges(&self) -> [[f64; 2]; 2] {
        let boxes = self.boxes.iter().map(|of| of[2]);
        let samples = self.samples.iter().map(|at| at[1]);
        let all: Vec<f64> = self.values.iter().copied().chain(samples).chain(boxes).collect();
        let [low, high] = ends(&all);
        let widest = ends(&self.deviations)[1].max(0.0) * DEVIATIONS;
        let room =
            if high > low { 0.08 * (high - low) + widest.min(0.5 * (high - low)) } else { 1.0 };
        let [first, last] = ends(&self.places);
        [[first, if last > first { last } else { first + 1.0 }], [low - room, high + room]]
    }
}

/// Formats a number in a few characters.
fn short(value: f64) -> String {
    let text = format!("{value:.2}");
    if text.len() <= 8 { text } else { format!("{value:.1e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_band_is_about_the_curve_and_as_wide_as_its_deviation() {
        let places: Vec<f64> = (0..=10).map(f64::from).collect();
        let deviations: Vec<f64> =
            places.iter().map(|x| if *x < 5.0 { 0.0 } else { 0.2 }).collect();
        let plot = SignalPlot {
            title: "a".to_owned(),
            values: vec![0.0; 11],
            places,
            deviations,
            samples: vec![[0.0, 1.0], [10.0, -1.0]],
            boxes: Vec::new(),
        };
        let picture = plot.draw().picture();
        let middle = MARGIN[2] + FIELD[1] / 2;
        let at = |x: usize, y: usize| picture.colour([MARGIN[0] + x, y]);
        assert_eq!(at(700, middle - 20), BAND);
        assert_eq!(at(100, middle - 20), PAPER);
        assert!(at(700, middle)[1] < 0x60, "the curve");
    }
}
