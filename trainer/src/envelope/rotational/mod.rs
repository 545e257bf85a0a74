//! Enveloping as published (S3): key gradients by rotational regression, vertices by a reduced
//! Poisson reconstruction, refined on the training meshes.

pub mod basis;
pub mod choose;
pub mod full;
pub mod gradient;
pub mod keys;
pub mod merge;
pub mod poisson;
pub mod predictor;
pub mod proxies;
pub mod reduce;
pub mod refine;
pub mod rotation;
pub mod scale_shear;
pub mod surface;
pub mod training;
pub mod validation;

use super::blend::Weights;
use super::motion::Poses;
use super::{FitError, weights};
use crate::bake::{EnvelopeParts, Key, Reconstruction};
use crate::examples::Examples;
use crate::progress::Progress;
use choose::{Candidates, Choice, Trial};
use faer::Mat;
use nalgebra::Matrix3;
use predictor::{GradientPredictor, predict_stacked};
use proxies::{CountTrial, ProxyCount};
use rayon::prelude::*;
use reduce::{Reduced, Reduction};
use refine::{Projection, Regression};
use serde::Serialize;
use sinew_runtime::format::Certificate;
use surface::Surface;
use training::Training;
use validation::{Targets, Validation};

/// Names of a fit's steps, in order.
pub const STEPS: [&str; 9] = [
    "LBS weights",
    "trajectory basis",
    "merging triangles",
    proxies::STEP,
    keys::STEP,
    "cross-validation",
    "near-rigid vertices",
    "refinement",
    "key predictors",
];

/// What a fit is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Options {
    /// P, or the error that decides it.
    pub proxies: ProxyCount,
    /// K, the most proxies a vertex follows.
    pub influences: usize,
    /// Whether c1 and c2 may be refined on the training meshes; S3 as published does not.
    pub refine: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self { proxies: ProxyCount::Fixed(40), influences: 4, refine: true }
    }
}

/// A fitted envelope of P proxies, in f64.
pub struct Rotational {
    /// α of each vertex on the proxies.
    pub weights: Weights,
    /// The key predictors, P.
    pub keys: Vec<GradientPredictor>,
    /// c1 and c2.
    pub reduced: Reduced,
    /// How it was fitted.
    pub report: Report,
}

/// What a fit did and measured; errors are RMS, as shares of the rest diagonal.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Dimensions of the trajectory basis.
    pub basis_rank: usize,
    /// What the basis leaves out.
    pub basis_residual: f64,
    /// 4-influence LBS on the training frames.
    pub lbs_rms: f64,
    /// Every number of proxies that was tried.
    pub proxy_counts: Vec<CountTrial>,
    /// The proxies' true maps on the training frames.
    pub proxy_rms: f64,
    /// The edges under the keys' true gradients on the training frames.
    pub key_rms: f64,
    /// The joints that each key follows, and how every other joint would have done.
    pub keys: Vec<KeyChoice>,
    /// The predicted envelope on the training frames.
    pub training_rms: f64,
    /// The contiguous folds, as ranges of the training frames.
    pub folds: Vec<std::ops::Range<usize>>,
    /// Every candidate of F, γ, μ and the refinement, and its cross-validated error.
    pub trials: Vec<Trial>,
    /// The candidate taken.
    pub choice: Choice,
    /// Its cross-validated error.
    pub validated_rms: f64,
    /// Condition number of the reduced system.
    pub condition: f64,
    /// Largest distance of a vertex of F from its LBS position on the training frames.
    pub near_rigid_deviation: f64,
    /// Largest |θ_j| in the training poses, J values in radians.
    pub angle_ranges: Vec<f64>,
}

/// Which joints a key follows.
#[derive(Clone, Debug, Serialize)]
pub struct KeyChoice {
    /// b.
    pub joint: usize,
    /// c.
    pub residual_joint: Option<usize>,
    /// Σ|R - R_pred|² of each joint as b, J.
    pub errors: Vec<f64>,
    /// Σ|R - R_pred|² of each joint as c, J; b's own is that without c.
    pub residual_errors: Vec<f64>,
}

impl KeyChoice {
    fn new(predictor: &GradientPredictor) -> Self {
        let rotation = &predictor.rotation;
        Self {
            joint: rotation.joint,
            residual_joint: rotation.residual.map(|(joint, _)| joint),
            errors: rotation.errors.clone(),
            residual_errors: rotation.residual_errors.clone(),
        }
    }
}

/// |θ| beyond which a joint comes near the seam of its rotation vector at π.
const SEAM: f64 = 0.9 * std::f64::consts::PI;

impl Report {
    /// Lists the joints that turn so far from their parent in training that the regression on
    /// their rotation vector, which jumps at a half turn, cannot be trusted there (METHOD §1.4).
    pub fn joints_near_the_seam(&self) -> impl Iterator<Item = usize> + '_ {
        self.angle_ranges.iter().enumerate().filter(|(_, range)| **range > SEAM).map(|(j, _)| j)
    }
}

/// Fits an envelope to the training frames of the examples; no other frame is read.
///
/// # Errors
/// [`FitError::TooFewPoses`], [`FitError::NoTriangles`], [`FitError::MaxError`],
/// [`FitError::Singular`].
pub fn fit(
    examples: &Examples,
    options: &Options,
    progress: &dyn Progress,
) -> Result<Rotational, FitError> {
    let Training { unit, centre, rest, triangles, poses, trajectories: moved } =
        Training::new(examples)?;
    let rest = &rest;

    progress.step("LBS weights", 1);
    let (joints, lbs_errors) = weights::fit(rest, &moved, &poses, weights::BASELINE_INFLUENCES);
    progress.step("trajectory basis", 1);
    let basis = basis::basis(&moved);
    let (basis_rank, basis_residual) = (basis.vectors.ncols(), basis.residual);
    let (surface, basis) = Surface::new(rest, triangles, &moved, basis);
    progress.step("merging triangles", surface.triangles.len());
    let tree = merge::MergeTree::build(&surface, || progress.advance(1));
    let followed = basis.transpose() * joint_maps(&joints, &poses);
    let proxies = proxies::fit(&surface, &tree, &followed, options, progress)?;
    let keys = keys::fit(&surface, &proxies, options.influences, progress);
    let sequences: Vec<_> = (0..keys.len()).map(|l| keys.sequence(l, &basis)).collect();

    let parents = &examples.skeleton.parents;
    let targets = Targets { rest, weights: &proxies.weights, trajectories: &moved };
    let validation = Validation::new(&targets, &poses, parents, &sequences, progress);
    let projection = Projection::new(&targets, proxies.len());
    let candidates = Candidates {
        reduction: Reduction {
            rest,
            triangles: &surface.triangles,
            proxies: &proxies.weights,
            keys: &keys.weights,
            joints: &joints,
            proxy_len: proxies.len(),
            joint_len: examples.joint_len(),
            fixed: &[],
            anchors: None,
        },
        lbs_errors: &lbs_errors,
        validation: &validation,
        projection: options.refine.then_some(&projection),
    };
    let (chosen, trials) = candidates.choose(progress)?;
    let choice = chosen.choice;

    progress.step("key predictors", 1);
    let predictors: Vec<_> =
        sequences.par_iter().map(|d| GradientPredictor::fit(&poses, parents, d)).collect();
    let predicted = predict_stacked(&predictors, &poses);
    let fixed = choose::near_rigid(&lbs_errors, choice.near_rigid_fraction);
    let system = Reduction { fixed: &fixed, anchors: Some(choice.anchors), ..candidates.reduction };
    let mut reduced = system.run().ok_or(FitError::Singular)?;
    if let Some(strength) = choice.refinement {
        let residual = projection.residual(&reduced.palette(&predicted, &poses));
        let regression = Regression::new(&predicted, &poses, &residual, &(0..0));
        reduced = regression.refine(&reduced, strength);
    }

    let maps = reduced.palette(&predicted, &poses);
    let lbs = (&joints, &poses.stacked());
    let report = Report {
        basis_rank,
        basis_residual,
        lbs_rms: Targets { weights: &joints, ..targets }.rms(lbs.1),
        proxy_counts: proxies.trials,
        proxy_rms: proxies.rms,
        key_rms: keys.rms,
        keys: predictors.iter().map(KeyChoice::new).collect(),
        training_rms: targets.rms(&maps),
        folds: validation::folds(poses.len()),
        validated_rms: chosen.rms,
        trials,
        choice,
        condition: system.equations().condition(),
        near_rigid_deviation: validation::largest_distance(
            rest,
            (&proxies.weights, &maps),
            lbs,
            &fixed,
        ),
        angle_ranges: poses.angle_ranges(),
    };
    let reduced = reduced.from_units_of(unit).from_centre(centre, poses.root());
    Ok(Rotational { report, weights: proxies.weights, keys: predictors, reduced })
}

/// Stacks the maps of the joints that some vertex follows: 3n x 4 per joint.
fn joint_maps(joints: &Weights, poses: &Poses) -> Mat<f64> {
    let mut used = vec![false; poses.joint_len()];
    (0..joints.len()).flat_map(|v| joints.of(v)).for_each(|(joint, _)| used[joint] = true);
    let followed: Vec<usize> = (0..used.len()).filter(|&joint| used[joint]).collect();
    let stacked = poses.stacked();
    Mat::from_fn(stacked.nrows(), 4 * followed.len(), |row, column| {
        stacked[(row, 4 * followed[column / 4] + column % 4)]
    })
}

impl Rotational {
    /// Gathers what a file holds of the envelope.
    pub fn parts(&self, examples: &Examples) -> EnvelopeParts {
        let (skeleton, diagonal) = (&examples.skeleton, examples.diagonal());
        let rows = |m: &Matrix3<f64>| [0, 1, 2].map(|r| [m[(r, 0)], m[(r, 1)], m[(r, 2)]]);
        let key = |key: &GradientPredictor| Key {
            joint: key.rotation.joint,
            twist: rows(&key.rotation.twist),
            residual: key.rotation.residual.map(|(joint, twist)| (joint, rows(&twist))),
            shear: std::array::from_fn(|r| std::array::from_fn(|c| key.shear[(r, c)])),
        };
        let row_major = |m: &Mat<f64>| m.row_iter().flat_map(|row| row.iter()).copied().collect();
        EnvelopeParts {
            name: "skin".to_owned(),
            joint_names: skeleton.names.clone(),
            parents: skeleton.parents.clone(),
            root: skeleton.root(),
            rest_frames: skeleton.rest.clone(),
            rest_positions: examples.rest.clone(),
            rest_normals: examples.rest_normals(),
            rest_tangents: examples.rest_tangents(),
            influences: (0..self.weights.len()).map(|v| self.weights.of(v).collect()).collect(),
            reconstruction: Some(Reconstruction {
                keys: self.keys.iter().map(key).collect(),
                c1: row_major(&self.reduced.c1),
                c2: row_major(&self.reduced.c2),
            }),
            groups: Vec::new(),
            pose_ranges: self.report.angle_ranges.clone(),
            certificate: Certificate {
                diagonal: diagonal as f32,
                training_rms: (diagonal * self.report.training_rms) as f32,
                cross_validated_rms: (diagonal * self.report.validated_rms) as f32,
                lbs_training_rms: (diagonal * self.report.lbs_rms) as f32,
                correction_error: 0.0,
            },
        }
    }
}
