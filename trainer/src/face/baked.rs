//! A face as its file holds it, evaluated by the runtime.

use super::basis::diagonal;
use super::error::FaceError;
use sinew_runtime::prior::{Anchor, Edit, Pin, PinJob, Pins, Prior, Temporal};
use sinew_runtime::skin::{Output, ShapesJob, cells};
use sinew_runtime::{CallError, Model, Skin};

/// Most pins of a command.
pub const PINS_MAX: usize = 256;

/// A face of V vertices and S shapes.
#[derive(Clone, Copy)]
pub struct BakedFace<'a> {
    /// Its skin.
    pub skin: Skin<'a>,
    /// Its prior.
    pub prior: Prior<'a>,
}

/// A face with weights.
pub struct Shaped {
    /// Positions, V.
    pub positions: Vec<[f64; 3]>,
    /// Normals of length 1 or 0, V.
    pub normals: Vec<[f64; 3]>,
}

/// What is asked of a solve beside its pins.
#[derive(Clone, Copy, Debug)]
pub struct Terms<'a> {
    /// What is changed as little as pins allow.
    pub anchor: Anchor,
    /// β: the square of the length by which a pin may miss.
    pub beta: f32,
    /// Whether weights stay between the prior's bounds.
    pub is_bounded: bool,
    /// What keeps the weights near those of the frame before.
    pub temporal: Option<Temporal<'a>>,
    /// How much the prior's symmetry counts.
    pub symmetry: f32,
    /// Whether of the pairs that cancel the smaller weight is held at 0.
    pub cancels: bool,
}

impl<'a> BakedFace<'a> {
    /// Finds the first face of a file: a prior, and the skin whose shapes it is of.
    ///
    /// # Errors
    /// [`FaceError::NoFace`]
    pub fn open<B: AsRef<[u8]>>(model: &'a Model<B>) -> Result<Self, FaceError> {
        let prior = model.prior().ok_or(FaceError::NoFace)?;
        let skin = model.skin_of(&prior).ok_or(FaceError::NoFace)?;
        Ok(Self { skin, prior })
    }

    /// Names the shapes.
    pub fn names(&self) -> Vec<String> {
        let name = |shape| self.skin.shape_name(shape).unwrap_or_default().to_owned();
        (0..self.skin.shape_len()).map(name).collect()
    }

    /// Measures the diagonal of the neutral face's box.
    pub fn diagonal(&self) -> f64 {
        let rest = |v| self.skin.rest_position(v).unwrap_or_default().map(f64::from);
        diagonal((0..self.skin.vertex_len()).map(rest))
    }

    /// Gives a vertex's neutral place, and how far each shape moves it.
    pub fn vertex(&self, vertex: usize) -> ([f64; 3], Vec<[f64; 3]>) {
        let rest = self.skin.rest_position(vertex).unwrap_or_default().map(f64::from);
        let mut deltas = vec![[0.0; 3]; self.skin.shape_len()];
        for (shape, delta) in self.skin.deltas_of(vertex) {
            deltas[shape] = delta.map(f64::from);
        }
        (rest, deltas)
    }

    /// Gives the place of a vertex in a face of S weights.
    pub fn place(&self, vertex: usize, weights: &[f64]) -> [f64; 3] {
        let (rest, deltas) = self.vertex(vertex);
        moved(rest, &deltas, weights)
    }

    /// Shapes the whole face.
    ///
    /// # Errors
    /// [`CallError`] of weights that are not S or not finite.
    pub fn shaped(&self, weights: &[f32]) -> Result<Shaped, CallError> {
        let len = self.skin.vertex_len();
        let (mut positions, mut normals) = (vec![[0.0_f32; 3]; len], vec![[0.0_f32; 3]; len]);
        let output = |floats| Some(Output { floats: cells(floats), stride: 3 });
        ShapesJob {
            skin: self.skin,
            weights,
            vertices: 0..len,
            positions: output(positions.as_flattened_mut()),
            normals: output(normals.as_flattened_mut()),
            tangents: None,
        }
        .run()?;
        let wide = |all: Vec<[f32; 3]>| all.into_iter().map(|v| v.map(f64::from)).collect();
        Ok(Shaped { positions: wide(positions), normals: wide(normals) })
    }

    /// Solves weights for pins.
    ///
    /// - `scratch`: kept from one solve to the next, so that those with the same pins are fast.
    /// - `weights`: S, changed.
    ///
    /// # Errors
    /// As [`PinJob::run`], and of more pins than [`PINS_MAX`].
    pub fn solve(
        &self,
        pins: &[Pin],
        terms: &Terms<'_>,
        scratch: &mut Vec<f64>,
        weights: &mut [f32],
    ) -> Result<Edit, CallError> {
        let mut list = Pins::<PINS_MAX>::new();
        pins.iter().try_for_each(|pin| list.add(*pin))?;
        let len = self.prior.counts().pin_scratch_len(list.list().scalar_len());
        scratch.resize(scratch.len().max(len), 0.0);
        let Terms { anchor, beta, is_bounded, temporal, symmetry, cancels } = *terms;
        let job = PinJob::new(self.prior, self.skin, list.list());
        PinJob { anchor, beta, is_bounded, temporal, symmetry, cancels, ..job }
            .run(scratch, weights)
    }
}

/// Moves a neutral place by S deltas at S weights.
pub fn moved(rest: [f64; 3], deltas: &[[f64; 3]], weights: &[f64]) -> [f64; 3] {
    [0, 1, 2]
        .map(|axis| rest[axis] + deltas.iter().zip(weights).map(|(u, z)| z * u[axis]).sum::<f64>())
}

impl Terms<'_> {
    /// Those of an artist's edit: from the weights now, between the bounds.
    pub fn edit(prior: &Prior<'_>) -> Self {
        Self {
            anchor: Anchor::Current,
            beta: prior.fit().beta,
            is_bounded: true,
            temporal: None,
            symmetry: 0.0,
            cancels: false,
        }
    }
}
