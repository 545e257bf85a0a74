//! Parameters as inputs of a kernel map, and the ways in which they may be taken.
//!
//! A rotation's name is that of its angles about x, y and z with commas between, empty where there is none:
//! so a file alone tells what an angle is.
//! What a map of views gives: points with depths, visibility, scores, in the order of the file.
//! How much each key view counts: from a configuration of points to the characteristic views (S1 §2, METHOD §6.3).
//! Why views give no map.

use crate::kernel::model::{EvaluationError, Input, InputKind, KernelModel, Output, OutputKind};
use crate::kernel::rotations::Feature;
use crate::kernel::scattered::error::KernelError;
use crate::numeric::columns::ends;
use crate::views::set::{Examples, Parameter, Values, View};
use sinew_runtime::kernel::EulerOrder;
use sinew_runtime::views::{Blend, Views};

/// Degrees of an angle's range from which on it is no number: what lies behind it comes round.
const HALF_TURN: f64 = 180.0;

/// Lists the names by which values of inputs are given.
pub fn names_of(inputs: &[Input]) -> Vec<&str> {
    inputs.iter().flat_map(angles_of).filter(|name| !name.is_empty()).collect()
}

/// Makes what is given of all inputs of values by name.
///
/// # Errors
/// [`FitError::Missing`] and [`FitError::Unknown`].
pub fn given(inputs: &[Input], values: &Values) -> Result<Vec<f64>, FitError> {
    let names = names_of(inputs);
    if let Some(found) = values.keys().find(|name| !names.contains(&name.as_str())) {
        return Err(FitError::Unknown { found: found.clone(), expected: names.join(", ") });
    }
    let value = |name: &str| match name {
        "" => Ok(0.0),
        _ => values.get(name).copied().ok_or_else(|| FitError::Missing(name.to_owned())),
    };
    inputs.iter().flat_map(angles_of).map(value).collect()
}

/// Splits a rotation's name; any other input's is its own.
fn angles_of(input: &Input) -> impl Iterator<Item = &str> {
    let parts = if matches!(input.kind, InputKind::Rotation { .. }) { 3 } else { 1 };
    input.name.splitn(parts, ',')
}

/// Lists the ways in which parameters may be taken: angles as one rotation, in each order that makes a
/// difference where none is said; and as numbers, where none of them turns as far as half round.
pub(super) fn ways(examples: &Examples) -> Vec<Vec<Input>> {
    let mut out = vec![Vec::new()];
    for parameter in &examples.parameters {
        let own: Vec<Input> = match parameter {
            Parameter::Scalar(name) => vec![scalar(name)],
            Parameter::Rotation { angles, order } => {
                let orders = match order {
                    Some(order) => vec![*order],
                    None => orders(angles, &examples.train),
                };
                orders.into_iter().map(|order| rotation(angles, order)).collect()
            }
        };
        out = out
            .iter()
            .flat_map(|way| own.iter().map(|input| [way.clone(), vec![input.clone()]].concat()))
            .collect();
    }
    let has_rotation = |way: &[Input]| way.iter().any(|input| input.kind != InputKind::Scalar);
    let names: Vec<&str> = examples.parameters.iter().flat_map(Parameter::names).collect();
    let narrow = examples.parameters.iter().all(|parameter| match parameter {
        Parameter::Scalar(_) => true,
        Parameter::Rotation { angles, .. } => {
            angles.iter().flatten().all(|angle| range(&examples.train, angle) < HALF_TURN)
        }
    });
    if narrow && has_rotation(&out[0]) {
        out.push(names.into_iter().map(scalar).collect());
    }
    out
}

fn scalar(name: &str) -> Input {
    Input { name: name.to_owned(), kind: InputKind::Scalar, weight: 1.0 }
}

fn rotation(angles: &[Option<String>; 3], order: EulerOrder) -> Input {
    let name = angles.each_ref().map(|angle| angle.as_deref().unwrap_or_default()).join(",");
    let kind = InputKind::Rotation { feature: Feature::Matrix, order: Some(order) };
    Input { name, kind, weight: 1.0 }
}

fn range(views: &[View], name: &str) -> f64 {
    let values: Vec<f64> = views.iter().filter_map(|view| view.values.get(name).copied()).collect();
    let [low, high] = ends(&values);
    high - low
}

/// Lists the orders that differ in angles that are not 0 in all views.
fn orders(angles: &[Option<String>; 3], views: &[View]) -> Vec<EulerOrder> {
    let turns = |axis: usize| {
        let values = angles[axis].iter().flat_map(|name| views.iter().map(|v| v.values.get(name)));
        values.flatten().any(|value| *value != 0.0)
    };
    let turning: Vec<char> =
        "XYZ".chars().enumerate().filter(|(axis, _)| turns(*axis)).map(|(_, c)| c).collect();
    let own = |order: &EulerOrder| -> String {
        order.name().chars().filter(|axis| turning.contains(axis)).collect()
    };
    let mut out: Vec<EulerOrder> = Vec::new();
    for order in EulerOrder::ALL {
        if out.iter().all(|other| own(other) != own(&order)) {
            out.push(order);
        }
    }
    out
}

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

/// Returns the weights of N key views by their scores, as the runtime has them: not negative, and they sum to 1.
pub fn weights(scores: &[f64]) -> Vec<f64> {
    let single: Vec<f32> = scores.iter().map(|score| *score as f32).collect();
    let mut out = vec![0.0; scores.len()];
    for (view, share) in Blend::of_scores(&single).views() {
        out[*view] += f64::from(*share);
    }
    out
}

/// Views that no map was fitted to; views count from 0.
#[derive(Debug, thiserror::Error)]
pub enum FitError {
    /// Parameters of a view cannot be taken.
    #[error("train view {view}: {error}")]
    Site {
        /// The view.
        view: usize,
        /// Why.
        error: EvaluationError,
    },
    /// Parameters cannot be taken.
    #[error(transparent)]
    Given(#[from] EvaluationError),
    /// A parameter has no value.
    #[error("parameter \"{0}\" is missing")]
    Missing(String),
    /// A name is no parameter's.
    #[error("\"{found}\" is no parameter: expected {expected}")]
    Unknown {
        /// The name.
        found: String,
        /// Those that there are.
        expected: String,
    },
    /// The parameters of all views cannot be measured.
    #[error(transparent)]
    Kernel(#[from] KernelError),
    /// Two views have the same parameters and different points.
    #[error("train views {first} and {second} have the same parameters")]
    Same {
        /// The earlier view.
        first: usize,
        /// The later one.
        second: usize,
    },
    /// Nothing could be solved.
    #[error("no polynomial and no kernel can be fitted to {views} views")]
    None {
        /// Views.
        views: usize,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    fn head(order: Option<EulerOrder>, reach: f64) -> Examples {
        let angles = [Some("pitch".to_owned()), Some("yaw".to_owned()), None];
        let view = |yaw: f64| View {
            values: [("pitch", 5.0 * yaw.signum()), ("yaw", yaw), ("smile", 0.5)]
                .map(|(name, value)| (name.to_owned(), value))
                .into(),
            points: Vec::new(),
            visible: Vec::new(),
            depths: Vec::new(),
            image: None,
            layers: Vec::new(),
        };
        Examples {
            name: "main".to_owned(),
            parameters: vec![
                Parameter::Rotation { angles, order },
                Parameter::Scalar("smile".to_owned()),
            ],
            train: vec![view(0.0), view(reach)],
            test: Vec::new(),
        }
    }

    #[test]
    fn angles_are_rotations_in_each_order_that_matters_or_numbers_where_they_are_narrow() {
        let count = |order, reach| ways(&head(order, reach)).len();
        assert_eq!(count(None, 90.0), 3, "x before y, y before x, numbers");
        assert_eq!(count(Some(EulerOrder::Yxz), 90.0), 2);
        assert_eq!(count(Some(EulerOrder::Yxz), 270.0), 1);
    }

    #[test]
    fn values_are_given_by_name() {
        let examples = head(Some(EulerOrder::Yxz), 90.0);
        let way = &ways(&examples)[0];
        assert_eq!(names_of(way), ["pitch", "yaw", "smile"]);
        let mut values = examples.train[1].values.clone();
        assert_eq!(given(way, &values).unwrap(), [5.0, 90.0, 0.0, 0.5]);
        values.insert("frown".to_owned(), 1.0);
        let refused = given(way, &values).unwrap_err().to_string();
        assert_eq!(refused, "\"frown\" is no parameter: expected pitch, yaw, smile");
        values.remove("frown");
        values.remove("yaw");
        assert_eq!(given(way, &values).unwrap_err().to_string(), "parameter \"yaw\" is missing");
    }
}
