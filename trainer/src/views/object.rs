//! A map of an object in f64, with its points where the runtime has them.

use super::deformation::Deformations;
use super::fit::{FitError, MapOutputs, given};
use super::player::Player;
use super::set::Values;
use crate::scattered::model::KernelModel;

/// Step of a difference of points along the derivatives of the map's numbers.
const DIFFERENCE: f64 = 1e-2;

/// A map, and how its points are deformed where the motion is another object's.
#[derive(Clone, Copy, Debug)]
pub struct ObjectMap<'a> {
    /// The map.
    pub model: &'a KernelModel,
    /// How many outputs it has.
    pub outputs: MapOutputs,
    /// The deformations of a transferred object; `None` of one that moves by itself.
    pub deformations: Option<&'a Deformations>,
}

impl ObjectMap<'_> {
    /// Evaluates the K points, pixels.
    ///
    /// # Errors
    /// [`FitError`] of the values.
    pub fn points(&self, values: &Values) -> Result<Vec<[f64; 2]>, FitError> {
        let evaluated = self.model.evaluate(&given(&self.model.inputs, values)?)?;
        Ok(self.places(&evaluated.numbers))
    }

    /// Returns the K points by the numbers of all outputs.
    pub(super) fn places(&self, numbers: &[f64]) -> Vec<[f64; 2]> {
        let shown = self.outputs.shown(numbers);
        match self.deformations {
            None => shown.points,
            Some(deformations) => deformations.moved(&shown.points, &shown.scores),
        }
    }

    /// Returns the derivatives of the K points, where the numbers of all outputs change by `slopes`.
    pub(super) fn slopes(&self, numbers: &[f64], slopes: &[f64]) -> Vec<[f64; 2]> {
        if self.deformations.is_none() {
            return self.outputs.shown(slopes).points;
        }
        let at = |step: f64| {
            let moved = numbers.iter().zip(slopes).map(|(number, slope)| number + step * slope);
            self.places(&moved.collect::<Vec<_>>())
        };
        let (after, before) = (at(DIFFERENCE), at(-DIFFERENCE));
        let slope = |(a, b): (&[f64; 2], &[f64; 2])| {
            [0, 1].map(|axis| (a[axis] - b[axis]) / (2.0 * DIFFERENCE))
        };
        after.iter().zip(&before).map(slope).collect()
    }
}

/// A map of a file, in f64.
#[derive(Debug)]
pub struct FileMap {
    model: KernelModel,
    outputs: MapOutputs,
    deformations: Option<Deformations>,
}

impl FileMap {
    /// Reads a player's map.
    pub fn new(player: &Player<'_>) -> Self {
        let views = player.views();
        Self {
            model: KernelModel::from_file(player.map()),
            outputs: MapOutputs::of(views),
            deformations: Deformations::of(views),
        }
    }

    /// Returns the map with the object's own points.
    pub fn object(&self) -> ObjectMap<'_> {
        let Self { model, outputs, deformations } = self;
        ObjectMap { model, outputs: *outputs, deformations: deformations.as_ref() }
    }
}
