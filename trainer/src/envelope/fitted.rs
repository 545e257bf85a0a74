//! A fitted envelope and its skin, in training units.

use super::correction::rounding;
use super::levels;
use super::model::{EnvelopeModel, FileModel, Group, Reconstruction, SkinModel};
use crate::envelope::lbs::blend::Weights;
use crate::envelope::lbs::targets::{bases, map_of, set_map, skin};
use crate::envelope::lbs::training::Training;
use crate::numeric::affine::{homogeneous, linear};
use crate::numeric::columns::{self, largest};
use crate::numeric::trs::{FLAT_SPREAD, Place, bone, project};
use faer::Mat;
use nalgebra::{Matrix3x4, Matrix4};
use rayon::prelude::*;
use serde::Serialize;
use sinew_runtime::envelope::{Certificate, HelperKind};
use std::ops::Range;

/// Name of a trained envelope.
pub const NAME: &str = "envelope";

/// A fitted envelope, in training units.
#[derive(Clone)]
pub struct Fitted {
    /// Model that predicts the palette.
    pub envelope: EnvelopeModel,
    /// Weights of the vertices on the palette.
    pub weights: Weights,
}

/// Errors of bones of translation, rotation and scale, over vertices and poses, as shares of the diagonal.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct BoneErrors {
    /// RMS distance of a vertex from its place by the palette.
    pub rms: f64,
    /// Largest distance.
    pub largest: f64,
}

impl Fitted {
    /// Creates an envelope without a correction on the joints of a training.
    ///
    /// - `reconstruction`: `None` for joints and helpers. [`Fitted::with`] then adds the helpers' groups.
    pub fn new(
        training: &Training,
        weights: Weights,
        reconstruction: Option<Reconstruction>,
    ) -> Self {
        let proxy_len = reconstruction.as_ref().map_or(0, |own| own.keys.len());
        let envelope = EnvelopeModel {
            name: NAME.to_owned(),
            skeleton: training.skeleton.clone(),
            groups: Vec::new(),
            helper_kind: HelperKind::Affine,
            places: places(training, &weights, 0..proxy_len),
            pose_ranges: training.poses.angle_ranges(),
            pose_gaps: training.poses.gaps(&training.skeleton.parents, &training.origins),
            stretch_ranges: training.poses.strain_ranges(),
            curves: match reconstruction {
                Some(_) => Vec::new(),
                None => training.curves(),
            },
            reconstruction,
            certificate: Certificate::default(),
        };
        Self { envelope, weights }
    }

    /// Adds a correction, given as groups of helpers.
    #[must_use]
    pub fn with(mut self, groups: Vec<Group>) -> Self {
        self.envelope.groups = groups;
        self
    }

    /// Sets the kind of the helpers, and the places of their vertices, P.
    #[must_use]
    pub fn with_helpers(mut self, helper_kind: HelperKind, places: Vec<Place>) -> Self {
        (self.envelope.helper_kind, self.envelope.places) = (helper_kind, places);
        self
    }

    /// Measures the skin of bones of translation, rotation and scale against the skin of the palettes.
    ///
    /// - `palettes`: of the training poses, 3n x 4 per transform.
    pub fn bone_errors(&self, training: &Training, palettes: &Mat<f64>) -> BoneErrors {
        let bones = self.changed(palettes.clone(), |map, place| match self.envelope.helper_kind {
            HelperKind::Affine => bone(map, place),
            _ => bone(map, &Place::at(place.centre.into())),
        });
        let apart = bones - palettes;
        let of_vertex = |v: usize| {
            columns::narrow_registers();
            let moved = skin(&training.rest[v], &self.weights, v, &apart);
            let squares = moved.chunks(3).map(|x| x.iter().map(|x| x * x).sum::<f64>());
            squares.fold([0.0, 0.0f64], |[sum, most], x| [sum + x, most.max(x)])
        };
        let all: Vec<_> = (0..training.rest.len()).into_par_iter().map(of_vertex).collect();
        let count = (all.len() * palettes.nrows() / 3).max(1) as f64;
        BoneErrors {
            rms: (all.iter().map(|own| own[0]).sum::<f64>() / count).sqrt(),
            largest: all.iter().map(|own| own[1]).fold(0.0, f64::max).sqrt(),
        }
    }

    /// Projects the helpers of palettes onto their kind; 3n x 4 per transform.
    pub fn projected(&self, palettes: Mat<f64>) -> Mat<f64> {
        let kind = self.envelope.helper_kind;
        self.changed(palettes, |map, place| project(kind, map, &place.centre))
    }

    /// Changes the proxies, which come last in a palette.
    fn changed(
        &self,
        mut palettes: Mat<f64>,
        change: impl Fn(&Matrix3x4<f64>, &Place) -> Matrix3x4<f64>,
    ) -> Mat<f64> {
        let first = self.envelope.first_proxy();
        for (proxy, place) in self.envelope.places.iter().enumerate() {
            for pose in 0..palettes.nrows() / 3 {
                let map = change(&map_of(&palettes, pose, first + proxy), place);
                set_map(&mut palettes, pose, first + proxy, &map);
            }
        }
        palettes
    }

    /// Reorders the proxies, if the palette has no joints. The first proxy is then the proxy that is least likely to
    /// mirror its vertices: runtimes test transform 0 to find out whether a pose is mirrored (METHOD §1.8).
    ///
    /// - `palettes`: the palettes of the training poses, 3n x 4P. They are reordered too.
    pub fn with_upright_first(&self, palettes: Mat<f64>) -> (Self, Mat<f64>) {
        let Self { envelope, weights } = self;
        if envelope.first_proxy() > 0 {
            return (Self { envelope: envelope.clone(), weights: weights.clone() }, palettes);
        }
        let least = |proxy: usize| {
            let poses = 0..palettes.nrows() / 3;
            let volume = |pose| linear(&map_of(&palettes, pose, proxy)).determinant();
            poses.map(volume).fold(f64::INFINITY, f64::min)
        };
        let least: Vec<f64> = (0..envelope.proxy_len()).map(least).collect();
        let order = envelope.order_from(largest(&least));
        let place = |proxy: usize| order.iter().position(|&other| other == proxy).unwrap_or(proxy);
        let weights = weights.renumbered(place);
        let palettes = bases(&palettes, &order);
        (Self { envelope: envelope.ordered(&order), weights }, palettes)
    }

    /// Converts to the model of a file in the units of the input, without tangent coefficients.
    ///
    /// - `certificate`: errors as shares of the diagonal. The error of the correction is added here.
    pub fn file_model(&self, training: &Training, certificate: Certificate) -> FileModel {
        let examples = training.examples;
        let mut envelope = self.envelope.restated(training.unit, training.centre);
        // The skeleton stays exact to the last digit.
        envelope.skeleton = examples.skeleton.clone();
        let surface = examples.surface();
        let influences: Vec<Vec<(usize, f64)>> =
            (0..self.weights.len()).map(|v| self.weights.of(v).collect()).collect();
        let to_engine =
            |(name, range): &(String, Range<usize>)| (name.clone(), surface.engine_range(range));
        let skin = SkinModel {
            ranges: examples.ranges.iter().map(to_engine).collect(),
            ..SkinModel::new(levels::OWN, &surface, &influences)
        };
        let groups = &self.envelope.groups;
        let length = |share: f32| (training.unit * f64::from(share)) as f32;
        envelope.certificate = Certificate {
            diagonal: training.unit as f32,
            training_rms: length(certificate.training_rms),
            same_clips_rms: length(certificate.same_clips_rms),
            other_clip_rms: certificate.other_clip_rms.map(length),
            lbs_training_rms: length(certificate.lbs_training_rms),
            correction_error: rounding::bound(groups, training, &envelope, &skin) as f32,
            base_training_rms: length(certificate.base_training_rms),
            trs_error: length(certificate.trs_error),
        };
        if examples.skeleton.is_still {
            envelope = envelope.without_joint();
        }
        FileModel {
            space: examples.space,
            envelopes: vec![envelope],
            skins: vec![skin],
            ..FileModel::default()
        }
    }
}

/// Returns the places of some transforms of a palette. A transform that moves no vertex has the place of all vertices.
pub(super) fn places(training: &Training, weights: &Weights, span: Range<usize>) -> Vec<Place> {
    let mut grams = vec![Matrix4::zeros(); span.len()];
    let mut all = Matrix4::zeros();
    for (v, x) in training.rest.iter().enumerate() {
        let own = homogeneous(x) * homogeneous(x).transpose();
        all += own;
        for (map, weight) in weights.of(v).filter(|(map, _)| span.contains(map)) {
            grams[map - span.start] += own * (weight * weight);
        }
    }
    let place = |gram| Place::new(gram, FLAT_SPREAD);
    grams.iter().filter_map(|gram| place(gram).or_else(|| place(&all))).collect()
}

/// Adds a correction to the proxies, which come last in a palette.
pub(super) fn corrected(mut palette: Mat<f64>, correction: &Mat<f64>) -> Mat<f64> {
    let first = palette.ncols() - correction.ncols();
    let mut proxies = palette.subcols_mut(first, correction.ncols());
    proxies += correction;
    palette
}
