//! From values to outputs: the fade, ranges, sums of 1, and rotations from their vectors.

use super::output::{OutputKind, OutputRow};
use super::rule::{Normalise, QueryRule};
use super::view::KernelMap;
use crate::error::{Argument, CallError, CallErrorKind};
use crate::numeric::{greater, lesser};

/// Computes the outputs of m values.
///
/// # Errors
/// [`CallErrorKind::NonFinite`]: an output is not finite; the index is that of its first number.
pub(super) fn evaluate(
    map: &KernelMap<'_>,
    confidence: f32,
    values: &[f32],
    out: &mut [f32],
) -> Result<(), CallError> {
    let rule = map.rule();
    let (mut values, mut left, mut place) = (values, &mut *out, 0);
    for output in map.outputs() {
        let (own, rest) = values.split_at(output.kind.value_len().min(values.len()));
        let len = output.kind.number_len().min(left.len());
        let (numbers, others) = core::mem::take(&mut left).split_at_mut(len);
        let mut found = own_values(own);
        let is_sound = found.iter().all(|x| x.is_finite());
        if rule.query == QueryRule::Fade {
            for (value, neutral) in found.iter_mut().zip(output.neutral_values()) {
                // At either end exactly one of the two.
                *value = confidence * *value + (1.0 - confidence) * neutral;
            }
        }
        let [x, y, z, w] = output_of(&output, found);
        for (number, value) in numbers.iter_mut().zip([x, y, z, w]) {
            *number = value;
        }
        check(is_sound && numbers.iter().all(|x| x.is_finite()), place)?;
        place += numbers.len();
        (values, left) = (rest, others);
    }
    normalise(map, rule.normalise, out)
}

/// Returns up to three values; zeros behind them.
fn own_values(values: &[f32]) -> [f32; 3] {
    let mut out = [0.0; 3];
    out.iter_mut().zip(values).for_each(|(out, value)| *out = *value);
    out
}

/// Returns an output of its values; zeros behind its numbers.
fn output_of(output: &OutputRow, [x, y, z]: [f32; 3]) -> [f32; 4] {
    let (low, high) = output.range;
    match output.kind {
        OutputKind::Scalar => [lesser(greater(x, low), high), 0.0, 0.0, 0.0],
        OutputKind::Vector3 => [x, y, z, 0.0],
        OutputKind::Rotation => product(output.neutral, rotation([x, y, z])),
    }
}

/// Returns the quaternion of a rotation's vector, 4 tan(angle / 4) along its axis: near the rotation vector,
/// and of no trigonometry.
fn rotation([x, y, z]: [f32; 3]) -> [f32; 4] {
    let square = (x * x + y * y + z * z) * 0.0625;
    let length = 1.0 + square;
    [0.5 * x / length, 0.5 * y / length, 0.5 * z / length, (1.0 - square) / length]
}

/// Returns the quaternion a b: first b, then a.
fn product([ax, ay, az, aw]: [f32; 4], [bx, by, bz, bw]: [f32; 4]) -> [f32; 4] {
    [
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    ]
}

/// Divides the marked outputs by their sum, if it is one that is brought to 1.
fn normalise(map: &KernelMap<'_>, rule: Normalise, out: &mut [f32]) -> Result<(), CallError> {
    if rule == Normalise::Never {
        return Ok(());
    }
    let mut sum = 0.0;
    let mut place = 0;
    for output in map.outputs() {
        if let Some(number) = out.get(place).filter(|_| output.is_marked) {
            sum += number;
            check(f32::is_finite(sum), place)?;
        }
        place += output.kind.number_len();
    }
    if sum > rule.least() {
        place = 0;
        for output in map.outputs() {
            if let Some(number) = out.get_mut(place).filter(|_| output.is_marked) {
                *number /= sum;
                check(number.is_finite(), place)?;
            }
            place += output.kind.number_len();
        }
    }
    Ok(())
}

/// Checks an output, given by its first number.
fn check(is_finite: bool, place: usize) -> Result<(), CallError> {
    if is_finite {
        return Ok(());
    }
    Err(CallError::new(CallErrorKind::NonFinite, Argument::Outputs).at(place))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vector_turns_by_four_times_the_tangent_of_a_quarter() {
        for angle in [0.0f32, 1e-3, 0.7, 2.0, 3.1, 5.0] {
            let quarter = f64::from(angle) / 4.0;
            let vector = [0.48, -0.6, 0.64].map(|x| (4.0 * quarter.tan() * x) as f32);
            let [x, y, z, w] = rotation(vector).map(f64::from);
            let (sine, cosine) = (2.0 * quarter).sin_cos();
            for (found, expected) in
                [(x, 0.48 * sine), (y, -0.6 * sine), (z, 0.64 * sine), (w, cosine)]
            {
                assert!((found - expected).abs() < 3e-7, "{angle}");
            }
        }
    }

    #[test]
    fn a_product_turns_by_the_second_first() {
        // A quarter about z, then a quarter about x: z goes to -y, as the first leaves it.
        let half = core::f32::consts::FRAC_1_SQRT_2;
        let both = product([half, 0.0, 0.0, half], [0.0, 0.0, half, half]);
        let turned = crate::linear::turn(both).map(|[_, _, z]| z);
        for (found, expected) in turned.iter().zip([0.0, -1.0, 0.0]) {
            assert!((found - expected).abs() < 1e-6);
        }
    }
}
