//! A fitted envelope and the skin that follows it, as training sees them.

use super::correction::rounding;
use super::levels;
use super::model::{EnvelopeModel, FileModel, Group, Reconstruction, Shapes, SkinModel};
use crate::envelope::lbs::blend::Weights;
use crate::envelope::lbs::stacked::{self, map_of};
use crate::envelope::lbs::training::Training;
use crate::numeric::affine::linear;
use crate::numeric::columns::largest;
use faer::Mat;
use sinew_runtime::envelope::Certificate;
use std::ops::Range;

/// What an envelope is called that a training makes.
pub const NAME: &str = "envelope";

/// A fitted envelope, in training units.
#[derive(Clone)]
pub struct Fitted {
    /// What predicts the palette.
    pub envelope: EnvelopeModel,
    /// The vertices' weights on it.
    pub weights: Weights,
}

impl Fitted {
    /// Makes an envelope on the joints of a training, without a correction.
    ///
    /// - `reconstruction`: none for joints and helpers, whose groups are still to be given.
    pub fn new(
        training: &Training,
        weights: Weights,
        reconstruction: Option<Reconstruction>,
    ) -> Self {
        let envelope = EnvelopeModel {
            name: NAME.to_owned(),
            skeleton: training.skeleton.clone(),
            reconstruction,
            groups: Vec::new(),
            pose_ranges: training.poses.angle_ranges(),
            pose_gaps: training.poses.gaps(&training.skeleton.parents, &training.origins),
            certificate: Certificate::default(),
        };
        Self { envelope, weights }
    }

    /// The same with a correction.
    #[must_use]
    pub fn with(mut self, groups: Vec<Group>) -> Self {
        self.envelope.groups = groups;
        self
    }

    /// The same, where no joint stands before the proxies, with that proxy first whose transform is least likely to
    /// mirror what it moves: runtimes ask transform 0 whether a pose is mirrored (METHOD §1.8).
    ///
    /// - `palettes`: of the training poses, 3n x 4P; they are put into the same order.
    pub fn led_by_upright(&self, palettes: Mat<f64>) -> (Self, Mat<f64>) {
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
        let renumbered = (0..weights.len())
            .map(|vertex| weights.of(vertex).map(|(l, alpha)| (place(l), alpha)).collect());
        let weights = Weights::from_lists(weights.most(), renumbered);
        let palettes = stacked::bases(&palettes, &order);
        (Self { envelope: envelope.ordered(&order), weights }, palettes)
    }

    /// Gives what a file holds of it, in the units of the input, the skin without tangent coefficients. The
    /// certificate's figures are RMS errors as shares of the diagonal; that of the correction is added here.
    pub fn file_model(&self, training: &Training, certificate: Certificate) -> FileModel {
        let examples = training.examples;
        let mut envelope = self.envelope.restated(training.unit, training.centre);
        // As they were given, to the last digit.
        envelope.skeleton = examples.skeleton.clone();
        let surface = examples.surface();
        let influences: Vec<_> =
            (0..self.weights.len()).map(|v| self.weights.of(v).collect()).collect();
        let of_engine =
            |(name, range): &(String, Range<usize>)| (name.clone(), surface.engine_range(range));
        let skin = SkinModel {
            name: levels::OWN.to_owned(),
            envelope: Some(0),
            rest_positions: surface.copied(&examples.rest),
            rest_normals: surface.normals(),
            rest_tangents: surface.tangents(),
            influences: surface.copied(&influences),
            tangent_coefficients: None,
            normal_errors: None,
            ranges: examples.ranges.iter().map(of_engine).collect(),
            shapes: Shapes::default(),
        };
        let groups = &self.envelope.groups;
        let length = |share: f32| (training.unit * f64::from(share)) as f32;
        envelope.certificate = Certificate {
            diagonal: training.unit as f32,
            training_rms: length(certificate.training_rms),
            same_clips_rms: length(certificate.same_clips_rms),
            other_clip_rms: certificate.other_clip_rms.map(length),
            lbs_training_rms: length(certificate.lbs_training_rms),
            correction_error: rounding::farthest(groups, training, &envelope, &skin) as f32,
            base_training_rms: length(certificate.base_training_rms),
        };
        FileModel {
            space: examples.space,
            envelopes: vec![envelope],
            skins: vec![skin],
            ..FileModel::default()
        }
    }
}

/// Adds a correction to the proxies, which stand last in a palette.
pub(super) fn corrected(mut palette: Mat<f64>, correction: &Mat<f64>) -> Mat<f64> {
    let first = palette.ncols() - correction.ncols();
    let mut proxies = palette.subcols_mut(first, correction.ncols());
    proxies += correction;
    palette
}
