//! An HTML page that shows the prior's effect: a face by a few handles, with and without the prior, and a drag.

use super::baked::Shaped;
use super::evaluate::{Evaluation, Gram, Method, Protocol, Row, wrong_handles};
use super::picture::{Paint, Photographer};
use crate::Error;
use crate::page::chart::colour_bar;
use crate::page::colour::Scale;
use crate::page::html::{self, figure, paragraph, section, side_by_side, table, text};
use sinew_runtime::prior::{Anchor, Pin, PinJob};

/// Pictures of the drag.
const STEPS: usize = 6;
/// Frames to show.
const SHOWN: usize = 3;

/// A page about a measurement.
pub struct Report<'a> {
    /// Faces and data of the measurement.
    pub protocol: &'a Protocol<'a>,
    /// Results of the measurement.
    pub evaluation: &'a Evaluation,
    /// Camera of the pictures.
    pub photographer: &'a Photographer<'a>,
    /// Name of the take.
    pub take: &'a str,
}

/// A solved face, and each vertex's distance from the true face.
struct Solved {
    shaped: Shaped,
    errors: Vec<f64>,
    pins: Vec<([f64; 3], [f64; 3])>,
    rms: f64,
}

impl Report<'_> {
    /// Renders the page as one HTML file without scripts or external resources.
    ///
    /// # Errors
    /// Nothing was measured, a picture cannot be encoded, or the runtime refuses a call.
    pub fn html(&self) -> Result<String, Error> {
        let Some((&handles, row)) = self.evaluation.handles.iter().next() else {
            return Err(wrong_handles(0, self.protocol.landmarks.len()));
        };
        let name = self.protocol.face.skin.name();
        let share = 100.0 * row.prior / row.slider;
        let head = format!(
            "<h1>{} by a few handles</h1>\n<p class=\"under\">{} vertices, {} shapes; measured on {} frames of {}</p>\n\
             <p class=\"verdict\">With {handles} of {} landmarks at their true place, the rest of the face has an RMS \
             error of <b>{:.4}</b>: {share:.0} % of the slider norm's error ({:.4}).</p>\n",
            text(name),
            self.protocol.face.skin.vertex_len(),
            self.protocol.face.skin.shape_len(),
            self.evaluation.frames,
            text(self.take),
            self.evaluation.landmarks,
            row.prior,
            row.slider,
        );
        let gram = Gram::new(&self.protocol.face, self.protocol.vertices.clone());
        let strongest = self.strongest(&gram);
        let sections = [
            section("By the number of handles", &self.figures()),
            section("Side by side", &self.frames(handles, row, &strongest, &gram)?),
            section("A drag", &self.drag(row, &strongest)?),
        ];
        Ok(html::page(&format!("{name} by a few handles"), &(head + &sections.concat())))
    }

    fn figures(&self) -> String {
        let head = [
            "handles",
            "nothing",
            "slider norm",
            "slider norm, from the mean",
            "prior",
            "prior, bounded",
        ];
        let rows = self.evaluation.handles.iter().map(|(handles, row)| {
            let figures = [row.nothing, row.slider, row.slider_mean, row.prior, row.bounded];
            let figures = figures.iter().map(|x| format!("{x:.4}"));
            std::iter::once(handles.to_string()).chain(figures).collect::<Vec<_>>()
        });
        let what = "RMS distance of the face to the take's, in the file's unit: the mean over ten draws of \
                    handles among the landmarks. The slider norm treats weights as independent (Lewis and Anjyo 2010); \
                    the prior has learned from the take which weights move together.";
        table(&head.map(str::to_owned), &rows.collect::<Vec<_>>()) + &paragraph(what)
    }

    /// Shows the most expressive frames: the take, the slider norm and the prior.
    fn frames(
        &self,
        handles: usize,
        row: &Row,
        strongest: &[&[f64]],
        gram: &Gram,
    ) -> Result<String, Error> {
        let pinned = self.protocol.draw(handles, 0);
        let mut out = paragraph(&format!(
            "Expressions of the take that move the most. Red dots are the {handles} handles, white rings their \
             targets. Colours are distances: first the motion of the take, then the errors of the other two on one scale."
        ));
        let Protocol { face, slider, .. } = *self.protocol;
        for frame in strongest {
            let shaped = face.shaped(&narrow(frame))?;
            let solve = |name: &str, face, anchor| {
                let method = Method { face, anchor, is_bounded: false };
                let weights = method.solve(&pinned, beta(row, name), &[*frame])?.concat();
                let own = self.protocol.face.shaped(&narrow(&weights))?;
                let pins = pinned.iter().map(|&v| (own.positions[v], face.place(v, frame)));
                let (pins, rms) = (pins.collect(), gram.mean_square(&weights, frame).sqrt());
                Ok::<_, Error>(Solved::new(own, &shaped, pins, rms))
            };
            let slider = solve("slider", slider, Anchor::Current)?;
            let prior = solve("prior", face, Anchor::Mean)?;
            let measured = self.protocol.vertices.clone();
            let scale =
                Scale::of(slider.errors[measured.clone()].iter().chain(&prior.errors[measured]));
            let clay = |shaped: &Shaped, pins: &[_], caption: &str| {
                let picture = self.photographer.take(shaped, &Paint::Clay, pins);
                figure(&picture, caption, "", &text(caption))
            };
            let caption =
                |name: &str, solved: &Solved| format!("{name}: RMS error {:.4}", solved.rms);
            let (of_slider, of_prior) = (caption("slider norm", &slider), caption("prior", &prior));
            let own: Vec<_> = pinned
                .iter()
                .map(|&vertex| (shaped.positions[vertex], shaped.positions[vertex]))
                .collect();
            let pictures = [
                clay(&shaped, &own, "the take"),
                clay(&slider.shaped, &slider.pins, &of_slider),
                clay(&prior.shaped, &prior.pins, &of_prior),
            ];
            out += &side_by_side(3, &pictures.into_iter().collect::<Result<Vec<_>, _>>()?);
            let heat = |solved: &Solved, caption: &str| -> Result<String, Error> {
                let paint = Paint::Heat(&solved.errors, scale);
                let picture = self.photographer.take(&solved.shaped, &paint, &[]);
                figure(&picture, caption, "", &(colour_bar(&scale, "") + "error"))
            };
            let neutral = face.shaped(&vec![0.0; frame.len()])?;
            let nothing = Solved::new(neutral, &shaped, Vec::new(), 0.0);
            let moved = Scale::of(&nothing.errors[self.protocol.vertices.clone()]);
            let picture =
                self.photographer.take(&shaped, &Paint::Heat(&nothing.errors, moved), &[]);
            let first =
                figure(&picture, "motion of the take", "", &(colour_bar(&moved, "") + "motion"))?;
            out += &side_by_side(3, &[first, heat(&slider, &of_slider)?, heat(&prior, &of_prior)?]);
        }
        Ok(out)
    }

    /// Shows one landmark dragged from the neutral face to its place in an expression.
    fn drag(&self, row: &Row, strongest: &[&[f64]]) -> Result<String, Error> {
        let face = &self.protocol.face;
        let Some(&frame) = strongest.first() else { return Ok(String::new()) };
        let rest = vec![0.0; frame.len()];
        let path = |vertex: usize| {
            let (from, to) = (face.place(vertex, &rest), face.place(vertex, frame));
            ((0..3).map(|axis| (to[axis] - from[axis]).powi(2)).sum::<f64>(), from, to)
        };
        let paths = self.protocol.landmarks.iter().map(|&vertex| (vertex, path(vertex)));
        let Some((vertex, (_, from, to))) = paths.max_by(|a, b| a.1.0.total_cmp(&b.1.0)) else {
            return Ok(String::new());
        };
        let mut out = paragraph(&format!(
            "Vertex {vertex} alone is dragged from its place in the neutral face to its place in the first expression above, \
             with weights between their bounds. Above the slider norm, below the prior."
        ));
        let both = [("slider", "slider norm", &self.protocol.slider), ("prior", "prior", face)];
        for (method, name, solver) in both {
            let mut pictures = Vec::new();
            let (mut scratch, mut weights) = (Vec::new(), vec![0.0_f32; frame.len()]);
            for step in 0..STEPS {
                let share = step as f64 / (STEPS - 1) as f64;
                let target = [0, 1, 2].map(|axis| from[axis] + share * (to[axis] - from[axis]));
                weights.fill(0.0);
                let options = PinJob { beta: beta(row, method), ..solver.edit() };
                let pin = Pin::new(vertex as u32, target.map(|x| x as f32));
                solver.solve(&[pin], &options, &mut scratch, &mut weights)?;
                let shaped = face.shaped(&weights)?;
                let pins = [(shaped.positions[vertex], target)];
                let picture = self.photographer.take(&shaped, &Paint::Clay, &pins);
                let caption = format!("{name}, {:.0} %", 100.0 * share);
                pictures.push(figure(&picture, &caption, "", &text(&caption))?);
            }
            out += &side_by_side(STEPS, &pictures);
        }
        Ok(out)
    }

    /// Picks frames that are far from the neutral face and from each other.
    fn strongest(&self, gram: &Gram) -> Vec<&[f64]> {
        let rest = vec![0.0; self.protocol.face.skin.shape_len()];
        let mut out: Vec<&[f64]> = Vec::new();
        while out.len() < SHOWN.min(self.protocol.frames.len()) {
            let apart = |frame: &&&[f64]| {
                let others = std::iter::once(rest.as_slice()).chain(out.iter().copied());
                let squares = others.map(|other| gram.mean_square(frame, other));
                squares.fold(f64::INFINITY, f64::min)
            };
            let farthest = self.protocol.frames.iter().max_by(|a, b| apart(a).total_cmp(&apart(b)));
            out.extend(farthest);
        }
        out
    }
}

impl Solved {
    fn new(shaped: Shaped, truth: &Shaped, pins: Vec<([f64; 3], [f64; 3])>, rms: f64) -> Self {
        let apart = |(a, b): (&[f64; 3], &[f64; 3])| {
            (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt()
        };
        let errors = shaped.positions.iter().zip(&truth.positions).map(apart).collect();
        Self { shaped, errors, pins, rms }
    }
}

/// Returns the β of a method.
fn beta(row: &Row, method: &str) -> f32 {
    row.methods.get(method).map_or(1.0, |figures| figures.beta) as f32
}

fn narrow(weights: &[f64]) -> Vec<f32> {
    weights.iter().map(|weight| *weight as f32).collect()
}
