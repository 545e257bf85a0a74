//! A loaded face, evaluated by the runtime.

use super::basis::diagonal;
use crate::Error;
use sinew_runtime::prior::{Edit, Pin, PinJob, Pins, Prior};
use sinew_runtime::skin::{Output, ShapesJob};
use sinew_runtime::{CallError, Model, Skin};

/// Most pins in one command.
pub const PINS_MAX: usize = 256;

/// No pins: a solve sets its own.
static NO_PINS: Pins<0> = Pins::new();

/// A loaded face with V vertices and S shapes.
#[derive(Clone, Copy)]
pub struct BakedFace<'a> {
    /// The skin.
    pub skin: Skin<'a>,
    /// The prior over the skin's shapes.
    pub prior: Prior<'a>,
}

/// Vertices of a face at given weights.
pub struct Shaped {
    /// Positions, V.
    pub positions: Vec<[f64; 3]>,
    /// Normals of length 1 or 0, V.
    pub normals: Vec<[f64; 3]>,
}

impl<'a> BakedFace<'a> {
    /// Finds the first face in a file: a prior and its skin.
    ///
    /// # Errors
    /// [`ErrorKind::Missing`](crate::ErrorKind::Missing): the file has no face.
    pub fn open<B: AsRef<[u8]>>(model: &'a Model<B>) -> Result<Self, Error> {
        let missing = || {
            Error::missing(
                "has no face: no prior over the shapes of a skin; `sinew face train` makes one",
            )
        };
        let prior = model.first::<Prior>().ok_or_else(missing)?;
        let skin = model.skin_of(&prior).ok_or_else(missing)?;
        Ok(Self { skin, prior })
    }

    /// Returns the names of the shapes.
    pub fn names(&self) -> Vec<String> {
        let name = |shape| self.skin.shape_name(shape).unwrap_or_default().to_owned();
        (0..self.skin.shape_len()).map(name).collect()
    }

    /// Returns the diagonal of the neutral face's bounding box.
    pub fn diagonal(&self) -> f64 {
        let rest = |v| self.skin.rest_position(v).unwrap_or_default().map(f64::from);
        diagonal((0..self.skin.vertex_len()).map(rest))
    }

    /// Returns a vertex's neutral position and its delta in each shape, S.
    pub fn vertex(&self, vertex: usize) -> ([f64; 3], Vec<[f64; 3]>) {
        let rest = self.skin.rest_position(vertex).unwrap_or_default().map(f64::from);
        let mut deltas = vec![[0.0; 3]; self.skin.shape_len()];
        for (shape, delta) in self.skin.deltas_of(vertex) {
            deltas[shape] = delta.map(f64::from);
        }
        (rest, deltas)
    }

    /// Returns a vertex's position at weights, S.
    pub fn place(&self, vertex: usize, weights: &[f64]) -> [f64; 3] {
        let (rest, deltas) = self.vertex(vertex);
        moved(rest, &deltas, weights)
    }

    /// Evaluates all positions and normals at weights, S.
    ///
    /// # Errors
    /// [`CallError`] if the weights are not S finite numbers.
    pub fn shaped(&self, weights: &[f32]) -> Result<Shaped, CallError> {
        let len = self.skin.vertex_len();
        let (mut positions, mut normals) = (vec![[0.0_f32; 3]; len], vec![[0.0_f32; 3]; len]);
        let output = |floats| Some(Output::new(floats, 3));
        ShapesJob::new(self.skin, weights)
            .vertices(0..len)
            .positions(output(positions.as_flattened_mut()))
            .normals(output(normals.as_flattened_mut()))
            .run()?;
        let wide = |all: Vec<[f32; 3]>| all.into_iter().map(|v| v.map(f64::from)).collect();
        Ok(Shaped { positions: wide(positions), normals: wide(normals) })
    }

    /// Returns the options of an artist's edit at rest, without pins: from the current weights, between the bounds.
    pub fn edit(&self) -> PinJob<'a> {
        PinJob::new(self.prior, self.skin, NO_PINS.list())
    }

    /// Solves for the weights that satisfy pins.
    ///
    /// - `options`: those of [`Self::edit`], or others; their prior, skin, palette and pins are not used.
    /// - `scratch`: reused between calls; solves with the same pins are then fast.
    /// - `weights`: S, changed in place.
    ///
    /// # Errors
    /// Errors of [`PinJob::run`]; more than [`PINS_MAX`] pins.
    pub fn solve(
        &self,
        pins: &[Pin],
        options: &PinJob<'_>,
        scratch: &mut Vec<f64>,
        weights: &mut [f32],
    ) -> Result<Edit, CallError> {
        let mut list = Pins::<PINS_MAX>::new();
        pins.iter().try_for_each(|pin| list.add(*pin))?;
        let len = self.prior.counts().pin_scratch_len(list.list().scalar_len());
        scratch.resize(scratch.len().max(len), 0.0);
        let job = PinJob { prior: self.prior, skin: self.skin, palette: &[], ..*options };
        PinJob { pins: list.list(), ..job }.run(scratch, weights)
    }
}

/// Adds S weighted deltas to a neutral position.
pub fn moved(rest: [f64; 3], deltas: &[[f64; 3]], weights: &[f64]) -> [f64; 3] {
    [0, 1, 2]
        .map(|axis| rest[axis] + deltas.iter().zip(weights).map(|(u, z)| z * u[axis]).sum::<f64>())
}
