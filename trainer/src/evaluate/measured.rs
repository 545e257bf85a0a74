//! Distances and angles between a skin and the true meshes, with their sums, means and percentiles; and the baselines on
//! the same frames: LBS with fitted weights, and LBS with the artist's own weights.

use super::character::{Baseline, Character, TrainingRecord, skin};
use crate::Error;
use crate::envelope::lbs::prior::own_weights;
use crate::envelope::normals::TrueNormals;
use crate::examples::{Examples, Importance};
use crate::numeric::columns::largest;
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
    /// Mean distance in % of the rest diagonal.
    pub mean_percent: f64,
    /// 99th percentile of the distances in % of the rest diagonal.
    pub p99_percent: f64,
    /// Largest distance in % of the rest diagonal.
    pub max_percent: f64,
    /// The distances in millimetres; `None` if the unit of the examples is unknown.
    #[serde(flatten)]
    pub millimetres: Option<Millimetres>,
    /// RMS angle between the normals and the true normals, in degrees, weighted by the area of the rest surface. A true
    /// normal is the area-weighted mean of the posed mesh's triangles.
    pub normal_rms_degrees: f64,
    /// Median of the angles by area, in degrees.
    pub normal_median_degrees: f64,
    /// 99th percentile of the angles, by area, in degrees.
    pub normal_p99_degrees: f64,
}

/// Distances of [`Errors`] in millimetres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Millimetres {
    /// RMS distance.
    pub rms_mm: f64,
    /// Mean distance.
    pub mean_mm: f64,
    /// 99th percentile of the distances.
    pub p99_mm: f64,
    /// Largest distance.
    pub max_mm: f64,
}

/// RMS error in % of the rest diagonal below which a baseline counts as exact; no error is compared with an exact
/// baseline.
pub const NEGLIGIBLE_PERCENT: f64 = 1e-4;

impl Errors {
    /// Returns the RMS error as a share of a baseline's; `None` if the baseline is exact.
    pub fn share_of(&self, baseline: &Self) -> Option<f64> {
        (baseline.rms_percent > NEGLIGIBLE_PERCENT).then(|| self.rms / baseline.rms)
    }
}

/// A model's confidence in some frames' poses, in [0, 1].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Confidence {
    /// Mean over the frames.
    pub mean: f64,
    /// Lowest confidence of a frame.
    pub least: f64,
}

/// A skin's errors in some frames.
pub struct Measured {
    /// Diagonal of the rest pose's bounding box, in units of the input.
    pub diagonal: f64,
    /// The diagonal in millimetres; `None` if the unit of the examples is unknown.
    pub diagonal_mm: Option<f64>,
    /// The frames, in the requested order.
    pub frames: Vec<MeasuredFrame>,
    /// Importance of each vertex, V numbers with mean 1; `None` for equal importance.
    importance: Option<Vec<f64>>,
    /// Weight of each engine vertex's normal, E numbers: its share of the rest surface's area times its vertex's
    /// importance.
    areas: Vec<f64>,
    /// Vertex that each engine vertex is a copy of, E.
    copy_of: Vec<usize>,
}

/// A skin's errors in one frame.
pub struct MeasuredFrame {
    /// Index of the frame.
    pub frame: usize,
    /// The model's confidence in the pose; 1 for a baseline.
    pub confidence: f64,
    /// V distances, in units of the input.
    pub distances: Vec<f64>,
    /// E angles between the normals of the engine vertices and the true normals, in radians; `None` if one of the two
    /// normals is zero.
    pub angles: Vec<Option<f64>>,
}

impl Measured {
    /// Measures a model with the runtime.
    ///
    /// # Errors
    /// The runtime refuses a frame.
    pub fn model(
        character: &Character<'_>,
        examples: &Examples,
        frames: &[usize],
    ) -> Result<Self, Error> {
        let truth = TrueNormals::new(examples.surface());
        let frames = frames.par_iter().map(|&frame| {
            let skin = skin(character, examples, frame)?;
            let measured = MeasuredFrame::new(examples, &truth, frame, |v| skin.vertex(v));
            Ok(MeasuredFrame { confidence: skin.confidence, ..measured })
        });
        Ok(Self::new(examples, frames.collect::<Result<_, Error>>()?))
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
    /// If `place` is not the index of a measured frame.
    pub fn errors_in(&self, place: usize) -> Errors {
        self.summary(std::slice::from_ref(&self.frames[place]))
    }

    /// Returns the RMS distance of vertices in one of the measured frames, in % of the rest diagonal.
    ///
    /// # Panics
    /// If `place` is not the index of a measured frame.
    pub fn rms_percent_in(&self, place: usize, vertices: &[usize]) -> f64 {
        let distances = &self.frames[place].distances;
        self.percent(rms(vertices.iter().map(|&v| (distances[v], self.importance().of(v)))))
    }

    /// Returns the RMS distance of vertices in all frames, in % of the rest diagonal.
    pub fn rms_percent_of(&self, vertices: &[usize]) -> f64 {
        let of = |frame: &'_ MeasuredFrame| -> Vec<(f64, f64)> {
            vertices.iter().map(|&v| (frame.distances[v], self.importance().of(v))).collect()
        };
        self.percent(rms(self.frames.iter().flat_map(of)))
    }

    /// Returns the RMS distance of each vertex over all frames, V values in % of the rest diagonal.
    pub fn vertex_rms_percent(&self) -> Vec<f64> {
        let vertex_len = self.frames.first().map_or(0, |frame| frame.distances.len());
        let of = |vertex| self.frames.iter().map(move |frame| (frame.distances[vertex], 1.0));
        (0..vertex_len).map(|vertex| self.percent(rms(of(vertex)))).collect()
    }

    /// Returns the distance of each vertex in one of the measured frames, V values in % of the rest diagonal.
    ///
    /// # Panics
    /// If `place` is not the index of a measured frame.
    pub fn percent_in(&self, place: usize) -> Vec<f64> {
        self.frames[place].distances.iter().map(|&length| self.percent(length)).collect()
    }

    /// Returns the RMS angle of each vertex's normals over all copies and frames, V values in degrees; 0 without
    /// normals.
    pub fn vertex_rms_degrees(&self) -> Vec<f64> {
        let copies = self.copies();
        let of = |copies: &Vec<usize>| {
            let angles =
                self.frames.iter().flat_map(|f| copies.iter().filter_map(|&e| f.angles[e]));
            rms(angles.map(|angle| (angle, 1.0))).to_degrees()
        };
        copies.iter().map(of).collect()
    }

    /// Returns the largest angle of each vertex's normals over all copies in one of the measured frames, V values in
    /// degrees; 0 without normals.
    ///
    /// # Panics
    /// If `place` is not the index of a measured frame.
    pub fn degrees_in(&self, place: usize) -> Vec<f64> {
        let angle = |&copy: &usize| self.frames[place].angles[copy].unwrap_or_default();
        let of = |copies: &Vec<usize>| copies.iter().map(angle).fold(0.0, f64::max).to_degrees();
        self.copies().iter().map(of).collect()
    }

    /// Sums the squared angles between normals and true normals over all frames, each times its area. Returns the sum
    /// in square radians, and the sum of the areas.
    pub fn squared_angles(&self) -> (f64, f64) {
        squares(self.frames.iter().flat_map(|frame| self.weighted_angles(frame)))
    }

    /// Returns the index of the measured frame with the largest RMS distance.
    pub fn worst(&self) -> usize {
        let all: Vec<f64> =
            self.frames.iter().map(|frame| rms(self.weighted_distances(frame))).collect();
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
            frames.iter().flat_map(|frame| self.weighted_angles(frame)).collect();
        let mut distances: Vec<(f64, f64)> =
            frames.iter().flat_map(|frame| self.weighted_distances(frame)).collect();
        let rms = rms(distances.iter().copied());
        let weighted = distances.iter().filter(|(_, weight)| *weight > 0.0);
        let largest = weighted.map(|(distance, _)| *distance).fold(0.0, f64::max);
        let sum = |of: fn(&(f64, f64)) -> f64| distances.iter().map(of).sum::<f64>();
        let mean = sum(|(distance, weight)| distance * weight) / sum(|(_, weight)| *weight);
        let p99 = percentile(&mut distances, 0.99);
        let [rms_percent, mean_percent, p99_percent, max_percent] =
            [rms, mean, p99, largest].map(|d| self.percent(d));
        let millimetres = |diagonal: f64| {
            let [rms_mm, mean_mm, p99_mm, max_mm] =
                [rms, mean, p99, largest].map(|length| length / self.diagonal * diagonal);
            Millimetres { rms_mm, mean_mm, p99_mm, max_mm }
        };
        Errors {
            rms,
            rms_percent,
            mean_percent,
            p99_percent,
            max_percent,
            millimetres: self.diagonal_mm.map(millimetres),
            normal_rms_degrees: self::rms(angles.iter().copied()).to_degrees(),
            normal_median_degrees: percentile(&mut angles, 0.5).to_degrees(),
            normal_p99_degrees: percentile(&mut angles, 0.99).to_degrees(),
        }
    }

    /// Lists the copies of each vertex, V lists.
    fn copies(&self) -> Vec<Vec<usize>> {
        let mut copies = vec![Vec::new(); self.copy_of.iter().max().map_or(0, |last| last + 1)];
        self.copy_of.iter().enumerate().for_each(|(copy, &vertex)| copies[vertex].push(copy));
        copies
    }

    /// Lists the distances in a frame with their weights.
    fn weighted_distances<'a>(
        &'a self,
        frame: &'a MeasuredFrame,
    ) -> impl Iterator<Item = (f64, f64)> + 'a {
        let weight = move |vertex| self.importance().of(vertex);
        frame.distances.iter().enumerate().map(move |(vertex, &d)| (d, weight(vertex)))
    }

    /// Lists the angles in a frame with their weights.
    fn weighted_angles<'a>(
        &'a self,
        frame: &'a MeasuredFrame,
    ) -> impl Iterator<Item = (f64, f64)> + 'a {
        let angles = frame.angles.iter().zip(&self.areas);
        angles.filter_map(|(angle, weight)| Some(((*angle)?, *weight)))
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
        // All copies of a vertex have the same position.
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

    /// Returns the vertex with the largest distance.
    pub fn worst_vertex(&self) -> usize {
        largest(&self.distances)
    }
}

/// Returns the weighted RMS of errors.
fn rms(errors: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (sum, all) = squares(errors);
    (sum / all.max(f64::MIN_POSITIVE)).sqrt()
}

/// Sums squared errors times their weights, and the weights.
fn squares(errors: impl Iterator<Item = (f64, f64)>) -> (f64, f64) {
    errors.fold((0.0, 0.0), |(sum, all), (d, weight)| (sum + weight * d * d, all + weight))
}

/// Returns the weighted percentile: the least error that `share` of the weight does not exceed. Sorts the errors.
fn percentile(errors: &mut [(f64, f64)], share: f64) -> f64 {
    errors.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    // The factor below 1 absorbs the rounding of a sum of weights.
    let mut left = share * errors.iter().map(|(_, weight)| weight).sum::<f64>() * (1.0 - 1e-12);
    let found = errors.iter().find(|(_, weight)| {
        left -= weight;
        left <= 0.0
    });
    found.map_or(0.0, |(error, _)| *error)
}

/// Name of the baseline with weights fitted to the training frames.
pub const LBS: &str = "LBS, fitted";
/// Name of the baseline with the mesh's own weights.
pub const OWN_WEIGHTS: &str = "own weights";

/// A baseline and its errors.
pub struct MeasuredBaseline {
    /// The baseline.
    pub baseline: Baseline,
    /// The errors.
    pub measured: Measured,
}

/// The baselines of examples, on the same frames.
pub struct Baselines {
    /// LBS with 4 influences, fitted to the training frames.
    pub lbs: MeasuredBaseline,
    /// LBS with [`own_weights`]; `None` if the mesh comes without weights.
    pub own_weights: Option<MeasuredBaseline>,
}

impl Baselines {
    /// Measures the baselines on frames of the examples. The fitted baseline comes from the model's record if the
    /// record has LBS weights.
    pub fn new(record: &TrainingRecord, examples: &Examples, frames: &[usize]) -> Self {
        let measured = |baseline: Baseline| {
            let measured = Measured::lbs(&baseline, examples, frames);
            MeasuredBaseline { baseline, measured }
        };
        let lbs = record.baseline(examples);
        let own = own_weights(examples, &lbs.weights);
        Self {
            own_weights: own.map(|own| measured(Baseline::new(own, examples))),
            lbs: measured(lbs),
        }
    }
}
