// The transcendental functions: the runtime's polynomials, operation by operation.

// Sine and versine (1 - cos) of an angle >= 0.
vec2 sin_versine(float angle) {
    precise float scaled = angle * 0.318309886 + 0.5;
    int turns = int(scaled);
    float k = float(turns);
    precise float r = ((angle - k * 3.140625) - k * 9.675026e-4) - k * 1.509958e-7;
    precise float x = r * r;
    precise float sine = r + r * x
        * (-0.1666666 + x * (8.333066e-3 + x * (-1.9809596e-4 + x * 2.6057655e-6)));
    precise float versine = 0.5 * x + x * x
        * (-0.04166666 + x * (1.3888675e-3 + x * (-2.4775738e-5 + x * 2.6317025e-7)));
    precise float opposite = 2.0 - versine;
    return (turns & 1) == 0 ? vec2(sine, versine) : vec2(-sine, opposite);
}

// Arc tangent of 0 <= z <= 1.
float atan_unit(float z) {
    precise float x = z * z;
    precise float tail = 0.043211833 + x * (-0.01636791 + x * 2.920688e-3);
    precise float middle = -0.14211056 + x * (0.10666004 + x * (-0.07552212 + x * tail));
    precise float angle = z + z * x * (-0.33333153 + x * (0.19993773 + x * middle));
    return angle;
}

// Angle of the point (x, y) from the x axis, both >= 0; 0 at the origin.
float quadrant_angle(float y, float x) {
    bool low = y <= x;
    precise float z = low ? y / x : x / y;
    if (low && !(x > 0.0)) {
        return 0.0;
    }
    precise float angle = atan_unit(z);
    precise float other = 1.57079632679 - angle;
    return low ? angle : other;
}

const float EXP_MAX = 87.0;

// e^-a of a >= 0, constant from EXP_MAX on.
float exp_negative(float value) {
    float a = value < EXP_MAX ? value : EXP_MAX;
    precise float scaled = a * 1.44269504089;
    float k = roundEven(scaled);
    precise float r = -((a - k * 0.6933594) - k * -2.1219444e-4);
    precise float tail = 0.041668266 + r * (8.368684e-3 + r * 1.3820947e-3);
    precise float power = 1.0 + (r + r * r * (0.49999994 + r * (0.16666521 + r * tail)));
    precise float result = power * intBitsToFloat(0x3f800000 - (int(k) << 23));
    return result;
}

// 1 - e^-a of a >= 0.
float one_minus_exp_negative(float a) {
    precise float tail = -0.041661285 + a * (8.311225e-3 + a * (-1.341553e-3 + a * 1.4658463e-4));
    precise float near = a + a * a * (-0.49999997 + a * (0.16666603 + a * tail));
    precise float far = 1.0 - exp_negative(a);
    return a < 0.69314718056 ? near : far;
}

// u^3 (10 - 15 u + 6 u^2) of 0 <= u <= 1.
float smooth_step(float u) {
    precise float v = 1.0 - u;
    precise float curve = u * u * u * (1.0 + v * (3.0 + v * 6.0));
    return curve < 1.0 ? curve : 1.0;
}

// Nearness of a squared distance: 1 up to a fade's start, 0 from its end, a quintic step between.
float nearness(float s, float start, float end) {
    precise float left = s < end ? end - s : 0.0;
    precise float u = left / (end - start);
    return smooth_step(u < 1.0 ? u : 1.0);
}

// A Matern kernel of a squared distance, by its number: 9, 10 and 11 are 1/2, 3/2 and 5/2.
float matern(uint kernel, float s) {
    precise float factored = kernel == 9u ? s : (kernel == 10u ? 3.0 : 5.0) * s;
    precise float scaled = sqrt(factored);
    if (kernel == 9u) {
        return exp_negative(scaled);
    }
    float a = scaled < EXP_MAX ? scaled : EXP_MAX;
    precise float polynomial = kernel == 10u ? 1.0 + a : 1.0 + a + a * a * (1.0 / 3.0);
    precise float value = polynomial * exp_negative(a);
    return value;
}
