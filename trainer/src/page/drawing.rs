//! A flat drawing, written as SVG or as PNG.

use super::colour::Colour;
use super::html::text;
use super::picture::Picture;
use crate::Error;
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};
use std::fmt::Write;

/// Shapes drawn over one another on white; coordinates in pixels, x to the right, y down.
pub struct Drawing {
    /// Width, in pixels.
    pub width: usize,
    /// Height, in pixels.
    pub height: usize,
    shapes: Vec<Shape>,
}

enum Shape {
    Image { at: [f64; 2], picture: Picture },
    Line { points: Vec<[f64; 2]>, width: f64, colour: Colour },
    Dot { at: [f64; 2], radius: f64, colour: Colour },
    Text { at: [f64; 2], anchor: Anchor, text: String },
}

/// The part of a text that stands at the text's position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// The first letter.
    Start,
    /// The middle.
    Middle,
    /// The last letter.
    End,
}

/// Height and weight of the letters.
const TEXT: RasterHeight = RasterHeight::Size16;
const WEIGHT: FontWeight = FontWeight::Regular;
/// Colour of all text and edges.
const INK: Colour = [0x22, 0x22, 0x22];

impl Drawing {
    /// Begins a drawing of a width and height in pixels.
    pub fn new(width: usize, height: usize) -> Self {
        Self { width, height, shapes: Vec::new() }
    }

    /// Draws a picture with its upper left corner at a position.
    pub fn image(&mut self, at: [f64; 2], picture: Picture) {
        self.shapes.push(Shape::Image { at, picture });
    }

    /// Draws a line through points.
    pub fn line(&mut self, points: Vec<[f64; 2]>, width: f64, colour: Colour) {
        self.shapes.push(Shape::Line { points, width, colour });
    }

    /// Draws the outline of a box.
    pub fn frame(&mut self, [x, y]: [f64; 2], [width, height]: [f64; 2]) {
        let (right, foot) = (x + width, y + height);
        self.line(vec![[x, y], [right, y], [right, foot], [x, foot], [x, y]], 1.0, INK);
    }

    /// Draws a dot with an outline.
    pub fn dot(&mut self, at: [f64; 2], radius: f64, colour: Colour) {
        self.shapes.push(Shape::Dot { at, radius, colour });
    }

    /// Writes a text with its foot at a position.
    pub fn text(&mut self, at: [f64; 2], anchor: Anchor, text: &str) {
        self.shapes.push(Shape::Text { at, anchor, text: text.to_owned() });
    }

    /// Returns the drawing as SVG.
    ///
    /// # Errors
    /// A picture of the drawing cannot be encoded.
    pub fn svg(&self) -> Result<String, Error> {
        let Self { width, height, shapes } = self;
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" font-family=\"monospace\" font-size=\"14\">\
             <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n"
        );
        for shape in shapes {
            // Writing to a string cannot fail.
            let _ = match shape {
                Shape::Image { at: [x, y], picture } => writeln!(
                    out,
                    "<image x=\"{x:.1}\" y=\"{y:.1}\" width=\"{}\" height=\"{}\" \
                     href=\"{}\"/>",
                    picture.size.width,
                    picture.size.height,
                    picture.data_uri()?
                ),
                Shape::Line { points, width, colour } => {
                    let points: Vec<String> =
                        points.iter().map(|[x, y]| format!("{x:.2},{y:.2}")).collect();
                    let (points, colour) = (points.join(" "), hex(*colour));
                    writeln!(
                        out,
                        "<polyline points=\"{points}\" fill=\"none\" stroke=\"{colour}\" \
                         stroke-width=\"{width}\" stroke-linejoin=\"round\"/>"
                    )
                }
                Shape::Dot { at: [x, y], radius, colour } => writeln!(
                    out,
                    "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{radius}\" fill=\"{}\" stroke=\"{}\"/>",
                    hex(*colour),
                    hex(INK)
                ),
                Shape::Text { at: [x, y], anchor, text: words } => writeln!(
                    out,
                    "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{}\" fill=\"{}\">{}</text>",
                    anchor.parts().0,
                    hex(INK),
                    text(words)
                ),
            };
        }
        Ok(out + "</svg>\n")
    }

    /// Returns the drawing as pixels.
    pub fn picture(&self) -> Picture {
        let mut out = Picture::filled(self.width, self.height, [0xff; 3]);
        for shape in &self.shapes {
            match shape {
                Shape::Image { at: [x, y], picture } => copy(&mut out, [*x, *y], picture),
                Shape::Line { points, width, colour } => {
                    for ends in points.windows(2) {
                        let [a, b] = [ends[0], ends[1]];
                        let reach = 0.5 * width;
                        let inside = |at| reach - segment_distance(at, a, b);
                        cover(&mut out, [a, b], reach, *colour, inside);
                    }
                }
                Shape::Dot { at, radius, colour } => {
                    let inside =
                        |reach: f64| move |p: [f64; 2]| reach - segment_distance(p, *at, *at);
                    let edge = radius + 0.5;
                    cover(&mut out, [*at, *at], edge, INK, inside(edge));
                    cover(&mut out, [*at, *at], *radius, *colour, inside(radius - 0.5));
                }
                Shape::Text { at, anchor, text } => write_text(&mut out, *at, *anchor, text),
            }
        }
        out
    }
}

impl Anchor {
    /// Returns the anchor's name in SVG, and its place as a share of the text's width.
    const fn parts(self) -> (&'static str, f64) {
        match self {
            Self::Start => ("start", 0.0),
            Self::Middle => ("middle", 0.5),
            Self::End => ("end", 1.0),
        }
    }
}

fn hex([r, g, b]: Colour) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Returns the distance of a point from the segment between two points.
pub(crate) fn segment_distance(point: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let along = [b[0] - a[0], b[1] - a[1]];
    let to = [point[0] - a[0], point[1] - a[1]];
    let squared = along[0] * along[0] + along[1] * along[1];
    let share = if squared > 0.0 { (to[0] * along[0] + to[1] * along[1]) / squared } else { 0.0 };
    let share = share.clamp(0.0, 1.0);
    (to[0] - share * along[0]).hypot(to[1] - share * along[1])
}

/// Mixes a colour into the pixels around a segment; `inside` returns how deep a pixel's centre lies inside the shape.
fn cover(
    out: &mut Picture,
    ends: [[f64; 2]; 2],
    reach: f64,
    colour: Colour,
    inside: impl Fn([f64; 2]) -> f64,
) {
    let span = |axis: usize, most: usize| {
        let [a, b] = ends.map(|end| end[axis]);
        let low = (a.min(b) - reach - 1.0).max(0.0) as usize;
        low..((a.max(b) + reach + 2.0).max(0.0) as usize).min(most)
    };
    for y in span(1, out.size.height) {
        for x in span(0, out.size.width) {
            let share = (inside([x as f64 + 0.5, y as f64 + 0.5]) + 0.5).clamp(0.0, 1.0);
            out.mix([x, y], colour, share);
        }
    }
}

fn copy(out: &mut Picture, [x, y]: [f64; 2], picture: &Picture) {
    let (left, top) = (x.round().max(0.0) as usize, y.round().max(0.0) as usize);
    for row in 0..picture.size.height {
        for column in 0..picture.size.width {
            out.mix([left + column, top + row], picture.colour([column, row]), 1.0);
        }
    }
}

fn write_text(out: &mut Picture, [x, y]: [f64; 2], anchor: Anchor, text: &str) {
    let letter = get_raster_width(WEIGHT, TEXT);
    let width = (letter * text.chars().count()) as f64;
    let left = x - anchor.parts().1 * width;
    // Letters stand a quarter of their raster's height above its foot.
    let top = (y - 0.75 * TEXT.val() as f64).round().max(0.0) as usize;
    for (place, character) in text.chars().enumerate() {
        let Some(raster) = get_raster(character, WEIGHT, TEXT) else { continue };
        let left = left.round().max(0.0) as usize + place * letter;
        for (row, shares) in raster.rows().enumerate() {
            for (column, share) in shares.iter().enumerate() {
                out.mix([left + column, top + row], INK, f64::from(*share) / 255.0);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawing() -> Drawing {
        let mut drawing = Drawing::new(80, 60);
        drawing.image([10.0, 10.0], Picture::filled(20, 20, [10, 20, 30]));
        drawing.line(vec![[0.0, 40.5], [80.0, 40.5]], 1.0, [255, 0, 0]);
        drawing.dot([50.5, 20.5], 5.0, [0, 255, 0]);
        drawing.text([40.0, 56.0], Anchor::Middle, "a<b");
        drawing
    }

    #[test]
    fn shapes_are_at_their_positions() {
        let picture = drawing().picture();
        assert_eq!(picture.colour([0, 0]), [255; 3]);
        assert_eq!(picture.colour([15, 15]), [10, 20, 30]);
        assert_eq!(picture.colour([60, 40]), [255, 0, 0]);
        assert_eq!(picture.colour([60, 42]), [255; 3]);
        assert_eq!(picture.colour([50, 20]), [0, 255, 0]);
        assert!(picture.colour([55, 20]).iter().all(|c| *c < 0x60), "the dot's edge");
        let dark = |x: usize| (44..58).any(|y| picture.colour([x, y])[0] < 0x80);
        assert!((28..52).any(dark) && !(0..24).any(dark) && !(56..80).any(dark), "the text");
    }

    #[test]
    fn svg_escapes_text() {
        let svg = drawing().svg().unwrap();
        assert!(svg.contains("a&lt;b") && svg.contains("data:image/png;base64,"));
    }
}
