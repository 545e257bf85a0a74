//! What a map of views gives: points with depths, visibility, scores, in the order of the file.

use super::error::FitError;
use super::inputs::given;
use crate::scattered::model::{KernelModel, Output, OutputKind};
use crate::views::set::Values;
use sinew_runtime::views::Views;

/// Above it a point is seen.
const SEEN: f64 = 0.5;

/// How many outputs of each kind there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MapOutputs {
    /// Control points, K.
    pub points: usize,
    /// Key views, N.
    pub views: usize,
    /// Layers, L.
    pub layers: usize,
}

/// What a map gives for parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    /// K points, pixels.
    pub points: Vec<[f64; 2]>,
    /// K depths.
    pub depths: Vec<f64>,
    /// K: whether each is seen.
    pub visible: Vec<bool>,
    /// N: how much each key view counts, 1 at its own parameters and 0 at those of others; the highest is the
    /// characteristic view.
    pub scores: Vec<f64>,
}

impl MapOutputs {
    /// Returns those of a file's object.
    pub fn of(views: &Views<'_>) -> Self {
        let (points, layers) = (views.point_len(), views.layer_len());
        Self { points, views: views.view_len(), layers }
    }

    /// Returns how many values all are.
    pub fn value_len(self) -> usize {
        4 * self.points + self.views + 2 * self.layers
    }

    /// Lists the values of points: x and y.
    pub(super) fn places(self) -> Vec<usize> {
        (0..self.points).flat_map(|k| [3 * k, 3 * k + 1]).collect()
    }

    /// Lists the values of depths.
    pub(super) fn depths(self) -> Vec<usize> {
        (0..self.points).map(|k| 3 * k + 2).collect()
    }

    /// Lists the values of visibility.
    pub(super) fn visibility(self) -> Vec<usize> {
        (3 * self.points..4 * self.points).collect()
    }

    /// Lists the values of key views' scores, of layers' opacities and of their orders.
    pub(super) fn numbers(self) -> Vec<usize> {
        (4 * self.points..self.value_len()).collect()
    }

    /// Names them.
    pub fn outputs(self) -> Vec<Output> {
        let [low, high] = [f32::MIN, f32::MAX].map(f64::from);
        let scalar = OutputKind::Scalar { low, high, normalised: false, neutral: 0.0 };
        let vector = OutputKind::Vector3 { neutral: [0.0; 3] };
        let of = |stem: &str, len: usize, kind| {
            let output = |number| Output { name: format!("{stem} {number}"), kind };
            (0..len).map(output).collect::<Vec<_>>()
        };
        [
            of("point", self.points, vector),
            of("visible", self.points, scalar),
            of("view", self.views, scalar),
            of("opacity", self.layers, scalar),
            of("order", self.layers, scalar),
        ]
        .concat()
    }

    /// Evaluates a map of these outputs.
    ///
    /// # Errors
    /// [`FitError`] of the values.
    pub fn evaluate(self, model: &KernelModel, values: &Values) -> Result<Shown, FitError> {
        let evaluated = model.evaluate(&given(&model.inputs, values)?)?;
        Ok(self.shown(&evaluated.numbers))
    }

    /// Reads the numbers of all outputs.
    pub fn shown(self, numbers: &[f64]) -> Shown {
        let (points, rest) = numbers.split_at((3 * self.points).min(numbers.len()));
        let (visible, rest) = rest.split_at(self.points.min(rest.len()));
        let (scores, _) = rest.split_at(self.views.min(rest.len()));
        let (points, _) = points.as_chunks::<3>();
        Shown {
            points: points.iter().map(|[x, y, _]| [*x, *y]).collect(),
            depths: points.iter().map(|[_, _, depth]| *depth).collect(),
            visible: visible.iter().map(|value| *value > SEEN).collect(),
            scores: scores.to_vec(),
        }
    }
}

impl Shown {
    /// Returns the characteristic view, the first of equals.
    pub fn view(&self) -> Option<usize> {
        let best = self.scores.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        self.scores.iter().position(|score| *score == best)
    }
}
