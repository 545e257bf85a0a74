//! What a few handles reach: the protocol of `sinew face eval`, which FACE.md states.

use super::baked::{BakedFace, Terms, moved};
use super::error::FaceError;
use super::measure::{Gram, cardinality, roughness};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::Serialize;
use sinew_runtime::prior::{Anchor, Pin};
use std::collections::BTreeMap;
use std::ops::Range;

/// Draws of handles, and the seed that they come from.
pub const DRAWS: u64 = 10;
/// See [`DRAWS`].
pub const SEED: u64 = 0;
/// Tolerances of pins that are tried, in diagonals of the face.
const TOLERANCES: [f64; 7] = [1e-6, 1e-5, 3e-5, 1e-4, 3e-4, 1e-3, 3e-3];

/// A face, the same with a prior that knows nothing, and what both are measured on.
pub struct Protocol<'a> {
    /// The face, with the prior that was learned.
    pub face: BakedFace<'a>,
    /// The same skin with the slider norm.
    pub slider: BakedFace<'a>,
    /// The slider norm around the learned mean.
    pub slider_mean: BakedFace<'a>,
    /// Vertices of which handles are drawn.
    pub landmarks: &'a [usize],
    /// Vertices of which distances are measured.
    pub vertices: Range<usize>,
    /// Weights of the frames on which each method's β is chosen, S each; the file's β without any.
    pub chosen_on: Vec<&'a [f64]>,
    /// Weights of the frames that are measured, S each.
    pub frames: Vec<&'a [f64]>,
    /// Frames of the measured range in which the tracking is lost.
    pub lost_frames: usize,
}

/// What was measured with so many handles; RMS distances in the file's unit, means over draws.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Row {
    /// The neutral face.
    pub nothing: f64,
    /// The slider norm, from the neutral face.
    pub slider: f64,
    /// The slider norm, from the mean of the training.
    pub slider_mean: f64,
    /// The prior, from its mean.
    pub prior: f64,
    /// The same between bounds.
    pub bounded: f64,
    /// More of each method.
    pub methods: BTreeMap<&'static str, Figures>,
}

/// More of a method, means over draws.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Figures {
    /// β.
    pub beta: f64,
    /// Weights above 0.01 in a frame.
    pub cardinality: f64,
    /// RMS over weights of the second difference from one measured frame to the next.
    pub roughness: f64,
    /// Share of the weights that are outside of [0, 1].
    pub outside: f64,
}

/// All that was measured.
#[derive(Clone, Debug, Serialize)]
pub struct Evaluation {
    /// Frames measured.
    pub frames: usize,
    /// Frames of the measured range in which the tracking is lost.
    pub lost_frames: usize,
    /// Frames on which β was chosen.
    pub chosen_on: usize,
    /// Vertices measured: the first and the end.
    pub vertices: [usize; 2],
    /// Landmarks of which handles were drawn.
    pub landmarks: usize,
    /// Draws.
    pub draws: u64,
    /// Their seed.
    pub seed: u64,
    /// Weights above 0.01 in a frame of the take itself.
    pub take_cardinality: f64,
    /// Roughness of the take itself.
    pub take_roughness: f64,
    /// By the number of handles.
    pub handles: BTreeMap<usize, Row>,
}

/// A way to make weights of pins.
#[derive(Clone, Copy)]
struct Method<'a> {
    name: &'static str,
    face: BakedFace<'a>,
    anchor: Anchor,
    is_bounded: bool,
}

impl Protocol<'_> {
    /// Measures each number of handles.
    ///
    /// # Errors
    /// [`FaceError::Handles`]: more handles than landmarks; those of the runtime.
    pub fn run(&self, handles: &[usize]) -> Result<Evaluation, FaceError> {
        let gram = Gram::new(&self.face, self.vertices.clone());
        let owned =
            |frames: &[&[f64]]| frames.iter().map(|frame| frame.to_vec()).collect::<Vec<_>>();
        let frames = owned(&self.frames);
        let mut rows = BTreeMap::new();
        for &count in handles {
            let len = self.landmarks.len();
            if count == 0 || count > len {
                return Err(FaceError::Handles { found: count, len });
            }
            rows.insert(count, self.row(count, &gram, &frames)?);
        }
        Ok(Evaluation {
            frames: frames.len(),
            lost_frames: self.lost_frames,
            chosen_on: self.chosen_on.len(),
            vertices: [self.vertices.start, self.vertices.end],
            landmarks: self.landmarks.len(),
            draws: DRAWS,
            seed: SEED,
            take_cardinality: cardinality(&frames),
            take_roughness: roughness(&frames),
            handles: rows,
        })
    }

    fn row(&self, count: usize, gram: &Gram, frames: &[Vec<f64>]) -> Result<Row, FaceError> {
        let handles: Vec<Vec<usize>> = (0..DRAWS).map(|draw| self.draw(count, draw)).collect();
        let chosen_on: Vec<Vec<f64>> = self.chosen_on.iter().map(|frame| frame.to_vec()).collect();
        let methods = [
            ("slider", self.slider, Anchor::Current, false),
            ("slider_mean", self.slider_mean, Anchor::Mean, false),
            ("prior", self.face, Anchor::Mean, false),
        ];
        let mut row = Row {
            nothing: rms(gram, &vec![vec![0.0; frames[0].len()]; frames.len()], frames),
            ..Row::default()
        };
        for (name, face, anchor, is_bounded) in methods {
            let method = Method { name, face, anchor, is_bounded };
            let beta = self.best(&method, &handles, gram, &chosen_on)?;
            row.add(&method, beta, method.measure(&handles, beta, gram, frames)?);
            if name == "prior" {
                let method = Method { name: "bounded", is_bounded: true, ..method };
                row.add(&method, beta, method.measure(&handles, beta, gram, frames)?);
            }
        }
        Ok(row)
    }

    /// Draws handles among the landmarks, without taking any twice.
    pub fn draw(&self, count: usize, draw: u64) -> Vec<usize> {
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        random.set_stream(draw);
        let mut left = self.landmarks.to_vec();
        (0..count).map(|_| left.swap_remove(random.random_range(0..left.len()))).collect()
    }

    /// Chooses the β with which a method is nearest to the frames that it is chosen on.
    fn best(
        &self,
        method: &Method<'_>,
        handles: &[Vec<usize>],
        gram: &Gram,
        frames: &[Vec<f64>],
    ) -> Result<f32, FaceError> {
        let mut best = (f64::INFINITY, self.face.prior.fit().beta);
        if frames.is_empty() {
            return Ok(best.1);
        }
        let diagonal = self.face.diagonal();
        for tolerance in TOLERANCES {
            let beta = (tolerance * diagonal).powi(2) as f32;
            let (error, _) = method.measure(handles, beta, gram, frames)?;
            if error < best.0 {
                best = (error, beta);
            }
        }
        Ok(best.1)
    }
}

impl Row {
    fn add(&mut self, method: &Method<'_>, beta: f32, (error, figures): (f64, Figures)) {
        match method.name {
            "slider" => self.slider = error,
            "slider_mean" => self.slider_mean = error,
            "prior" => self.prior = error,
            _ => self.bounded = error,
        }
        self.methods.insert(method.name, Figures { beta: beta.into(), ..figures });
    }
}

impl Method<'_> {
    /// Solves every frame with the handles of each draw, and gives the mean over draws of the RMS distance.
    fn measure(
        &self,
        handles: &[Vec<usize>],
        beta: f32,
        gram: &Gram,
        frames: &[Vec<f64>],
    ) -> Result<(f64, Figures), FaceError> {
        let draws = handles.par_iter().map(|handles| {
            let solved = self.solve(handles, beta, frames)?;
            let outside = |weight: &&f64| !(0.0..=1.0).contains(*weight);
            let len = solved.len() * self.face.skin.shape_len();
            let figures = Figures {
                beta: 0.0,
                cardinality: cardinality(&solved),
                roughness: roughness(&solved),
                outside: solved.iter().flatten().filter(outside).count() as f64 / len.max(1) as f64,
            };
            Ok((rms(gram, &solved, frames), figures))
        });
        let draws: Vec<(f64, Figures)> = draws.collect::<Result<_, FaceError>>()?;
        let mean = |of: &dyn Fn(&(f64, Figures)) -> f64| {
            draws.iter().map(of).sum::<f64>() / draws.len().max(1) as f64
        };
        let figures = Figures {
            beta: 0.0,
            cardinality: mean(&|draw| draw.1.cardinality),
            roughness: mean(&|draw| draw.1.roughness),
            outside: mean(&|draw| draw.1.outside),
        };
        Ok((mean(&|draw| draw.0), figures))
    }

    /// Solves frames, each from the neutral face, with handles where they truly are.
    fn solve(
        &self,
        handles: &[usize],
        beta: f32,
        frames: &[Vec<f64>],
    ) -> Result<Vec<Vec<f64>>, FaceError> {
        let Self { anchor, is_bounded, .. } = *self;
        let terms = Terms { anchor, beta, is_bounded, ..Terms::edit(&self.face.prior) };
        let of_handles: Vec<_> =
            handles.iter().map(|&vertex| (vertex, self.face.vertex(vertex))).collect();
        let mut scratch = Vec::new();
        let solve = |frame: &Vec<f64>| {
            let pin = |(vertex, (rest, deltas)): &(usize, ([f64; 3], Vec<[f64; 3]>))| {
                Pin::new(*vertex as u32, moved(*rest, deltas, frame).map(|x| x as f32))
            };
            let pins: Vec<Pin> = of_handles.iter().map(pin).collect();
            let mut weights = vec![0.0; frame.len()];
            self.face.solve(&pins, &terms, &mut scratch, &mut weights)?;
            Ok(weights.into_iter().map(f64::from).collect())
        };
        frames.iter().map(solve).collect()
    }
}

/// Computes the RMS distance over vertices and frames.
fn rms(gram: &Gram, found: &[Vec<f64>], truth: &[Vec<f64>]) -> f64 {
    let squares = found.iter().zip(truth).map(|(a, b)| gram.mean_square(a, b));
    (squares.sum::<f64>() / truth.len().max(1) as f64).sqrt()
}
