//! From values to outputs: the fade, ranges, sums of 1, and rotations from their vectors.

use super::output::OutputKind;
use super::rule::{Normalise, QueryRule};
use super::view::KernelMap;
use crate::error::{Argument, CallError, CallErrorKind};
use crate::numeric::{greater, lesser};

/// Computes the outputs of m values, which the fade may change.
///
/// # Errors
/// [`CallErrorKind::NonFinite`]: an output is not finite; the index is that of its first number.
pub(super) fn evaluate(
    map: &KernelMap<'_>,
    confidence: f32,
    values: &mut [f32],
    out: &mut [f32],
) -> Result<(), CallError> {
    let rule = map.rule();
    // Before a range keeps what is infinite within it.
    check(map, values, |kind| kind.value_len())?;
    if rule.query == QueryRule::Fade {
        fade(map, confidence, values);
    }
    let (mut values, mut left) = (&*values, &mut *out);
    for output in map.outputs() {
        // Of a loaded file there are as many of both as its outputs have.
        let (own, rest) = values.split_at(output.kind.value_len().min(values.len()));
        let len = output.kind.number_len().min(left.len());
        let (numbers, others) = core::mem::take(&mut left).split_at_mut(len);
        (values, left) = (rest, others);
        match (output.kind, own, numbers) {
            (OutputKind::Scalar, [x], [out]) => {
                let (low, high) = output.range;
                *out = lesser(greater(*x, low), high);
            }
            (OutputKind::Rotation, [x, y, z], [a, b, c, d]) => {
                [*a, *b, *c, *d] = product(output.neutral, rotation([*x, *y, *z]));
            }
            (_, own, numbers) => numbers.iter_mut().zip(own).for_each(|(out, x)| *out = *x),
        }
    }
    normalise(map, rule.normalise, out);
    check(map, out, |kind| kind.number_len())
}

/// Lets values tend to the neutral ones; at either end they are exactly one of the two.
fn fade(map: &KernelMap<'_>, confidence: f32, values: &mut [f32]) {
    let mut left = values.iter_mut();
    for output in map.outputs() {
        let neutrals = output.neutral_values();
        let neutrals = neutrals.iter().take(output.kind.value_len());
        for (neutral, value) in neutrals.zip(left.by_ref()) {
            *value = confidence * *value + (1.0 - confidence) * neutral;
        }
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
fn normalise(map: &KernelMap<'_>, rule: Normalise, out: &mut [f32]) {
    if rule == Normalise::Never {
        return;
    }
    let (mut sum, mut place) = (0.0, 0);
    for output in map.outputs() {
        if let Some(number) = out.get(place).filter(|_| output.is_marked) {
            sum += number;
        }
        place += output.kind.number_len();
    }
    if sum > rule.least() {
        // What a sum that overflows leaves would look like a number.
        let by = if sum.is_finite() { sum } else { f32::NAN };
        place = 0;
        for output in map.outputs() {
            if let Some(number) = out.get_mut(place).filter(|_| output.is_marked) {
                *number /= by;
            }
            place += output.kind.number_len();
        }
    }
}

/// Checks that values or outputs are finite, of which an output has so many.
fn check(
    map: &KernelMap<'_>,
    values: &[f32],
    len: impl Fn(OutputKind) -> usize,
) -> Result<(), CallError> {
    let Some(unsound) = values.iter().position(|x| !x.is_finite()) else { return Ok(()) };
    // The first number of the output that it belongs to.
    let (mut end, mut place) = (0, 0);
    for output in map.outputs() {
        end += len(output.kind);
        if unsound < end {
            break;
        }
        place += output.kind.number_len();
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
