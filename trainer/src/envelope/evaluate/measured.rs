//! Distances of a skin from the truth, and every sum, mean and percentile that is made of them.

use super::{Baseline, Character, EvaluateError, skin};
use crate::examples::{Examples, Importance};
use nalgebra::Vector3;
use rayon::prelude::*;
use serde::Serialize;

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
    /// How much each vertex counts, V numbers of mean 1; all alike without.
    importance: Option<Vec<f64>>,
}

/// A skin's distances from the truth in one frame.
pub struct MeasuredFrame {
    /// Its number.
    pub frame: usize,
    /// The model's confidence in its pose; 1 for LBS.
    pub confidence: f64,
    /// V distances, in units of the input.
    pub distances: Vec<f64>,
    /// Sum of the squared angles between normals, in radians, as the vertices count.
    squared_angles: f64,
    /// How much the vertices count that have a normal.
    angles: f64,
}

impl Measured {
    /// Measures a model by the runtime.
    ///
    /// # Errors
    /// [`EvaluateError::Frame`].
    pub fn model(
        character: &Character<'_>,
        examples: &Examples,
        frames: &[usize],
    ) -> Result<Self, EvaluateError> {
        let frames = frames.par_iter().map(|&frame| {
            let skin = skin(character, examples, frame)?;
            let measured = MeasuredFrame::new(examples, frame, |v| skin.vertex(v));
            Ok(MeasuredFrame { confidence: skin.confidence(), ..measured })
        });
        Ok(Self::new(examples, frames.collect::<Result<_, EvaluateError>>()?))
    }

    /// Measures the baseline.
    pub fn lbs(lbs: &Baseline, examples: &Examples, frames: &[usize]) -> Self {
        let frames = frames
            .par_iter()
            .map(|&frame| MeasuredFrame::new(examples, frame, |v| lbs.vertex(examples, frame, v)));
        Self::new(examples, frames.collect())
    }

    fn new(examples: &Examples, frames: Vec<MeasuredFrame>) -> Self {
        Self { diagonal: examples.diagonal(), frames, importance: examples.importance.clone() }
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
        self.percent(rms(vertices.iter().map(|&v| (distances[v], self.importance().of(v)))))
    }

    /// RMS distance of some vertices in all frames, in % of the rest diagonal.
    pub fn rms_percent_of(&self, vertices: &[usize]) -> f64 {
        let of = |frame: &'_ MeasuredFrame| -> Vec<(f64, f64)> {
            vertices.iter().map(|&v| (frame.distances[v], self.importance().of(v))).collect()
        };
        self.percent(rms(self.frames.iter().flat_map(of)))
    }

    /// RMS distance of each vertex in all frames, V values in % of the rest diagonal.
    pub fn vertex_rms_percent(&self) -> Vec<f64> {
        let vertex_len = self.frames.first().map_or(0, |frame| frame.distances.len());
        let of = |vertex| self.frames.iter().map(move |frame| (frame.distances[vertex], 1.0));
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
        let all: Vec<f64> = self.frames.iter().map(|frame| rms(self.counted(frame))).collect();
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
        let angles: f64 = frames.iter().map(|f| f.angles).sum();
        let mut distances: Vec<(f64, f64)> =
            frames.iter().flat_map(|frame| self.counted(frame)).collect();
        let rms = rms(distances.iter().copied());
        let counted = distances.iter().filter(|(_, counts)| *counts > 0.0);
        let largest = counted.map(|(distance, _)| *distance).fold(0.0, f64::max);
        Errors {
            rms,
            rms_percent: self.percent(rms),
            p99_percent: self.percent(percentile(&mut distances, 0.99)),
            max_percent: self.percent(largest),
            normal_rms_degrees: (squared_angles / angles.max(f64::MIN_POSITIVE))
                .sqrt()
                .to_degrees(),
        }
    }

    /// The distances in a frame, each with how much it counts.
    fn counted<'a>(&'a self, frame: &'a MeasuredFrame) -> impl Iterator<Item = (f64, f64)> + 'a {
        let counts = move |vertex| self.importance().of(vertex);
        frame.distances.iter().enumerate().map(move |(vertex, &d)| (d, counts(vertex)))
    }

    fn importance(&self) -> Importance<'_> {
        Importance::by(self.importance.as_deref())
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
        let mut all = Self { frame, confidence: 1.0, distances, squared_angles: 0.0, angles: 0.0 };
        for vertex in 0..truth.len() {
            let (position, normal) = skinned(vertex);
            all.distances.push((position - Vector3::from(truth[vertex])).norm());
            let expected = Vector3::from(normals[vertex]);
            if expected.norm_squared() > 0.0 && normal.norm_squared() > 0.0 {
                let angle = expected.cross(&normal).norm().atan2(expected.dot(&normal));
                let counts = examples.importance().of(vertex);
                all.squared_angles += counts * angle * angle;
                all.angles += counts;
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

/// RMS of distances, each with how much it counts.
fn rms(distances: impl Iterator<Item = (f64, f64)>) -> f64 {
    let add =
        |(sum, all): (f64, f64), (d, counts): (f64, f64)| (sum + counts * d * d, all + counts);
    let (sum, all) = distances.fold((0.0, 0.0), add);
    (sum / all.max(f64::MIN_POSITIVE)).sqrt()
}

/// The least distance that this share of the vertices does not exceed, as they count; sorts them.
fn percentile(distances: &mut [(f64, f64)], share: f64) -> f64 {
    distances.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    // What rounding leaves of a whole number of vertices is none.
    let mut left = share * distances.iter().map(|(_, counts)| counts).sum::<f64>() * (1.0 - 1e-12);
    let found = distances.iter().find(|(_, counts)| {
        left -= counts;
        left <= 0.0
    });
    found.map_or(0.0, |(distance, _)| *distance)
}
