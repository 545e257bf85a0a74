#version 450
#extension GL_GOOGLE_include_directive : require
// Stage shapes: weights of shapes to the rest mesh of a skin. One thread a vertex, one workgroup a
// block.

#include "shapes_params.glsl"
#include "blob.glsl"
#include "frame.glsl"

layout(local_size_x = 64) in;
layout(set = 0, binding = 2, std430) readonly buffer Weights {
    float weights[];
};
layout(set = 0, binding = 3, std430) writeonly buffer Out {
    float out_floats[];
};

void put(uint at, vec3 v) {
    out_floats[at] = v.x;
    out_floats[at + 1u] = v.y;
    out_floats[at + 2u] = v.z;
}

const uint ELEMENT_F16 = 4u;
const uint ELEMENT_I8 = 5u;

// Number `index` of a section of deltas or slopes.
float number(uint section, uint index) {
    if (params.element == ELEMENT_I8) {
        uint word = blob[section + index / 4u];
        return float(int(word << (24u - 8u * (index & 3u))) >> 24);
    }
    if (params.element == ELEMENT_F16) {
        return half_float(blob_half(section, index) << 16u);
    }
    return blob_float(section + index);
}

void main() {
    uint instance = gl_WorkGroupID.y;
    uint block = params.vertex_first / 64u + gl_WorkGroupID.x;
    uint own = gl_LocalInvocationID.x;
    uint vertex = 64u * block + own;
    if (vertex < params.vertex_first || vertex - params.vertex_first >= params.vertex_len) {
        return;
    }
    uint i = vertex - params.vertex_first;
    bool tilts = params.normals_offset != NONE || params.tangents_offset != NONE;
    precise vec3 offset = vec3(0.0);
    precise vec2 tilt = vec2(0.0);
    uint entry_first = 0u;
    uint entry_end = 0u;
    if (params.shape_blocks != NONE) {
        entry_first = blob[params.shape_blocks + block];
        entry_end = blob[params.shape_blocks + block + 1u];
    }
    // Bits of a mask below the vertex's own bit.
    uvec2 below = own < 32u ? uvec2((1u << own) - 1u, 0u)
        : uvec2(0xffffffffu, (1u << (own - 32u)) - 1u);
    for (uint entry = entry_first; entry < entry_end; entry++) {
        uint at = params.shape_entries + 4u * entry;
        uvec2 mask = uvec2(blob[at], blob[at + 1u]);
        uint bits = own < 32u ? mask.x : mask.y;
        if (((bits >> (own & 31u)) & 1u) == 0u) {
            continue;
        }
        uint shape = blob[at + 2u];
        float weight = weights[params.weights_offset + instance * params.weights_stride + shape];
        if (weight == 0.0) {
            continue;
        }
        uint delta = blob[at + 3u] + uint(bitCount(mask.x & below.x) + bitCount(mask.y & below.y));
        uint row = params.shapes + 8u * shape;
        uint first = 3u * delta;
        vec3 by = vec3(
            number(params.shape_deltas, first),
            number(params.shape_deltas, first + 1u),
            number(params.shape_deltas, first + 2u)
        );
        precise float scaled = weight * blob_float(row);
        offset += by * scaled;
        if (tilts) {
            first = 2u * delta;
            vec2 slopes =
                vec2(number(params.shape_slopes, first), number(params.shape_slopes, first + 1u));
            precise float of_slopes = weight * blob_float(row + 1u);
            tilt += slopes * of_slopes;
        }
    }

    if (params.positions_offset != NONE) {
        precise vec3 place = vertex_vec3(params.rest_positions, 3u, vertex) + offset;
        uint at = params.positions_offset + instance * params.positions_instance_stride;
        put(at + i * params.positions_stride, place);
    }
    if (!tilts) {
        return;
    }
    vec3 normal = vertex_vec3(params.rest_normals, 3u, vertex);
    vec4 tangent = vec4(0.0);
    if (params.rest_tangents != NONE) {
        tangent = vertex_vec4(params.rest_tangents, vertex);
    }
    if (params.normals_offset != NONE) {
        Frame frame;
        if (params.rest_tangents == NONE) {
            frame = frame_of_normal(normal, normal.z);
        } else {
            frame = frame_of_tangent(normal, tangent.xyz);
        }
        precise vec3 tilted = (normal - frame.g * tilt.x) - frame.h * tilt.y;
        uint at = params.normals_offset + instance * params.normals_instance_stride;
        put(at + i * params.normals_stride, unit(tilted, 1.0, normal));
    }
    if (params.tangents_offset != NONE) {
        precise vec3 lifted = tangent.xyz + normal * tilt.x;
        uint at = params.tangents_offset + instance * params.tangents_instance_stride
            + i * params.tangents_stride;
        put(at, unit(lifted, 1.0, tangent.xyz));
        out_floats[at + 3u] = tangent.w;
    }
}
