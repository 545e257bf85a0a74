#version 450
#extension GL_GOOGLE_include_directive : require
// Stage confidence: the confidence in a pose. One workgroup an instance, with one active thread.

#include "params.glsl"
#include "blob.glsl"
#include "numeric.glsl"

layout(local_size_x = 64) in;
layout(set = 0, binding = 2, std430) readonly buffer Poses {
    float poses[];
};
layout(set = 0, binding = 3, std430) readonly buffer Scratch {
    float scratch[];
};
layout(set = 0, binding = 4, std430) buffer Confidences {
    float confidences[];
};

#include "joint.glsl"

const uint ROTATIONAL = 1u;

// 1 up to `most`; falls to 0 where a value exceeds it by half the range plus 0.1.
float within(float value, float most, float range) {
    precise float excess = max(value - most, 0.0) / (0.5 * range + 0.1);
    precise float own = 1.0 - smooth_step(min(excess, 1.0));
    return own;
}

// The confidence in a joint from its strain; 0 for a hidden joint.
float of_strain(uint base, uint pose, uint joint) {
    if (is_hidden(linear_part(pose + 12u * joint))) {
        return 0.0;
    }
    if (!stretches()) {
        return 1.0;
    }
    uint at = base + params.strains + 6u * joint;
    vec3 stretch = vec3(scratch[at], scratch[at + 3u], scratch[at + 5u]);
    vec3 shear = vec3(scratch[at + 1u], scratch[at + 2u], scratch[at + 4u]);
    precise float norm = sqrt(dot3(stretch, stretch) + 2.0 * dot3(shear, shear));
    float range = blob_float(params.stretch_ranges + joint);
    precise float most = 1.5 * range;
    return within(norm, most, range);
}

void main() {
    uint instance = gl_WorkGroupID.y;
    if (gl_LocalInvocationIndex != 0u) {
        return;
    }
    uint pose = params.poses_offset + instance * params.poses_stride;
    uint base = params.scratch_offset + instance * params.scratch_stride;
    float confidence = 1.0;
    if (params.predictor == ROTATIONAL) {
        for (uint joint = 0u; joint < params.joint_len; joint++) {
            vec3 theta = load(base + params.rotations + 3u * joint);
            precise float angle = sqrt(dot3(theta, theta));
            float range = blob_float(params.pose_ranges + joint);
            confidence = min(confidence, within(angle, range, range));
            confidence = min(confidence, of_strain(base, pose, joint));
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
            confidence = min(confidence, of_strain(base, pose, joint));
        }
        for (uint curve = 0u; curve < params.curve_len; curve++) {
            float least = blob_float(params.curve_ranges + 2u * curve);
            precise float range = 0.5 * (blob_float(params.curve_ranges + 2u * curve + 1u) - least);
            precise float apart = abs(scratch[base + params.curve_features + curve] - (least + range));
            precise float most = 1.5 * range;
            confidence = min(confidence, within(apart, most, range));
        }
    }
    confidences[params.confidences_offset + instance * params.confidences_stride] = confidence;
}
