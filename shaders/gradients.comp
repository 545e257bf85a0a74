#version 450
#extension GL_GOOGLE_include_directive : require
// Stage gradients: poses to relative transforms, rotations and the keys' gradients. One workgroup an
// instance.

#include "params.glsl"
#include "blob.glsl"
#include "numeric.glsl"
#include "rotation.glsl"

layout(local_size_x = 64) in;
layout(set = 0, binding = 2, std430) readonly buffer Poses {
    float poses[];
};
layout(set = 0, binding = 3, std430) coherent buffer Scratch {
    float scratch[];
};

#include "joint.glsl"

const uint KEY_WORDS = 55u;

void store(uint at, vec3 v) {
    scratch[at] = v.x;
    scratch[at + 1u] = v.y;
    scratch[at + 2u] = v.z;
}

vec3 transform(mat3 m, vec3 v) {
    precise vec3 sum = m[0] * v.x + m[1] * v.y + m[2] * v.z;
    return sum;
}

mat3 transform_columns(mat3 m, mat3 n) {
    return mat3(transform(m, n[0]), transform(m, n[1]), transform(m, n[2]));
}

// The transpose of the inverse of the root's linear part; 0 for a hidden root.
mat3 inverse_transposed(mat3 linear) {
    mat3 cofactors =
        mat3(cross3(linear[1], linear[2]), cross3(linear[2], linear[0]), cross3(linear[0], linear[1]));
    precise float scale = is_hidden(linear) ? 0.0 : 1.0 / dot3(linear[0], cofactors[0]);
    precise vec3 x = cofactors[0] * scale;
    precise vec3 y = cofactors[1] * scale;
    precise vec3 z = cofactors[2] * scale;
    return mat3(x, y, z);
}

// The rotation vector of a rotation matrix.
vec3 log_of(mat3 m) {
    vec4 q = quaternion(m);
    vec3 v = q.xyz;
    float w = q.w;
    precise float len = sqrt(dot3(v, v));
    if (len < 1.0e-18) {
        return vec3(0.0);
    }
    precise float scale = 2.0 * quadrant_angle(len, w) / len;
    precise vec3 theta = v * scale;
    return theta;
}

// The rotation matrix of a rotation vector.
mat3 exp_of(vec3 v) {
    float square = dot3(v, v);
    precise float a = 1.0;
    precise float b = 0.5;
    if (square >= 1.0e-8) {
        precise float angle = sqrt(square);
        vec2 both = sin_versine(angle);
        a = both.x / angle;
        b = both.y / square;
    }
    precise vec3 turn = a * v;
    precise float xx = v.x * v.x;
    precise float yy = v.y * v.y;
    precise float zz = v.z * v.z;
    precise float xy = b * (v.x * v.y);
    precise float xz = b * (v.x * v.z);
    precise float yz = b * (v.y * v.z);
    precise vec3 x = vec3(1.0 - b * (yy + zz), xy + turn.z, xz - turn.y);
    precise vec3 y = vec3(xy - turn.z, 1.0 - b * (xx + zz), yz + turn.x);
    precise vec3 z = vec3(xz + turn.y, yz - turn.x, 1.0 - b * (xx + yy));
    return mat3(x, y, z);
}

// The rotation matrix of A theta; A is three rows of the blob.
mat3 twist(uint at, vec3 theta) {
    return exp_of(vec3(
        dot3(blob_vec3(at), theta),
        dot3(blob_vec3(at + 3u), theta),
        dot3(blob_vec3(at + 6u), theta)
    ));
}

// A row of six numbers, times two vectors.
float row_product(uint at, vec3 a, vec3 b) {
    precise float sum = dot3(blob_vec3(at), a) + dot3(blob_vec3(at + 3u), b);
    return sum;
}

void main() {
    uint thread = gl_LocalInvocationIndex;
    uint instance = gl_WorkGroupID.y;
    uint pose = params.poses_offset + instance * params.poses_stride;
    uint base = params.scratch_offset + instance * params.scratch_stride;
    uint relative = base + params.relative;
    uint rotations = base + params.rotations;

    uint root = pose + 12u * params.root;
    mat3 back = linear_part(root);
    vec3 origin = pose_column(root, 3u);
    if (stretches()) {
        back = inverse_transposed(back);
    }
    for (uint joint = thread; joint < params.joint_len; joint += 64u) {
        uint at = relative + 12u * joint;
        if (joint == params.root) {
            store(at, vec3(1.0, 0.0, 0.0));
            store(at + 3u, vec3(0.0, 1.0, 0.0));
            store(at + 6u, vec3(0.0, 0.0, 1.0));
            store(at + 9u, vec3(0.0));
        } else {
            uint own = pose + 12u * joint;
            precise vec3 apart = pose_column(own, 3u) - origin;
            store(at, transform_transposed(back, pose_column(own, 0u)));
            store(at + 3u, transform_transposed(back, pose_column(own, 1u)));
            store(at + 6u, transform_transposed(back, pose_column(own, 2u)));
            store(at + 9u, transform_transposed(back, apart));
        }
    }
    memoryBarrierBuffer();
    barrier();

    // Rotations of stage polar, or the linear parts of the relative transforms.
    uint turns = stretches() ? base + params.turns : relative;
    uint turn_stride = stretches() ? 9u : 12u;
    for (uint joint = thread; joint < params.joint_len; joint += 64u) {
        uint parent = blob_half(params.hierarchy, joint);
        vec3 theta = vec3(0.0);
        if (parent != NO_JOINT) {
            mat3 above = load_columns(turns + turn_stride * parent);
            mat3 own = load_columns(turns + turn_stride * joint);
            theta = log_of(transform_columns_transposed(above, own));
        }
        store(rotations + 3u * joint, theta);
    }
    memoryBarrierBuffer();
    barrier();

    for (uint key = thread; key < params.proxy_len; key += 64u) {
        uint at = params.keys + KEY_WORDS * key;
        uint joint = blob[at] & 0xffffu;
        uint residual = blob[at] >> 16u;
        uint parent = blob_half(params.hierarchy, joint);
        vec3 b = load(rotations + 3u * joint);
        vec3 p = vec3(0.0);
        if (parent != NO_JOINT) {
            p = load(rotations + 3u * parent);
        }
        // Entries xx, xy, xz, yy, yz, zz of S - I.
        float entries[6];
        for (uint i = 0u; i < 6u; i++) {
            precise float sum = row_product(at + 19u + 6u * i, b, p);
            if (params.key_stretches != NONE) {
                uint strain = base + params.strains + 6u * joint;
                uint g = params.key_stretches + 36u * key + 6u * i;
                sum += row_product(g, load(strain), load(strain + 3u));
            }
            entries[i] = sum;
        }
        precise float xx = 1.0 + entries[0];
        precise float yy = 1.0 + entries[3];
        precise float zz = 1.0 + entries[5];
        mat3 gradient = mat3(
            vec3(xx, entries[1], entries[2]),
            vec3(entries[1], yy, entries[4]),
            vec3(entries[2], entries[4], zz)
        );
        if (residual != NO_JOINT) {
            gradient = transform_columns(twist(at + 10u, load(rotations + 3u * residual)), gradient);
        }
        gradient = transform_columns(twist(at + 1u, b), gradient);
        if (parent != NO_JOINT) {
            mat3 turn = load_columns(turns + turn_stride * parent);
            if (stretches()) {
                turn = transform_columns_transposed(load_columns(turns + turn_stride * params.root), turn);
            }
            gradient = transform_columns(turn, gradient);
        }
        uint to = base + params.gradients + 9u * key;
        store(to, gradient[0]);
        store(to + 3u, gradient[1]);
        store(to + 6u, gradient[2]);
    }
}
