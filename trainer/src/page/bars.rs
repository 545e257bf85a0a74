//! Bars in tables and under pictures, as inline SVG.

use super::colour::{Scale, heat};
use std::fmt::Write;

/// A bar for each value against the largest of all.
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

/// The colours of a scale and the errors that they stand for.
pub(crate) fn colour_bar(scale: &Scale, unit: &str) -> String {
    const STRIPS: usize = 60;
    const WIDTH: f64 = 300.0;
    let mut out = String::from("<svg class=\"scale\" viewBox=\"-14 0 328 34\" role=\"img\" ");
    let _ = write!(out, "aria-label=\"colours from 0 to {} {unit}\">", scale.most);
    for strip in 0..STRIPS {
        let [r, g, b] = heat((strip as f64 + 0.5) / STRIPS as f64);
        let width = WIDTH / STRIPS as f64;
        // A little wider, so that no gap shows between two.
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

/// Writes a number with as few digits as tell it to three of them.
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
