#version 450
#extension GL_GOOGLE_include_directive : require
// Stage kernel: queries to outputs and their confidence. One workgroup a query. Its threads
// exchange results in scratch, and in the workgroup's memory for one tile of centres at a time.

#include "kernel_params.glsl"
#include "blob.glsl"
#include "numeric.glsl"
#include "kernel_value.glsl"

layout(local_size_x = 64) in;
layout(set = 0, binding = 2, std430) readonly buffer Queries {
    float queries[];
};
layout(set = 0, binding = 3, std430) coherent buffer Scratch {
    float scratch[];
};
layout(set = 0, binding = 4, std430) coherent buffer Out {
    float out_floats[];
};

const uint INPUT_WORDS = 4u;
const uint OUTPUT_WORDS = 7u;
const uint CLAMP = 1u;
const uint FADE = 2u;
const uint ALWAYS = 1u;
const uint INFINITE = 0x7f800000u;
// Number of centres that are evaluated before their values are summed.
const uint TILE = 256u;

shared float basis[TILE];
shared float uncertainties[TILE];
shared float confidence;
shared float divisor;
// 1 if a CPU would refuse the query.
shared uint unsound;

uint query_rule() {
    return (blob[params.kernel_rule] >> 16u) & 0xffu;
}

uint normalise_rule() {
    return blob[params.kernel_rule] >> 24u;
}

// Marks the query if a number is not finite. Tests the bits, because comparisons on a GPU need not
// respect NaN.
void watch(float x) {
    if ((floatBitsToUint(x) & INFINITE) == INFINITE) {
        atomicOr(unsound, 1u);
    }
}

// First word of a row of a matrix in blocks of 8 rows; the next column is 8 words further.
uint row_of(uint matrix, uint column_len, uint row) {
    return matrix + row / 8u * (8u * column_len) + row % 8u;
}

#include "kernel_features.glsl"
#include "kernel_outputs.glsl"

void main() {
    uint thread = gl_LocalInvocationIndex;
    uint instance = gl_WorkGroupID.y;
    uint query = params.queries_offset + instance * params.queries_stride;
    uint outputs = params.outputs_offset + instance * params.outputs_stride;
    uint u = params.scratch_offset + instance * params.scratch_stride;
    uint metric = u + params.feature_len;
    uint terms = metric + params.metric_len;
    uint values = terms + params.term_len;
    if (thread == 0u) {
        unsound = 0u;
    }
    memoryBarrierShared();
    barrier();

    uint i = 0u;
    uint number = query;
    uint feature = 0u;
    for (uint own = thread; own < params.input_len; own += 64u) {
        for (; i < own; i++) {
            uint kind = blob[params.inputs + INPUT_WORDS * i] & 0xffu;
            number += number_len(kind);
            feature += feature_len(kind);
        }
        put_features(params.inputs + INPUT_WORDS * own, number, u, feature);
    }
    memoryBarrierBuffer();
    barrier();

    for (uint r = thread; r < params.metric_len; r += 64u) {
        precise float sum = 0.0;
        uint at = row_of(params.metric, params.feature_len, r);
        for (uint f = 0u; f < params.feature_len; f++) {
            sum += blob_float(at) * scratch[u + f];
            at += 8u;
        }
        scratch[metric + r] = sum;
    }
    // Each monomial is a multiple of an earlier one, so one thread computes them all: the last,
    // which has the fewest rows.
    if (thread == 63u) {
        for (uint t = 0u; t < params.term_len; t++) {
            uint earlier = blob[params.terms + t] & 0xffffu;
            precise float power = 1.0;
            if (earlier != NO_TERM) {
                power = scratch[terms + earlier] * scratch[u + (blob[params.terms + t] >> 16u)];
            }
            scratch[terms + t] = power;
        }
    }
    for (uint v = thread; v < params.value_len; v += 64u) {
        scratch[values + v] = 0.0;
    }
    memoryBarrierBuffer();
    barrier();

    uint rule = blob[params.kernel_rule];
    float fade_start = blob_float(params.kernel_rule + 1u);
    float fade_end = blob_float(params.kernel_rule + 2u);
    uint column_len = params.centre_len + params.term_len;
    bool measured = params.metric_len > 0u;
    uint z = measured ? metric : u;
    uint z_len = measured ? params.metric_len : params.feature_len;
    precise float uncertainty = 1.0;
    for (uint first = 0u; first < params.centre_len; first += TILE) {
        uint len = min(TILE, params.centre_len - first);
        for (uint k = thread; k < len; k += 64u) {
            precise float s = 0.0;
            uint at = row_of(params.kernel_centres, z_len, first + k);
            for (uint c = 0u; c < z_len; c++) {
                precise float apart = scratch[z + c] - blob_float(at);
                s += apart * apart;
                at += 8u;
            }
            basis[k] = kernel_value(rule & 0xffu, (rule >> 8u) & 0xffu, s);
            if (fade_end > 0.0) {
                precise float own = 1.0 - nearness(s, fade_start, fade_end);
                uncertainties[k] = own;
            }
        }
        memoryBarrierShared();
        barrier();
        for (uint v = thread; v < params.value_len; v += 64u) {
            precise float sum = scratch[values + v];
            uint at = row_of(params.kernel_coefficients, column_len, v) + 8u * first;
            for (uint k = 0u; k < len; k++) {
                sum += blob_float(at) * basis[k];
                at += 8u;
            }
            scratch[values + v] = sum;
        }
        if (thread == 63u && fade_end > 0.0) {
            for (uint k = 0u; k < len; k++) {
                uncertainty *= uncertainties[k];
            }
        }
        memoryBarrierShared();
        barrier();
    }
    for (uint v = thread; v < params.value_len; v += 64u) {
        precise float sum = scratch[values + v];
        uint at = row_of(params.kernel_coefficients, column_len, v) + 8u * params.centre_len;
        for (uint t = 0u; t < params.term_len; t++) {
            sum += blob_float(at) * scratch[terms + t];
            at += 8u;
        }
        watch(sum);
        scratch[values + v] = sum;
    }
    if (thread == 63u) {
        precise float certain = 1.0 - uncertainty;
        confidence = fade_end > 0.0 ? certain : 1.0;
    }
    memoryBarrierBuffer();
    memoryBarrierShared();
    barrier();

    i = 0u;
    uint value = values;
    uint at = outputs;
    for (uint own = thread; own < params.output_len; own += 64u) {
        for (; i < own; i++) {
            uint kind = blob[params.outputs + OUTPUT_WORDS * i] & 0xffu;
            value += value_len(kind);
            at += output_len(kind);
        }
        put_outputs(params.outputs + OUTPUT_WORDS * own, value, at);
    }
    if (normalise_rule() != 0u) {
        memoryBarrierBuffer();
        barrier();
        if (thread == 0u) {
            divisor = divisor_of(outputs);
        }
        memoryBarrierShared();
        barrier();
        if (divisor > 0.0) {
            i = 0u;
            at = outputs;
            for (uint own = thread; own < params.output_len; own += 64u) {
                for (; i < own; i++) {
                    at += output_len(blob[params.outputs + OUTPUT_WORDS * i] & 0xffu);
                }
                if (is_marked(params.outputs + OUTPUT_WORDS * own)) {
                    precise float share = out_floats[at] / divisor;
                    put_output(at, share);
                }
            }
        }
    }
    memoryBarrierShared();
    barrier();

    if (thread == 0u && params.confidences_offset != NONE) {
        uint to = params.confidences_offset + instance * params.confidences_stride;
        // NaN from its bits, because arithmetic on a GPU need not produce NaN.
        out_floats[to] = unsound == 0u ? confidence : uintBitsToFloat(0x7fc00000u);
    }
}
