//! An envelope in f64: what predicts a palette from a pose.

use super::group::{Group, Input};
use super::key::Key;
use crate::examples::Skeleton;
use crate::numeric::affine;
use crate::regression::confidence::MapConfidence;
use crate::regression::map::KernelMap;
use faer::Mat;
use nalgebra::{Matrix3, Matrix6};
use sinew_runtime::Envelope;
use sinew_runtime::envelope::{Certificate, Predictor};

/// An envelope, in one unit of length and about one origin.
#[derive(Clone, Debug)]
pub struct EnvelopeModel {
    /// Name of the part.
    pub name: String,
    /// J joints, of one root.
    pub skeleton: Skeleton,
    /// The proxies' reconstruction; `None` for the kernel predictor, of joints and helpers.
    pub reconstruction: Option<Reconstruction>,
    /// Kernel maps of the helpers; a rotational envelope has none.
    pub groups: Vec<Group>,
    /// Largest rotation of each joint relative to its parent in training, J, in radians.
    pub pose_ranges: Vec<f64>,
    /// How far each joint's origin came in training from where its parent carries it, at the most, J.
    pub pose_gaps: Vec<f64>,
    /// What the fit was measured to reach.
    pub certificate: Certificate,
}

/// What predicts the transforms of P proxies: `t = c1 d + c2 q` (METHOD §1.7.3).
#[derive(Clone, Debug)]
pub struct Reconstruction {
    /// Key predictors, P.
    pub keys: Vec<Key>,
    /// c1, 4P x 3P.
    pub c1: Mat<f64>,
    /// c2, 4P x 4J.
    pub c2: Mat<f64>,
}

impl EnvelopeModel {
    /// Tells which predictor it is.
    pub fn predictor(&self) -> Predictor {
        match &self.reconstruction {
            None => Predictor::Kernel,
            Some(_) => Predictor::Rotational,
        }
    }

    /// Counts the joints, J.
    pub fn joint_len(&self) -> usize {
        self.skeleton.parents.len()
    }

    /// Counts the proxies, P.
    pub fn proxy_len(&self) -> usize {
        let helpers = self.groups.iter().map(|group| group.proxies.len()).sum();
        self.reconstruction.as_ref().map_or(helpers, |r| r.keys.len())
    }

    /// Gives the place of the first proxy in the palette; before it stand the joints, where the
    /// palette has them.
    pub fn first_proxy(&self) -> usize {
        if self.reconstruction.is_some() { 0 } else { self.joint_len() }
    }

    /// Counts the transforms of the palette.
    pub fn palette_len(&self) -> usize {
        self.first_proxy() + self.proxy_len()
    }

    /// Gives the key predictors; none of the kernel predictor.
    pub fn keys(&self) -> &[Key] {
        self.reconstruction.as_ref().map_or(&[], |r| &r.keys)
    }

    /// Widens what a file holds. Rest frames are the inverses of its inverse binds.
    pub fn from_file(envelope: &Envelope<'_>) -> Self {
        let joints = 0..envelope.joint_len();
        let name = |joint| envelope.joint_name(joint).unwrap_or_default().to_owned();
        let keys: Vec<_> = (0..envelope.proxy_len()).filter_map(|l| envelope.key(l)).collect();
        let (p, j) = (keys.len(), joints.len());
        Self {
            name: envelope.name().to_owned(),
            skeleton: Skeleton {
                names: joints.clone().map(name).collect(),
                parents: joints.clone().map(|joint| envelope.parent(joint)).collect(),
                rest: joints.clone().map(|joint| rest_frame(envelope, joint)).collect(),
                roots: Vec::new(),
                unplaced: Vec::new(),
            },
            reconstruction: envelope.predictor().reconstructs().then(|| Reconstruction {
                keys: keys.iter().map(key).collect(),
                c1: Mat::from_fn(4 * p, 3 * p, |r, c| wide(envelope.c1(r, c))),
                c2: Mat::from_fn(4 * p, 4 * j, |r, c| wide(envelope.c2(r, c))),
            }),
            groups: envelope.groups().map(|group| widened(&group)).collect(),
            pose_ranges: joints.clone().map(|joint| wide(envelope.pose_range(joint))).collect(),
            pose_gaps: joints.map(|joint| wide(envelope.pose_gap(joint))).collect(),
            certificate: envelope.certificate(),
        }
    }
}

fn wide(value: Option<f32>) -> f64 {
    value.map_or(f64::NAN, f64::from)
}

/// Inverts the file's inverse bind; the origin is the file's own, where it has one.
fn rest_frame(envelope: &Envelope<'_>, joint: usize) -> [[f64; 4]; 3] {
    let bind = envelope.inverse_bind(joint).unwrap_or([[f32::NAN; 4]; 3]);
    let bind = affine::from_rows(&bind.map(|row| row.map(f64::from)));
    let turn = affine::linear(&bind).try_inverse().unwrap_or(Matrix3::repeat(f64::NAN));
    let origin = match envelope.origin(joint) {
        Some(origin) => origin.map(f64::from).into(),
        None => -turn * bind.column(3),
    };
    affine::to_rows(&affine::joined(&turn, &origin))
}

fn key(key: &sinew_runtime::envelope::Key) -> Key {
    let matrix = |rows: &[[f32; 3]; 3]| Matrix3::from_fn(|r, c| f64::from(rows[r][c]));
    Key {
        joint: key.joint,
        twist: matrix(&key.twist),
        residual: key.residual.map(|(joint, twist)| (joint, matrix(&twist))),
        shear: Matrix6::from_fn(|r, c| f64::from(key.shear[r][c])),
    }
}

/// Widens a group's arrays. Its kernels' values at rest are computed, not the file's.
fn widened(group: &sinew_runtime::envelope::Group<'_>) -> Group {
    let (d, n) = (group.input_len(), group.centre_len());
    let (r, m) = (group.rank(), group.certainty_len());
    let input = |(feature, weight): (usize, f32)| Input { feature, weight: weight.into() };
    Group {
        joint: group.joint,
        proxies: group.proxies.clone(),
        inputs: (0..d).filter_map(|i| group.input(i)).map(input).collect(),
        map: KernelMap {
            kernel: group.kernel,
            centres: Mat::from_fn(d, n, |i, k| wide(group.centre(k, i))),
            coefficients: Mat::from_fn(r + m, n + d, |r, c| wide(group.coefficient(r, c))),
            confidence: MapConfidence {
                len: m,
                reach: group.confidence.reach.into(),
                linear: group.confidence.linear.into(),
                signal: group.confidence.signal.into(),
                noise: group.confidence.noise.into(),
            },
        },
        outputs: Mat::from_fn(12 * group.proxies.len(), r, |row, c| wide(group.output(row, c))),
    }
}
