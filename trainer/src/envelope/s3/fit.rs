//! Fits an envelope by rotational regression: proxies, keys, and the reduced reconstruction.

use super::keys::{GradientPredictor, predict_stacked};
use super::merge::MergeTree;
use super::proxies::CountTrial;
use super::reduce::{Reduced, Reduction};
use super::rotation::KeyChoice;
use super::surface::Surface;
use super::validation::{Refinement, RefinementTrial, Refining, Setting, SettingTrial, Validation};
use super::{Method, RotationalOptions, keys, proxies, published, validation};
use crate::Error;
use crate::envelope::fitted::Fitted;
use crate::envelope::lbs::blend::Weights;
use crate::envelope::lbs::poses::Poses;
use crate::envelope::lbs::projection::Projection;
use crate::envelope::lbs::training::Training;
use crate::numeric::columns;
use crate::progress::Progress;
use faer::Mat;
use nalgebra::Matrix3;
use serde::Serialize;

/// A fitted envelope of P proxies, in training units.
pub struct Rotational {
    /// Weights α of each vertex on the proxies.
    weights: Weights,
    /// Method of the fit: [`Method::Refined`] only if the refinement lowers the cross-validated error.
    pub method: Method,
    /// Predictors of the keys' gradients, P.
    predictors: Vec<GradientPredictor>,
    /// c1 and c2.
    reduced: Reduced,
    /// Proxy maps of all training poses, 3n x 4P; the maps of a fold come from a fit without the fold.
    pub validated: Mat<f64>,
    /// Choices and errors of the fit.
    pub report: RotationalReport,
}

/// Choices and errors of a fit. Errors are RMS, as shares of the rest diagonal.
#[derive(Clone, Debug, Serialize)]
pub struct RotationalReport {
    /// Dimensions of the trajectory basis.
    pub basis_rank: usize,
    /// Error of the projection onto the basis.
    pub basis_residual: f64,
    /// Tried numbers of proxies, and their errors.
    pub proxy_counts: Vec<CountTrial>,
    /// Error of the vertices under the proxies' fitted maps on the training frames.
    pub proxy_rms: f64,
    /// Error of the edges under the keys' fitted gradients on the training frames.
    pub key_rms: f64,
    /// Joints of each key, and the errors of all other joints.
    pub keys: Vec<KeyChoice>,
    /// Tried F, γ and μ, and their cross-validated errors.
    pub trials: Vec<SettingTrial>,
    /// Chosen F, γ and μ.
    pub choice: Setting,
    /// Tried refinements, and their cross-validated errors.
    pub refinements: Vec<RefinementTrial>,
    /// Chosen refinement; `None` if every refinement has a larger error.
    pub refinement: Option<Refinement>,
    /// Condition number of the reduced system.
    pub condition: f64,
    /// Largest distance of a vertex of F from its LBS position on the training frames.
    pub near_rigid_deviation: f64,
}

/// Fits an envelope to the training frames.
///
/// # Errors
/// - No number of proxies reaches the requested error.
/// - Every reduced system is singular.
pub fn fit(
    training: &Training,
    options: &RotationalOptions,
    progress: &dyn Progress,
) -> Result<Rotational, Error> {
    let Training { rest, triangles, poses, trajectories, lbs, .. } = training;
    let parents = &training.skeleton.parents;
    let (joints, lbs_errors) = (&lbs.weights, &lbs.errors);
    progress.step("trajectory basis", 1);
    let basis = training.basis();
    let surface = Surface::new(rest, triangles.clone(), trajectories, basis, training.importance());
    progress.step("merging triangles", surface.triangles.len());
    let tree = MergeTree::build(&surface, || progress.advance(1));
    let mut proxies = match options.method {
        Method::Published => published::fit_proxies(&surface, &tree, options, progress)?,
        _ => {
            let followed = basis.vectors.transpose() * joint_maps(joints, poses);
            proxies::fit(&surface, &tree, &followed, options, progress)?
        }
    };
    proxies.sort_by_joint(joints, poses.joint_len());
    let keys = keys::fit(&surface, &proxies, options.influences, progress);
    let sequences = keys.sequences(&basis.vectors);

    let published = (options.method == Method::Published).then(|| published::setting(lbs_errors));
    let (weights, palette_len) = match &published {
        Some(setting) => {
            let fixed = validation::near_rigid(lbs_errors, setting.near_rigid_fraction);
            let weights = published::fixed_on_joints(&proxies, joints, &fixed);
            (weights, proxies.len() + poses.joint_len())
        }
        None => (proxies.weights.clone(), proxies.len()),
    };
    let targets = training.targets(&weights);
    let predictor = |poses: &Poses, d: &[Matrix3<f64>]| {
        GradientPredictor::fit(poses, parents, d, options.method)
    };
    let projection = Projection::new(&targets, palette_len);
    let keyed = Validation::new(&projection, poses, &sequences, &predictor, progress);
    let reduction = Reduction {
        rest,
        triangles: &surface.triangles,
        proxies: &proxies.weights,
        keys: &keys.weights,
        joints,
        proxy_len: proxies.len(),
        joint_len: poses.joint_len(),
        fixed: &[],
        anchors: None,
    };
    let (choice, trials) = match published {
        Some(setting) => (setting, Vec::new()),
        None => validation::choose_setting(reduction, lbs_errors, &keyed, progress)?,
    };
    let fixed = validation::near_rigid(lbs_errors, choice.near_rigid_fraction);
    let system = Reduction { fixed: &fixed, anchors: Some(choice.anchors), ..reduction };
    let unrefined = system.run().ok_or_else(validation::singular)?;
    let unrefined = if published.is_some() { unrefined.and_joints() } else { unrefined };

    let mut method = if published.is_some() { Method::Published } else { Method::Unrefined };
    let mut validated = keyed.unrefined(&unrefined);
    let (mut predictors, mut reduced) = (keyed.predictors.clone(), unrefined.clone());
    let (mut refinement, mut refinements) = (None, Vec::new());
    if options.method == Method::Refined {
        progress.step("refinement", 1);
        let rigid = keyed.without_shear();
        let [shearing, rigid] = [&keyed, &rigid].map(|keyed| Refining::new(&unrefined, keyed));
        (refinement, refinements) = validation::choose_refinement(&shearing, &rigid);
        if let Some(choice) = &refinement {
            let refining = if choice.shear { &shearing } else { &rigid };
            (method, reduced) = (Method::Refined, refining.refined(choice));
            validated = refining.validated(choice);
            predictors.clone_from(&refining.keyed.predictors);
        }
    }
    let maps = reduced.palette(&predict_stacked(&predictors, poses), poses);
    let report = RotationalReport {
        basis_rank: basis.vectors.ncols(),
        basis_residual: basis.residual,
        proxy_counts: proxies.trials,
        proxy_rms: proxies.rms,
        key_rms: keys.rms,
        keys: keyed.predictors.iter().map(|predictor| predictor.choice.clone()).collect(),
        trials,
        choice,
        refinements,
        refinement,
        condition: system.equations().condition(),
        near_rigid_deviation: validation::largest_distance(
            rest,
            (&weights, &maps),
            (joints, &poses.stacked()),
            &fixed,
        ),
    };
    Ok(Rotational { weights, method, predictors, reduced, validated, report })
}

/// Stacks the maps of the joints that at least one vertex follows, 3n x 4 per joint.
fn joint_maps(joints: &Weights, poses: &Poses) -> Mat<f64> {
    let mut used = vec![false; poses.joint_len()];
    (0..joints.len()).flat_map(|v| joints.of(v)).for_each(|(joint, _)| used[joint] = true);
    let followed: Vec<usize> = (0..used.len()).filter(|&joint| used[joint]).collect();
    columns::some(&poses.stacked(), &columns::of_maps(&followed))
}

impl Rotational {
    /// Returns the fitted envelope.
    pub fn fitted(&self, training: &Training) -> Fitted {
        let reconstruction = published::reconstruction(&self.predictors, &self.reduced);
        Fitted::new(training, self.weights.clone(), Some(reconstruction))
    }
}
