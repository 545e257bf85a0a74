//! Small faces with known numbers, and dense solves of their pins.

use faer::linalg::solvers::{DenseSolveCore, Solve};
use faer::{Mat, Side};
use sinew_runtime::prior::{Anchor, Edit, Pin, PinJob, Pins};
use sinew_runtime::{CallError, Model, Prior, Skin};
use sinew_trainer::envelope::model::{FileModel, PriorModel, Shapes, SkinModel};
use sinew_trainer::face::prior::{Pairs, learned};

/// Numbers in [-1, 1], reproducible on every machine.
pub(crate) struct Numbers(u64);

impl Numbers {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x2545_f491_4f6c_dd1d)
    }

    pub(crate) fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64 * 2.0 - 1.0
    }

    pub(crate) fn list(&mut self, len: usize) -> Vec<f64> {
        (0..len).map(|_| self.next()).collect()
    }

    pub(crate) fn matrix(&mut self, rows: usize, columns: usize) -> Mat<f64> {
        let all = self.list(rows * columns);
        Mat::from_fn(rows, columns, |i, j| all[i * columns + j])
    }
}

/// A face of V vertices and S shapes in single precision, and its prior.
pub(crate) struct Face {
    pub(crate) file: Vec<u8>,
    pub(crate) skin: SkinModel,
    pub(crate) prior: PriorModel,
}

/// Number of vertices of a face; no shape moves the last one.
pub(crate) const VERTICES: usize = 130;

impl Face {
    /// Makes a face of S shapes and its prior. Each shape moves 30 consecutive vertices; the prior
    /// is of 200 frames of correlated weights.
    pub(crate) fn new(s: usize, seed: u64) -> Self {
        let mut numbers = Numbers::new(seed);
        let skin = skin(s, &mut numbers);
        let latent = s.div_ceil(3);
        let mix = numbers.matrix(latent, s);
        let frames: Vec<Vec<f64>> = (0..200)
            .map(|_| {
                let own = numbers.list(latent);
                let of = |j| (0..latent).map(|l| own[l] * mix[(l, j)]).sum::<f64>();
                (0..s).map(|j| (0.3 + 0.5 * of(j)).clamp(0.0, 1.0)).collect()
            })
            .collect();
        let pairs = match s >= 4 {
            true => Pairs { mirrored: vec![[0, 1]], cancelling: vec![[2, 3]] },
            false => Pairs::default(),
        };
        Self::of(skin, learned(&frames, vec![[0.0, 1.0]; s], &pairs, 0.01))
    }

    /// Bakes a face and reads it back, rounded to single precision.
    pub(crate) fn of(skin: SkinModel, prior: PriorModel) -> Self {
        let skin = SkinModel { influences: Vec::new(), ..skin };
        let model = FileModel { skins: vec![skin], priors: vec![prior], ..FileModel::default() };
        let file = model.bake().unwrap();
        let loaded = Model::from_bytes(&file).unwrap();
        let skin = SkinModel::from_file(&loaded.first::<Skin>().unwrap());
        let prior = PriorModel::from_file(&loaded.first::<Prior>().unwrap(), 0);
        Self { file, skin, prior }
    }

    pub(crate) fn shape_len(&self) -> usize {
        self.prior.shape_len()
    }

    /// Runs a job on weights.
    pub(crate) fn solve(
        &self,
        pins: &[Pin],
        weights: &[f64],
        set: impl Fn(&mut PinJob<'_>),
    ) -> Result<(Vec<f64>, Edit), CallError> {
        let mut scratch = self.scratch(pins.len());
        self.solve_in(&mut scratch, pins, weights, set)
    }

    /// Makes scratch for a number of pins.
    pub(crate) fn scratch(&self, pins: usize) -> Vec<f64> {
        let model = Model::from_bytes(&self.file).unwrap();
        vec![f64::NAN; model.first::<Prior>().unwrap().counts().pin_scratch_len(3 * pins)]
    }

    pub(crate) fn solve_in(
        &self,
        scratch: &mut [f64],
        pins: &[Pin],
        weights: &[f64],
        set: impl Fn(&mut PinJob<'_>),
    ) -> Result<(Vec<f64>, Edit), CallError> {
        let model = Model::from_bytes(&self.file).unwrap();
        let (prior, skin): (Prior<'_>, Skin<'_>) =
            (model.first::<Prior>().unwrap(), model.first::<Skin>().unwrap());
        let mut list = Pins::<32>::new();
        for pin in pins {
            list.add(*pin)?;
        }
        let mut job = PinJob::new(prior, skin, list.list());
        job.is_bounded = false;
        set(&mut job);
        let mut weights: Vec<f32> = weights.iter().map(|w| *w as f32).collect();
        let edit = job.run(scratch, &mut weights)?;
        Ok((weights.into_iter().map(f64::from).collect(), edit))
    }

    /// Applies weights to all vertices at rest.
    pub(crate) fn moved(&self, weights: &[f64]) -> Vec<[f64; 3]> {
        let mut out = self.skin.rest_positions.clone();
        for (weight, deltas) in weights.iter().zip(&self.skin.shapes.deltas) {
            for (x, u) in out.as_flattened_mut().iter_mut().zip(deltas.as_flattened()) {
                *x += weight * u;
            }
        }
        out
    }

    /// Returns the rows of pins at rest: B, and the values at weights of 0.
    pub(crate) fn rows(&self, pins: &[Pin]) -> (Mat<f64>, Vec<f64>) {
        let all: Vec<(usize, [f32; 4])> = pins
            .iter()
            .flat_map(|pin| pin.rows.iter().map(|row| (pin.vertex as usize, *row)))
            .filter(|(_, [x, y, z, _])| [*x, *y, *z] != [0.0; 3])
            .collect();
        let look = |row: [f32; 4], x: [f64; 3]| -> f64 {
            (0..3).map(|i| f64::from(row[i]) * x[i]).sum::<f64>()
        };
        let b = Mat::from_fn(all.len(), self.shape_len(), |i, j| {
            look(all[i].1, self.skin.shapes.deltas[j][all[i].0])
        });
        let rest =
            all.iter().map(|(v, row)| look(*row, self.skin.rest_positions[*v]) + f64::from(row[3]));
        (b, rest.collect())
    }
}

/// Makes a mesh with shapes.
pub(crate) fn skin(s: usize, numbers: &mut Numbers) -> SkinModel {
    let positions: Vec<[f64; 3]> =
        (0..VERTICES).map(|_| [numbers.next(), numbers.next(), numbers.next()]).collect();
    let deltas = (0..s)
        .map(|shape| {
            let moved = |v: usize| (v + 17 * shape) % (VERTICES - 1) < 60 && v < VERTICES - 1;
            let of = |v| if moved(v) { [(); 3].map(|()| numbers.next()) } else { [0.0; 3] };
            (0..VERTICES).map(of).collect()
        })
        .collect();
    SkinModel {
        name: "face".to_owned(),
        envelope: None,
        rest_normals: vec![[0.0, 0.0, 1.0]; VERTICES],
        rest_positions: positions,
        rest_tangents: None,
        influences: Vec::new(),
        tangent_coefficients: None,
        normal_errors: None,
        ranges: Vec::new(),
        shapes: Shapes {
            names: (0..s).map(|shape| format!("shape {shape}")).collect(),
            deltas,
            slopes: vec![vec![[0.0; 2]; VERTICES]; s],
            ..Shapes::default()
        },
    }
}

/// Returns the targets of pins.
pub(crate) fn targets(pins: &[Pin]) -> Vec<f64> {
    let looks = |row: &[f32; 4]| row[..3] != [0.0; 3];
    let of = |pin: &Pin| {
        let each: Vec<(f32, [f32; 4])> = pin.target.into_iter().zip(pin.rows).collect();
        each.into_iter()
            .filter(|(_, row)| looks(row))
            .map(|(x, _)| f64::from(x))
            .collect::<Vec<_>>()
    };
    pins.iter().flat_map(of).collect()
}

/// Solves the dual form: `anchor + Σ Bᵀ (B Σ Bᵀ + N)⁻¹ (target - rest - B anchor)`, of k x k
/// (METHOD §5.1).
pub(crate) fn dual(
    covariance: &Mat<f64>,
    b: &Mat<f64>,
    noise: &[f64],
    missing: &[f64],
    anchor: &[f64],
) -> Vec<f64> {
    let k = b.nrows();
    let noise = Mat::from_fn(k, k, |i, j| if i == j { noise[i] } else { 0.0 });
    let kernel = b * covariance * b.transpose() + noise;
    let own = Mat::from_fn(k, 1, |i, _| {
        missing[i] - (0..anchor.len()).map(|j| b[(i, j)] * anchor[j]).sum::<f64>()
    });
    let step = covariance * b.transpose() * kernel.partial_piv_lu().solve(own);
    anchor.iter().enumerate().map(|(i, a)| a + step[(i, 0)]).collect()
}

/// Solves a square system with a symmetric matrix.
pub(crate) fn solved(matrix: &Mat<f64>, right: &[f64]) -> Vec<f64> {
    let right = Mat::from_fn(right.len(), 1, |i, _| right[i]);
    let x = matrix.llt(Side::Lower).unwrap().solve(right);
    (0..x.nrows()).map(|i| x[(i, 0)]).collect()
}

/// Computes Σ⁻¹.
pub(crate) fn inverse(matrix: &Mat<f64>) -> Mat<f64> {
    matrix.llt(Side::Lower).unwrap().inverse()
}

/// Returns the largest difference between two lists, relative to the largest number of the second.
pub(crate) fn apart(a: &[f64], b: &[f64]) -> f64 {
    assert!(a.len() == b.len() && !a.is_empty());
    let scale = b.iter().fold(1e-300, |most: f64, x| most.max(x.abs()));
    let each = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    // NaN counts as an infinite difference.
    each.fold(0.0, |most: f64, x| if x <= most { most } else { x }) / scale
}

/// The pins of these tests: one in space, one of two coordinates, one on a screen, at places that
/// no weights reach.
pub(crate) fn three() -> Vec<Pin> {
    let screen = [[0.8, 0.1, 0.0, 0.3], [0.0, 0.9, -0.2, -0.1]];
    vec![
        Pin::new(3, [0.4, -0.2, 0.1]),
        Pin::new(70, [0.2, 0.5, -0.3]).masked([true, false, true]).with_stiffness(2.5),
        Pin::on_screen(40, screen, [0.6, -0.1]),
    ]
}

/// Returns the noise of each scalar of the pins: the diagonal of N.
pub(crate) fn noise(pins: &[Pin], beta: f64) -> Vec<f64> {
    let looks = |pin: &Pin| pin.rows.iter().filter(|row| row[..3] != [0.0; 3]).count();
    let of = |pin: &Pin| vec![beta / f64::from(pin.stiffness); looks(pin)];
    pins.iter().flat_map(of).collect()
}

/// Sorts pins in the order of a list, so that rows have the same order.
pub(crate) fn sorted(mut pins: Vec<Pin>) -> Vec<Pin> {
    pins.sort_by_key(|pin| pin.vertex);
    pins
}

/// Draws weights of a face within its bounds.
pub(crate) fn weights(s: usize, seed: u64) -> Vec<f64> {
    Numbers::new(seed).list(s).iter().map(|x| f64::from((0.5 + 0.5 * x) as f32)).collect()
}

/// Both anchors.
pub(crate) const ANCHORS: [Anchor; 2] = [Anchor::Current, Anchor::Mean];
