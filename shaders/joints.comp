#version 450
#extension GL_GOOGLE_include_directive : require
// Stage joints: copies the joints' transforms, and gives each helper the transform of its dominant
// joint. One thread a transform.

#include "params.glsl"
#include "blob.glsl"

layout(local_size_x = 64) in;
layout(set = 0, binding = 2, std430) readonly buffer Poses {
    float poses[];
};
layout(set = 0, binding = 3, std430) buffer Palettes {
    float palettes[];
};

void main() {
    uint instance = gl_WorkGroupID.y;
    uint transform = gl_GlobalInvocationID.x;
    if (transform >= params.palette_len) {
        return;
    }
    uint joint = transform;
    if (transform >= params.joint_len) {
        // Finds the group of this helper; the helpers of a group follow those of the group before
        // it.
        uint left = transform - params.joint_len;
        uint row = params.groups;
        uint proxy_len = blob[row + 2u] >> 16u;
        while (left >= proxy_len) {
            left -= proxy_len;
            row += 8u;
            proxy_len = blob[row + 2u] >> 16u;
        }
        joint = blob[row] & 0xffffu;
    }
    uint pose = params.poses_offset + instance * params.poses_stride + 12u * joint;
    uint to = params.palettes_offset + instance * params.palettes_stride + 12u * transform;
    for (uint i = 0u; i < 12u; i++) {
        if (joint == NO_JOINT) {
            // Helpers of an envelope without joints start from the identity.
            palettes[to + i] = float(i % 5u == 0u);
        } else {
            palettes[to + i] = poses[pose + i];
        }
    }
}
