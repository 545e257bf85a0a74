//! The interface of a backend: every stage for a batch of poses.

use crate::compare::{POISON, poisoned};
use crate::filters::FilterSubject;
use crate::kernels::KernelSubject;
use crate::shapes::ShapeSubject;
use sinew_gpu::headless::HeadlessError;
use sinew_gpu::layout::{Attribute, LayoutError, ShapesBatch, SkinBatch, Stage};
use sinew_runtime::envelope::STRAIN_LEN;
use sinew_runtime::{CallError, Envelope, Matrix3x4, Model, Skin};
use sinew_trainer::envelope::model::{EnvelopeModel, SkinModel};
use sinew_trainer::regression::arithmetic::Arithmetic;
use thiserror::Error;

/// A file with its envelope and its skin.
#[derive(Clone, Copy, Debug)]
pub struct Loaded<'a> {
    /// The file.
    pub model: Model<&'a [u8]>,
    /// Its envelope.
    pub envelope: Envelope<'a>,
    /// The skin that follows the envelope.
    pub skin: Skin<'a>,
}

impl<'a> Loaded<'a> {
    /// Loads a model.
    ///
    /// # Panics
    /// If the bytes are not a model with an envelope and a skin.
    pub fn new(bytes: &'a [u8]) -> Self {
        let model = Model::from_bytes(bytes).expect("a baked model loads");
        let envelope = model.first::<Envelope>().and_then(|envelope| envelope.layout().open(bytes));
        let skin = model.first::<Skin>().and_then(|skin| skin.layout().open(bytes));
        let (envelope, skin) =
            (envelope.expect("it holds an envelope"), skin.expect("it holds a skin"));
        Self { model, envelope, skin }
    }

    /// Converts envelope and skin to f64: the oracles.
    pub fn widened(&self) -> (EnvelopeModel, SkinModel) {
        (EnvelopeModel::from_file(&self.envelope), SkinModel::from_file(&self.skin))
    }
}

/// Poses of n instances, instance after instance.
#[derive(Clone, Copy, Debug)]
pub struct Poses<'a> {
    /// Number of instances, n. A model without joints does not show it in `joints`.
    pub len: usize,
    /// Skinning matrices, n J.
    pub joints: &'a [Matrix3x4],
    /// Values of the curves, n C.
    pub curves: &'a [f32],
}

impl<'a> Poses<'a> {
    /// Returns the pose of instance i.
    #[must_use]
    pub fn one(self, i: usize) -> Self {
        let Self { len, joints, curves } = self;
        Self { len: 1, joints: part(joints, len, i), curves: part(curves, len, i) }
    }
}

/// An implementation of the stages. All inputs and outputs are instance after instance. Outputs come
/// poisoned, and a backend must write every float.
pub trait Backend {
    /// Returns the precision of the backend's arithmetic.
    fn arithmetic(&self) -> Arithmetic;

    /// Whether the backend evaluates a stage of an envelope and its skin alone.
    fn has(&self, loaded: &Loaded<'_>, stage: Stage) -> bool;

    /// Evaluates the rotations and the strains of joints that stretch.
    ///
    /// # Errors
    /// [`Failure`]
    fn polar(&self, loaded: &Loaded<'_>, poses: Poses<'_>, out: &mut Split) -> Result<(), Failure>;

    /// Evaluates the joints' relative transforms, their rotations and the keys' gradients.
    ///
    /// # Errors
    /// [`Failure`]
    fn gradients(
        &self,
        loaded: &Loaded<'_>,
        poses: Poses<'_>,
        split: &Split,
        out: &mut Gradients,
    ) -> Result<(), Failure>;

    /// Evaluates `t = c1 d + c2 q`, moved by the root's transform.
    ///
    /// # Errors
    /// [`Failure`]
    fn palette(
        &self,
        loaded: &Loaded<'_>,
        poses: Poses<'_>,
        input: &Gradients,
        out_palettes: &mut [Matrix3x4],
    ) -> Result<(), Failure>;

    /// Copies the joints' transforms, and gives each helper the transform of its dominant joint.
    ///
    /// # Errors
    /// [`Failure`]
    fn joints(
        &self,
        loaded: &Loaded<'_>,
        poses: Poses<'_>,
        out_palettes: &mut [Matrix3x4],
    ) -> Result<(), Failure>;

    /// Evaluates the features, all of an instance in the order of a file. The strains are copied
    /// from `split`.
    ///
    /// # Errors
    /// [`Failure`]
    fn features(
        &self,
        loaded: &Loaded<'_>,
        poses: Poses<'_>,
        split: &Split,
        out_features: &mut [f32],
    ) -> Result<(), Failure>;

    /// Adds the results of the kernel maps to the palettes, which hold the base.
    ///
    /// # Errors
    /// [`Failure`]
    fn correction(
        &self,
        loaded: &Loaded<'_>,
        poses: Poses<'_>,
        features: &[f32],
        out_palettes: &mut [Matrix3x4],
        out_confidences: &mut [f32],
    ) -> Result<(), Failure>;

    /// Evaluates the confidences of a rotational model from n J rotations.
    ///
    /// # Errors
    /// [`Failure`]
    fn confidence(
        &self,
        loaded: &Loaded<'_>,
        poses: Poses<'_>,
        rotations: &[[f32; 3]],
        split: &Split,
        out_confidences: &mut [f32],
    ) -> Result<(), Failure>;

    /// Skins vertices by n palettes; leaves all floats outside the attributes unchanged.
    ///
    /// # Errors
    /// [`Failure`]
    fn skin(
        &self,
        loaded: &Loaded<'_>,
        palettes: &[Matrix3x4],
        skin: &SkinBatch,
        out: &mut [f32],
    ) -> Result<(), Failure>;

    /// Evaluates n queries of a kernel: outputs and confidences.
    ///
    /// # Errors
    /// [`Failure`]
    fn kernel(
        &self,
        subject: &KernelSubject<'_>,
        queries: &[f32],
        out: &mut [f32],
        out_confidences: &mut [f32],
    ) -> Result<(), Failure>;

    /// Evaluates the rest meshes of n faces from their weights; leaves all floats outside the
    /// attributes unchanged.
    ///
    /// # Errors
    /// [`Failure`]
    fn shapes(
        &self,
        subject: &ShapeSubject<'_>,
        batch: &ShapesBatch,
        out: &mut [f32],
    ) -> Result<(), Failure>;

    /// Makes the signals of a subject finer.
    ///
    /// # Errors
    /// [`Failure`]
    fn filter(&self, subject: &FilterSubject<'_>, out: &mut [f32]) -> Result<(), Failure>;

    /// Evaluates palettes, confidences and skins from poses.
    ///
    /// # Errors
    /// [`Failure`]
    fn whole(
        &self,
        loaded: &Loaded<'_>,
        poses: Poses<'_>,
        skin: &SkinBatch,
        out: &mut Whole,
    ) -> Result<(), Failure>;
}

/// Reasons why a backend has no result.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Failure {
    /// The runtime refuses the call.
    #[error(transparent)]
    Call(#[from] CallError),
    /// The device reports an error.
    #[error(transparent)]
    Device(#[from] HeadlessError),
    /// The batch cannot be evaluated on the device.
    #[error(transparent)]
    Layout(#[from] LayoutError),
    /// A float that the stage must not write has changed.
    #[error("{stage} has written to float {float} of {resource}, which is not its own")]
    Touched {
        /// The stage.
        stage: &'static str,
        /// The buffer.
        resource: &'static str,
        /// Index of the float in the buffer.
        float: usize,
    },
}

/// Outputs of stage polar, which later stages read; empty if no joint stretches.
#[derive(Clone, Debug)]
pub struct Split {
    /// Rotations as three columns, J an instance.
    pub turns: Vec<[[f32; 3]; 3]>,
    /// Strains, J an instance.
    pub strains: Vec<[f32; STRAIN_LEN]>,
}

impl Split {
    /// Returns poisoned outputs for n instances.
    pub fn poisoned(envelope: &Envelope<'_>, n: usize) -> Self {
        let len = if envelope.stretches() { n * envelope.joint_len() } else { 0 };
        Self { turns: vec![[[POISON; 3]; 3]; len], strains: poisoned(len) }
    }
}

/// Outputs of stage gradients, which stage palette reads.
#[derive(Clone, Debug)]
pub struct Gradients {
    /// The stack q, 4J columns an instance.
    pub relative: Vec<[f32; 3]>,
    /// θ, J an instance.
    pub rotations: Vec<[f32; 3]>,
    /// The stack d, 3P columns an instance.
    pub gradients: Vec<[f32; 3]>,
}

impl Gradients {
    /// Returns poisoned outputs for n instances.
    pub fn poisoned(envelope: &Envelope<'_>, n: usize) -> Self {
        Self {
            relative: poisoned(4 * n * envelope.joint_len()),
            rotations: poisoned(n * envelope.joint_len()),
            gradients: poisoned(3 * n * envelope.proxy_len()),
        }
    }
}

/// Returns poisoned floats for the skins of n instances, with some floats behind that nothing may
/// change.
pub fn poisoned_out(skin: &SkinBatch, n: usize) -> Vec<f32> {
    poisoned_attributes(&attributes(skin), skin.vertices.len(), n)
}

/// Returns poisoned floats for attributes of `vertex_len` vertices and n instances, with some
/// floats behind. Each attribute comes with its floats a vertex.
pub fn poisoned_attributes(
    attributes: &[(Option<Attribute>, usize)],
    vertex_len: usize,
    n: usize,
) -> Vec<f32> {
    let last = vertex_len.checked_sub(1);
    let ends = attributes.iter().filter_map(|(attribute, own)| {
        let Attribute { offset, stride, instance_stride } = (*attribute)?;
        Some(offset + last? * stride + own + n.saturating_sub(1) * instance_stride)
    });
    vec![POISON; ends.max().unwrap_or(0) + 5]
}

/// Lists the attributes of a skin, each with its floats a vertex.
pub fn attributes(skin: &SkinBatch) -> [(Option<Attribute>, usize); 3] {
    [(skin.positions, 3), (skin.normals, 3), (skin.tangents, 4)]
}

/// Final outputs of an envelope and its skin.
#[derive(Clone, Debug)]
pub struct Whole {
    /// Palettes.
    pub palettes: Vec<Matrix3x4>,
    /// Confidences, n.
    pub confidences: Vec<f32>,
    /// Skins.
    pub skin: Vec<f32>,
}

impl Whole {
    /// Returns poisoned outputs for n instances.
    pub fn poisoned(envelope: &Envelope<'_>, skin: &SkinBatch, n: usize) -> Self {
        Self {
            palettes: poisoned_transforms(n * envelope.palette_len()),
            confidences: vec![POISON; n],
            skin: poisoned_out(skin, n),
        }
    }
}

/// Returns poisoned transforms, which a backend must write.
pub fn poisoned_transforms(len: usize) -> Vec<Matrix3x4> {
    vec![[[POISON; 4]; 3]; len]
}

/// Returns instance i's part of a list that holds equally many elements for each of n instances.
pub fn part<T>(list: &[T], n: usize, i: usize) -> &[T] {
    let len = list.len() / n;
    &list[i * len..][..len]
}

/// Lists the floats of transforms, row by row.
pub fn floats(transforms: &[Matrix3x4]) -> &[f32] {
    transforms.as_flattened().as_flattened()
}
