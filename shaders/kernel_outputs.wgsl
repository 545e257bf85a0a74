// From values to outputs: fades, ranges, rotations from their vectors, and outputs that sum to 1.

// Count of an output's numbers by its kind; a rotation has 4 numbers, but 3 values.
fn output_len(kind: u32) -> u32 {
    return select(select(4u, 3u, kind == 2u), 1u, kind == 1u);
}

fn value_len(kind: u32) -> u32 {
    return select(3u, 1u, kind == 1u);
}

// A value, blended towards the neutral value if the query rule is FADE.
fn faded(value: f32, neutral: f32) -> f32 {
    if query_rule() == FADE {
        return confidence * value + (1.0 - confidence) * neutral;
    }
    return value;
}

fn put_output(at: u32, value: f32) {
    watch(value);
    out[at] = value;
}

// Stores the quaternion product a b: b is applied first.
fn put_product(at: u32, a: vec4<f32>, b: vec4<f32>) {
    put_output(at, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y);
    put_output(at + 1u, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x);
    put_output(at + 2u, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w);
    put_output(at + 3u, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z);
}

// Computes one output, given by its row in the file, from its values.
fn put_outputs(row: u32, value: u32, at: u32) {
    let kind = blob[row] & 0xffu;
    let neutral = blob_vec4(row + 3u);
    if kind == 1u {
        let x = faded(scratch[value], neutral.x);
        let low = blob_float(row + 1u);
        let high = blob_float(row + 2u);
        let kept = select(x, low, low > x);
        put_output(at, select(kept, high, high < kept));
        return;
    }
    let own = select(neutral.xyz, vec3<f32>(0.0), kind == 3u);
    let x = faded(scratch[value], own.x);
    let y = faded(scratch[value + 1u], own.y);
    let z = faded(scratch[value + 2u], own.z);
    if kind == 2u {
        put_output(at, x);
        put_output(at + 1u, y);
        put_output(at + 2u, z);
        return;
    }
    let square = (x * x + y * y + z * z) * 0.0625;
    let length = 1.0 + square;
    let turn = vec4<f32>(0.5 * x / length, 0.5 * y / length, 0.5 * z / length, (1.0 - square) / length);
    put_product(at, neutral, turn);
}

// Whether an output, given by its row in the file, is one of the normalised outputs.
fn is_marked(row: u32) -> bool {
    return (blob[row] & 0xff00u) != 0u;
}

// Divisor of the normalised outputs, which start at first; 0 if they are not divided.
fn divisor_of(first: u32) -> f32 {
    var sum = 0.0;
    var at = first;
    for (var i = 0u; i < params.output_len; i++) {
        let row = params.outputs + OUTPUT_WORDS * i;
        if is_marked(row) {
            sum += out[at];
        }
        at += output_len(blob[row] & 0xffu);
    }
    if sum > select(1.0, 1.0e-12, normalise_rule() == ALWAYS) {
        watch(sum);
        return sum;
    }
    return 0.0;
}
