//! Drags a few points. The parameters follow first, by their covariance in training, then the points nearby follow.

use super::fit::{angles_of, given, names_of, with_features};
use super::object::{ObjectMap, centred, norm};
use super::set::Values;
use crate::Error;
use crate::regression::rotations::Feature;
use crate::scattered::model::{InputKind, KernelModel};
use nalgebra::{DMatrix, DVector};
use sinew_runtime::kernel::EulerOrder;

/// Standard deviation of the distance between a point and its pin, pixels.
const NOISE: f64 = 0.5;
/// Largest number of steps.
const STEPS: usize = 20;
/// Step of a parameter for the central difference.
const DIFFERENCE: f64 = 1e-4;
/// Standard deviation of an angle if the file has no training parameters, degrees.
const ANGLE: f64 = 20.0;
/// Smallest variance of a parameter, over the mean variance.
const FLOOR: f64 = 1e-3;
/// Reach of the remaining offset of a pin, over the size of the object.
const REACH: f64 = 0.1;

/// Index of a point, and the position to drag the point to, pixels.
pub type Pin = (usize, [f64; 2]);

/// Finds parameters near `start` that bring points to their pins. The change of the parameters is the likeliest by
/// their covariance in training (METHOD §5.1).
///
/// # Errors
/// The values are invalid.
pub fn follow(object: &ObjectMap, start: &Values, pins: &[Pin]) -> Result<Values, Error> {
    let model = &object.model;
    let names: Vec<String> = names_of(&model.inputs).into_iter().map(str::to_owned).collect();
    let by_name =
        |x: &DVector<f64>| -> Values { names.iter().cloned().zip(x.iter().copied()).collect() };
    given(&model.inputs, start)?;
    let from = DVector::from_iterator(names.len(), names.iter().map(|name| start[name]));
    let covariance = covariance(model, &names);
    let places = |x: &DVector<f64>| -> Result<DVector<f64>, Error> {
        let points = object.points(&by_name(x))?;
        Ok(DVector::from_iterator(2 * pins.len(), pins.iter().flat_map(|(k, _)| points[*k])))
    };
    let target = DVector::from_iterator(2 * pins.len(), pins.iter().flat_map(|(_, to)| *to));
    let noise = DMatrix::identity(2 * pins.len(), 2 * pins.len()) * (NOISE * NOISE);
    let mut x = from.clone();
    for _ in 0..STEPS {
        let here = places(&x)?;
        let mut jacobian = DMatrix::zeros(2 * pins.len(), names.len());
        for column in 0..names.len() {
            let moved = |sign: f64| {
                let mut x = x.clone();
                x[column] += sign * DIFFERENCE;
                places(&x)
            };
            jacobian.set_column(column, &((moved(1.0)? - moved(-1.0)?) / (2.0 * DIFFERENCE)));
        }
        let wanted = &target - &here + &jacobian * (&x - &from);
        let spread = &covariance * jacobian.transpose();
        let Some(solved) = (&jacobian * &spread + &noise).cholesky() else { break };
        let next = &from + spread * solved.solve(&wanted);
        let step = (&next - &x).norm();
        x = next;
        if step < 1e-9 {
            break;
        }
    }
    Ok(by_name(&x))
}

/// Moves the dragged points to their pins, and points nearby along with them.
pub fn bend(points: &mut [[f64; 2]], pins: &[Pin]) {
    let (centre, size) = (centred(points), points.len().max(1) as f64);
    let reach = REACH * norm(&centre.0) / size.sqrt() * 2.0;
    let falloff = |a: [f64; 2], b: [f64; 2]| {
        let square = (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2);
        libm::exp(-square / (reach * reach))
    };
    let at: Vec<[f64; 2]> = pins.iter().map(|(k, _)| points[*k]).collect();
    let matrix = DMatrix::from_fn(pins.len(), pins.len(), |i, k| {
        falloff(at[i], at[k]) + if i == k { 1e-9 } else { 0.0 }
    });
    let off = DMatrix::from_fn(pins.len(), 2, |i, axis| pins[i].1[axis] - at[i][axis]);
    let Some(solved) = matrix.cholesky().map(|factor| factor.solve(&off)) else { return };
    for point in points.iter_mut() {
        let own = *point;
        for (row, pin) in at.iter().enumerate() {
            let share = falloff(own, *pin);
            (0..2).for_each(|axis| point[axis] += share * solved[(row, axis)]);
        }
    }
}

/// Estimates the covariance of the training parameters from the centres of the kernel, which are the training views.
/// Without centres, estimates the covariance from the ranges.
fn covariance(model: &KernelModel, names: &[String]) -> DMatrix<f64> {
    let rows = examples(model);
    let d = names.len();
    let mut out = DMatrix::zeros(d, d);
    if rows.len() > 1 {
        let n = rows.len() as f64;
        let mean: Vec<f64> =
            (0..d).map(|c| rows.iter().map(|row| row[c]).sum::<f64>() / n).collect();
        for row in &rows {
            for (i, k) in (0..d).flat_map(|i| (0..d).map(move |k| (i, k))) {
                out[(i, k)] += (row[i] - mean[i]) * (row[k] - mean[k]) / n;
            }
        }
    } else {
        spreads(model).iter().enumerate().for_each(|(c, own)| out[(c, c)] = own.powi(2));
    }
    // A parameter that is constant in training may still move a little.
    let floor = FLOOR * out.trace() / d.max(1) as f64;
    (0..d).for_each(|c| out[(c, c)] += floor);
    out
}

/// Lists standard deviations of the parameters by their ranges.
fn spreads(model: &KernelModel) -> Vec<f64> {
    let mut out = Vec::new();
    for (input, first) in with_features(&model.inputs) {
        let [low, high] = model.ranges[first];
        match input.kind {
            InputKind::Rotation { .. } => {
                out.extend(names_of(std::slice::from_ref(input)).iter().map(|_| ANGLE));
            }
            _ => out.push((high - low) / 12f64.sqrt()),
        }
    }
    out
}

/// Reads the training parameters from the centres, in the order of their names.
fn examples(model: &KernelModel) -> Vec<Vec<f64>> {
    let sum = &model.sum;
    let row = |k: usize| {
        let value = |c: usize| match sum.scale[c] {
            0.0 => sum.shift[c],
            scale => sum.centres[(c, k)] / scale + sum.shift[c],
        };
        let mut out = Vec::new();
        for (input, first) in with_features(&model.inputs) {
            match input.kind {
                InputKind::Rotation { feature: Feature::Matrix, order: Some(order) } => {
                    let matrix: [f64; 9] = std::array::from_fn(|entry| value(first + entry));
                    let angles = angles(order, &matrix);
                    let named = angles_of(input).zip(angles);
                    out.extend(named.filter(|(name, _)| !name.is_empty()).map(|(_, angle)| angle));
                }
                _ => out.push(value(first)),
            }
        }
        out
    };
    (0..sum.centres.ncols()).map(row).collect()
}

/// Returns the angles about x, y and z of a rotation matrix (by rows) in an order, degrees.
fn angles(order: EulerOrder, matrix: &[f64; 9]) -> [f64; 3] {
    let [i, j, k] = match order {
        EulerOrder::Xyz => [0, 1, 2],
        EulerOrder::Xzy => [0, 2, 1],
        EulerOrder::Yxz => [1, 0, 2],
        EulerOrder::Yzx => [1, 2, 0],
        EulerOrder::Zxy => [2, 0, 1],
        EulerOrder::Zyx => [2, 1, 0],
    };
    let sign = if (i + 1) % 3 == j { 1.0 } else { -1.0 };
    let at = |r: usize, c: usize| matrix[3 * r + c];
    let mut out = [0.0; 3];
    out[i] = (sign * at(k, j)).atan2(at(k, k));
    out[j] = (-sign * at(k, i)).clamp(-1.0, 1.0).asin();
    out[k] = (sign * at(j, i)).atan2(at(i, i));
    out.map(f64::to_degrees)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::regression::rotations::from_euler;

    #[test]
    fn angles_come_back_from_their_matrix() {
        for order in EulerOrder::ALL {
            let expected = [25.0, -70.0, 140.0];
            let expected =
                [0, 1, 2].map(|axis| if axis == middle(order) { -40.0 } else { expected[axis] });
            let matrix = Feature::Matrix.of(from_euler(order, expected)).unwrap();
            let found = angles(order, &matrix.try_into().unwrap());
            assert!((0..3).all(|axis| (found[axis] - expected[axis]).abs() < 1e-9), "{order:?}");
        }
    }

    fn middle(order: EulerOrder) -> usize {
        "XYZ".find(&order.name()[1..2]).unwrap()
    }

    #[test]
    fn dragged_points_meet_their_pins_and_far_points_stay() {
        let grid = |place: usize| [f64::from(place as u32 % 10), f64::from(place as u32 / 10)];
        let mut points: Vec<[f64; 2]> = (0..100).map(grid).collect();
        bend(&mut points, &[(0, [-0.5, 0.25]), (11, [1.0, 1.0])]);
        assert!((points[0][0] + 0.5).abs() < 1e-6 && (points[11][1] - 1.0).abs() < 1e-6);
        assert!((points[99][0] - 9.0).abs() < 1e-6);
    }
}
