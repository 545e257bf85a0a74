#version 450
#extension GL_GOOGLE_include_directive : require
// Stage 3: palettes to positions, normals and tangents. One thread a vertex.

#include "params.glsl"

layout(local_size_x = 64) in;
layout(set = 0, binding = 2, std430) readonly buffer Palettes {
    vec4 palettes[];
};
layout(set = 0, binding = 3, std430) writeonly buffer OutA {
    float out_a[];
};
layout(set = 0, binding = 4, std430) writeonly buffer OutB {
    float out_b[];
};

void put(uint buffer_, uint at, vec3 v) {
    if (buffer_ == 1u) {
        out_a[at] = v.x;
        out_a[at + 1u] = v.y;
        out_a[at + 2u] = v.z;
    } else {
        out_b[at] = v.x;
        out_b[at + 1u] = v.y;
        out_b[at + 2u] = v.z;
    }
}

vec3 cross3(vec3 a, vec3 b) {
    precise vec3 product = a.yzx * b.zxy - a.zxy * b.yzx;
    return product;
}

// A matrix of columns x, y, z times a vector.
vec3 along(vec3 x, vec3 y, vec3 z, vec3 v) {
    precise vec3 sum = x * v.x + y * v.y + z * v.z;
    return sum;
}

// A vector's direction, or the rest pose's where it has none: its square is not a normal number.
vec3 unit(vec3 v, vec3 rest) {
    precise float square = v.x * v.x + v.y * v.y + v.z * v.z;
    if (square >= 1.17549435e-38 && square <= 3.4028234e+38) {
        precise float scale = 1.0 / sqrt(square);
        precise vec3 direction = v * scale;
        return direction;
    }
    return rest;
}

void main() {
    uint item = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u
        + gl_LocalInvocationIndex;
    uint instance = item / params.vertex_len;
    uint i = item % params.vertex_len;
    if (instance >= params.instance_len) {
        return;
    }
    uint vertex = params.vertex_first + i;
    uint palette = (params.palettes_offset + instance * params.palettes_stride) / 4u;
    precise vec4 row_x = vec4(0.0);
    precise vec4 row_y = vec4(0.0);
    precise vec4 row_z = vec4(0.0);
    for (uint k = 0u; k < params.influence_len; k++) {
        uint influence = vertex * params.influence_len + k;
        float weight = blob_float(params.influence_weights + influence);
        uint at = palette + 3u * blob_half(params.influence_indices, influence);
        row_x += palettes[at] * weight;
        row_y += palettes[at + 1u] * weight;
        row_z += palettes[at + 2u] * weight;
    }
    vec3 x = vec3(row_x.x, row_y.x, row_z.x);
    vec3 y = vec3(row_x.y, row_y.y, row_z.y);
    vec3 z = vec3(row_x.z, row_y.z, row_z.z);

    if (params.positions_buffer != 0u) {
        vec3 rest = blob_vec3(params.rest_positions + 3u * vertex);
        precise vec3 moved = along(x, y, z, rest) + vec3(row_x.w, row_y.w, row_z.w);
        uint at = params.positions_offset + instance * params.positions_instance_stride
            + i * params.positions_stride;
        put(params.positions_buffer, at, moved);
    }
    if (params.normals_buffer != 0u) {
        vec3 rest = blob_vec3(params.rest_normals + 3u * vertex);
        // By the cofactors.
        vec3 turned = along(cross3(y, z), cross3(z, x), cross3(x, y), rest);
        uint at = params.normals_offset + instance * params.normals_instance_stride
            + i * params.normals_stride;
        put(params.normals_buffer, at, unit(turned, rest));
    }
    if (params.tangents_buffer != 0u) {
        vec3 rest = blob_vec3(params.rest_tangents + 4u * vertex);
        uint at = params.tangents_offset + instance * params.tangents_instance_stride
            + i * params.tangents_stride;
        put(params.tangents_buffer, at, unit(along(x, y, z, rest), rest));
        float hand = blob_float(params.rest_tangents + 4u * vertex + 3u);
        if (params.tangents_buffer == 1u) {
            out_a[at + 3u] = hand;
        } else {
            out_b[at + 3u] = hand;
        }
    }
}
