//! Distances of a skin from the truth, and every sum, mean and percentile that is made of them.

use super::{EvaluateError, Lbs, skin};
use crate::examples::Examples;
use nalgebra::Vector3;
use rayon::prelude::*;
use serde::Serialize;
use sinew_runtime::Envelope;

/// Errors over the vertices of some frames.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Errors {
    /// RMS distance, in units of the input.
    pub rms: f64,
    /// RMS distance in % of the rest diagonal.
    pub rms_percent: f64,
    /// 99th percentile of the distances in % of the rest diagonal.
    pub p99_percent: f64,
    /// Largest distance in % of the rest diagonal.
    pub max_percent: f64,
    /// RMS angle between the normals and those of the posed mesh, in degrees.
    pub normal_rms_degrees: f64,
}

/// A model's confidence in some frames' poses, in [0, 1].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Confidence {
    /// On average.
    pub mean: f64,
    /// In the frame of which it is least certain.
    pub least: f64,
}

/// A skin's distances from the truth in some frames.
pub struct Measured {
    /// Diagonal of the rest pose's bounding box, in units of the input.
    pub diagonal: f64,
    /// The frames, in the order in which they were asked for.
    pub frames: Vec<MeasuredFrame>,
}

/// A skin's distances from the truth in one frame.
pub struct MeasuredFrame {
    /// Its number.
    pub frame: usize,
    /// The model's confidence in its pose; 1 for LBS.
    pub confidence: f64,
    /// V distances, in units of the input.
    pub distances: Vec<f64>,
    /// Sum of the squared angles between normals, in radians.
    squared_angles: f64,
    /// Vertices that have a normal.
    angles: usize,
}

impl Measured {
    /// Measures a model by the runtime.
    ///
    /// # Errors
    /// [`EvaluateError::Frame`].
    pub fn model(
        envelope: &Envelope<'_>,
        examples: &Examples,
        frames: &[usize],
    ) -> Result<Self, EvaluateError> {
        let frames = frames.par_iter().map(|&frame| {
            let skin = skin(envelope, examples, frame)?;
            let measured = MeasuredFrame::new(examples, frame, |v| skin.vertex(v));
            Ok(MeasuredFrame { confidence: skin.confidence(), ..measured })
        });
        let frames = frames.collect::<Result<_, EvaluateError>>()?;
        Ok(Self { diagonal: examples.diagonal(), frames })
    }

    /// Measures the baseline.
    pub fn lbs(lbs: &Lbs, examples: &Examples, frames: &[usize]) -> Self {
        let frames = frames
            .par_iter()
            .map(|&frame| MeasuredFrame::new(examples, frame, |v| lbs.vertex(examples, frame, v)));
        Self { diagonal: examples.diagonal(), frames: frames.collect() }
    }

    /// Summarises all vertices in all frames.
    pub fn errors(&self) -> Errors {
        self.summary(&self.frames)
    }

    /// Summarises all vertices in one of the measured frames.
    ///
    /// # Panics
    /// If there are no more than `place` of them.
    pub fn errors_in(&self, place: usize) -> Errors {
        self.summary(std::slice::from_ref(&self.frames[place]))
    }

    /// RMS distance of some vertices in one of the measured frames, in % of the rest diagonal.
    ///
    /// # Panics
    /// If there are no more than `place` of them.
    pub fn rms_percent_in(&self, place: usize, vertices: &[usize]) -> f64 {
        let distances = &self.frames[place].distances;
        self.percent(rms(vertices.iter().map(|&vertex| distances[vertex])))
    }

    /// RMS distance of some vertices in all frames, in % of the rest diagonal.
    pub fn rms_percent_of(&self, vertices: &[usize]) -> f64 {
        let of = |frame: &'_ MeasuredFrame| -> Vec<f64> {
            vertices.iter().map(|&vertex| frame.distances[vertex]).collect()
        };
        self.percent(rms(self.frames.iter().flat_map(of)))
    }

    /// RMS distance of each vertex in all frames, V values in % of the rest diagonal.
    pub fn vertex_rms_percent(&self) -> Vec<f64> {
        let vertex_len = self.frames.first().map_or(0, |frame| frame.distances.len());
        let of = |vertex| self.frames.iter().map(move |frame| frame.distances[vertex]);
        (0..vertex_len).map(|vertex| self.percent(rms(of(vertex)))).collect()
    }

    /// Distance of each vertex in one of the measured frames, V values in % of the rest diagonal.
    ///
    /// # Panics
    /// If there are no more than `place` of them.
    pub fn percent_in(&self, place: usize) -> Vec<f64> {
        self.frames[place].distances.iter().map(|&length| self.percent(length)).collect()
    }

    /// Finds the frame with the largest RMS distance: its place among those measured.
    pub fn worst(&self) -> usize {
        let all: Vec<f64> =
            self.frames.iter().map(|frame| rms(frame.distances.iter().copied())).collect();
        largest(&all)
    }

    /// Summarises the confidence.
    pub fn confidence(&self) -> Confidence {
        let all = self.frames.iter().map(|frame| frame.confidence);
        Confidence {
            mean: all.clone().sum::<f64>() / self.frames.len() as f64,
            least: all.fold(1.0, f64::min),
        }
    }

    fn summary(&self, frames: &[MeasuredFrame]) -> Errors {
        let squared_angles: f64 = frames.iter().map(|f| f.squared_angles).sum();
        let angles: usize = frames.iter().map(|f| f.angles).sum();
        let mut distances: Vec<f64> =
            frames.iter().flat_map(|f| f.distances.iter().copied()).collect();
        let rms = rms(distances.iter().copied());
        Errors {
            rms,
            rms_percent: self.percent(rms),
            p99_percent: self.percent(percentile(&mut distances, 99)),
            max_percent: self.percent(distances.iter().copied().fold(0.0, f64::max)),
            normal_rms_degrees: (squared_angles / angles.max(1) as f64).sqrt().to_degrees(),
        }
    }

    fn percent(&self, length: f64) -> f64 {
        100.0 * length / self.diagonal
    }
}

impl MeasuredFrame {
    fn new(
        examples: &Examples,
        frame: usize,
        skinned: impl Fn(usize) -> (Vector3<f64>, Vector3<f64>),
    ) -> Self {
        let truth = examples.frame(frame);
        let normals = examples.posed_normals(frame);
        let distances = Vec::with_capacity(truth.len());
        let mut all = Self { frame, confidence: 1.0, distances, squared_angles: 0.0, angles: 0 };
        for vertex in 0..truth.len() {
            let (position, normal) = skinned(vertex);
            all.distances.push((position - Vector3::from(truth[vertex])).norm());
            let expected = Vector3::from(normals[vertex]);
            if expected.norm_squared() > 0.0 && normal.norm_squared() > 0.0 {
                let angle = expected.cross(&normal).norm().atan2(expected.dot(&normal));
                all.squared_angles += angle * angle;
                all.angles += 1;
            }
        }
        all
    }

    /// Finds the vertex with the largest distance.
    pub fn worst_vertex(&self) -> usize {
        largest(&self.distances)
    }
}

/// Finds the first of the largest values; 0 where there is none.
pub fn largest(values: &[f64]) -> usize {
    let all = values.iter().enumerate().rev();
    all.max_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(place, _)| place)
}

fn rms(distances: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = distances.fold((0.0, 0_usize), |(sum, n), d| (sum + d * d, n + 1));
    (sum / count.max(1) as f64).sqrt()
}

/// The least distance that so many % of the vertices do not exceed; reorders them.
fn percentile(distances: &mut [f64], percent: usize) -> f64 {
    match (distances.len() * percent).div_ceil(100).checked_sub(1) {
        Some(rank) => *distances.select_nth_unstable_by(rank, f64::total_cmp).1,
        None => 0.0,
    }
}
