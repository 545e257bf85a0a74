//! Pictures of functions of one or two numbers, side by side.

use super::matrix;
use super::solver::fit::Fit;
use super::solver::options::Options;
use super::solver::samples::{Conflicts, Samples};
use super::solver::scaling::Block;
use crate::numeric::columns::ends;
use crate::page::colour::{Colour, heat};
use crate::page::drawing::{Anchor, Drawing};
use crate::page::picture::Picture;
use crate::regression::function::order;
use faer::Mat;
use sinew_runtime::kernel::Kernel;

/// Side of a panel's field in pixels, and number of steps along a curve.
const SIDE: usize = 240;
/// Margins of a panel: left, right, above, below.
const MARGIN: [usize; 4] = [64, 16, 28, 44];
/// Panels in a row.
const COLUMNS: usize = 4;
/// Width and height of the key to a field's colours.
const KEY: [usize; 2] = [SIDE, 14];
/// Number of contours over the range of a field.
const CONTOURS: f64 = 10.0;
const CURVE: Colour = [0xbd, 0x2b, 0x44];
const LINE: Colour = [0x22, 0x22, 0x22];
/// Opacity of a contour.
const CONTOUR: f64 = 0.35;

/// Panels of functions over one domain, with samples.
pub struct Plot {
    /// Names of the one or two inputs.
    pub inputs: Vec<String>,
    /// Least and greatest value of each input.
    pub domain: Vec<[f64; 2]>,
    /// Sites of samples.
    pub sites: Vec<Vec<f64>>,
    /// Functions to draw.
    pub panels: Vec<Panel>,
}

/// Panel of one function.
pub struct Panel {
    /// Title of the panel.
    pub title: String,
    /// Values of the function at [`Plot::points`]: along the domain, or row by row from the upper left.
    pub values: Vec<f64>,
    /// Values of the samples.
    pub samples: Vec<f64>,
}

impl Plot {
    /// Lists the points where panels have values.
    pub fn points(domain: &[[f64; 2]]) -> Vec<Vec<f64>> {
        let at = |[low, high]: [f64; 2], step: usize| {
            low + (high - low) * (step as f64 + 0.5) / SIDE as f64
        };
        match domain {
            [x] => (0..SIDE).map(|step| vec![at(*x, step)]).collect(),
            [x, y] => {
                let row =
                    |row: usize| (0..SIDE).map(move |c| vec![at(*x, c), at(*y, SIDE - 1 - row)]);
                (0..SIDE).flat_map(row).collect()
            }
            _ => Vec::new(),
        }
    }

    /// Draws the panels, all on one scale.
    pub fn draw(&self) -> Drawing {
        let columns = self.panels.len().clamp(1, COLUMNS);
        let rows = self.panels.len().div_ceil(columns);
        let [left, right, above, below] = MARGIN;
        let (width, height) = (left + SIDE + right, above + SIDE + below);
        let is_field = self.domain.len() > 1;
        let foot = if is_field { KEY[1] + below } else { 0 };
        let mut out = Drawing::new(columns * width, rows * height + foot);
        let range = self.range();
        for (number, panel) in self.panels.iter().enumerate() {
            let (row, column) = (number / columns, number % columns);
            let corner = [(column * width + left) as f64, (row * height + above) as f64];
            if is_field {
                self.field(&mut out, corner, panel, range);
            } else {
                self.curve(&mut out, corner, panel, range);
            }
            let side = SIDE as f64;
            out.frame(corner, [side, side]);
            let middle = corner[0] + 0.5 * side;
            out.text([middle, corner[1] - 10.0], Anchor::Middle, &panel.title);
        }
        if is_field {
            key(&mut out, [left as f64, (rows * height) as f64], range);
        }
        out
    }

    /// Returns the least and the greatest value of the samples, widened. Values outside this range are cut off.
    fn range(&self) -> [f64; 2] {
        let [low, high] = ends(self.panels.iter().flat_map(|panel| &panel.samples));
        let room = if high > low { 0.25 * (high - low) } else { 1.0 };
        [low - room, high + room]
    }

    fn curve(&self, out: &mut Drawing, corner: [f64; 2], panel: &Panel, range: [f64; 2]) {
        let side = SIDE as f64;
        let height = |y: f64| corner[1] + side * (1.0 - share(y, range));
        let is_inside = |y: &f64| (range[0]..=range[1]).contains(y);
        let steps: Vec<(usize, f64)> = panel.values.iter().copied().enumerate().collect();
        // A curve that leaves the panel ends at the panel's edge.
        for run in steps.chunk_by(|(_, a), (_, b)| is_inside(a) || is_inside(b)) {
            let points = run.iter().map(|(step, y)| [corner[0] + *step as f64 + 0.5, height(*y)]);
            out.line(points.collect(), 1.8, CURVE);
        }
        for (site, y) in self.sites.iter().zip(&panel.samples) {
            let x = corner[0] + side * share(site[0], self.domain[0]);
            out.dot([x, height(*y)], 4.0, [0xff; 3]);
        }
        self.numbers(out, corner, range);
    }

    fn field(&self, out: &mut Drawing, corner: [f64; 2], panel: &Panel, range: [f64; 2]) {
        let mut picture = Picture::filled(SIDE, SIDE, [0xff; 3]);
        let band = |place: usize| (CONTOURS * share(panel.values[place], range)).floor();
        for place in 0..panel.values.len() {
            let at = [place % SIDE, place / SIDE];
            picture.set(at, heat(share(panel.values[place], range)));
            let below = place + SIDE;
            let crosses = at[0] + 1 < SIDE && band(place) != band(place + 1)
                || below < panel.values.len() && band(place) != band(below);
            if crosses {
                picture.mix(at, LINE, CONTOUR);
            }
        }
        out.image(corner, picture);
        let side = SIDE as f64;
        for (site, y) in self.sites.iter().zip(&panel.samples) {
            let x = corner[0] + side * share(site[0], self.domain[0]);
            let y_place = corner[1] + side * (1.0 - share(site[1], self.domain[1]));
            out.dot([x, y_place], 5.0, heat(share(*y, range)));
        }
        self.numbers(out, corner, self.domain[1]);
    }

    /// Writes the range of both sides.
    fn numbers(&self, out: &mut Drawing, [x, y]: [f64; 2], side: [f64; 2]) {
        let (length, [low, high]) = (SIDE as f64, self.domain[0]);
        let foot = y + length + 16.0;
        out.text([x, foot], Anchor::Start, &short(low));
        out.text([x + length, foot], Anchor::End, &short(high));
        out.text([x + 0.5 * length, foot + 16.0], Anchor::Middle, &self.inputs[0]);
        out.text([x - 6.0, y + length], Anchor::End, &short(side[0]));
        out.text([x - 6.0, y + 12.0], Anchor::End, &short(side[1]));
        if let Some(name) = self.inputs.get(1) {
            out.text([x - 6.0, y + 0.5 * length], Anchor::End, name);
        }
    }
}

/// Draws the key to the colours.
fn key(out: &mut Drawing, corner: [f64; 2], [low, high]: [f64; 2]) {
    let [width, height] = KEY;
    let mut picture = Picture::filled(width, height, [0xff; 3]);
    for column in 0..width {
        let colour = heat(column as f64 / (width - 1) as f64);
        (0..height).for_each(|row| picture.set([column, row], colour));
    }
    out.image(corner, picture);
    out.frame(corner, KEY.map(|side| side as f64));
    let foot = corner[1] + height as f64 + 16.0;
    out.text([corner[0], foot], Anchor::Start, &short(low));
    out.text([corner[0] + width as f64, foot], Anchor::End, &short(high));
}

/// Returns the position of a value in a range, in [0, 1].
fn share(value: f64, [low, high]: [f64; 2]) -> f64 {
    ((value - low) / (high - low)).clamp(0.0, 1.0)
}

/// Formats a number in a few letters.
fn short(value: f64) -> String {
    let text = format!("{value:.2}");
    if text.len() <= 7 { text } else { format!("{value:.0e}") }
}

/// Fits every kernel to samples of one value, with a width of the samples' mean distance, and evaluates the fits at
/// points.
///
/// A kernel that needs more samples is omitted.
pub fn all_kernels(
    sites: &[Vec<f64>],
    values: &[f64],
    points: &[Vec<f64>],
) -> Vec<(String, Vec<f64>)> {
    let d = sites.first().map_or(0, Vec::len);
    let values = Mat::from_fn(values.len(), 1, |i, _| values[i]);
    let blocks = vec![Block { len: 1, weight: 1.0 }; d];
    let Ok(samples) = Samples::new(&matrix(sites), &values, &blocks, Conflicts::Average) else {
        return Vec::new();
    };
    let solvable = Kernel::ALL.into_iter().filter(|kernel| order(*kernel).is_some());
    let fitted = solvable.filter_map(|kernel| {
        let fit = Fit::new(&samples, &Options::new(kernel)).ok()?;
        let at = |point: &Vec<f64>| fit.sum.evaluate(point)[0];
        Some((kernel.name().to_owned(), points.iter().map(at).collect()))
    });
    fitted.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_go_along_the_domain_and_down_its_rows() {
        let line = Plot::points(&[[0.0, 1.0]]);
        assert_eq!((line.len(), line[0][0]), (SIDE, 0.5 / SIDE as f64));
        let field = Plot::points(&[[0.0, 1.0], [2.0, 4.0]]);
        assert_eq!(field.len(), SIDE * SIDE);
        assert!(field[0][0] < 0.01 && field[0][1] > 3.99, "the upper left");
        assert!(field[SIDE * SIDE - 1][0] > 0.99 && field[SIDE * SIDE - 1][1] < 2.01);
    }

    #[test]
    fn a_field_is_coloured_by_its_values() {
        let domain = vec![[0.0, 1.0], [0.0, 1.0]];
        let values = Plot::points(&domain).iter().map(|at| at[0]).collect();
        let panel = Panel { title: "x".to_owned(), values, samples: vec![0.0, 1.0] };
        let sites = vec![vec![0.0, 0.5], vec![1.0, 0.5]];
        let inputs = vec!["x".to_owned(), "y".to_owned()];
        let picture = Plot { inputs, domain, sites, panels: vec![panel] }.draw().picture();
        let at = |x: usize| picture.colour([MARGIN[0] + x, MARGIN[2] + 20])[1];
        assert!(at(3) > at(120) && at(120) > at(236), "darker to the right");
    }
}
