//! Charts and bars as inline SVG, coloured by the page's style.

use super::colour::{Scale, heat};
use super::html::text;
use std::fmt::Write;

/// Margins in pixels; the left margin holds the numbers of the left side.
const LEFT: f64 = 52.0;
const RIGHT: f64 = 12.0;
const TOP: f64 = 26.0;
const BOTTOM: f64 = 40.0;
/// Fewest pixels between two numbers.
const TICK_GAP: f64 = 26.0;

/// A range of numbers along one side of a chart.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Range {
    low: f64,
    high: f64,
    log: bool,
}

/// A chart under construction.
pub(crate) struct Chart {
    width: f64,
    height: f64,
    x: Range,
    y: Range,
    body: String,
}

impl Range {
    /// Makes a linear range.
    pub(crate) fn linear(low: f64, high: f64) -> Self {
        Self { low, high: if high > low { high } else { low + 1.0 }, log: false }
    }

    /// Makes a logarithmic range between two positive numbers, `low` below `high`.
    pub(crate) fn between(low: f64, high: f64) -> Self {
        Self { low, high, log: true }
    }

    /// Makes a logarithmic range over the positive numbers, of at most four decades.
    pub(crate) fn log(numbers: impl IntoIterator<Item = f64>) -> Self {
        let (mut low, mut high) = (f64::INFINITY, 0.0);
        for number in numbers.into_iter().filter(|number| *number > 0.0) {
            low = low.min(number);
            high = f64::max(high, number);
        }
        if high == 0.0 {
            (low, high) = (1.0, 1.0);
        }
        Self { low: low.max(1e-4 * high) / 1.2, high: 1.2 * high, log: true }
    }

    /// Returns the place of a value along the side, in [0, 1].
    fn place(&self, value: f64) -> f64 {
        let Self { low, high, log } = *self;
        let share = if log {
            (value.max(low) / low).ln() / (high / low).ln()
        } else {
            (value - low) / (high - low)
        };
        share.clamp(0.0, 1.0)
    }

    /// Lists at most `most` round numbers of the range.
    fn ticks(&self, most: usize) -> Vec<(f64, String)> {
        let steps: [&[f64]; 3] = [&[1.0, 2.0, 5.0], &[1.0, 3.0], &[1.0]];
        if self.log {
            let decades = self.low.log10().floor() as i32..=self.high.log10().ceil() as i32;
            let of = |steps: &[f64]| -> Vec<(f64, String)> {
                let all = decades.clone().flat_map(|d| steps.iter().map(move |s| number(*s, d)));
                all.filter(|tick| (self.low..=self.high).contains(&tick.0)).collect()
            };
            let few = steps.iter().map(|steps| of(steps)).find(|ticks| ticks.len() <= most);
            return few.unwrap_or_else(|| of(&[1.0]));
        }
        let decade = ((self.high - self.low) / most as f64).log10().floor() as i32;
        let step = [1.0, 2.0, 5.0, 10.0, 20.0].map(|step| number(step, decade).0);
        let room = |step: &&f64| (self.high - self.low) / **step <= most as f64;
        let step = *step.iter().find(room).unwrap_or(&step[4]);
        let (first, last) = ((self.low / step).ceil() as i64, (self.high / step).floor() as i64);
        let places = usize::try_from(-decade).unwrap_or(0);
        (first..=last).map(|k| k as f64 * step).map(|v| (v, format!("{v:.places$}"))).collect()
    }
}

impl Chart {
    /// Begins a chart of a width and height in pixels.
    pub(crate) fn new((width, height): (f64, f64), x: Range, y: Range) -> Self {
        Self { width, height, x, y, body: String::new() }
    }

    /// Returns the pixel of a point.
    fn at(&self, x: f64, y: f64) -> (f64, f64) {
        let (width, height) = (self.width - LEFT - RIGHT, self.height - TOP - BOTTOM);
        (LEFT + width * self.x.place(x), TOP + height * (1.0 - self.y.place(y)))
    }

    fn push(&mut self, item: std::fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = self.body.write_fmt(item);
    }

    /// Names the sides, and draws the numbers and grid lines of the left side.
    pub(crate) fn sides(&mut self, x: &str, y: &str) {
        let most = ((self.height - TOP - BOTTOM) / TICK_GAP).max(2.0) as usize;
        for (value, name) in self.y.ticks(most) {
            let ((left, at), right) = (self.at(self.x.low, value), self.width - RIGHT);
            self.push(format_args!(
                "<line class=\"grid\" x1=\"{left:.1}\" x2=\"{right:.1}\" y1=\"{at:.1}\" y2=\"{at:.1}\"/>\
                 <text class=\"end\" x=\"{:.1}\" y=\"{:.1}\">{name}</text>",
                left - 7.0,
                at + 4.0
            ));
        }
        let (foot, middle) = (self.height - 4.0, 0.5 * (LEFT + self.width - RIGHT));
        let (x, y) = (text(x), text(y));
        self.push(format_args!(
            "<text class=\"side\" x=\"0\" y=\"12\">{y}</text>\
             <text class=\"side middle\" x=\"{middle:.1}\" y=\"{foot:.1}\">{x}</text>"
        ));
    }

    /// Writes round numbers under the chart.
    pub(crate) fn numbers(&mut self) {
        let most = ((self.width - LEFT - RIGHT) / (2.5 * TICK_GAP)).max(2.0) as usize;
        for (value, name) in self.x.ticks(most) {
            self.mark(value, &name);
        }
    }

    /// Writes a label under a number of the lower side.
    pub(crate) fn mark(&mut self, x: f64, name: &str) {
        let (at, foot) = self.at(x, self.y.low);
        let name = text(name);
        self.push(format_args!(
            "<line class=\"tick\" x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"{foot:.1}\" y2=\"{:.1}\"/>\
             <text class=\"middle\" x=\"{at:.1}\" y=\"{:.1}\">{name}</text>",
            foot + 4.0,
            foot + 17.0
        ));
    }

    /// Draws a line through points.
    pub(crate) fn line(&mut self, class: &str, points: &[(f64, f64)]) {
        let path = self.path(points);
        self.push(format_args!("<path class=\"line {class}\" d=\"{path}\"/>"));
    }

    /// Fills the area under a line through points.
    pub(crate) fn area(&mut self, class: &str, points: &[(f64, f64)]) {
        let (Some(first), Some(last)) = (points.first(), points.last()) else { return };
        let path = self.path(points);
        let (left, foot) = self.at(first.0, self.y.low);
        let (right, _) = self.at(last.0, self.y.low);
        self.push(format_args!(
            "<path class=\"area {class}\" d=\"{path}L{right:.1} {foot:.1}L{left:.1} {foot:.1}Z\"/>"
        ));
    }

    /// Draws a dot at each point.
    pub(crate) fn dots(&mut self, class: &str, points: &[(f64, f64)]) {
        for &(x, y) in points {
            let (x, y) = self.at(x, y);
            self.push(format_args!(
                "<circle class=\"dot {class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\"/>"
            ));
        }
    }

    /// Colours the background between two numbers of the lower side and writes a name at the top.
    pub(crate) fn band(&mut self, class: &str, (from, to): (f64, f64), name: &str) {
        let ((left, foot), (right, _)) = (self.at(from, self.y.low), self.at(to, self.y.low));
        let (name, width, height) = (text(name), right - left, foot - TOP);
        self.push(format_args!(
            "<g class=\"band {class}\"><rect x=\"{left:.1}\" y=\"{TOP}\" width=\"{width:.1}\" \
             height=\"{height:.1}\"/>"
        ));
        // A name without room would cover its neighbour. The tooltip still shows the name.
        if 6.5 * name.chars().count() as f64 <= width {
            self.push(format_args!(
                "<text x=\"{:.1}\" y=\"{:.1}\">{name}</text>",
                left + 4.0,
                TOP + 13.0
            ));
        }
        self.push(format_args!("<title>{name}</title></g>"));
    }

    /// Adds a tooltip between two numbers of the lower side.
    pub(crate) fn tooltip(&mut self, (from, to): (f64, f64), what: &str) {
        let ((left, foot), (right, _)) = (self.at(from, self.y.low), self.at(to, self.y.low));
        let (what, width, height) = (text(what), right - left, foot - TOP);
        self.push(format_args!(
            "<rect class=\"tell\" x=\"{left:.1}\" y=\"{TOP}\" width=\"{width:.2}\" \
             height=\"{height:.1}\"><title>{what}</title></rect>"
        ));
    }

    /// Ends the chart; `description` describes the chart to readers who cannot see it.
    pub(crate) fn finish(self, description: &str) -> String {
        let Self { width, height, body, .. } = self;
        let description = text(description);
        format!(
            "<svg class=\"chart\" role=\"img\" aria-label=\"{description}\" viewBox=\"0 0 {width} \
             {height}\">{body}</svg>\n"
        )
    }

    fn path(&self, points: &[(f64, f64)]) -> String {
        let mut path = String::new();
        for (number, &(x, y)) in points.iter().enumerate() {
            let (x, y) = self.at(x, y);
            let _ = write!(path, "{}{x:.1} {y:.1}", if number == 0 { 'M' } else { 'L' });
        }
        if points.len() == 1 {
            // Round line ends turn this into a dot.
            path += "h0";
        }
        path
    }
}

/// Returns the legend of lines, from their classes and names.
pub(crate) fn legend(entries: &[(&str, &str)]) -> String {
    let of = |(class, name): &(&str, &str)| {
        format!("<span><i class=\"{class}\"></i>{}</span>", text(name))
    };
    format!("<p class=\"legend\">{}</p>\n", entries.iter().map(of).collect::<String>())
}

/// Returns a bar for each value, scaled so that `most` fills the width.
pub(crate) fn bars(values: &[(&str, f64)], most: f64) -> String {
    let height = 9 * values.len();
    let mut out = format!("<svg class=\"bars\" viewBox=\"0 0 200 {height}\" aria-hidden=\"true\">");
    for (row, (class, value)) in values.iter().enumerate() {
        let width = if most > 0.0 { 200.0 * value / most } else { 0.0 };
        let _ = write!(
            out,
            "<rect class=\"{class}\" x=\"0\" y=\"{}\" width=\"{width:.1}\" height=\"7\"/>",
            9 * row + 1
        );
    }
    out + "</svg>"
}

/// Returns the colours of a scale, with the errors that they represent.
pub(crate) fn colour_bar(scale: &Scale, unit: &str) -> String {
    const STRIPS: usize = 60;
    const WIDTH: f64 = 300.0;
    let mut out = String::from("<svg class=\"scale\" viewBox=\"-14 0 328 34\" role=\"img\" ");
    let _ = write!(out, "aria-label=\"colours from 0 to {} {unit}\">", scale.most);
    for strip in 0..STRIPS {
        let [r, g, b] = heat((strip as f64 + 0.5) / STRIPS as f64);
        let width = WIDTH / STRIPS as f64;
        // Strips overlap a little, so that no gap shows between them.
        let _ = write!(
            out,
            "<rect x=\"{}\" y=\"0\" width=\"{}\" height=\"12\" fill=\"#{r:02x}{g:02x}{b:02x}\"/>",
            strip as f64 * width,
            width + if strip + 1 < STRIPS { 0.5 } else { 0.0 }
        );
    }
    for tick in scale.ticks() {
        let x = WIDTH * scale.place(tick);
        let name = significant(tick);
        let _ = write!(
            out,
            "<line class=\"tick\" x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"12\" y2=\"16\"/>\
             <text class=\"middle\" x=\"{x:.1}\" y=\"29\">{name}</text>"
        );
    }
    out + "</svg>"
}

/// Returns `step` times a power of ten, and its text.
fn number(step: f64, decade: i32) -> (f64, String) {
    let places = usize::try_from(-decade).unwrap_or(0);
    let value = step * 10_f64.powi(decade);
    (value, format!("{value:.places$}"))
}

/// Formats a number to three significant digits, without trailing zeros.
fn significant(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let places = usize::try_from(2 - value.log10().floor() as i64).unwrap_or(0);
    let digits = format!("{value:.places$}");
    match digits.contains('.') {
        true => digits.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => digits,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(range: Range, most: usize) -> Vec<String> {
        range.ticks(most).into_iter().map(|tick| tick.1).collect()
    }

    #[test]
    fn ticks_are_round_and_no_more_than_asked() {
        assert_eq!(names(Range::linear(0.0, 1.0), 5), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(
            names(Range::linear(0.0, 730.0), 8),
            ["0", "100", "200", "300", "400", "500", "600", "700"]
        );
        let log = Range::between(0.004, 2.5);
        assert_eq!(names(log, 9), ["0.005", "0.01", "0.02", "0.05", "0.1", "0.2", "0.5", "1", "2"]);
        assert_eq!(names(log, 6), ["0.01", "0.03", "0.1", "0.3", "1"]);
        assert_eq!(names(log, 4), ["0.01", "0.1", "1"]);
    }

    #[test]
    fn places_are_proportional_or_by_ratios() {
        assert_eq!(Range::linear(2.0, 6.0).place(3.0), 0.25);
        let log = Range::between(0.01, 100.0);
        assert!((log.place(1.0) - 0.5).abs() < 1e-12);
        assert_eq!((log.place(0.0), log.place(1e9)), (0.0, 1.0));
        // Zero has no place on a logarithmic side, and does not stretch the side.
        assert!((Range::log([0.0, 1.0, 100.0]).place(10.0) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn lines_go_through_their_points() {
        let mut chart =
            Chart::new((100.0, 100.0), Range::linear(0.0, 1.0), Range::linear(0.0, 1.0));
        chart.line("model", &[(0.0, 0.0), (1.0, 1.0)]);
        let (left, right, top, foot) = (LEFT, 100.0 - RIGHT, TOP, 100.0 - BOTTOM);
        let path = format!("d=\"M{left:.1} {foot:.1}L{right:.1} {top:.1}\"");
        assert!(chart.finish("a <chart>").contains(&path));
    }

    #[test]
    fn numbers_on_a_scale_are_short_and_true() {
        for (value, expected) in [
            (0.0, "0"),
            (0.375, "0.375"),
            (1.25, "1.25"),
            (2.0, "2"),
            (0.0016, "0.0016"),
            (120.0, "120"),
        ] {
            assert_eq!(significant(value), expected);
        }
    }

    #[test]
    fn bars_are_as_long_as_their_values() {
        let out = bars(&[("lbs", 4.0), ("model", 1.0)], 8.0);
        assert!(out.contains("class=\"lbs\" x=\"0\" y=\"1\" width=\"100.0\""), "{out}");
        assert!(out.contains("class=\"model\" x=\"0\" y=\"10\" width=\"25.0\""), "{out}");
    }
}
