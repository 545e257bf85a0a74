//! Inputs and outputs of a map of views.
//!
//! The name of a rotation joins the names of its angles about x, y and z by commas. An unused angle has an empty name.
//! So the file alone says which angles a parameter sets. Outputs are points with depths, visibility, scores of key
//! views, and opacities and orders of layers, in the order of the file.

use crate::Error;
use crate::numeric::columns::ends;
use crate::regression::rotations::Feature;
use crate::scattered::model::{Input, InputKind, KernelModel, Output, OutputKind};
use crate::views::set::{Examples, Parameter, Values, View};
use sinew_runtime::kernel::EulerOrder;
use sinew_runtime::views::{Blend, Views};

/// Smallest range of an angle that must be a rotation, degrees. Numbers do not wrap around.
const HALF_TURN: f64 = 180.0;

/// Lists the names of the parameters of inputs.
pub fn names_of(inputs: &[Input]) -> Vec<&str> {
    inputs.iter().flat_map(angles_of).filter(|name| !name.is_empty()).collect()
}

/// Lists the numbers of all inputs from values by name. Unused angles are 0.
///
/// # Errors
/// - [`ErrorKind::Missing`](crate::ErrorKind::Missing): a parameter has no value.
/// - [`ErrorKind::Value`](crate::ErrorKind::Value): no parameter has the name of a value.
pub fn given(inputs: &[Input], values: &Values) -> Result<Vec<f64>, Error> {
    let names = names_of(inputs);
    if let Some(found) = values.keys().find(|name| !names.contains(&name.as_str())) {
        return Err(unknown_parameter(found, &names));
    }
    let missing = |name: &str| Error::missing(format!("parameter \"{name}\" is missing"));
    let value = |name: &str| match name {
        "" => Ok(0.0),
        _ => values.get(name).copied().ok_or_else(|| missing(name)),
    };
    inputs.iter().flat_map(angles_of).map(value).collect()
}

/// Makes the error of a name that no parameter has.
pub(in crate::views) fn unknown_parameter(found: &str, names: &[&str]) -> Error {
    Error::value(format!("\"{found}\" is no parameter: expected {}", names.join(", ")))
}

/// Splits the name of a rotation into angles. The name of any other input is not split.
pub(in crate::views) fn angles_of(input: &Input) -> impl Iterator<Item = &str> {
    let parts = if matches!(input.kind, InputKind::Rotation { .. }) { 3 } else { 1 };
    input.name.splitn(parts, ',')
}

/// Pairs each input with the index of its first feature.
pub(in crate::views) fn with_features(inputs: &[Input]) -> impl Iterator<Item = (&Input, usize)> {
    inputs.iter().scan(0, |next, input| {
        let first = *next;
        *next += input.kind.feature_len();
        Some((input, first))
    })
}

/// Visibility above which a point is visible.
const SEEN: f64 = 0.5;

/// Number of outputs of each kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MapOutputs {
    /// Number of control points, K.
    pub points: usize,
    /// Number of key views, N.
    pub views: usize,
    /// Number of layers, L.
    pub layers: usize,
}

/// Outputs of a map at parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    /// The K points, pixels.
    pub points: Vec<[f64; 2]>,
    /// The K depths, pixels.
    pub depths: Vec<f64>,
    /// Whether each of the K points is visible.
    pub visible: Vec<bool>,
    /// The N scores of the key views: 1 at the view's own parameters, 0 at those of the others. The characteristic view
    /// has the highest score.
    pub scores: Vec<f64>,
}

impl MapOutputs {
    /// Returns the numbers of outputs of an object in a file.
    pub fn of(views: &Views<'_>) -> Self {
        let (points, layers) = (views.point_len(), views.layer_len());
        Self { points, views: views.view_len(), layers }
    }

    /// Returns the number of values of all outputs.
    pub fn value_len(self) -> usize {
        4 * self.points + self.views + 2 * self.layers
    }

    /// Lists the indices of the values of points (x and y), of depths, of visibility, and of all numbers: key views'
    /// scores, layers' opacities and layers' orders.
    pub(super) fn rows(self) -> [Vec<usize>; 4] {
        let k = self.points;
        [
            (0..k).flat_map(|k| [3 * k, 3 * k + 1]).collect(),
            (0..k).map(|k| 3 * k + 2).collect(),
            (3 * k..4 * k).collect(),
            (4 * k..self.value_len()).collect(),
        ]
    }

    /// Lists the outputs with their names.
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

    /// Evaluates a map with these outputs.
    ///
    /// # Errors
    /// The values are invalid.
    pub fn evaluate(self, model: &KernelModel, values: &Values) -> Result<Shown, Error> {
        let evaluated = model.evaluate(&given(&model.inputs, values)?)?;
        Ok(self.shown(&evaluated.numbers))
    }

    /// Splits the numbers of all outputs.
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
    /// Returns the characteristic view. The first of equal scores wins.
    pub fn view(&self) -> Option<usize> {
        let best = self.scores.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        self.scores.iter().position(|score| *score == best)
    }
}

/// Returns the weights of N key views by their scores, as the runtime computes them (S1 §2, METHOD §6.3). Weights are
/// not negative and sum to 1.
pub fn weights(scores: &[f64]) -> Vec<f64> {
    let single: Vec<f32> = scores.iter().map(|score| *score as f32).collect();
    let mut out = vec![0.0; scores.len()];
    for (view, share) in Blend::of_scores(&single).views() {
        out[*view] += f64::from(*share);
    }
    out
}

/// Lists the encodings of parameters as inputs. Angles are one rotation, in each order that makes a difference if the
/// order is open. If no angle varies by half a turn, angles are also tried as numbers.
pub(super) fn encodings(examples: &Examples) -> Vec<Vec<Input>> {
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
            .flat_map(|encoding| {
                own.iter().map(|input| [encoding.clone(), vec![input.clone()]].concat())
            })
            .collect();
    }
    let rotations =
        || examples.parameters.iter().filter(|own| !matches!(own, Parameter::Scalar(_)));
    let mut angles = rotations().flat_map(Parameter::names);
    let is_narrow = angles.all(|angle| range(&examples.train, angle) < HALF_TURN);
    if is_narrow && rotations().next().is_some() {
        let names = examples.parameters.iter().flat_map(Parameter::names);
        out.push(names.map(scalar).collect());
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

/// Lists the orders that differ for the angles that turn in some view.
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
    fn angles_are_rotations_in_each_order_or_numbers_if_narrow() {
        let count = |order, reach| encodings(&head(order, reach)).len();
        assert_eq!(count(None, 90.0), 3, "x before y, y before x, numbers");
        assert_eq!(count(Some(EulerOrder::Yxz), 90.0), 2);
        assert_eq!(count(Some(EulerOrder::Yxz), 270.0), 1);
    }

    #[test]
    fn values_are_given_by_name() {
        let examples = head(Some(EulerOrder::Yxz), 90.0);
        let encoding = &encodings(&examples)[0];
        assert_eq!(names_of(encoding), ["pitch", "yaw", "smile"]);
        let mut values = examples.train[1].values.clone();
        assert_eq!(given(encoding, &values).unwrap(), [5.0, 90.0, 0.0, 0.5]);
        values.insert("frown".to_owned(), 1.0);
        let refused = given(encoding, &values).unwrap_err().to_string();
        assert_eq!(refused, "\"frown\" is no parameter: expected pitch, yaw, smile");
        values.remove("frown");
        values.remove("yaw");
        assert_eq!(
            given(encoding, &values).unwrap_err().to_string(),
            "parameter \"yaw\" is missing"
        );
    }
}
