// The kernels of scattered data, as functions of a squared distance.

// Natural logarithm of x >= 0; subnormal numbers count as the least normal number.
fn ln(x: f32) -> f32 {
    // The bits of floats >= 0, read as integers, have the order of the floats.
    let bits = max(bitcast<i32>(x), 0x00800000);
    // Subtracting the bits of sqrt(1/2) puts mantissas between sqrt(1/2) and sqrt(2).
    let k = (bits - 0x3f3504f3) >> 23u;
    let f = bitcast<f32>(bits - (k << 23u)) - 1.0;
    let n = f32(k);
    let square = f * f;
    let tail = 0.14201586 + f * (-0.13159598 + f * (0.12762143 + f * -0.07636362));
    let middle = -0.2500082 + f * (0.20001242 + f * (-0.1662341 + f * tail));
    let curve = square * f * (0.3333333 + f * middle) - 0.5 * square;
    return (f + (curve + n * -2.1219444e-4)) + n * 0.6933594;
}

// A kernel by its number and its parameter in the file.
fn kernel_value(kernel: u32, parameter: u32, s: f32) -> f32 {
    switch kernel {
        case 1u: {
            return -sqrt(s);
        }
        case 2u: {
            return 0.5 * s * ln(s);
        }
        case 3u: {
            return s * sqrt(s);
        }
        case 4u: {
            return -(s * s * sqrt(s));
        }
        case 5u: {
            return -sqrt(1.0 + s);
        }
        case 6u: {
            return 1.0 / sqrt(1.0 + s);
        }
        case 7u: {
            return 1.0 / (1.0 + s);
        }
        case 8u: {
            return exp_negative(s);
        }
        case 12u: {
            return wendland(parameter, sqrt(s));
        }
        case 13u: {
            return hat(parameter, s);
        }
        default: {
            return matern(kernel, s);
        }
    }
}

// (1 - r)^(l + 1) ((l + 1) r + 1), r clamped to 1; the power multiplies from the left.
fn wendland(l: u32, distance: f32) -> f32 {
    let r = select(distance, 1.0, 1.0 < distance);
    let q = 1.0 - r;
    var power = q;
    for (var i = 1u; i < l; i++) {
        power *= q;
    }
    return power * q * ((f32(l) + 1.0) * r + 1.0);
}

// 1 - r^power where r < 1, else 0; powers are 1, 3 and 5.
fn hat(power: u32, s: f32) -> f32 {
    let r = sqrt(s);
    var fallen = r;
    if power == 3u {
        fallen = s * r;
    } else if power != 1u {
        fallen = s * s * r;
    }
    return select(0.0, 1.0 - fallen, r < 1.0);
}
