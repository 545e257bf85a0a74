// Stage kernel: queries to outputs and their confidence. One workgroup a query. Its threads
// exchange results in scratch, and in the workgroup's memory for one tile of centres at a time.

@group(0) @binding(2) var<storage, read> queries: array<f32>;
@group(0) @binding(3) var<storage, read_write> scratch: array<f32>;
@group(0) @binding(4) var<storage, read_write> out: array<f32>;

const INPUT_WORDS: u32 = 4u;
const OUTPUT_WORDS: u32 = 7u;
const CLAMP: u32 = 1u;
const FADE: u32 = 2u;
const ALWAYS: u32 = 1u;
const INFINITE: u32 = 0x7f800000u;
// Number of centres that are evaluated before their values are summed.
const TILE: u32 = 256u;

var<workgroup> basis: array<f32, TILE>;
var<workgroup> uncertainties: array<f32, TILE>;
var<workgroup> confidence: f32;
var<workgroup> divisor: f32;
// 1 if a CPU would refuse the query.
var<workgroup> unsound: atomic<u32>;

fn query_rule() -> u32 {
    return (blob[params.kernel_rule] >> 16u) & 0xffu;
}

fn normalise_rule() -> u32 {
    return blob[params.kernel_rule] >> 24u;
}

// Marks the query if a number is not finite. Tests the bits, because comparisons on a GPU need not
// respect NaN.
fn watch(x: f32) {
    if (bitcast<u32>(x) & INFINITE) == INFINITE {
        atomicStore(&unsound, 1u);
    }
}

// First word of a row of a matrix in blocks of 8 rows; the next column is 8 words further.
fn row_of(matrix: u32, column_len: u32, row: u32) -> u32 {
    return matrix + row / 8u * (8u * column_len) + row % 8u;
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let instance = workgroup.y;
    let query = params.queries_offset + instance * params.queries_stride;
    let outputs = params.outputs_offset + instance * params.outputs_stride;
    let u = params.scratch_offset + instance * params.scratch_stride;
    let metric = u + params.feature_len;
    let terms = metric + params.metric_len;
    let values = terms + params.term_len;

    var i = 0u;
    var number = query;
    var feature = 0u;
    for (var own = thread; own < params.input_len; own += 64u) {
        for (; i < own; i++) {
            let kind = blob[params.inputs + INPUT_WORDS * i] & 0xffu;
            number += number_len(kind);
            feature += feature_len(kind);
        }
        put_features(params.inputs + INPUT_WORDS * own, number, u, feature);
    }
    storageBarrier();

    for (var r = thread; r < params.metric_len; r += 64u) {
        var sum = 0.0;
        var at = row_of(params.metric, params.feature_len, r);
        for (var f = 0u; f < params.feature_len; f++) {
            sum += blob_float(at) * scratch[u + f];
            at += 8u;
        }
        scratch[metric + r] = sum;
    }
    // Each monomial is a multiple of an earlier one, so one thread computes them all: the last,
    // which has the fewest rows.
    if thread == 63u {
        for (var t = 0u; t < params.term_len; t++) {
            let earlier = blob[params.terms + t] & 0xffffu;
            var power = 1.0;
            if earlier != NO_TERM {
                power = scratch[terms + earlier] * scratch[u + (blob[params.terms + t] >> 16u)];
            }
            scratch[terms + t] = power;
        }
    }
    for (var v = thread; v < params.value_len; v += 64u) {
        scratch[values + v] = 0.0;
    }
    storageBarrier();

    let rule = blob[params.kernel_rule];
    let fade_start = blob_float(params.kernel_rule + 1u);
    let fade_end = blob_float(params.kernel_rule + 2u);
    let column_len = params.centre_len + params.term_len;
    var z = u;
    var z_len = params.feature_len;
    if params.metric_len > 0u {
        z = metric;
        z_len = params.metric_len;
    }
    var uncertainty = 1.0;
    for (var first = 0u; first < params.centre_len; first += TILE) {
        let len = min(TILE, params.centre_len - first);
        for (var k = thread; k < len; k += 64u) {
            var s = 0.0;
            var at = row_of(params.kernel_centres, z_len, first + k);
            for (var c = 0u; c < z_len; c++) {
                let apart = scratch[z + c] - blob_float(at);
                s += apart * apart;
                at += 8u;
            }
            basis[k] = kernel_value(rule & 0xffu, (rule >> 8u) & 0xffu, s);
            if fade_end > 0.0 {
                uncertainties[k] = 1.0 - nearness(s, fade_start, fade_end);
            }
        }
        workgroupBarrier();
        for (var v = thread; v < params.value_len; v += 64u) {
            var sum = scratch[values + v];
            var at = row_of(params.kernel_coefficients, column_len, v) + 8u * first;
            for (var k = 0u; k < len; k++) {
                sum += blob_float(at) * basis[k];
                at += 8u;
            }
            scratch[values + v] = sum;
        }
        if thread == 63u && fade_end > 0.0 {
            for (var k = 0u; k < len; k++) {
                uncertainty *= uncertainties[k];
            }
        }
        workgroupBarrier();
    }
    for (var v = thread; v < params.value_len; v += 64u) {
        var sum = scratch[values + v];
        var at = row_of(params.kernel_coefficients, column_len, v) + 8u * params.centre_len;
        for (var t = 0u; t < params.term_len; t++) {
            sum += blob_float(at) * scratch[terms + t];
            at += 8u;
        }
        watch(sum);
        scratch[values + v] = sum;
    }
    if thread == 63u {
        confidence = select(1.0, 1.0 - uncertainty, fade_end > 0.0);
    }
    storageBarrier();
    workgroupBarrier();

    i = 0u;
    var value = values;
    var at = outputs;
    for (var own = thread; own < params.output_len; own += 64u) {
        for (; i < own; i++) {
            let kind = blob[params.outputs + OUTPUT_WORDS * i] & 0xffu;
            value += value_len(kind);
            at += output_len(kind);
        }
        put_outputs(params.outputs + OUTPUT_WORDS * own, value, at);
    }
    if normalise_rule() != 0u {
        storageBarrier();
        if thread == 0u {
            divisor = divisor_of(outputs);
        }
        workgroupBarrier();
        if divisor > 0.0 {
            i = 0u;
            at = outputs;
            for (var own = thread; own < params.output_len; own += 64u) {
                for (; i < own; i++) {
                    at += output_len(blob[params.outputs + OUTPUT_WORDS * i] & 0xffu);
                }
                if is_marked(params.outputs + OUTPUT_WORDS * own) {
                    put_output(at, out[at] / divisor);
                }
            }
        }
    }
    workgroupBarrier();

    if thread == 0u && params.confidences_offset != NONE {
        let at = params.confidences_offset + instance * params.confidences_stride;
        // NaN from its bits, because arithmetic on a GPU need not produce NaN.
        let bits = select(bitcast<u32>(confidence), 0x7fc00000u, atomicLoad(&unsound) != 0u);
        out[at] = bitcast<f32>(bits);
    }
}
