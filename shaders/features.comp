#version 450
#extension GL_GOOGLE_include_directive : require
// Stage features: the rotation and the translation of each joint relative to its parent, and the
// curves. One thread a joint and a curve.

#include "params.glsl"
#include "blob.glsl"
#include "rotation.glsl"

layout(local_size_x = 64) in;
layout(set = 0, binding = 2, std430) readonly buffer Poses {
    float poses[];
};
layout(set = 0, binding = 3, std430) readonly buffer Curves {
    float curves[];
};
layout(set = 0, binding = 4, std430) buffer Scratch {
    float scratch[];
};

#include "joint.glsl"

// S - I, where S is half of a rotation; the odd part of S fades towards half a turn.
mat3 half_of(mat3 m) {
    vec4 q = quaternion(m);
    precise float len = sqrt((q.x * q.x + q.y * q.y + q.z * q.z) + q.w * q.w);
    precise float low = 1.0 - q.w / len;
    low = low * low;
    low = low * low;
    precise float odd = (1.0 - low * low) / len;
    precise float even = 1.0 / (len * (len + q.w));
    precise vec3 v = q.xyz * odd;
    precise float xx = q.x * q.x;
    precise float yy = q.y * q.y;
    precise float zz = q.z * q.z;
    precise float xy = even * (q.x * q.y);
    precise float xz = even * (q.x * q.z);
    precise float yz = even * (q.y * q.z);
    precise vec3 a = vec3(-even * (yy + zz), xy + v.z, xz - v.y);
    precise vec3 b = vec3(xy - v.z, -even * (xx + zz), yz + v.x);
    precise vec3 c = vec3(xz + v.y, yz - v.x, -even * (xx + yy));
    return mat3(a, b, c);
}

void main() {
    uint instance = gl_WorkGroupID.y;
    uint joint = gl_GlobalInvocationID.x;
    uint curve = joint;
    uint base = params.scratch_offset + instance * params.scratch_stride;
    if (curve < params.curve_len) {
        uint at = params.curves_offset + instance * params.curves_stride + curve;
        scratch[base + params.curve_features + curve] = curves[at];
    }
    if (joint >= params.joint_len) {
        return;
    }
    uint pose = params.poses_offset + instance * params.poses_stride;
    uint to = base + params.features + 12u * joint;
    uint parent = blob_half(params.hierarchy, joint);
    uint own = pose + 12u * joint;
    mat3 linear = linear_part(own);
    uint above = pose + 12u * parent;
    if (parent == NO_JOINT || is_hidden(linear) || is_hidden(linear_part(above))) {
        for (uint i = 0u; i < 12u; i++) {
            scratch[to + i] = 0.0;
        }
        return;
    }
    mat3 parent_linear = linear_part(above);
    vec3 origin = blob_vec3(params.origins + 3u * joint);
    // The differences come first, so that the rest pose gives exactly 0.
    precise vec3 x = linear[0] - parent_linear[0];
    precise vec3 y = linear[1] - parent_linear[1];
    precise vec3 z = linear[2] - parent_linear[2];
    precise vec3 apart = pose_column(own, 3u) - pose_column(above, 3u);
    precise vec3 gap = (x * origin.x + y * origin.y + z * origin.z) + apart;
    mat3 turn = linear;
    mat3 parent_turn = parent_linear;
    if (stretches()) {
        turn = load_columns(base + params.turns + 9u * joint);
        parent_turn = load_columns(base + params.turns + 9u * parent);
    }
    gap = transform_transposed(parent_turn, gap);
    turn = half_of(transform_columns_transposed(parent_turn, turn));
    for (uint i = 0u; i < 9u; i++) {
        scratch[to + 4u * (i % 3u) + i / 3u] = turn[i / 3u][i % 3u];
    }
    for (uint r = 0u; r < 3u; r++) {
        scratch[to + 4u * r + 3u] = gap[r];
    }
}
