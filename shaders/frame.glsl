// Directions of a vertex, the frame of its surface, and half-precision numbers.

#include "vector.glsl"

// Whether a vector has a direction: its squared length is a normal number.
bool has_direction(vec3 v) {
    float square = dot3(v, v);
    return square >= 1.17549435e-38 && square <= 3.4028234e+38;
}

// A vector scaled to length 1, times `side` (1 or -1); `rest` if the vector has no direction.
vec3 unit(vec3 v, float side, vec3 rest) {
    if (has_direction(v)) {
        precise float scale = side * (1.0 / sqrt(dot3(v, v)));
        precise vec3 direction = v * scale;
        return direction;
    }
    return rest;
}

// Half-precision number, normal or 0, in the upper half of a word.
float half_float(uint high) {
    uint bits = uint(int(high) >> 3) & 0x8fffe000u;
    return uintBitsToFloat((bits & 0x7fffffffu) == 0u ? bits : bits + 0x38000000u);
}

// Two tangent directions of the rest surface; tangent coefficients and slopes refer to them.
struct Frame {
    vec3 g;
    vec3 h;
};

Frame frame_of_tangent(vec3 normal, vec3 tangent) {
    vec3 h = cross3(normal, tangent);
    return Frame(cross3(h, normal), h);
}

// Frame of a normal without a tangent; `up` is the z of the file's own normal.
Frame frame_of_normal(vec3 n, float up) {
    float side = uintBitsToFloat(0x3f800000u | (floatBitsToUint(up) & 0x80000000u));
    precise float sided = side * n.x;
    precise float share = n.x / (side + n.z);
    precise vec3 g = vec3(1.0 - sided * share, -(side * n.y * share), -sided);
    return Frame(g, cross3(n, g));
}
