//! Models under test, with their oracles and poses.

use crate::backend::{Loaded, Poses};
use crate::models;
use crate::poses::{POSES, Pose, poses};
use sinew_runtime::Matrix3x4;
use sinew_trainer::envelope::model::{EnvelopeModel, SkinModel};

/// Number of poses of a secondary model: ten rounds of every kind of rigid pose.
pub const FEWER_POSES: usize = 140;

/// A model under test.
pub struct Subject<'a> {
    /// Name of the model.
    pub name: &'static str,
    /// The model.
    pub loaded: Loaded<'a>,
    /// Oracle of the envelope.
    pub oracle: EnvelopeModel,
    /// Oracle of the skin.
    pub skin: SkinModel,
    /// Poses of the model.
    pub poses: Vec<Pose>,
    /// Matrices of all poses, J each.
    pub transforms: Vec<Matrix3x4>,
    /// Curves of all poses, C each.
    pub curves: Vec<f32>,
}

impl<'a> Subject<'a> {
    /// Loads a model and draws poses.
    ///
    /// # Panics
    /// If the bytes are not a model with an envelope and a skin.
    pub fn new(name: &'static str, bytes: &'a [u8], pose_len: usize) -> Self {
        let loaded = Loaded::new(bytes);
        let poses = poses(&loaded.envelope, pose_len);
        Self::with_poses(name, loaded, poses)
    }

    /// Takes any poses of a model.
    pub fn with_poses(name: &'static str, loaded: Loaded<'a>, poses: Vec<Pose>) -> Self {
        let transforms = poses.iter().flat_map(|pose| pose.transforms.iter().copied()).collect();
        let curves = poses.iter().flat_map(|pose| pose.curves.iter().copied()).collect();
        let (oracle, skin) = loaded.widened();
        Self { name, oracle, skin, loaded, poses, transforms, curves }
    }

    /// Returns the poses as a backend takes them.
    pub fn inputs(&self) -> Poses<'_> {
        let Self { transforms, curves, .. } = self;
        Poses { len: self.poses.len(), joints: transforms, curves }
    }

    /// Describes the subject for messages.
    pub fn described(&self) -> String {
        let envelope = &self.loaded.envelope;
        format!("{}, {:?}, {envelope:?}", self.name, envelope.predictor())
    }

    /// Keeps the first poses.
    #[must_use]
    pub fn shortened(mut self, pose_len: usize) -> Self {
        self.poses.truncate(pose_len);
        self.transforms.truncate(self.poses.len() * self.loaded.envelope.joint_len());
        self.curves.truncate(self.poses.len() * self.loaded.envelope.curve_len());
        self
    }
}

/// Returns the trained character and, if its data is present, the real arm, for every predictor.
pub fn characters() -> Vec<Subject<'static>> {
    let arms = models::arm().into_iter().flatten();
    let arms = arms.map(|bytes| Subject::new("arm", bytes, FEWER_POSES));
    trained(POSES).into_iter().chain(arms).collect()
}

/// Returns the trained character for every predictor, and one with tangent coefficients, with
/// `pose_len` poses each.
pub fn trained(pose_len: usize) -> Vec<Subject<'static>> {
    let trained = models::trained().iter().map(|bytes| Subject::new("demo", bytes, pose_len));
    trained.chain([Subject::new("demo with coefficients", models::turned(), pose_len)]).collect()
}

/// Returns a random model of every shape, with `pose_len` poses each; some have no vertices.
pub fn shapes(pose_len: usize) -> impl Iterator<Item = Subject<'static>> {
    models::shapes().iter().map(move |bytes| Subject::new("random", bytes, pose_len))
}

/// Returns the random models that have vertices.
pub fn random() -> Vec<Subject<'static>> {
    let has_vertices = |own: &Subject<'_>| own.loaded.skin.vertex_len() > 0;
    shapes(FEWER_POSES).filter(has_vertices).collect()
}
