// The kernels of scattered data, as functions of a squared distance.

// Natural logarithm of x >= 0; subnormal numbers count as the least normal number.
float ln(float x) {
    // The bits of floats >= 0, read as integers, have the order of the floats.
    int bits = max(floatBitsToInt(x), 0x00800000);
    // Subtracting the bits of sqrt(1/2) puts mantissas between sqrt(1/2) and sqrt(2).
    int k = (bits - 0x3f3504f3) >> 23;
    precise float f = intBitsToFloat(bits - (k << 23)) - 1.0;
    float n = float(k);
    precise float square = f * f;
    precise float tail = 0.14201586 + f * (-0.13159598 + f * (0.12762143 + f * -0.07636362));
    precise float middle = -0.2500082 + f * (0.20001242 + f * (-0.1662341 + f * tail));
    precise float curve = square * f * (0.3333333 + f * middle) - 0.5 * square;
    precise float result = (f + (curve + n * -2.1219444e-4)) + n * 0.6933594;
    return result;
}

// (1 - r)^(l + 1) ((l + 1) r + 1), r clamped to 1; the power multiplies from the left.
float wendland(uint l, float distance) {
    float r = 1.0 < distance ? 1.0 : distance;
    precise float q = 1.0 - r;
    precise float power = q;
    for (uint i = 1u; i < l; i++) {
        power *= q;
    }
    precise float value = power * q * ((float(l) + 1.0) * r + 1.0);
    return value;
}

// 1 - r^power where r < 1, else 0; powers are 1, 3 and 5.
float hat(uint power, float s) {
    precise float r = sqrt(s);
    precise float fallen = power == 1u ? r : (power == 3u ? s * r : s * s * r);
    precise float left = 1.0 - fallen;
    return r < 1.0 ? left : 0.0;
}

// A kernel by its number and its parameter in the file.
float kernel_value(uint kernel, uint parameter, float s) {
    precise float r = sqrt(s);
    precise float shifted = 1.0 + s;
    precise float value;
    switch (kernel) {
        case 1u:
            value = -r;
            break;
        case 2u:
            value = 0.5 * s * ln(s);
            break;
        case 3u:
            value = s * r;
            break;
        case 4u:
            value = -(s * s * r);
            break;
        case 5u:
            value = -sqrt(shifted);
            break;
        case 6u:
            value = 1.0 / sqrt(shifted);
            break;
        case 7u:
            value = 1.0 / shifted;
            break;
        case 8u:
            value = exp_negative(s);
            break;
        case 12u:
            value = wendland(parameter, r);
            break;
        case 13u:
            value = hat(parameter, s);
            break;
        default:
            value = matern(kernel, s);
            break;
    }
    return value;
}
