#version 450
#extension GL_GOOGLE_include_directive : require
// Stage features: the rotation and the translation of each joint relative to its parent. One thread
// a joint.

#include "params.glsl"
#include "blob.glsl"
#include "rotation.glsl"

layout(local_size_x = 64) in;
layout(set = 0, binding = 2, std430) readonly buffer Poses {
    float poses[];
};
layout(set = 0, binding = 3, std430) buffer Scratch {
    float scratch[];
};

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
    if (joint >= params.joint_len) {
        return;
    }
    uint pose = params.poses_offset + instance * params.poses_stride;
    uint base = params.scratch_offset + instance * params.scratch_stride;
    uint to = base + params.features + 12u * joint;
    uint parent = blob_half(params.hierarchy, joint);
    if (parent == NO_JOINT) {
        for (uint i = 0u; i < 12u; i++) {
            scratch[to + i] = 0.0;
        }
        return;
    }
    vec3 origin = blob_vec3(params.origins + 3u * joint);
    uint above = pose + 12u * parent;
    uint own = pose + 12u * joint;
    mat3 rotation;
    for (uint r = 0u; r < 3u; r++) {
        float x = poses[above + r];
        float y = poses[above + 4u + r];
        float z = poses[above + 8u + r];
        precise vec4 row;
        for (uint c = 0u; c < 4u; c++) {
            precise float a = poses[own + c];
            precise float b = poses[own + 4u + c];
            precise float d = poses[own + 8u + c];
            if (c == 3u) {
                // The difference comes first, so that the rest pose gives exactly 0.
                a -= poses[above + 3u];
                b -= poses[above + 7u];
                d -= poses[above + 11u];
            }
            row[c] = x * a + y * b + z * d;
        }
        for (uint c = 0u; c < 3u; c++) {
            rotation[c][r] = row[c];
        }
        row[r] -= 1.0;
        precise float origin_row = (row.x * origin.x + row.y * origin.y + row.z * origin.z) + row.w;
        scratch[to + 4u * r + 3u] = origin_row;
    }
    mat3 turn = half_of(rotation);
    for (uint i = 0u; i < 9u; i++) {
        scratch[to + 4u * (i % 3u) + i / 3u] = turn[i / 3u][i % 3u];
    }
}
