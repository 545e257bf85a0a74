//! What a file holds of a fitted envelope, in the units of the input.

use super::fitted::{Base, Fitted};
use super::helpers::features::Input;
use super::helpers::group::Group;
use super::rotational::predictor::GradientPredictor;
use super::training::Training;
use super::{levels, rounding};
use crate::bake::{self, EnvelopeParts, Key, ModelParts, Reconstruction, SkinParts};
use crate::examples::Examples;
use faer::Mat;
use nalgebra::Matrix3;
use sinew_runtime::envelope::Certificate;

impl Fitted {
    /// Gathers what a file holds of the envelope. The certificate's figures are RMS errors as shares
    /// of the diagonal; that of the correction is added here.
    pub fn parts(
        &self,
        training: &Training,
        examples: &Examples,
        certificate: Certificate,
    ) -> ModelParts {
        let skeleton = &examples.skeleton;
        let groups: Vec<bake::Group> = self.groups.iter().map(|g| baked(g, training)).collect();
        let length = |share: f32| (training.unit * f64::from(share)) as f32;
        let envelope = EnvelopeParts {
            name: "envelope".to_owned(),
            joint_names: skeleton.names.clone(),
            parents: skeleton.parents.clone(),
            root: skeleton.root(),
            rest_frames: skeleton.rest.clone(),
            reconstruction: self.reconstruction(training),
            groups,
            pose_ranges: training.poses.angle_ranges(),
            certificate: Certificate {
                diagonal: training.unit as f32,
                training_rms: length(certificate.training_rms),
                cross_validated_rms: length(certificate.cross_validated_rms),
                lbs_training_rms: length(certificate.lbs_training_rms),
                correction_error: 0.0,
            },
        };
        let skin = SkinParts {
            name: levels::OWN.to_owned(),
            envelope: Some(0),
            rest_positions: examples.rest.clone(),
            rest_normals: examples.rest_normals(),
            rest_tangents: examples.rest_tangents(),
            influences: (0..self.weights.len()).map(|v| self.weights.of(v).collect()).collect(),
            ranges: examples.ranges.clone(),
        };
        let farthest = rounding::farthest(self, training, &envelope, &skin);
        let certificate = Certificate { correction_error: farthest as f32, ..envelope.certificate };
        ModelParts {
            space: examples.space,
            envelopes: vec![EnvelopeParts { certificate, ..envelope }],
            skins: vec![skin],
        }
    }

    fn reconstruction(&self, training: &Training) -> Option<Reconstruction> {
        let Base::Reconstruction(keys, reduced) = &self.base else { return None };
        let reduced = reduced.clone().from_units_of(training.unit);
        let reduced = reduced.from_centre(training.centre, training.poses.root());
        let rows = |m: &Matrix3<f64>| [0, 1, 2].map(|r| [m[(r, 0)], m[(r, 1)], m[(r, 2)]]);
        let key = |key: &GradientPredictor| Key {
            joint: key.rotation.joint,
            twist: rows(&key.rotation.twist),
            residual: key.rotation.residual.map(|(joint, twist)| (joint, rows(&twist))),
            shear: std::array::from_fn(|r| std::array::from_fn(|c| key.shear[(r, c)])),
        };
        Some(Reconstruction {
            keys: keys.iter().map(key).collect(),
            c1: row_major(&reduced.c1),
            c2: row_major(&reduced.c2),
        })
    }
}

fn row_major(m: &Mat<f64>) -> Vec<f64> {
    m.row_iter().flat_map(|row| row.iter()).copied().collect()
}

/// Restates a group for lengths and positions of the input: about the centre o, a correction
/// `[L | t]` in units u adds `L (x - o) + u t`.
fn baked(group: &Group, training: &Training) -> bake::Group {
    let [ox, oy, oz] = training.centre;
    let input = |input: &Input| {
        let unit = if input.is_displacement() { training.unit } else { 1.0 };
        (input.feature, input.weight / unit)
    };
    let outputs = Mat::from_fn(group.outputs.nrows(), group.outputs.ncols(), |row, z| {
        let own = |c: usize| group.outputs[(row - row % 4 + c, z)];
        match row % 4 {
            3 => training.unit * own(3) - (own(0) * ox + own(1) * oy + own(2) * oz),
            c => own(c),
        }
    });
    bake::Group {
        joint: group.joint,
        kernel: group.map.kernel,
        proxies: group.proxies.len(),
        inputs: group.inputs.iter().map(input).collect(),
        centres: group.map.centres.col_iter().map(|t| t.iter().copied().collect()).collect(),
        rank: group.outputs.ncols(),
        coefficients: row_major(&group.map.coefficients),
        outputs: row_major(&outputs),
        fade: (group.map.fade.start, group.map.fade.end),
    }
}
