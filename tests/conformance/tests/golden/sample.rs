//! Makes the model of each golden file.

use ::models::{GOLDEN_KIND_NAMES, GOLDEN_NAMES, GOLDEN_STRETCH_NAMES};
use faer::{Mat, MatRef};
use nalgebra::{Matrix3, SMatrix};
use sinew_runtime::envelope::{Certificate, GroupKernel, HelperKind, Predictor};
use sinew_runtime::format::{Axis, Handedness, Space};
use sinew_trainer::envelope::model::{
    Curve, EnvelopeModel, Feature, FeatureOrder, FileModel, Group, Input, Key, Reconstruction,
    Shapes, Shear, SkinModel,
};
use sinew_trainer::examples::Skeleton;
use sinew_trainer::numeric::trs::Place;
use sinew_trainer::regression::confidence::MapConfidence;
use sinew_trainer::regression::map::KernelMap;

/// A golden envelope.
#[derive(Clone, Copy, Debug)]
pub(super) struct Golden {
    pub(super) predictor: Predictor,
    /// Whether joints stretch. Curves then move a kernel envelope.
    pub(super) stretches: bool,
    /// Number of the kind of the helpers.
    pub(super) kind: usize,
    /// Name of the file.
    pub(super) file: &'static str,
}

pub(super) const RIGID: Golden =
    Golden { predictor: Predictor::Kernel, stretches: false, kind: 0, file: GOLDEN_NAMES[1] };

pub(super) fn goldens() -> impl Iterator<Item = Golden> {
    let names = [(false, GOLDEN_NAMES), (true, GOLDEN_STRETCH_NAMES)].into_iter();
    let all = names.flat_map(|(stretches, files)| {
        let files = Predictor::ALL.into_iter().zip(files);
        files.map(move |(predictor, file)| Golden { predictor, stretches, kind: 0, file })
    });
    let kinds = GOLDEN_KIND_NAMES.into_iter().zip(1..);
    all.chain(kinds.map(|(file, kind)| Golden { stretches: kind == 1, kind, file, ..RIGID }))
}

/// Makes a model of an envelope and its skin: 24 vertices, 5 joints, 5 proxies, 4 influences; the
/// root is joint 3. An envelope of kernels that stretches has 3 curves.
pub(super) fn file_model(golden: Golden) -> FileModel {
    let Golden { predictor, stretches, kind, .. } = golden;
    let mut dyadic = Dyadic(7);
    let (v, j, p, root) = (24, 5, 5, 3);
    let curves = [("smile", [-1.0, 1.0]), ("blink", [0.0, 1.0]), ("jaw/open", [-0.5, 1.0])];
    let curves = curves.map(|(name, range)| Curve { name: name.to_owned(), range });
    let curves = curves.into_iter().filter(|_| stretches && predictor.corrects());
    let curves: Vec<_> = curves.collect();
    let order = FeatureOrder { joint_len: j, stretches };
    let feature_len = order.index(Feature::Curve(curves.len()));
    let rest_frames = (0..j).map(|joint| {
        let x = joint as f64;
        [[0.0, -1.0, 0.0, x], [1.0, 0.0, 0.0, 0.5], [0.0, 0.0, 1.0, 0.0]]
    });
    let axis = |i: usize| [0, 1, 2].map(|c| if i % 3 == c { 1.0 } else { 0.0 });
    let tangent = |i: usize| {
        let [x, y, z] = axis(i + 1);
        [x, y, z, if i.is_multiple_of(2) { 1.0 } else { -1.0 }]
    };
    let palette_len = if predictor == Predictor::Kernel { j + p } else { p };
    let influences = (0..v).map(|vertex| match vertex % 3 {
        0 => vec![(vertex % palette_len, 1.0)],
        1 => vec![(vertex % palette_len, 0.75), ((vertex + 1) % palette_len, 0.25)],
        _ => (0..4).map(|slot| ((vertex + slot) % palette_len, 0.25)).collect(),
    });
    let keys = (0..p).map(|l| Key {
        joint: l % j,
        twist: dyadic.matrix(0.5),
        residual: (l % 2 == 1).then(|| ((l + 2) % j, dyadic.matrix(0.25))),
        shear: {
            let turns = dyadic.matrix::<6>(0.125);
            let strains = if stretches { dyadic.matrix::<6>(0.125) } else { SMatrix::zeros() };
            Shear::from_fn(|r, c| if c < 6 { turns[(r, c)] } else { strains[(r, c - 6)] })
        },
    });
    let keys = keys.collect();
    let c1 = dyadic.dense(4 * p, 3 * p, 0.25);
    let mut c2 = dyadic.dense(4 * p, 4 * j, 0.25);
    // The sums of rows make the rest pose exact: c1 I + c2 rest = [I | 0].
    for row in 0..4 * p {
        for c in 0..3 {
            let of_c1 = c1.row(row).iter().skip(c).step_by(3).sum::<f64>();
            let of_c2 = c2.row(row).iter().skip(c).step_by(4).sum::<f64>();
            c2[(row, 4 * root + c)] -= of_c1 + of_c2 - if row % 4 == c { 1.0 } else { 0.0 };
        }
    }
    // Two, one and two proxies; odd sizes; the two predictors together have all four kernels.
    let first = usize::from(predictor.number());
    let groups = [(2, 5, 13, 3), (1, 9, 7, 11), (2, 3, 17, 1)].into_iter().enumerate();
    let mut end = 0;
    let groups = groups.map(|(g, (proxies, d, n, rank))| {
        end += proxies;
        let mut input = |i: usize| {
            // From the end, each group of an envelope that stretches has a curve and a strain.
            let index = match stretches {
                true => feature_len - 1 - (32 * i + g) % feature_len,
                false => (7 * i + 12 * g) % feature_len,
            };
            Input { feature: order.feature(index), weight: 0.75 - dyadic.next(0.25) }
        };
        Group {
            joint: 2 * g,
            proxies: end - proxies..end,
            inputs: (0..d).map(&mut input).collect(),
            map: KernelMap {
                kernel: GroupKernel::ALL[(first + g) % 4],
                centres: dyadic.dense(n, d, 1.0).transpose().to_owned(),
                coefficients: dyadic.dense(rank + 2, n + d, 0.25),
                confidence: MapConfidence {
                    len: 2,
                    reach: 4.0,
                    linear: 0.25,
                    signal: 8.0,
                    noise: 16.0,
                },
            },
            outputs: dyadic.dense(12 * proxies, rank, 0.25),
        }
    });
    let groups = if predictor.corrects() { groups.collect() } else { Vec::new() };
    let reconstruction = Reconstruction { keys, c1, c2 };
    let skin = SkinModel {
        name: "golden skin".to_owned(),
        envelope: Some(0),
        rest_positions: (0..v).map(|_| [(); 3].map(|()| dyadic.next(2.0))).collect(),
        rest_normals: (0..v).map(axis).collect(),
        rest_tangents: Some((0..v).map(tangent).collect()),
        influences: influences.collect(),
        tangent_coefficients: None,
        normal_errors: None,
        ranges: vec![("body".to_owned(), 0..20), ("eyes".to_owned(), 20..24)],
        shapes: Shapes::default(),
    };
    let place = |l: f64| Place {
        centre: [l, 0.5, -0.25].into(),
        spread: Matrix3::new(0.5, 0.125, -0.0625, 0.125, 0.375, 0.0, -0.0625, 0.0, 0.25),
    };
    let envelope = EnvelopeModel {
        name: "golden".to_owned(),
        skeleton: Skeleton {
            names: ["hand", "elbow", "shoulder", "hip", "tail"].map(str::to_owned).to_vec(),
            parents: vec![Some(1), Some(2), Some(3), None, Some(3)],
            rest: rest_frames.collect(),
            ..Skeleton::default()
        },
        reconstruction: predictor.reconstructs().then_some(reconstruction),
        groups,
        helper_kind: HelperKind::ALL[if predictor.corrects() { kind } else { 0 }],
        places: (0..p).map(|l| place(l as f64)).collect(),
        pose_ranges: vec![2.0, 1.0, 0.75, 0.0, 1.25],
        pose_gaps: vec![0.0, 0.125, 0.0, 0.0, 0.0625],
        stretch_ranges: stretches.then(|| vec![0.25, 0.125, 0.25, 0.0, 0.25]),
        curves,
        certificate: Certificate {
            diagonal: 4.0,
            training_rms: 0.125,
            same_clips_rms: 0.25,
            lbs_training_rms: 0.5,
            correction_error: if predictor.corrects() { 0.0625 } else { 0.0 },
            base_training_rms: if predictor.corrects() { 0.375 } else { 0.125 },
            other_clip_rms: predictor.corrects().then_some(0.4375),
            trs_error: 0.03125,
        },
    };
    let space = Space {
        up: Some(Axis::Y),
        forward: Some(Axis::Z),
        handedness: Handedness::Right,
        unit: Some(1.0),
    };
    FileModel { space, envelopes: vec![envelope], skins: vec![skin], ..FileModel::default() }
}

/// Pseudo-random multiples of 1/64 in [-1, 1), which f32 holds exactly.
struct Dyadic(u32);

impl Dyadic {
    fn next(&mut self, scale: f64) -> f64 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let unit = f64::from(self.0 >> 25) / 64.0 - 1.0;
        unit * scale
    }

    fn list(&mut self, len: usize, scale: f64) -> Vec<f64> {
        (0..len).map(|_| self.next(scale)).collect()
    }

    /// Draws a matrix, row by row.
    fn matrix<const N: usize>(&mut self, scale: f64) -> SMatrix<f64, N, N> {
        SMatrix::from_row_slice(&self.list(N * N, scale))
    }

    /// Draws a matrix, row by row.
    fn dense(&mut self, rows: usize, columns: usize, scale: f64) -> Mat<f64> {
        MatRef::from_row_major_slice(&self.list(rows * columns, scale), rows, columns).to_owned()
    }
}
