//! A page that shows what a prior does: a face by a few handles, with it and without, and a drag.

use super::baked::{BakedFace, Shaped, Terms};
use super::error::FaceError;
use super::evaluate::{Evaluation, Protocol, Row};
use super::measure::Gram;
use super::picture::{Paint, Photographer};
use crate::page::chart::colour_bar;
use crate::page::colour::Scale;
use crate::page::html::{self, figure, paragraph, section, side_by_side, table, text};
use png::EncodingError;
use sinew_runtime::prior::{Anchor, Pin};

/// Pictures of a drag.
const STEPS: usize = 6;
/// Frames that are shown.
const SHOWN: usize = 3;

/// A report on what a protocol measured.
pub struct Report<'a> {
    /// What was measured, and on what.
    pub protocol: &'a Protocol<'a>,
    /// The figures.
    pub evaluation: &'a Evaluation,
    /// Takes the pictures.
    pub photographer: &'a Photographer<'a>,
    /// What the take is called.
    pub take: &'a str,
}

/// A face that was solved, and how far each vertex is from the truth.
struct Solved {
    shaped: Shaped,
    errors: Vec<f64>,
    pins: Vec<([f64; 3], [f64; 3])>,
    rms: f64,
}

impl Report<'_> {
    /// Writes the page: one HTML file that needs neither network nor script.
    ///
    /// # Errors
    /// Those of the runtime, and [`FaceError::Picture`].
    pub fn html(&self) -> Result<String, FaceError> {
        let Some((&handles, row)) = self.evaluation.handles.iter().next() else {
            return Err(FaceError::Handles { found: 0, len: self.protocol.landmarks.len() });
        };
        let name = self.protocol.face.skin.name();
        let share = 100.0 * row.prior / row.slider;
        let head = format!(
            "<h1>{} by a few handles</h1>\n<p class=\"under\">{} vertices, {} shapes; measured on {} frames of {}</p>\n\
             <p class=\"verdict\">With {handles} of {} landmarks at their true place the rest of the face is off by \
             <b>{:.4}</b>, RMS: {share:.0} % of what the slider norm leaves ({:.4}).</p>\n",
            text(name),
            self.protocol.face.skin.vertex_len(),
            self.protocol.face.skin.shape_len(),
            self.evaluation.frames,
            text(self.take),
            self.evaluation.landmarks,
            row.prior,
            row.slider,
        );
        let sections = [
            section("By the number of handles", &self.figures()),
            section("Side by side", &self.frames(handles, row)?),
            section("A drag", &self.drag(row)?),
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
                    handles among the landmarks. The slider norm lets no weight know of another (Lewis and Anjyo 2010); the \
                    prior knows from the take which go together.";
        table(&head.map(str::to_owned), &rows.collect::<Vec<_>>()) + &paragraph(what)
    }

    /// The frames that move the most, as they are, by the slider norm and by the prior.
    fn frames(&self, handles: usize, row: &Row) -> Result<String, FaceError> {
        let pinned = self.protocol.draw(handles, 0);
        let gram = Gram::new(&self.protocol.face, self.protocol.vertices.clone());
        let mut out = paragraph(&format!(
            "Expressions of the take that move the most. Red dots are the {handles} handles, in white rings where they \
             are to be. Colours are distances: how far the take moves the face, then how far the other two are off, on one scale."
        ));
        for frame in self.strongest(&gram) {
            let truth = narrow(frame);
            let shaped = self.protocol.face.shaped(&truth)?;
            let slider = self.solve(
                &self.protocol.slider,
                Anchor::Current,
                row,
                "slider",
                &pinned,
                frame,
                &gram,
            )?;
            let prior =
                self.solve(&self.protocol.face, Anchor::Mean, row, "prior", &pinned, frame, &gram)?;
            let measured = self.protocol.vertices.clone();
            let scale =
                Scale::of(slider.errors[measured.clone()].iter().chain(&prior.errors[measured]));
            let clay = |shaped: &Shaped, pins: &[_], caption: &str| {
                let picture = self.photographer.take(shaped, &Paint::Clay, pins);
                figure(&picture, caption, "", &text(caption))
            };
            let told =
                |name: &str, solved: &Solved| format!("{name}: off by {:.4}, RMS", solved.rms);
            let (of_slider, of_prior) = (told("slider norm", &slider), told("prior", &prior));
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
            let heat = |solved: &Solved, caption: &str| -> Result<String, EncodingError> {
                let paint = Paint::Heat(&solved.errors, scale);
                let picture = self.photographer.take(&solved.shaped, &paint, &[]);
                figure(&picture, caption, "", &(colour_bar(&scale, "") + "how far it is off"))
            };
            let neutral = self.protocol.face.shaped(&vec![0.0; truth.len()])?;
            let nothing = Solved::new(neutral, &shaped, Vec::new(), 0.0);
            let moved = Scale::of(&nothing.errors[self.protocol.vertices.clone()]);
            let picture =
                self.photographer.take(&shaped, &Paint::Heat(&nothing.errors, moved), &[]);
            let first = figure(
                &picture,
                "how far the take moves",
                "",
                &(colour_bar(&moved, "") + "how far it moves"),
            )?;
            out += &side_by_side(3, &[first, heat(&slider, &of_slider)?, heat(&prior, &of_prior)?]);
        }
        Ok(out)
    }

    /// One landmark, dragged from the neutral face to where an expression has it.
    fn drag(&self, row: &Row) -> Result<String, FaceError> {
        let face = &self.protocol.face;
        let gram = Gram::new(face, self.protocol.vertices.clone());
        let Some(frame) = self.strongest(&gram).into_iter().next() else {
            return Ok(String::new());
        };
        let rest = vec![0.0; frame.len()];
        let way = |vertex: usize| {
            let (from, to) = (face.place(vertex, &rest), face.place(vertex, frame));
            ((0..3).map(|axis| (to[axis] - from[axis]).powi(2)).sum::<f64>(), from, to)
        };
        let ways = self.protocol.landmarks.iter().map(|&vertex| (vertex, way(vertex)));
        let Some((vertex, (_, from, to))) = ways.max_by(|a, b| a.1.0.total_cmp(&b.1.0)) else {
            return Ok(String::new());
        };
        let mut out = paragraph(&format!(
            "Vertex {vertex} alone is dragged from where it is in the neutral face to where the first expression above has \
             it, weights between their bounds. Above the slider norm, below the prior."
        ));
        let both = [("slider", "slider norm", &self.protocol.slider), ("prior", "prior", face)];
        for (method, name, solver) in both {
            let mut pictures = Vec::new();
            let (mut scratch, mut weights) = (Vec::new(), vec![0.0_f32; frame.len()]);
            for step in 0..STEPS {
                let share = step as f64 / (STEPS - 1) as f64;
                let target = [0, 1, 2].map(|axis| from[axis] + share * (to[axis] - from[axis]));
                let beta = row.methods.get(method).map_or(1.0, |figures| figures.beta) as f32;
                weights.fill(0.0);
                let terms = Terms { beta, ..Terms::edit(&solver.prior) };
                let pin = Pin::new(vertex as u32, target.map(|x| x as f32));
                solver.solve(&[pin], &terms, &mut scratch, &mut weights)?;
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

    /// Lists frames that move the face the most and are not alike.
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

    #[expect(clippy::too_many_arguments, reason = "what a solve and its measure take")]
    fn solve(
        &self,
        solver: &BakedFace<'_>,
        anchor: Anchor,
        row: &Row,
        method: &str,
        pinned: &[usize],
        frame: &[f64],
        gram: &Gram,
    ) -> Result<Solved, FaceError> {
        let beta = row.methods.get(method).map_or(1.0, |figures| figures.beta) as f32;
        let terms = Terms { anchor, beta, is_bounded: false, ..Terms::edit(&solver.prior) };
        let places: Vec<[f64; 3]> =
            pinned.iter().map(|&vertex| solver.place(vertex, frame)).collect();
        let pin = |(&vertex, place): (&usize, &[f64; 3])| {
            Pin::new(vertex as u32, place.map(|x| x as f32))
        };
        let pins: Vec<Pin> = pinned.iter().zip(&places).map(pin).collect();
        let mut weights = vec![0.0; frame.len()];
        solver.solve(&pins, &terms, &mut Vec::new(), &mut weights)?;
        let shaped = self.protocol.face.shaped(&weights)?;
        let truth = self.protocol.face.shaped(&narrow(frame))?;
        let pins =
            pinned.iter().zip(places).map(|(&v, place)| (shaped.positions[v], place)).collect();
        let wide: Vec<f64> = weights.into_iter().map(f64::from).collect();
        Ok(Solved::new(shaped, &truth, pins, gram.mean_square(&wide, frame).sqrt()))
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

fn narrow(weights: &[f64]) -> Vec<f32> {
    weights.iter().map(|weight| *weight as f32).collect()
}
