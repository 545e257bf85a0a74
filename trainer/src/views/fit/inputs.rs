//! Parameters as inputs of a kernel map, and the ways in which they may be taken.
//!
//! A rotation's name is that of its angles about x, y and z with commas between, empty where there is none:
//! so a file alone tells what an angle is.

use super::error::FitError;
use crate::numeric::columns::ends;
use crate::regression::rotations::Feature;
use crate::scattered::model::{Input, InputKind};
use crate::views::set::{Examples, Parameter, Values, View};
use sinew_runtime::kernel::EulerOrder;

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
