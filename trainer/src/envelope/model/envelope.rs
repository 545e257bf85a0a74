//! An envelope in f64: predicts a palette from a pose.

use super::feature::{Feature, FeatureOrder};
use super::key::{Key, Shear, wide};
use crate::examples::Skeleton;
use crate::numeric::affine;
use crate::numeric::trs::Place;
use crate::regression::confidence::MapConfidence;
use crate::regression::map::KernelMap;
use faer::Mat;
use nalgebra::{Matrix3, Matrix3x4, Vector3};
use serde::Serialize;
use sinew_runtime::Envelope;
use sinew_runtime::envelope::{Certificate, HelperKind, Predictor};
use std::ops::Range;

/// An envelope. All its lengths have one unit, all its positions one origin.
#[derive(Clone, Debug)]
pub struct EnvelopeModel {
    /// Name of the part.
    pub name: String,
    /// J joints with one root.
    pub skeleton: Skeleton,
    /// Reconstruction of the proxies; `None` for the kernel predictor, whose palette has joints and helpers.
    pub reconstruction: Option<Reconstruction>,
    /// Groups of helpers with their kernel maps; empty for a rotational envelope.
    pub groups: Vec<Group>,
    /// Transforms that the helpers may have; affine for a rotational envelope.
    pub helper_kind: HelperKind,
    /// Place of each proxy's vertices at rest, P.
    pub places: Vec<Place>,
    /// Largest rotation of each joint relative to its parent in training, J, radians.
    pub pose_ranges: Vec<f64>,
    /// Largest distance in training of each joint's origin from its place under the parent's transform, J.
    pub pose_gaps: Vec<f64>,
    /// Largest norm of each joint's strain in training, J; `None` if no joint stretches.
    pub stretch_ranges: Option<Vec<f64>>,
    /// The curves, C.
    pub curves: Vec<Curve>,
    /// Measured errors of the fit.
    pub certificate: Certificate,
}

/// A curve of the pose.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Name.
    pub name: String,
    /// Least and greatest value in training.
    pub range: [f64; 2],
}

/// Reconstruction of the transforms of P proxies: `t = c1 d + c2 q` (METHOD §1.7.3).
#[derive(Clone, Debug)]
pub struct Reconstruction {
    /// Key predictors, P.
    pub keys: Vec<Key>,
    /// c1, 4P x 3P.
    pub c1: Mat<f64>,
    /// c2, 4P x 4J.
    pub c2: Mat<f64>,
}

/// A group of proxies that share a dominant joint and a kernel map (METHOD §1.9). Adds `Q_dom K` to its proxies, with
/// `K = outputs z` and z the latent values of the kernel map.
#[derive(Clone, Debug)]
pub struct Group {
    /// Dominant joint.
    pub joint: usize,
    /// Range of its proxies in 0..P; it starts at the end of the previous group.
    pub proxies: Range<usize>,
    /// Inputs of the map, d.
    pub inputs: Vec<Input>,
    /// Kernel map from d inputs to r latent values.
    pub map: KernelMap,
    /// Linear map from latent values to the maps of p proxies, 12p x r: row 12 l + 4 r + c is entry r, c of proxy l.
    pub outputs: Mat<f64>,
}

/// A feature and its weight.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Input {
    /// The feature.
    pub feature: Feature,
    /// Factor of the feature.
    pub weight: f64,
}

impl EnvelopeModel {
    /// Returns the kind of predictor.
    pub fn predictor(&self) -> Predictor {
        match &self.reconstruction {
            None => Predictor::Kernel,
            Some(_) => Predictor::Rotational,
        }
    }

    /// Returns the order of the features in a file.
    pub fn feature_order(&self) -> FeatureOrder {
        let stretches = self.stretch_ranges.is_some();
        FeatureOrder { joint_len: self.joint_len(), stretches }
    }

    /// Returns the number of joints, J.
    pub fn joint_len(&self) -> usize {
        self.skeleton.parents.len()
    }

    /// Returns the number of proxies, P.
    pub fn proxy_len(&self) -> usize {
        let helpers = self.groups.iter().map(|group| group.proxies.len()).sum();
        self.reconstruction.as_ref().map_or(helpers, |r| r.keys.len())
    }

    /// Returns the palette index of the first proxy: J if the palette starts with the joints, else 0.
    pub fn first_proxy(&self) -> usize {
        if self.reconstruction.is_some() { 0 } else { self.joint_len() }
    }

    /// Returns the number of transforms in the palette.
    pub fn palette_len(&self) -> usize {
        self.first_proxy() + self.proxy_len()
    }

    /// Returns the keys; empty for the kernel predictor.
    pub fn keys(&self) -> &[Key] {
        self.reconstruction.as_ref().map_or(&[], |r| &r.keys)
    }

    /// Converts a loaded envelope to f64. Rest frames are the inverses of the file's inverse binds.
    pub fn from_file(envelope: &Envelope<'_>) -> Self {
        let joints = 0..envelope.joint_len();
        let name = |joint| envelope.joint_name(joint).unwrap_or_default().to_owned();
        let keys: Vec<_> = (0..envelope.proxy_len()).filter_map(|l| envelope.key(l)).collect();
        let (p, j) = (keys.len(), joints.len());
        let order = FeatureOrder { joint_len: j, stretches: envelope.stretches() };
        let curve = |curve| Curve {
            name: envelope.curve_name(curve).unwrap_or_default().to_owned(),
            range: envelope.curve_range(curve).unwrap_or_default().map(f64::from),
        };
        let strain_range = |joint| wide(envelope.stretch_range(joint));
        Self {
            name: envelope.name().to_owned(),
            skeleton: Skeleton {
                names: joints.clone().map(name).collect(),
                parents: joints.clone().map(|joint| envelope.parent(joint)).collect(),
                rest: joints.clone().map(|joint| rest_frame(envelope, joint)).collect(),
                is_still: joints.is_empty(),
                ..Skeleton::default()
            },
            reconstruction: envelope.predictor().reconstructs().then(|| Reconstruction {
                keys: keys.iter().map(key).collect(),
                c1: Mat::from_fn(4 * p, 3 * p, |r, c| wide(envelope.c1(r, c))),
                c2: Mat::from_fn(4 * p, 4 * j, |r, c| wide(envelope.c2(r, c))),
            }),
            groups: envelope.groups().map(|loaded| group(&loaded, order)).collect(),
            helper_kind: envelope.helper_kind(),
            places: (0..envelope.proxy_len()).filter_map(|proxy| place(envelope, proxy)).collect(),
            stretch_ranges: order.stretches.then(|| joints.clone().map(strain_range).collect()),
            curves: (0..envelope.curve_len()).map(curve).collect(),
            pose_ranges: joints.clone().map(|joint| wide(envelope.pose_range(joint))).collect(),
            pose_gaps: joints.map(|joint| wide(envelope.pose_gap(joint))).collect(),
            certificate: envelope.certificate(),
        }
    }

    /// Lists the proxies in an order with `first` first, then the other proxies of its group, then the rest.
    pub fn order_from(&self, first: usize) -> Vec<usize> {
        let own = self.groups.iter().find(|group| group.proxies.contains(&first));
        let beside = |proxy: &usize| own.is_some_and(|group| group.proxies.contains(proxy));
        let mut order: Vec<usize> = (0..self.proxy_len()).collect();
        order.sort_by_key(|proxy| (*proxy != first, !beside(proxy)));
        order
    }

    /// Reorders the proxies. Predictions do not change, bit for bit.
    ///
    /// - `order`: permutation of 0..P that keeps the proxies of each group together.
    #[must_use]
    pub fn ordered(&self, order: &[usize]) -> Self {
        let mut out = self.clone();
        if let Some(reconstruction) = &mut out.reconstruction {
            for matrix in [&mut reconstruction.c1, &mut reconstruction.c2] {
                *matrix = rows(matrix, 4, order);
            }
        }
        out.places = order.iter().map(|&proxy| self.places[proxy]).collect();
        let place = |proxy: usize| order.iter().position(|&other| other == proxy).unwrap_or(proxy);
        out.groups.sort_by_key(|group| group.proxies.clone().map(place).min());
        let mut start = 0;
        for group in &mut out.groups {
            let Group { proxies, outputs, .. } = group;
            let mut own: Vec<usize> = (0..proxies.len()).collect();
            own.sort_by_key(|own| place(proxies.start + own));
            *outputs = rows(outputs, 12, &own);
            *proxies = start..start + own.len();
            start = proxies.end;
        }
        out
    }

    /// Removes the one joint of a skeleton that never moves. A helper that never moves takes its place in the palette.
    #[must_use]
    pub fn without_joint(&self) -> Self {
        let mut out = self.clone();
        out.skeleton = Skeleton { is_still: true, ..Skeleton::default() };
        out.groups.iter_mut().for_each(|group| {
            group.proxies = group.proxies.start + 1..group.proxies.end + 1;
        });
        out.groups.insert(0, Group::nothing(0, 0..1));
        out.places.insert(0, Place::at(self.skeleton.rest[0].map(|row| row[3])));
        (out.pose_ranges, out.pose_gaps) = (Vec::new(), Vec::new());
        out
    }

    /// Converts a model to the input's unit and origin. The model's positions are `(x - centre) / unit` of the input's
    /// x.
    #[must_use]
    pub fn restated(&self, unit: f64, centre: [f64; 3]) -> Self {
        let mut out = self.clone();
        for frame in &mut out.skeleton.rest {
            for (row, centre) in frame.iter_mut().zip(centre) {
                row[3] = unit * row[3] + centre;
            }
        }
        for place in &mut out.places {
            place.centre = place.centre * unit + Vector3::from(centre);
        }
        out.pose_gaps.iter_mut().for_each(|gap| *gap *= unit);
        let root = self.skeleton.root();
        if let Some(reconstruction) = &mut out.reconstruction {
            reconstruction.scale(unit);
            reconstruction.shift(centre, root);
        }
        out.groups.iter_mut().for_each(|group| group.restate(unit, centre));
        out
    }
}

impl Group {
    /// Creates a group that adds 0.
    pub fn nothing(joint: usize, proxies: Range<usize>) -> Self {
        let outputs = Mat::zeros(12 * proxies.len(), 0);
        Self { joint, proxies, inputs: Vec::new(), map: KernelMap::nothing(), outputs }
    }

    /// Returns true if the map has centres; without centres the group adds 0.
    pub fn has_centres(&self) -> bool {
        self.map.centres.ncols() > 0
    }

    /// Computes the inputs of the map from the features of a pose, d.
    ///
    /// - `order`: of the features.
    pub fn input(&self, features: &[f64], order: FeatureOrder) -> Vec<f64> {
        let value = |input: &Input| input.weight * features[order.index(input.feature)];
        self.inputs.iter().map(value).collect()
    }

    /// Computes K of each proxy from the latent values, r.
    pub fn maps(&self, latents: &[f64]) -> impl Iterator<Item = Matrix3x4<f64>> {
        (0..self.proxies.len()).map(move |l| {
            Matrix3x4::from_fn(|r, c| {
                let row = self.outputs.row(12 * l + 4 * r + c);
                row.iter().zip(latents).map(|(a, z)| a * z).sum()
            })
        })
    }

    /// Converts the group. With unit u and centre o, a correction `[L | t]` adds `L (x - o) + u t`.
    fn restate(&mut self, unit: f64, [ox, oy, oz]: [f64; 3]) {
        for input in self.inputs.iter_mut().filter(|input| input.feature.is_length()) {
            *input = Input { weight: input.weight / unit, ..*input };
        }
        let outputs = &self.outputs;
        self.outputs = Mat::from_fn(outputs.nrows(), outputs.ncols(), |row, z| {
            let own = |c: usize| outputs[(row - row % 4 + c, z)];
            match row % 4 {
                3 => unit * own(3) - (own(0) * ox + own(1) * oy + own(2) * oz),
                c => own(c),
            }
        });
    }
}

impl Reconstruction {
    /// Multiplies all lengths by `unit`.
    fn scale(&mut self, unit: f64) {
        let is_translation = |index: usize| index % 4 == 3;
        for row in 0..self.c2.nrows() {
            let scale = if is_translation(row) { unit } else { 1.0 };
            for column in 0..self.c1.ncols() {
                self.c1[(row, column)] *= scale;
            }
            for column in 0..self.c2.ncols() {
                self.c2[(row, column)] *= scale / if is_translation(column) { unit } else { 1.0 };
            }
        }
    }

    /// Moves the origin: with centre o, a joint's map `[Q | d]` becomes `[Q | d + Qo - o]`. The root's block of q is
    /// `[I | 0]`, so the constant o goes into this block.
    fn shift(&mut self, centre: [f64; 3], root: usize) {
        let (c1, c2) = (&mut self.c1, &mut self.c2);
        for row in 0..c2.nrows() {
            for joint in 0..c2.ncols() / 4 {
                let shift = c2[(row, 4 * joint + 3)];
                for (axis, o) in centre.iter().enumerate() {
                    c2[(row, 4 * joint + axis)] += o * shift;
                    c2[(row, 4 * root + axis)] -= o * shift;
                }
            }
        }
        for proxy in 0..c2.nrows() / 4 {
            let shift = 4 * proxy + 3;
            for (axis, o) in centre.iter().enumerate() {
                for column in 0..c1.ncols() {
                    c1[(shift, column)] -= o * c1[(4 * proxy + axis, column)];
                }
                for column in 0..c2.ncols() {
                    c2[(shift, column)] -= o * c2[(4 * proxy + axis, column)];
                }
                c2[(shift, 4 * root + axis)] += o;
            }
        }
    }
}

/// Reorders blocks of `each` rows.
fn rows(matrix: &Mat<f64>, each: usize, order: &[usize]) -> Mat<f64> {
    Mat::from_fn(matrix.nrows(), matrix.ncols(), |row, column| {
        matrix[(each * order[row / each] + row % each, column)]
    })
}

/// Computes a joint's rest frame from its inverse bind; takes the origin from the file if it has one.
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

/// Converts the place of a helper's vertices to f64.
fn place(envelope: &Envelope<'_>, proxy: usize) -> Option<Place> {
    let [xx, xy, xz, yy, yz, zz] = envelope.helper_spread(proxy)?.map(f64::from);
    Some(Place {
        centre: envelope.helper_centre(proxy)?.map(f64::from).into(),
        spread: Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz),
    })
}

/// Converts a loaded key to f64.
fn key(key: &sinew_runtime::envelope::Key) -> Key {
    let matrix = |rows: &[[f32; 3]; 3]| Matrix3::from_fn(|r, c| f64::from(rows[r][c]));
    Key {
        joint: key.joint,
        twist: matrix(&key.twist),
        residual: key.residual.map(|(joint, twist)| (joint, matrix(&twist))),
        shear: Shear::from_fn(|r, c| match (c.checked_sub(6), key.stretch) {
            (None, _) => f64::from(key.shear[r][c]),
            (Some(c), Some(stretch)) => f64::from(stretch[r][c]),
            (Some(_), None) => 0.0,
        }),
    }
}

/// Converts a loaded group to f64. The kernel values at rest are computed again, not read from the file.
fn group(group: &sinew_runtime::envelope::Group<'_>, order: FeatureOrder) -> Group {
    let (d, n) = (group.input_len(), group.centre_len());
    let (r, m) = (group.rank(), group.certainty_len());
    let input = |(index, weight): (usize, f32)| Input {
        feature: order.feature(index),
        weight: weight.into(),
    };
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
