//! Points of an object in f64, as the runtime places them; its key views; and parallel deformation (S1 §2.3, Eq. 5;
//! METHOD §6.6).
//!
//! Parallel deformation lends the motion of a prototype to an instance of the same class: `O' = R'_B + s (O_B - R_B)`
//! plus the barycentre of the prototype. B marks points less their own barycentre.

use super::fit::{MapOutputs, given, weights};
use super::player::Player;
use super::set::Values;
use crate::Error;
use crate::page::picture::Picture;
use crate::scattered::model::KernelModel;
use sinew_runtime::views::Views;

/// Step of the central difference along the slopes of the outputs.
const DIFFERENCE: f64 = 1e-2;

/// A map, and the deformation of its points if another object lent the motion.
#[derive(Clone, Debug)]
pub struct ObjectMap {
    /// The map.
    pub model: KernelModel,
    /// Number of outputs of each kind.
    pub outputs: MapOutputs,
    /// Deformations of a transferred object; `None` for an object with its own motion.
    pub deformations: Option<Deformations>,
}

impl ObjectMap {
    /// Reads the map of a player in f64.
    pub fn new(player: &Player<'_>) -> Self {
        let views = player.views();
        Self {
            model: KernelModel::from_file(player.map()),
            outputs: MapOutputs::of(views),
            deformations: Deformations::of(views),
        }
    }

    /// Evaluates the K points, pixels.
    ///
    /// # Errors
    /// The values are invalid.
    pub fn points(&self, values: &Values) -> Result<Vec<[f64; 2]>, Error> {
        self.at(&given(&self.model.inputs, values)?)
    }

    /// Evaluates the K points, given the numbers of all inputs.
    pub(super) fn at(&self, given: &[f64]) -> Result<Vec<[f64; 2]>, Error> {
        Ok(self.places(&self.model.evaluate(given)?.numbers))
    }

    /// Returns the K points, given the numbers of all outputs.
    fn places(&self, numbers: &[f64]) -> Vec<[f64; 2]> {
        let shown = self.outputs.shown(numbers);
        match &self.deformations {
            None => shown.points,
            Some(deformations) => deformations.moved(&shown.points, &shown.scores),
        }
    }

    /// Returns the derivatives of the K points, given the derivatives `slopes` of the outputs.
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

/// A key view.
#[derive(Clone, Debug)]
pub struct KeyView {
    /// Name of the key view.
    pub name: String,
    /// L pictures, each with the position of its upper left corner on the screen. `None` if the key view does not show
    /// the layer.
    pub pictures: Vec<Option<(Picture, [usize; 2])>>,
    /// Positions of the K points on the screen, pixels.
    pub points: Vec<[f64; 2]>,
    /// Whether each of the K points is visible.
    pub visible: Vec<bool>,
    /// Deformation from the prototype, if the motion is lent.
    pub deformation: Option<Deformation>,
}

/// Deformation of an instance from its prototype in one key view.
#[derive(Clone, Debug, PartialEq)]
pub struct Deformation {
    /// Scale s: 1, or the norm of the instance over the norm of the prototype.
    pub scale: f64,
    /// Offsets R' - s R of the K points, pixels. R and R' are the points of the prototype and of the instance, less
    /// their barycentres.
    pub offsets: Vec<[f64; 2]>,
}

impl Deformation {
    /// Makes a deformation from K points of a prototype and K points of an instance.
    ///
    /// - `by_size`: whether the motion scales with the size of the instance (S1's footnote 2).
    pub fn new(prototype: &[[f64; 2]], instance: &[[f64; 2]], by_size: bool) -> Self {
        let [prototype, instance] = [prototype, instance].map(|points| centred(points).0);
        let ratio = norm(&instance) / norm(&prototype);
        let scale = if by_size && ratio.is_finite() { ratio } else { 1.0 };
        let offset = |(own, other): (&[f64; 2], &[f64; 2])| {
            [0, 1].map(|axis| other[axis] - scale * own[axis])
        };
        Self { scale, offsets: prototype.iter().zip(&instance).map(offset).collect() }
    }
}

/// Deformations of a transferred object from its prototype, by key view.
#[derive(Clone, Debug, PartialEq)]
pub struct Deformations {
    /// Deformation in each key view.
    pub keys: Vec<Deformation>,
}

impl Deformations {
    /// Reads the deformations of an object in a file; `None` if the object has its own motion.
    pub fn of(views: &Views<'_>) -> Option<Self> {
        let key = |view| {
            let offsets = (0..).map_while(|point| views.offset(view, point));
            let offsets = offsets.map(|offset| offset.map(f64::from)).collect();
            Some(Deformation { scale: views.ratio(view)?.into(), offsets })
        };
        views.is_transferred().then(|| Self { keys: (0..).map_while(key).collect() })
    }

    /// Moves the object as its prototype moved, by the deformations of the key views weighted by score.
    ///
    /// - `prototype`: K points, pixels.
    /// - `scores`: N scores of the object's key views.
    pub fn moved(&self, prototype: &[[f64; 2]], scores: &[f64]) -> Vec<[f64; 2]> {
        let (own, centre) = centred(prototype);
        let weights = weights(scores);
        let keys = || self.keys.iter().zip(&weights).filter(|(_, weight)| **weight > 0.0);
        let scale: f64 = keys().map(|(key, weight)| weight * key.scale).sum();
        let point = |(k, own): (usize, &[f64; 2])| {
            [0, 1].map(|axis| {
                let offset: f64 = keys().map(|(key, weight)| weight * key.offsets[k][axis]).sum();
                scale * own[axis] + offset + centre[axis]
            })
        };
        own.iter().enumerate().map(point).collect()
    }
}

/// Subtracts the barycentre from points, and returns both.
pub fn centred(points: &[[f64; 2]]) -> (Vec<[f64; 2]>, [f64; 2]) {
    let len = points.len().max(1) as f64;
    let centre = [0, 1].map(|axis| points.iter().map(|point| point[axis]).sum::<f64>() / len);
    let own = points.iter().map(|point| [0, 1].map(|axis| point[axis] - centre[axis]));
    (own.collect(), centre)
}

/// Returns the norm of all points as one vector.
pub fn norm(points: &[[f64; 2]]) -> f64 {
    points.as_flattened().iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    const FIGURE: [[f64; 2]; 4] = [[1.0, 2.0], [5.0, 2.5], [4.0, 7.0], [0.5, 6.0]];
    const OTHER: [[f64; 2]; 4] = [[11.0, 0.0], [17.0, 1.0], [16.0, 9.0], [10.0, 8.5]];

    fn far(a: &[[f64; 2]], b: &[[f64; 2]]) -> f64 {
        let apart = a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| (a - b).abs());
        apart.fold(0.0, f64::max)
    }

    fn moved(own: Deformation, prototype: &[[f64; 2]]) -> Vec<[f64; 2]> {
        Deformations { keys: vec![own] }.moved(prototype, &[1.0])
    }

    fn waved(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
        points.iter().map(|[x, y]| [x + (0.3 * y).sin() + 9.0, y * 1.1 - 0.2 * x]).collect()
    }

    #[test]
    fn a_prototype_lends_itself_its_own_motion() {
        for by_size in [false, true] {
            let own = Deformation::new(&FIGURE, &FIGURE, by_size);
            let waved = waved(&FIGURE);
            assert!(far(&moved(own, &waved), &waved) < 1e-14);
        }
    }

    #[test]
    fn a_prototype_at_rest_gives_the_instance_at_rest() {
        for by_size in [false, true] {
            let own = Deformation::new(&FIGURE, &OTHER, by_size);
            let found = centred(&moved(own, &FIGURE)).0;
            assert!(far(&found, &centred(&OTHER).0) < 1e-14);
        }
    }

    #[test]
    fn motion_is_parallel_and_scales_with_the_instance_by_size() {
        let waved = waved(&FIGURE);
        let change: Vec<_> = centred(&waved).0.into_iter().zip(centred(&FIGURE).0).collect();
        for (by_size, factor) in
            [(false, 1.0), (true, norm(&centred(&OTHER).0) / norm(&centred(&FIGURE).0))]
        {
            let found = centred(&moved(Deformation::new(&FIGURE, &OTHER, by_size), &waved)).0;
            for ((found, other), (moved, own)) in found.iter().zip(centred(&OTHER).0).zip(&change) {
                for axis in 0..2 {
                    let expected = factor * (moved[axis] - own[axis]);
                    assert!((found[axis] - other[axis] - expected).abs() < 1e-13);
                }
            }
        }
    }
}
