#version 450
#extension GL_GOOGLE_include_directive : require
// Stage confidence: the confidence in a pose. One workgroup an instance, with one active thread.

#include "params.glsl"
#include "blob.glsl"
#include "numeric.glsl"

layout(local_size_x = 64) in;
layout(set = 0, binding = 2, std430) readonly buffer Scratch {
    float scratch[];
};
layout(set = 0, binding = 3, std430) buffer Confidences {
    float confidences[];
};

const uint ROTATIONAL = 1u;

// 1 up to the angle `most`; falls to 0 where the angle exceeds it by half the range plus 0.1.
float within(float angle, float most, float range) {
    precise float excess = max(angle - most, 0.0) / (0.5 * range + 0.1);
    precise float own = 1.0 - smooth_step(min(excess, 1.0));
    return own;
}

void main() {
    uint instance = gl_WorkGroupID.y;
    if (gl_LocalInvocationIndex != 0u) {
        return;
    }
    uint base = params.scratch_offset + instance * params.scratch_stride;
    float confidence = 1.0;
    if (params.predictor == ROTATIONAL) {
        for (uint joint = 0u; joint < params.joint_len; joint++) {
            uint at = base + params.rotations + 3u * joint;
            vec3 theta = vec3(scratch[at], scratch[at + 1u], scratch[at + 2u]);
            precise float square = theta.x * theta.x + theta.y * theta.y + theta.z * theta.z;
            precise float angle = sqrt(square);
            float range = blob_float(params.pose_ranges + joint);
            confidence = min(confidence, within(angle, range, range));
        }
    } else if (params.group_len > 0u) {
        precise float explained_error = 0.0;
        precise float unexplained_error = 0.0;
        for (uint i = 0u; i < params.group_len; i++) {
            uint error = base + params.group_confidences + 2u * i;
            explained_error += scratch[error];
            unexplained_error += scratch[error + 1u];
        }
        precise float total = 1.0 + explained_error;
        precise float share = total / (total + unexplained_error);
        confidence = share;
        for (uint joint = 0u; joint < params.joint_len; joint++) {
            uint at = base + params.features + 12u * joint;
            precise float trace = scratch[at] + scratch[at + 5u] + scratch[at + 10u];
            precise float angle = 2.0 * sqrt(max(0.0, -trace));
            float range = blob_float(params.pose_ranges + joint);
            precise float most = 1.5 * range;
            confidence = min(confidence, within(angle, most, range));
        }
    }
    confidences[params.confidences_offset + instance * params.confidences_stride] = confidence;
}
