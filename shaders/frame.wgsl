// Directions of a vertex, the frame of its surface, and half-precision numbers.

fn cross3(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    return a.yzx * b.zxy - a.zxy * b.yzx;
}

fn dot3(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

// Whether a vector has a direction: its squared length is a normal number.
fn has_direction(v: vec3<f32>) -> bool {
    let square = dot3(v, v);
    return square >= 1.17549435e-38 && square <= 3.4028234e+38;
}

// A vector scaled to length 1, times side (1 or -1); rest if the vector has no direction.
fn unit(v: vec3<f32>, side: f32, rest: vec3<f32>) -> vec3<f32> {
    if has_direction(v) {
        return v * (side * (1.0 / sqrt(dot3(v, v))));
    }
    return rest;
}

// Half-precision number, normal or 0, in the upper half of a word.
fn half_float(high: u32) -> f32 {
    let bits = bitcast<u32>(bitcast<i32>(high) >> 3u) & 0x8fffe000u;
    return bitcast<f32>(select(bits + 0x38000000u, bits, (bits & 0x7fffffffu) == 0u));
}

// Two tangent directions of the rest surface; tangent coefficients and slopes refer to them.
struct Frame {
    g: vec3<f32>,
    h: vec3<f32>,
}

fn frame_of_tangent(normal: vec3<f32>, tangent: vec3<f32>) -> Frame {
    let h = cross3(normal, tangent);
    return Frame(cross3(h, normal), h);
}

// Frame of a normal without a tangent; up is the z of the file's own normal.
fn frame_of_normal(n: vec3<f32>, up: f32) -> Frame {
    let side = bitcast<f32>(0x3f800000u | (bitcast<u32>(up) & 0x80000000u));
    let sided = side * n.x;
    let share = n.x / (side + n.z);
    let g = vec3<f32>(1.0 - sided * share, -(side * n.y * share), -sided);
    return Frame(g, cross3(n, g));
}

