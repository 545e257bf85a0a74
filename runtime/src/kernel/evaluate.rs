//! Evaluation: from a query to outputs. The last steps apply the fade, the ranges and the
//! normalisation, and turn vectors into rotations.

use super::counts::KernelCounts;
use super::point::{self, Point};
use super::rows::OutputKind;
use super::rule::{Normalise, QueryRule};
use super::view::KernelMap;
use crate::error::{Argument, CallError, CallErrorKind};
use crate::lanes::{Unit, in_lanes};
use crate::linear::{Sum, block_product, block_sums, padded, split};
use crate::numeric::{greater, lesser, nearness};
use crate::unit::{by_unit, level};

impl KernelCounts {
    /// Returns the floats of scratch that [`KernelMap::evaluate`] needs.
    pub const fn scratch_len(&self) -> usize {
        let (n, m) = (self.centre_len as usize, self.value_len as usize);
        // A rotation has one more number than values.
        Point::scratch_len(self) + padded(n) + padded(m) + m + self.output_len as usize
    }
}

impl KernelMap<'_> {
    /// Returns the floats of scratch that [`KernelMap::evaluate`] needs.
    pub const fn scratch_len(&self) -> usize {
        self.counts().scratch_len()
    }

    /// Computes the outputs of a query, and returns their confidence in [0, 1]. The confidence is 1
    /// near a centre and 0 far from all centres; a kernel without a fade always returns 1.
    ///
    /// - `query`: [`KernelMap::query_len`] numbers, one input after the other. A scalar has 1
    ///   number, a vector 3, and a rotation a quaternion x, y, z, w of any length but 0.
    /// - `scratch`: at least [`KernelMap::scratch_len`] floats, of any content.
    /// - `out`: [`KernelMap::result_len`] numbers, one output after the other. A scalar has 1
    ///   number, a vector 3, and a rotation a quaternion of length 1.
    ///
    /// # Errors
    /// - [`crate::CallErrorKind::Length`]: `query` or `out` has another length.
    /// - [`crate::CallErrorKind::TooShort`]: `scratch` is too short.
    /// - [`crate::CallErrorKind::NonFinite`]: a number of `query` is not finite; or an output would
    ///   not be, because the query is too far out for single precision. The index of an output is
    ///   the index of its first number.
    /// - [`crate::CallErrorKind::ZeroRotation`]: the quaternion of input `index` has no direction.
    pub fn evaluate(
        &self,
        query: &[f32],
        scratch: &mut [f32],
        out: &mut [f32],
    ) -> Result<f32, CallError> {
        let counts = self.counts();
        let (n, m) = (counts.centre_len as usize, counts.value_len as usize);
        Argument::Outputs.check_len(self.result_len(), out.len())?;
        Argument::Scratch.check_least(counts.scratch_len(), scratch.len())?;
        point::check(self, query)?;
        let (point, scratch) = Point::new(self, query, scratch);
        let (basis, scratch) = split(scratch, padded(n));
        let (values, scratch) = split(scratch, padded(m));
        let confidence = self.basis(&point, basis.as_chunks_mut().0);
        let basis = basis.get(..n).unwrap_or_default();
        // Without centres and terms no column is summed.
        values.fill(0.0);
        block_product(level(), self.coefficients(), [basis, point.terms], values.as_chunks_mut().0);
        let (found, _) = split(scratch, out.len());
        let (values, _) = split(values, m);
        outputs(self, confidence, values, found)?;
        out.iter_mut().zip(found).for_each(|(out, found)| *out = *found);
        Ok(confidence)
    }

    /// Computes G for each centre, n values in whole blocks, and returns the confidence.
    pub(super) fn basis(&self, point: &Point<'_>, out: &mut [[f32; 8]]) -> f32 {
        let (rule, level) = (self.rule(), level());
        block_sums(level, Sum::Squared, self.centres(), point.z, out);
        let mut uncertainty = 1.0;
        let mut left = self.counts().centre_len as usize;
        for out in out {
            // A centre with nearness 1 leaves no uncertainty, for any other centres.
            if rule.has_fade() && uncertainty > 0.0 {
                let near = by_unit!(level, unit => {
                    unit.floats(in_lanes(unit.load(out), #[inline(always)] |s| nearness(s, rule.fade)))
                });
                for near in near.iter().take(left) {
                    uncertainty *= 1.0 - near;
                }
                left = left.saturating_sub(8);
            }
            *out = by_unit!(level, unit => unit.floats(rule.kernel.values(unit.load(out))));
        }
        if rule.has_fade() { 1.0 - uncertainty } else { 1.0 }
    }
}

/// Computes the outputs from m values. The fade may change the values.
///
/// # Errors
/// [`CallErrorKind::NonFinite`]: an output is not finite; the index is the index of its first
/// number.
fn outputs(
    map: &KernelMap<'_>,
    confidence: f32,
    values: &mut [f32],
    out: &mut [f32],
) -> Result<(), CallError> {
    let rule = map.rule();
    // Checked first, because a range would clamp an infinite value.
    check_finite(map, values, |kind| kind.value_len())?;
    if rule.query == QueryRule::Fade {
        fade(map, confidence, values);
    }
    let (mut values, mut left) = (&*values, &mut *out);
    for output in map.outputs() {
        // In a loaded file the lengths agree.
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
    check_finite(map, out, |kind| kind.number_len())
}

/// Blends values toward the neutral values. At confidence 0 or 1 the result is exactly one of the
/// two.
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

/// Returns the quaternion for a rotation's vector, 4 tan(angle / 4) along its axis. The vector is
/// close to the rotation vector, and needs no trigonometry.
fn rotation([x, y, z]: [f32; 3]) -> [f32; 4] {
    let square = (x * x + y * y + z * z) * 0.0625;
    let length = 1.0 + square;
    [0.5 * x / length, 0.5 * y / length, 0.5 * z / length, (1.0 - square) / length]
}

/// Returns the quaternion a b, which applies b first.
fn product([ax, ay, az, aw]: [f32; 4], [bx, by, bz, bw]: [f32; 4]) -> [f32; 4] {
    [
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    ]
}

/// Divides the marked outputs by their sum, if the rule normalises this sum.
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
        // Division by an infinite sum would give a finite result.
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

/// Checks that values or outputs are finite. `len` returns the numbers per output.
fn check_finite(
    map: &KernelMap<'_>,
    values: &[f32],
    len: impl Fn(OutputKind) -> usize,
) -> Result<(), CallError> {
    let Some(unsound) = values.iter().position(|x| !x.is_finite()) else { return Ok(()) };
    // Find the first number of the output with the invalid number.
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
        // A quarter turn about z leaves z in place; a quarter turn about x then takes z to -y.
        let half = core::f32::consts::FRAC_1_SQRT_2;
        let both = product([half, 0.0, 0.0, half], [0.0, 0.0, half, half]);
        let turned = crate::linear::turn(both).map(|[_, _, z]| z);
        for (found, expected) in turned.iter().zip([0.0, -1.0, 0.0]) {
            assert!((found - expected).abs() < 1e-6);
        }
    }
}
