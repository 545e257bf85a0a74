// From values to outputs: fades, ranges, rotations from their vectors, and outputs that sum to 1.

// Count of an output's numbers by its kind; a rotation has 4 numbers, but 3 values.
uint output_len(uint kind) {
    return kind == 1u ? 1u : (kind == 2u ? 3u : 4u);
}

uint value_len(uint kind) {
    return kind == 1u ? 1u : 3u;
}

// A value, blended towards the neutral value if the query rule is FADE.
float faded(float value, float neutral) {
    precise float both = confidence * value + (1.0 - confidence) * neutral;
    return query_rule() == FADE ? both : value;
}

void put_output(uint at, float value) {
    watch(value);
    out_floats[at] = value;
}

// Stores the quaternion product a b: b is applied first.
void put_product(uint at, vec4 a, vec4 b) {
    precise vec4 both = vec4(
        a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
        a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
        a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w,
        a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z
    );
    put_output(at, both.x);
    put_output(at + 1u, both.y);
    put_output(at + 2u, both.z);
    put_output(at + 3u, both.w);
}

// Computes one output, given by its row in the file, from its values.
void put_outputs(uint row, uint value, uint at) {
    uint kind = blob[row] & 0xffu;
    vec4 neutral = blob_vec4(row + 3u);
    if (kind == 1u) {
        float x = faded(scratch[value], neutral.x);
        float low = blob_float(row + 1u);
        float high = blob_float(row + 2u);
        float kept = low > x ? low : x;
        put_output(at, high < kept ? high : kept);
        return;
    }
    vec3 own = kind == 3u ? vec3(0.0) : neutral.xyz;
    float x = faded(scratch[value], own.x);
    float y = faded(scratch[value + 1u], own.y);
    float z = faded(scratch[value + 2u], own.z);
    if (kind == 2u) {
        put_output(at, x);
        put_output(at + 1u, y);
        put_output(at + 2u, z);
        return;
    }
    precise float square = (x * x + y * y + z * z) * 0.0625;
    precise float length = 1.0 + square;
    precise vec4 turn =
        vec4(0.5 * x / length, 0.5 * y / length, 0.5 * z / length, (1.0 - square) / length);
    put_product(at, neutral, turn);
}

// Whether an output, given by its row in the file, is one of the normalised outputs.
bool is_marked(uint row) {
    return (blob[row] & 0xff00u) != 0u;
}

// Divisor of the normalised outputs, which start at `first`; 0 if they are not divided.
float divisor_of(uint first) {
    precise float sum = 0.0;
    uint at = first;
    for (uint i = 0u; i < params.output_len; i++) {
        uint row = params.outputs + OUTPUT_WORDS * i;
        if (is_marked(row)) {
            sum += out_floats[at];
        }
        at += output_len(blob[row] & 0xffu);
    }
    if (sum > (normalise_rule() == ALWAYS ? 1.0e-12 : 1.0)) {
        watch(sum);
        return sum;
    }
    return 0.0;
}
