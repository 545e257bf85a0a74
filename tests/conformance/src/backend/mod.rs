//! The stages as every backend offers them: a batch of poses in, outputs for all of them.

mod cpu;

pub use cpu::Cpu;

use crate::compare::{POISON, poisoned};
use sinew_gpu::headless::HeadlessError;
use sinew_gpu::layout::{Attribute, Buffer, LayoutError, Skin, Stage};
use sinew_runtime::{Envelope, EvalError, Matrix3x4, Model};
use sinew_trainer::kernel::arithmetic::Arithmetic;
use thiserror::Error;

/// A file and the envelope in it.
#[derive(Clone, Copy, Debug)]
pub struct Loaded<'a> {
    /// The file.
    pub model: Model<'a>,
    /// Its envelope.
    pub envelope: Envelope<'a>,
}

impl<'a> Loaded<'a> {
    /// Loads a model.
    ///
    /// # Panics
    /// If the bytes are no model with an envelope.
    pub fn new(bytes: &'a [u8]) -> Self {
        let model = Model::from_bytes(bytes).expect("a baked model loads");
        Self { model, envelope: model.envelope().expect("it holds an envelope") }
    }
}

/// An implementation of the stages. `poses` are n J matrices, one instance after the other, as are
/// all inputs and outputs; outputs come poisoned, and every float of them is to be written.
pub trait Backend {
    /// Returns how exactly it computes.
    fn arithmetic(&self) -> Arithmetic;

    /// Whether it evaluates a stage of a model alone.
    fn has(&self, loaded: &Loaded<'_>, stage: Stage) -> bool;

    /// Evaluates the joints' relative maps, their rotations and the keys' gradients.
    ///
    /// # Errors
    /// [`Failure`]
    fn gradients(
        &self,
        loaded: &Loaded<'_>,
        poses: &[Matrix3x4],
        out: &mut Gradients,
    ) -> Result<(), Failure>;

    /// Evaluates `t = c1 d + c2 q`, moved by the root's map.
    ///
    /// # Errors
    /// [`Failure`]
    fn palette(
        &self,
        loaded: &Loaded<'_>,
        poses: &[Matrix3x4],
        input: &Gradients,
        out_palettes: &mut [Matrix3x4],
    ) -> Result<(), Failure>;

    /// Copies the joints, and gives each helper the map of its dominant joint.
    ///
    /// # Errors
    /// [`Failure`]
    fn joints(
        &self,
        loaded: &Loaded<'_>,
        poses: &[Matrix3x4],
        out_palettes: &mut [Matrix3x4],
    ) -> Result<(), Failure>;

    /// Evaluates the joints' features, n J matrices.
    ///
    /// # Errors
    /// [`Failure`]
    fn features(
        &self,
        loaded: &Loaded<'_>,
        poses: &[Matrix3x4],
        out_features: &mut [Matrix3x4],
    ) -> Result<(), Failure>;

    /// Adds what the kernel maps give to the palettes, which hold their base.
    ///
    /// # Errors
    /// [`Failure`]
    fn correction(
        &self,
        loaded: &Loaded<'_>,
        poses: &[Matrix3x4],
        features: &[Matrix3x4],
        out_palettes: &mut [Matrix3x4],
        out_confidences: &mut [f32],
    ) -> Result<(), Failure>;

    /// Evaluates the confidences of a rotational model, of n J rotations.
    ///
    /// # Errors
    /// [`Failure`]
    fn confidence(
        &self,
        loaded: &Loaded<'_>,
        rotations: &[[f32; 3]],
        out_confidences: &mut [f32],
    ) -> Result<(), Failure>;

    /// Skins vertices by n palettes; leaves every float between and beyond the attributes alone.
    ///
    /// # Errors
    /// [`Failure`]
    fn skin(
        &self,
        loaded: &Loaded<'_>,
        palettes: &[Matrix3x4],
        skin: &Skin,
        out: &mut Buffers,
    ) -> Result<(), Failure>;

    /// Goes from poses to palettes, confidences and the skin.
    ///
    /// # Errors
    /// [`Failure`]
    fn whole(
        &self,
        loaded: &Loaded<'_>,
        poses: &[Matrix3x4],
        skin: &Skin,
        out: &mut Whole,
    ) -> Result<(), Failure>;
}

/// Why a backend gives nothing.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Failure {
    /// The runtime refuses.
    #[error(transparent)]
    Eval(#[from] EvalError),
    /// The device refuses.
    #[error(transparent)]
    Device(#[from] HeadlessError),
    /// The batch cannot be evaluated on the device.
    #[error(transparent)]
    Layout(#[from] LayoutError),
    /// A float that is not the stage's to write has changed.
    #[error("{stage} has written to float {float} of {resource}, which is not its own")]
    Touched {
        /// What ran.
        stage: &'static str,
        /// The buffer.
        resource: &'static str,
        /// The float's place in it.
        float: usize,
    },
}

/// What the first stage writes and the second reads.
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
    /// Makes outputs for n instances.
    pub fn poisoned(envelope: &Envelope<'_>, n: usize) -> Self {
        Self {
            relative: poisoned(4 * n * envelope.joint_len()),
            rotations: poisoned(n * envelope.joint_len()),
            gradients: poisoned(3 * n * envelope.proxy_len()),
        }
    }
}

/// The two buffers that skins are written to.
#[derive(Clone, Debug)]
pub struct Buffers {
    /// Buffer A.
    pub a: Vec<f32>,
    /// Buffer B.
    pub b: Vec<f32>,
}

impl Buffers {
    /// Makes buffers for the skins of n instances, with room to spare that nobody may touch.
    pub fn poisoned(skin: &Skin, n: usize) -> Self {
        let mut lens = [5, 5];
        for (attribute, own) in attributes(skin) {
            if let (Some(attribute), Some(last)) = (attribute, skin.vertices.len().checked_sub(1)) {
                let vertex = attribute.offset + last * attribute.stride + own;
                let end = vertex + n.saturating_sub(1) * attribute.instance_stride;
                let len = &mut lens[usize::from(attribute.buffer == Buffer::B)];
                *len = (*len).max(end + 5);
            }
        }
        Self { a: vec![POISON; lens[0]], b: vec![POISON; lens[1]] }
    }
}

/// Lists the attributes of a skin with the floats of each.
pub fn attributes(skin: &Skin) -> [(Option<Attribute>, usize); 3] {
    [(skin.positions, 3), (skin.normals, 3), (skin.tangents, 4)]
}

/// What comes out at the far end.
#[derive(Clone, Debug)]
pub struct Whole {
    /// Palettes.
    pub palettes: Vec<Matrix3x4>,
    /// Confidences, n.
    pub confidences: Vec<f32>,
    /// Skins.
    pub skin: Buffers,
}

impl Whole {
    /// Makes outputs for n instances.
    pub fn poisoned(envelope: &Envelope<'_>, skin: &Skin, n: usize) -> Self {
        Self {
            palettes: poisoned_maps(n * envelope.palette_len()),
            confidences: vec![POISON; n],
            skin: Buffers::poisoned(skin, n),
        }
    }
}

/// Makes maps that a backend must write.
pub fn poisoned_maps(len: usize) -> Vec<Matrix3x4> {
    vec![[[POISON; 4]; 3]; len]
}

/// Returns instance i's part of a list that holds as much for each of n.
pub fn part<T>(list: &[T], n: usize, i: usize) -> &[T] {
    let len = list.len() / n;
    &list[i * len..][..len]
}

/// Lists the floats of maps, row by row.
pub fn floats(maps: &[Matrix3x4]) -> &[f32] {
    maps.as_flattened().as_flattened()
}
