#version 450
#extension GL_GOOGLE_include_directive : require
// Stage filter: samples of signals to finer samples. One thread a number.

#include "filter_params.glsl"
#include "blob.glsl"

layout(local_size_x = 64) in;
layout(set = 0, binding = 2, std430) readonly buffer Samples {
    float samples[];
};
layout(set = 0, binding = 3, std430) writeonly buffer Out {
    float out_floats[];
};

void main() {
    uint instance = gl_WorkGroupID.y;
    uint own = gl_GlobalInvocationID.x;
    uint fine = own / params.lane_len;
    uint coarse = fine / params.factor;
    if (coarse >= params.sample_len) {
        return;
    }
    uint phase = fine - params.factor * coarse;
    // The window is centred on the sample; near an end of the signal the window stays inside.
    uint middle = params.tap_len / 2u;
    uint start = min(max(coarse, middle) - middle, params.sample_len - params.tap_len);
    uint row = (coarse - start) * params.factor + phase;
    uint taps = params.filter_taps + row * params.tap_len;
    uint at = params.samples_offset + instance * params.samples_stride
        + start * params.lane_len + (own - fine * params.lane_len);
    precise float sum = 0.0;
    for (uint tap = 0u; tap < params.tap_len; tap++) {
        sum += blob_float(taps + tap) * samples[at];
        at += params.lane_len;
    }
    out_floats[params.outputs_offset + instance * params.outputs_stride + own] = sum;
}
