//! Distances and angles of a skin from the truth, and every sum, mean and percentile that is made of them.

use super::{Baseline, Character, EvaluateError, skin};
use crate::envelope::normals::TrueNormals;
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
    /// The distances in millimetres; `None` where the unit of the examples is not known.
    #[serde(flatten)]
    pub millimetres: Option<Millimetres>,
    /// RMS angle, over the rest surface's area, between the normals and the true ones: those of the posed mesh,
    /// the mean of its triangles' by area. In degrees.
    pub normal_rms_degrees: f64,
    /// Angle that half of the area does not exceed, in degrees.
    pub normal_median_degrees: f64,
    /// 99th percentile of the angles, by area, in degrees.
    pub normal_p99_degrees: f64,
}

/// Distances of [`Errors`] in millimetres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Millimetres {
    /// RMS distance.
    pub rms_mm: f64,
    /// 99th percentile of the distances.
    pub p99_mm: f64,
    /// Largest distance.
    pub max_mm: f64,
}

/// RMS error of a baseline, in % of the rest diagonal, below which no error is compared with it.
pub const NOTHING: f64 = 1e-4;

impl Errors {
    /// Returns the RMS error as a share of a baseline's; `None` where the baseline is exact.
    pub fn share_of(&self, baseline: &Self) -> Option<f64> {
        (baseline.rms_percent > NOTHING).then(|| self.rms / baseline.rms)
    }
}

/// A model's confidence in some frames' poses, in [0, 1].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Confidence {
    /// On average.
    pub mean: f64,
    /// In the frame of which it is least certain.
    pub least: f64,
}

/// A skin's errors in some frames.
pub struct Measured {
    /// Diagonal of the rest pose's bounding box, in units of the input.
    pub diagonal: f64,
    /// The diagonal in millimetres; `None` where the unit of the examples is not known.
    pub diagonal_mm: Option<f64>,
    /// The frames, in the order in which they were asked for.
    pub frames: Vec<MeasuredFrame>,
    /// How much each vertex counts, V numbers of mean 1; all alike without.
    importance: Option<Vec<f64>>,
    /// How much each normal of the engine's vertices counts, E numbers: its share of the rest surface's area, as its
    /// vertex counts.
    areas: Vec<f64>,
    /// The vertex that each of the engine's is a copy of, E.
    copy_of: Vec<usize>,
}

/// A skin's errors in one frame.
pub struct MeasuredFrame {
    /// Its number.
    pub frame: usize,
    /// The model's confidence in its pose; 1 for a baseline.
    pub confidence: f64,
    /// V distances, in units of the input.
    pub distances: Vec<f64>,
    /// E angles between the normals of the engine's vertices and the true ones, in radians; none where one of the two
    /// has no direction.
    pub angles: Vec<Option<f64>>,
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
        let truth = TrueNormals::new(examples.surface());
        let frames = frames.par_iter().map(|&frame| {
            let skin = skin(character, examples, frame)?;
            let measured = MeasuredFrame::new(examples, &truth, frame, |v| skin.vertex(v));
            Ok(MeasuredFrame { confidence: skin.confidence(), ..measured })
        });
        Ok(Self::new(examples, frames.collect::<Result<_, EvaluateError>>()?))
    }

    /// Measures a baseline.
    pub fn lbs(lbs: &Baseline, examples: &Examples, frames: &[usize]) -> Self {
        let truth = TrueNormals::new(examples.surface());
        let frames = frames.par_iter().map(|&frame| {
            MeasuredFrame::new(examples, &truth, frame, |v| lbs.vertex(examples, frame, v))
        });
        Self::new(examples, frames.collect())
    }

    fn new(examples: &Examples, frames: Vec<MeasuredFrame>) -> Self {
        let importance = examples.importance.clone();
        let surface = examples.surface();
        let copy_of: Vec<usize> = (0..surface.engine_len()).map(|e| surface.copy_of(e)).collect();
        let areas = surface.areas().into_iter().zip(&copy_of);
        let areas = areas.map(|(area, &vertex)| area * examples.importance().of(vertex)).collect();
        let (diagonal, diagonal_mm) = (examples.diagonal(), examples.diagonal_mm());
        Self { diagonal, diagonal_mm, frames, importance, areas, copy_of }
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

    /// RMS angle of each vertex's normals, of all its copies, in all frames, V values in degrees; 0 where it has none.
    pub fn vertex_rms_degrees(&self) -> Vec<f64> {
        let copies = self.copies();
        let of = |copies: &Vec<usize>| {
            let angles =
                self.frames.iter().flat_map(|f| copies.iter().filter_map(|&e| f.angles[e]));
            rms(angles.map(|angle| (angle, 1.0))).to_degrees()
        };
        copies.iter().map(of).collect()
    }

    /// Largest angle of each vertex's normals, of all its copies, in one of the measured frames, V values in degrees;
    /// 0 where it has none.
    ///
    /// # Panics
    /// If there are no more than `place` of them.
    pub fn degrees_in(&self, place: usize) -> Vec<f64> {
        let angle = |&copy: &usize| self.frames[place].angles[copy].unwrap_or_default();
        let of = |copies: &Vec<usize>| copies.iter().map(angle).fold(0.0, f64::max).to_degrees();
        self.copies().iter().map(of).collect()
    }

    /// Sums the squared angles between normals and true normals over all frames, each times its area. Returns the sum, in
    /// square radians, and the sum of the areas.
    pub fn squared_angles(&self) -> (f64, f64) {
        squares(self.frames.iter().flat_map(|frame| self.counted_angles(frame)))
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
        let mut angles: Vec<(f64, f64)> =
            frames.iter().flat_map(|frame| self.counted_angles(frame)).collect();
        let mut distances: Vec<(f64, f64)> =
            frames.iter().flat_map(|frame| self.counted(frame)).collect();
        let rms = rms(distances.iter().copied());
        let counted = distances.iter().filter(|(_, counts)| *counts > 0.0);
        let largest = counted.map(|(distance, _)| *distance).fold(0.0, f64::max);
        let p99 = percentile(&mut distances, 0.99);
        let [rms_percent, p99_percent, max_percent] = [rms, p99, largest].map(|d| self.percent(d));
        let millimetres = |diagonal: f64| {
            let [rms_mm, p99_mm, max_mm] =
                [rms, p99, largest].map(|length| length / self.diagonal * diagonal);
            Millimetres { rms_mm, p99_mm, max_mm }
        };
        Errors {
            rms,
            rms_percent,
            p99_percent,
            max_percent,
            millimetres: self.diagonal_mm.map(millimetres),
            normal_rms_degrees: self::rms(angles.iter().copied()).to_degrees(),
            normal_median_degrees: percentile(&mut angles, 0.5).to_degrees(),
            normal_p99_degrees: percentile(&mut angles, 0.99).to_degrees(),
        }
    }

    /// Lists the copies of each vertex, V.
    fn copies(&self) -> Vec<Vec<usize>> {
        let mut copies = vec![Vec::new(); self.copy_of.iter().max().map_or(0, |last| last + 1)];
        self.copy_of.iter().enumerate().for_each(|(copy, &vertex)| copies[vertex].push(copy));
        copies
    }

    /// The distances in a frame, each with how much it counts.
    fn counted<'a>(&'a self, frame: &'a MeasuredFrame) -> impl Iterator<Item = (f64, f64)> + 'a {
        let counts = move |vertex| self.importance().of(vertex);
        frame.distances.iter().enumerate().map(move |(vertex, &d)| (d, counts(vertex)))
    }

    /// The angles in a frame, each with how much it counts.
    fn counted_angles<'a>(
        &'a self,
        frame: &'a MeasuredFrame,
    ) -> impl Iterator<Item = (f64, f64)> + 'a {
        let angles = frame.angles.iter().zip(&self.areas);
        angles.filter_map(|(angle, counts)| Some(((*angle)?, *counts)))
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
        truth: &TrueNormals<'_>,
        frame: usize,
        skinned: impl Fn(usize) -> (Vector3<f64>, Vector3<f64>),
    ) -> Self {
        let (surface, positions) = (examples.surface(), examples.frame(frame));
        let mut distances = vec![0.0; positions.len()];
        let mut angles = Vec::with_capacity(surface.engine_len());
        // Copies of one vertex have one place.
        for (copy, expected) in truth.posed(examples.frame(frame)).into_iter().enumerate() {
            let (position, normal) = skinned(copy);
            let vertex = surface.copy_of(copy);
            distances[vertex] = (position - Vector3::from(positions[vertex])).norm();
            let expected = Vector3::from(expected);
            let both = expected.norm_squared() > 0.0 && normal.norm_squared() > 0.0;
            let angle = || expected.cross(&normal).norm().atan2(expected.dot(&normal));
            angles.push(both.then(angle));
        }
        Self { frame, confidence: 1.0, distances, angles }
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

/// RMS of errors, each with how much it counts.
fn rms(errors: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (sum, all) = squares(errors);
    (sum / all.max(f64::MIN_POSITIVE)).sqrt()
}

/// Sums squared errors times their weights, and the weights.
fn squares(errors: impl Iterator<Item = (f64, f64)>) -> (f64, f64) {
    errors.fold((0.0, 0.0), |(sum, all), (d, counts)| (sum + counts * d * d, all + counts))
}

/// The least error that this share of all does not exceed, as they count; sorts them.
fn percentile(errors: &mut [(f64, f64)], share: f64) -> f64 {
    errors.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    // What rounding leaves of a whole number of vertices is none.
    let mut left = share * errors.iter().map(|(_, counts)| counts).sum::<f64>() * (1.0 - 1e-12);
    let found = errors.iter().find(|(_, counts)| {
        left -= counts;
        left <= 0.0
    });
    found.map_or(0.0, |(error, _)| *error)
}
