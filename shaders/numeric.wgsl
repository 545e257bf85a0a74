// The transcendental functions: the runtime's polynomials, operation by operation. The signs leave
// a compiler no sum to split: it sees 1 + (a + b), not 1 - (-a - b).

// Sine and versine (1 - cos) of an angle >= 0.
fn sin_versine(angle: f32) -> vec2<f32> {
    let turns = i32(angle * 0.318309886 + 0.5);
    let k = f32(turns);
    let r = ((angle - k * 3.140625) - k * 9.675026e-4) - k * 1.509958e-7;
    let x = r * r;
    let sine = r + r * x
        * (-0.1666666 + x * (8.333066e-3 + x * (-1.9809596e-4 + x * 2.6057655e-6)));
    let versine = 0.5 * x + x * x
        * (-0.04166666 + x * (1.3888675e-3 + x * (-2.4775738e-5 + x * 2.6317025e-7)));
    return select(vec2<f32>(-sine, 2.0 - versine), vec2<f32>(sine, versine), (turns & 1) == 0);
}

// Arc tangent of 0 <= z <= 1.
fn atan_unit(z: f32) -> f32 {
    let x = z * z;
    let tail = 0.043211833 + x * (-0.01636791 + x * 2.920688e-3);
    let middle = -0.14211056 + x * (0.10666004 + x * (-0.07552212 + x * tail));
    return z + z * x * (-0.33333153 + x * (0.19993773 + x * middle));
}

// Angle of the point (x, y) from the x axis, both >= 0; 0 at the origin.
fn quadrant_angle(y: f32, x: f32) -> f32 {
    if y <= x {
        if x > 0.0 {
            return atan_unit(y / x);
        }
        return 0.0;
    }
    return 1.57079632679 - atan_unit(x / y);
}

const EXP_MAX: f32 = 87.0;

// e^-a of a >= 0, constant from EXP_MAX on.
fn exp_negative(value: f32) -> f32 {
    let a = select(EXP_MAX, value, value < EXP_MAX);
    let k = round(a * 1.44269504089);
    let r = -((a - k * 0.6933594) - k * -2.1219444e-4);
    let tail = 0.041668266 + r * (8.368684e-3 + r * 1.3820947e-3);
    let power = 1.0 - (-r - r * r * (0.49999994 + r * (0.16666521 + r * tail)));
    return power * bitcast<f32>(0x3f800000 - (i32(k) << 23u));
}

// 1 - e^-a of a >= 0.
fn one_minus_exp_negative(a: f32) -> f32 {
    let tail = -0.041661285 + a * (8.311225e-3 + a * (-1.341553e-3 + a * 1.4658463e-4));
    let near = a + a * a * (-0.49999997 + a * (0.16666603 + a * tail));
    return select(1.0 - exp_negative(a), near, a < 0.69314718056);
}

// u^3 (10 - 15 u + 6 u^2) of 0 <= u <= 1.
fn smooth_step(u: f32) -> f32 {
    let v = 1.0 - u;
    let step = u * u * u * (1.0 + v * (3.0 + v * 6.0));
    return select(1.0, step, step < 1.0);
}

// Nearness of a squared distance: 1 up to a fade's start, 0 from its end, a quintic step between.
fn nearness(s: f32, start: f32, end: f32) -> f32 {
    let left = select(0.0, end - s, s < end);
    let u = left / (end - start);
    return smooth_step(select(1.0, u, u < 1.0));
}

// A Matern kernel of a squared distance, by its number: 9, 10 and 11 are 1/2, 3/2 and 5/2.
fn matern(kernel: u32, s: f32) -> f32 {
    if kernel == 9u {
        return exp_negative(sqrt(s));
    }
    let scaled = sqrt(select(5.0, 3.0, kernel == 10u) * s);
    let a = select(EXP_MAX, scaled, scaled < EXP_MAX);
    if kernel == 10u {
        return (1.0 + a) * exp_negative(a);
    }
    // The square is always the lesser operand; min forces the compiler to compute it before the
    // product.
    return (1.0 + a + min(a * a, EXP_MAX * EXP_MAX) * (1.0 / 3.0)) * exp_negative(a);
}
