#version 450
#extension GL_GOOGLE_include_directive : require
// The confidence in a pose. One thread an instance.

#include "params.glsl"
#include "numeric.glsl"

layout(local_size_x = 64) in;
layout(set = 0, binding = 2, std430) readonly buffer Work {
    float work[];
};
layout(set = 0, binding = 3, std430) buffer Confidences {
    float confidences[];
};

const uint ROTATIONAL = 1u;

void main() {
    uint instance = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u
        + gl_LocalInvocationIndex;
    if (instance >= params.instance_len) {
        return;
    }
    uint base = params.work_offset + instance * params.work_stride;
    float confidence = 1.0;
    if (params.predictor == ROTATIONAL) {
        for (uint joint = 0u; joint < params.joint_len; joint++) {
            uint at = base + params.rotations + 3u * joint;
            vec3 theta = vec3(work[at], work[at + 1u], work[at + 2u]);
            precise float square = theta.x * theta.x + theta.y * theta.y + theta.z * theta.z;
            precise float angle = sqrt(square);
            float range = blob_float(params.pose_ranges + joint);
            precise float excess = max(angle - range, 0.0) / (0.5 * range + 0.1);
            precise float own = 1.0 - smooth_step(min(excess, 1.0));
            confidence = min(confidence, own);
        }
    } else {
        for (uint i = 0u; i < params.group_len; i++) {
            confidence = min(confidence, work[base + params.certainties + i]);
        }
    }
    confidences[params.confidences_offset + instance * params.confidences_stride] = confidence;
}
