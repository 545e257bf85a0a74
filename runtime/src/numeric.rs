//! The transcendental functions, each in one bounded-range form that every backend shares.
//!
//! Coefficients are minimax fits of the relative error, rounded to f32. Evaluation is Horner's
//! scheme without fused multiply-add. The tests hold the error bounds in the comments.

use crate::lanes::{HALF_KEPT, HALF_SCALE, ROUND, Real};

/// Returns the correctly rounded square root of `x >= 0`.
#[inline]
pub(crate) fn sqrt<R: Real>(x: R) -> R {
    x.square_root()
}

/// Returns the lesser of two numbers; `a` where they are equal, or `b` is not a number.
///
/// `f32::min` may return either of two zeros, and does so differently on different CPUs.
#[inline(always)]
pub(crate) fn lesser<R: Real>(a: R, b: R) -> R {
    b.where_less(a, || b, || a)
}

/// Returns the greater of two numbers; `a` where they are equal, or `b` is not a number.
#[inline(always)]
pub(crate) fn greater<R: Real>(a: R, b: R) -> R {
    a.where_less(b, || b, || a)
}

/// Decodes the two half-precision numbers in a word, lower half first; each is normal or 0.
#[inline(always)]
pub(crate) fn halves(word: u32) -> [f32; 2] {
    // Sign, exponent and mantissa move to their places in single precision.
    let single = |high: u32| f32::from_bits((high as i32 >> 3) as u32 & HALF_KEPT) * HALF_SCALE;
    [single(word << 16), single(word)]
}

/// Largest number of half turns that [`sin_versine`] reduces. A multiple of pi's parts is exact
/// below 2^12.
pub(crate) const HALF_TURNS_MAX: f32 = 1024.0;

/// Returns the sine and the versine (1 - cos) of an angle in radians, `0 <= angle <= pi
/// HALF_TURNS_MAX`.
///
/// The versine keeps its relative accuracy near 0, where 1 - cos would lose accuracy (METHOD §7).
/// Error: 2 ULP up to pi/2; above, 1.3e-7 of the sine and 2e-7 of the versine.
pub(crate) fn sin_versine(angle: f32) -> (f32, f32) {
    // pi in three parts. Multiples of the first two are exact below 2^12.
    const PI_0: f32 = 3.140_625;
    const PI_1: f32 = 9.675_026e-4;
    const PI_2: f32 = 1.509_958e-7;
    let turns = (angle * core::f32::consts::FRAC_1_PI + 0.5) as i32;
    let k = turns as f32;
    let r = ((angle - k * PI_0) - k * PI_1) - k * PI_2;
    let x = r * r;
    let sine = r + r
        * x
        * (-0.166_666_6 + x * (8.333_066e-3 + x * (-1.980_959_6e-4 + x * 2.605_765_5e-6)));
    let versine = 0.5 * x
        + x * x
            * (-0.041_666_66 + x * (1.388_867_5e-3 + x * (-2.477_573_8e-5 + x * 2.631_702_5e-7)));
    if turns & 1 == 0 { (sine, versine) } else { (-sine, 2.0 - versine) }
}

/// Returns the angle of the point (x, y) from the x axis, `x >= 0`, `y >= 0`, in [0, pi/2].
///
/// Error: 2.1 ULP. The origin gives 0.
pub(crate) fn quadrant_angle(y: f32, x: f32) -> f32 {
    let is_steep = y > x;
    let (lesser, greater) = if is_steep { (x, y) } else { (y, x) };
    let angle = atan_unit(if greater > 0.0 { lesser / greater } else { 0.0 });
    if is_steep { core::f32::consts::FRAC_PI_2 - angle } else { angle }
}

// ln 2 in two parts. Multiples of the first are exact below 2^8.
const LN_2_0: f32 = 0.693_359_4;
const LN_2_1: f32 = -2.121_944_4e-4;

/// Argument at which [`exp_negative`] stops falling, above the least normal number.
pub(crate) const EXP_MAX: f32 = 87.0;

/// Returns `e^-a` of `a >= 0`: 1 at 0, and 1.6e-38 from [`EXP_MAX`] on. NaN also gives 1.6e-38.
///
/// Error: 1 ULP. The code has no branches and only integer steps that GLSL and WGSL have. Bare
/// targets share one function, because inlined copies took 2 kB.
#[cfg_attr(not(target_os = "none"), inline(always))]
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn exp_negative<R: Real>(a: R) -> R {
    let a = lesser(a.splat(EXP_MAX), a);
    let rounded = a.splat(ROUND) - a * core::f32::consts::LOG2_E;
    let k = rounded - ROUND;
    let r = (-a - k * LN_2_0) - k * LN_2_1;
    let tail = r * (r * 1.382_094_7e-3 + 8.368_684e-3) + 0.041_668_266;
    let power = (r * r * (r * (r * tail + 0.166_665_21) + 0.499_999_94) + r) + 1.0;
    power * rounded.power_of_two()
}

/// Returns `1 - e^-a` of `a >= 0`, accurate to its last places for small a too.
///
/// Error: 2 ULP.
#[inline(always)]
pub(crate) fn one_minus_exp_negative<R: Real>(a: R) -> R {
    // Above ln 2 the difference from 1 loses no accuracy.
    let tail = a * (a * (a * 1.465_846_3e-4 - 1.341_553e-3) + 8.311_225e-3) - 0.041_661_285;
    let near = a * a * (a * (a * tail + 0.166_666_03) - 0.499_999_97) + a;
    a.where_less(
        a.splat(core::f32::consts::LN_2),
        || near,
        #[inline(always)]
        || a.splat(1.0) - exp_negative(a),
    )
}

/// Returns the natural logarithm of `x >= 0`. Below the least normal number it returns that
/// number's logarithm.
///
/// Error: 1 ULP, also near 1, where the logarithm is small. The code has no branches and only
/// integer steps that GLSL and WGSL have.
#[cfg(feature = "kernel")]
#[cfg_attr(not(target_os = "none"), inline(always))]
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) fn ln<R: Real>(x: R) -> R {
    let (k, mantissa) = greater(x, x.splat(f32::MIN_POSITIVE)).exponent_and_mantissa();
    let f = mantissa - 1.0;
    let square = f * f;
    let tail = f * (f * (f * -0.076_363_62 + 0.127_621_43) - 0.131_595_98) + 0.142_015_86;
    let middle = f * (f * (f * tail - 0.166_234_1) + 0.200_012_42) - 0.250_008_2;
    let curve = square * f * (f * middle + 0.333_333_3) - square * 0.5;
    (f + (curve + k * LN_2_1)) + k * LN_2_0
}

/// Returns the nearness of a squared distance, in [0, 1]: 1 up to a fade's start, 0 from its end
/// on, and a quintic step between (METHOD §2.6). NaN counts as far.
#[inline(always)]
pub(crate) fn nearness<R: Real>(s: R, (start, end): (f32, f32)) -> R {
    let last = s.splat(end);
    let left = s.where_less(last, || last - s, || s.splat(0.0));
    let u = left / s.splat(end - start);
    smoothstep(lesser(u.splat(1.0), u))
}

/// Returns `u³ (10 - 15 u + 6 u²)` of `0 <= u <= 1`, in [0, 1]: 0 at 0, 1 at 1, flat at both.
///
/// Written in v = 1 - u, which makes every term positive. Error: 4e-7 of the value.
#[inline(always)]
pub(crate) fn smoothstep<R: Real>(u: R) -> R {
    let v = u.splat(1.0) - u;
    let step = u * u * u * (v * (v * 6.0 + 3.0) + 1.0);
    lesser(step.splat(1.0), step)
}

/// Returns the arc tangent of `0 <= z <= 1`.
#[cfg_attr(target_os = "none", inline(never))]
fn atan_unit(z: f32) -> f32 {
    let x = z * z;
    let tail = 0.043_211_833 + x * (-0.016_367_91 + x * 2.920_688e-3);
    let middle = -0.142_110_56 + x * (0.106_660_04 + x * (-0.075_522_12 + x * tail));
    z + z * x * (-0.333_331_53 + x * (0.199_937_73 + x * middle))
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use core::f32::consts::{FRAC_PI_2, PI};

    /// Distance in units of the last place of the exact value, rounded to f32.
    fn ulps(found: f32, exact: f64) -> f64 {
        assert!(found.is_finite());
        let near = exact as f32;
        let step = f32::from_bits(near.abs().max(1e-30).to_bits() + 1) - near.abs().max(1e-30);
        (f64::from(found) - exact).abs() / f64::from(step)
    }

    /// Every `stride`-th f32 from `from` to `to`; only some hundreds under Miri, which is slow.
    fn dense(from: f32, to: f32, stride: usize) -> impl Iterator<Item = f32> {
        let stride = if cfg!(miri) { 10_007 * stride } else { stride };
        (from.to_bits()..=to.to_bits()).step_by(stride).map(f32::from_bits)
    }

    #[test]
    fn sine_and_versine_to_their_last_places() {
        let (mut sine_ulps, mut versine_ulps) = (0.0f64, 0.0f64);
        for x in dense(1e-6, FRAC_PI_2, 31) {
            let (sine, versine) = sin_versine(x);
            let half = (f64::from(x) / 2.0).sin();
            sine_ulps = sine_ulps.max(ulps(sine, f64::from(x).sin()));
            versine_ulps = versine_ulps.max(ulps(versine, 2.0 * half * half));
        }
        assert!(sine_ulps <= 2.0 && versine_ulps <= 2.0, "{sine_ulps} {versine_ulps}");
        assert!(sine_ulps > 0.4 && versine_ulps > 0.4, "the measure sees rounding");
    }

    #[test]
    fn sine_and_versine_over_the_whole_range() {
        let (mut sine_error, mut versine_error) = (0.0f64, 0.0f64);
        for x in dense(FRAC_PI_2, PI * HALF_TURNS_MAX, 61) {
            let (sine, versine) = sin_versine(x);
            let x = f64::from(x);
            sine_error = sine_error.max((f64::from(sine) - x.sin()).abs());
            versine_error = versine_error.max((f64::from(versine) - (1.0 - x.cos())).abs());
        }
        assert!(sine_error <= 1.3e-7 && versine_error <= 2e-7, "{sine_error} {versine_error}");
    }

    #[test]
    fn one_minus_the_exponential_to_its_last_places() {
        let mut worst = 0.0f64;
        for a in dense(1e-12, 90.0, 251) {
            worst = worst.max(ulps(one_minus_exp_negative(a), -f64::from(-a).exp_m1()));
        }
        assert!(worst <= 2.0 && worst > 0.4, "{worst}");
        assert_eq!(one_minus_exp_negative(0.0f32), 0.0);
        assert_eq!(one_minus_exp_negative(f32::INFINITY), 1.0);
    }

    #[test]
    fn quadrant_angle_to_its_last_places() {
        let mut worst = 0.0f64;
        for y in dense(1e-12, 1.0, 61) {
            let x = 1.0 - 0.25 * y;
            for (y, x) in [(y, x), (x, y)] {
                worst = worst.max(ulps(quadrant_angle(y, x), f64::from(y).atan2(f64::from(x))));
            }
        }
        assert!(worst <= 2.1, "{worst}");
        assert_eq!(quadrant_angle(0.0, 0.0), 0.0);
        assert_eq!(quadrant_angle(1.0, 0.0), FRAC_PI_2);
        assert_eq!(quadrant_angle(0.0, 1.0), 0.0);
    }

    #[test]
    fn exponentials_to_their_last_places() {
        let mut worst = 0.0f64;
        for a in dense(1e-9, EXP_MAX, 61) {
            worst = worst.max(ulps_down_to_the_least(exp_negative(a), (-f64::from(a)).exp()));
        }
        assert!(worst <= 1.0 && worst > 0.4, "{worst}");
        assert_eq!([0.0, -0.0, f32::MIN_POSITIVE].map(exp_negative), [1.0; 3]);
    }

    /// Like [`ulps`], for numbers below 1e-30 too.
    fn ulps_down_to_the_least(found: f32, exact: f64) -> f64 {
        let near = exact as f32;
        assert!(found.is_normal() && near.is_normal());
        (f64::from(found) - exact).abs() / f64::from(near.next_up() - near)
    }

    #[cfg(feature = "kernel")]
    #[test]
    fn logarithms_to_their_last_places() {
        let (mut near, mut far) = (0.0f64, 0.0f64);
        for x in dense(0.5, 2.0, 7) {
            near = near.max(ulps(ln(x), f64::from(x).ln()));
        }
        for x in dense(f32::MIN_POSITIVE, f32::MAX, 211) {
            far = far.max(ulps(ln(x), f64::from(x).ln()));
        }
        assert!(near <= 1.0 && far <= 1.0 && near > 0.4 && far > 0.4, "{near} {far}");
        assert_eq!(ln(1.0f32), 0.0);
        assert_eq!([0.0f32, -0.0, 1e-45].map(ln), [ln(f32::MIN_POSITIVE); 3]);
        assert!([f32::INFINITY, f32::NAN].map(ln).iter().all(|x| x.is_finite()));
    }

    #[test]
    fn exponentials_stop_at_a_normal_number() {
        let least = exp_negative(EXP_MAX);
        assert!(least.is_normal() && least < 2e-38);
        let beyond = [EXP_MAX + 0.01, 88.0, 1e9, f32::MAX, f32::INFINITY, f32::NAN];
        assert!(beyond.iter().all(|&a| exp_negative(a) == least));
    }

    #[test]
    fn the_step_is_exact_at_its_ends_and_never_leaves_them() {
        assert_eq!([0.0f32, 0.5, 1.0].map(smoothstep), [0.0, 0.5, 1.0]);
        for u in dense(1e-12, 1.0, 31) {
            let x = f64::from(u);
            let exact = x * x * x * (10.0 - 15.0 * x + 6.0 * x * x);
            let step = smoothstep(u);
            assert!((0.0..=1.0).contains(&step));
            assert!((f64::from(step) / exact - 1.0).abs() <= 4e-7, "{u}");
        }
    }

    #[test]
    fn the_first_of_two_zeros_is_taken() {
        for f in [lesser::<f32>, greater] {
            assert_eq!(f(0.0, -0.0).to_bits(), 0.0f32.to_bits());
            assert_eq!(f(-0.0, 0.0).to_bits(), (-0.0f32).to_bits());
            assert_eq!(f(1.0, f32::NAN), 1.0);
        }
        assert_eq!([lesser(1.0, 2.0), lesser(2.0, 1.0)], [1.0f32; 2]);
        assert_eq!([greater(1.0, 2.0), greater(2.0, 1.0)], [2.0f32; 2]);
    }

    #[test]
    fn square_roots_are_correctly_rounded() {
        assert!(dense(1e-40, 1e38, 997).all(|x| sqrt(x) == f64::from(x).sqrt() as f32));
    }
}
