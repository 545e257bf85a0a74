//! Measures the accuracy with a few handles, by the protocol of `sinew face eval` in FACE.md; and distances between
//! faces.

use super::baked::{BakedFace, moved};
use crate::Error;
use faer::Mat;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::Serialize;
use sinew_runtime::prior::{Anchor, Pin, PinJob};
use std::collections::BTreeMap;
use std::ops::Range;

/// Number of random draws of handles.
pub const DRAWS: u64 = 10;
/// Seed of the draws.
pub const SEED: u64 = 0;
/// Tolerances of pins to try, as fractions of the face's diagonal.
const TOLERANCES: [f64; 7] = [1e-6, 1e-5, 3e-5, 1e-4, 3e-4, 1e-3, 3e-3];

/// A face, two baselines and the data of a measurement.
pub struct Protocol<'a> {
    /// The face with its learned prior.
    pub face: BakedFace<'a>,
    /// Baseline: the skin with the slider norm.
    pub slider: BakedFace<'a>,
    /// Baseline: the skin with the slider norm around the learned mean.
    pub slider_mean: BakedFace<'a>,
    /// Candidate vertices for handles.
    pub landmarks: &'a [usize],
    /// Vertices at which distances are measured.
    pub vertices: Range<usize>,
    /// Weights (S) of the frames that choose each method's β; if empty, the file's β is used.
    pub chosen_on: Vec<&'a [f64]>,
    /// Weights (S) of the measured frames.
    pub frames: Vec<&'a [f64]>,
    /// Frames of the measured range without tracking.
    pub lost_frames: usize,
}

/// Results for one number of handles: RMS distances in the file's unit, averaged over draws.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Row {
    /// The neutral face.
    pub nothing: f64,
    /// The slider norm around the neutral face.
    pub slider: f64,
    /// The slider norm around the mean of the training frames.
    pub slider_mean: f64,
    /// The prior around its mean.
    pub prior: f64,
    /// The prior around its mean, with weights between the bounds.
    pub bounded: f64,
    /// Further figures of each method.
    pub methods: BTreeMap<&'static str, Figures>,
}

/// Further figures of a method, averaged over draws.
#[derive(Clone, Debug, Serialize)]
pub struct Figures {
    /// β.
    pub beta: f64,
    /// Weights above 0.01 per frame.
    pub cardinality: f64,
    /// RMS second difference of the weights between measured frames.
    pub roughness: f64,
    /// Fraction of weights outside [0, 1].
    pub outside: f64,
}

/// Results of a measurement.
#[derive(Clone, Debug, Serialize)]
pub struct Evaluation {
    /// Number of measured frames.
    pub frames: usize,
    /// Frames of the measured range without tracking.
    pub lost_frames: usize,
    /// Number of frames that chose β.
    pub chosen_on: usize,
    /// Range of measured vertices.
    pub vertices: [usize; 2],
    /// Number of candidate vertices for handles.
    pub landmarks: usize,
    /// Number of draws.
    pub draws: u64,
    /// Seed of the draws.
    pub seed: u64,
    /// Weights above 0.01 per frame of the take.
    pub take_cardinality: f64,
    /// Roughness of the take.
    pub take_roughness: f64,
    /// Results by number of handles.
    pub handles: BTreeMap<usize, Row>,
}

/// A method that turns pins into weights.
#[derive(Clone, Copy)]
pub(super) struct Method<'a> {
    pub(super) face: BakedFace<'a>,
    pub(super) anchor: Anchor,
    pub(super) is_bounded: bool,
}

impl Protocol<'_> {
    /// Measures the accuracy for each number of handles.
    ///
    /// # Errors
    /// [`ErrorKind::Value`](crate::ErrorKind::Value) for 0 handles or more than there are landmarks; errors of the
    /// runtime.
    pub fn run(&self, handles: &[usize]) -> Result<Evaluation, Error> {
        let gram = Gram::new(&self.face, self.vertices.clone());
        let mut rows = BTreeMap::new();
        for &count in handles {
            let len = self.landmarks.len();
            if count == 0 || count > len {
                return Err(wrong_handles(count, len));
            }
            rows.insert(count, self.row(count, &gram)?);
        }
        Ok(Evaluation {
            frames: self.frames.len(),
            lost_frames: self.lost_frames,
            chosen_on: self.chosen_on.len(),
            vertices: [self.vertices.start, self.vertices.end],
            landmarks: self.landmarks.len(),
            draws: DRAWS,
            seed: SEED,
            take_cardinality: cardinality(&self.frames),
            take_roughness: roughness(&self.frames),
            handles: rows,
        })
    }

    fn row(&self, count: usize, gram: &Gram) -> Result<Row, Error> {
        let handles: Vec<Vec<usize>> = (0..DRAWS).map(|draw| self.draw(count, draw)).collect();
        let frames = &self.frames;
        let mut row = Row {
            nothing: rms(gram, &vec![vec![0.0; frames[0].len()]; frames.len()], frames),
            ..Row::default()
        };
        for (name, face, anchor) in [
            ("slider", self.slider, Anchor::Current),
            ("slider_mean", self.slider_mean, Anchor::Mean),
            ("prior", self.face, Anchor::Mean),
        ] {
            let method = Method { face, anchor, is_bounded: false };
            let beta = self.best_beta(&method, &handles, gram)?;
            row.add(name, method.measure(&handles, beta, gram, frames)?);
            if name == "prior" {
                let method = Method { is_bounded: true, ..method };
                row.add("bounded", method.measure(&handles, beta, gram, frames)?);
            }
        }
        Ok(row)
    }

    /// Draws handles from the landmarks, without replacement.
    pub fn draw(&self, count: usize, draw: u64) -> Vec<usize> {
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        random.set_stream(draw);
        let mut left = self.landmarks.to_vec();
        (0..count).map(|_| left.swap_remove(random.random_range(0..left.len()))).collect()
    }

    /// Chooses the β with the smallest error on the frames for this choice.
    fn best_beta(
        &self,
        method: &Method<'_>,
        handles: &[Vec<usize>],
        gram: &Gram,
    ) -> Result<f32, Error> {
        let mut best = (f64::INFINITY, self.face.prior.fit().beta);
        if self.chosen_on.is_empty() {
            return Ok(best.1);
        }
        let diagonal = self.face.diagonal();
        for tolerance in TOLERANCES {
            let beta = (tolerance * diagonal).powi(2) as f32;
            let (error, _) = method.measure(handles, beta, gram, &self.chosen_on)?;
            if error < best.0 {
                best = (error, beta);
            }
        }
        Ok(best.1)
    }
}

impl Row {
    fn add(&mut self, name: &'static str, (error, figures): (f64, Figures)) {
        match name {
            "slider" => self.slider = error,
            "slider_mean" => self.slider_mean = error,
            "prior" => self.prior = error,
            _ => self.bounded = error,
        }
        self.methods.insert(name, figures);
    }
}

impl Method<'_> {
    /// Returns the mean over draws of the RMS distance, and further figures.
    fn measure(
        &self,
        handles: &[Vec<usize>],
        beta: f32,
        gram: &Gram,
        frames: &[&[f64]],
    ) -> Result<(f64, Figures), Error> {
        let draws = handles.par_iter().map(|handles| {
            let solved = self.solve(handles, beta, frames)?;
            let outside = |weight: &&f64| !(0.0..=1.0).contains(*weight);
            let outside = solved.iter().flatten().filter(outside).count() as f64;
            let len = solved.len() * self.face.skin.shape_len();
            let (error, outside) = (rms(gram, &solved, frames), outside / len.max(1) as f64);
            Ok([error, cardinality(&solved), roughness(&solved), outside])
        });
        let draws: Vec<[f64; 4]> = draws.collect::<Result<_, Error>>()?;
        let mean =
            |of: usize| draws.iter().map(|draw| draw[of]).sum::<f64>() / draws.len().max(1) as f64;
        let [error, cardinality, roughness, outside] = [0, 1, 2, 3].map(mean);
        Ok((error, Figures { beta: beta.into(), cardinality, roughness, outside }))
    }

    /// Solves each frame from the neutral face, with handles at their true positions.
    pub(super) fn solve(
        &self,
        handles: &[usize],
        beta: f32,
        frames: &[&[f64]],
    ) -> Result<Vec<Vec<f64>>, Error> {
        let Self { anchor, is_bounded, .. } = *self;
        let options = PinJob { anchor, beta, is_bounded, ..self.face.edit() };
        let of_handles: Vec<_> =
            handles.iter().map(|&vertex| (vertex, self.face.vertex(vertex))).collect();
        let mut scratch = Vec::new();
        let solve = |frame: &&[f64]| {
            let pin = |(vertex, (rest, deltas)): &(usize, ([f64; 3], Vec<[f64; 3]>))| {
                Pin::new(*vertex as u32, moved(*rest, deltas, frame).map(|x| x as f32))
            };
            let pins: Vec<Pin> = of_handles.iter().map(pin).collect();
            let mut weights = vec![0.0; frame.len()];
            self.face.solve(&pins, &options, &mut scratch, &mut weights)?;
            Ok(weights.into_iter().map(f64::from).collect())
        };
        frames.iter().map(solve).collect()
    }
}

/// Makes the error of too few or too many handles.
pub(super) fn wrong_handles(found: usize, len: usize) -> Error {
    Error::value(format!("{found} handles: expected 1 to {len}, as many as the face has landmarks"))
}

/// Computes the RMS distance over vertices and frames.
fn rms(gram: &Gram, found: &[Vec<f64>], truth: &[&[f64]]) -> f64 {
    let squares = found.iter().zip(truth).map(|(a, b)| gram.mean_square(a, b));
    (squares.sum::<f64>() / truth.len().max(1) as f64).sqrt()
}

/// Inner products of shapes over some vertices. A face is linear in its weights, so the products give all distances.
pub struct Gram {
    matrix: Mat<f64>,
}

impl Gram {
    /// Computes the products from the deltas in the file.
    pub fn new(face: &BakedFace<'_>, vertices: Range<usize>) -> Self {
        let (len, shapes) = (vertices.len().max(1), face.skin.shape_len());
        let mut matrix = Mat::<f64>::zeros(shapes, shapes);
        for vertex in vertices {
            let moved: Vec<(usize, [f64; 3])> =
                face.skin.deltas_of(vertex).map(|(shape, u)| (shape, u.map(f64::from))).collect();
            for (a, u) in &moved {
                for (b, v) in &moved {
                    matrix[(*a, *b)] += (u[0] * v[0] + u[1] * v[1] + u[2] * v[2]) / len as f64;
                }
            }
        }
        Self { matrix }
    }

    /// Computes the mean square distance over the vertices between the faces of two weight vectors.
    pub fn mean_square(&self, a: &[f64], b: &[f64]) -> f64 {
        let by: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
        let row = |i: usize| (0..by.len()).map(|j| self.matrix[(i, j)] * by[j]).sum::<f64>();
        (0..by.len()).map(|i| by[i] * row(i)).sum::<f64>().max(0.0)
    }
}

/// Counts the weights above 0.01, averaged over frames.
pub fn cardinality(frames: &[impl AsRef<[f64]>]) -> f64 {
    const AT_WORK: f64 = 0.01;
    let weights = frames.iter().flat_map(|frame| frame.as_ref());
    let count = weights.filter(|weight| weight.abs() > AT_WORK).count();
    count as f64 / frames.len().max(1) as f64
}

/// Computes the RMS second difference in time over weights and frames; 0 for fewer than three frames.
pub fn roughness(frames: &[impl AsRef<[f64]>]) -> f64 {
    let mut sum = 0.0;
    let mut len = 0;
    for three in frames.windows(3) {
        let [first, second, third] = [0, 1, 2].map(|at| three[at].as_ref());
        for ((a, b), c) in first.iter().zip(second).zip(third) {
            sum += (a - 2.0 * b + c).powi(2);
            len += 1;
        }
    }
    if len == 0 { 0.0 } else { (sum / f64::from(len)).sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_smooth_and_a_zigzag_rough() {
        let line: Vec<Vec<f64>> = (0..5).map(|k| vec![0.1 * f64::from(k), 0.3]).collect();
        assert!(roughness(&line) < 1e-15);
        let zigzag: Vec<Vec<f64>> = (0..5).map(|k| vec![f64::from(k % 2), 0.0]).collect();
        // Second difference of 2 in one of two weights.
        assert!((roughness(&zigzag) - 2.0_f64.sqrt()).abs() < 1e-12);
        assert_eq!(roughness(&line[..2]), 0.0);
        assert_eq!(cardinality(&line), 9.0 / 5.0);
    }
}
