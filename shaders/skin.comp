#version 450
#extension GL_GOOGLE_include_directive : require
// Stage skin: palettes to positions, normals and tangents. One thread a vertex.

#include "params.glsl"
#include "blob.glsl"

layout(local_size_x = 64) in;
layout(set = 0, binding = 2, std430) readonly buffer Palettes {
    vec4 palettes[];
};
layout(set = 0, binding = 3, std430) readonly buffer Host {
    uint host[];
};
layout(set = 0, binding = 4, std430) writeonly buffer Out {
    float out_floats[];
};

vec3 host_vec3(uint word) {
    return uintBitsToFloat(uvec3(host[word], host[word + 1u], host[word + 2u]));
}

// A vertex at rest: as the host's mesh has it where it brings one, or else as the file's has.
vec3 rest_position(uint instance, uint vertex) {
    if (params.host_positions_offset == NONE) {
        return blob_vec3(params.rest_positions + 3u * vertex);
    }
    uint first = params.host_positions_offset + instance * params.host_positions_stride;
    return host_vec3(first + 3u * vertex);
}

vec3 rest_normal(uint instance, uint vertex) {
    if (params.host_normals_offset == NONE) {
        return blob_vec3(params.rest_normals + 3u * vertex);
    }
    uint first = params.host_normals_offset + instance * params.host_normals_stride;
    return host_vec3(first + 3u * vertex);
}

// A direction and, last, the handedness.
vec4 rest_tangent(uint instance, uint vertex) {
    if (params.host_tangents_offset == NONE) {
        return blob_vec4(params.rest_tangents + 4u * vertex);
    }
    uint at = params.host_tangents_offset + instance * params.host_tangents_stride + 4u * vertex;
    return vec4(host_vec3(at), uintBitsToFloat(host[at + 3u]));
}

void put(uint at, vec3 v) {
    out_floats[at] = v.x;
    out_floats[at + 1u] = v.y;
    out_floats[at + 2u] = v.z;
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
    uint instance = gl_WorkGroupID.y;
    uint i = gl_GlobalInvocationID.x;
    if (i >= params.vertex_len) {
        return;
    }
    uint vertex = params.vertex_first + i;
    if (params.host_remap_offset != NONE) {
        uint at = params.host_remap_offset + instance * params.host_remap_stride + vertex;
        // The host's own index: one beyond the mesh must not be followed.
        vertex = min(host[at], params.mesh_len - 1u);
    }
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

    if (params.positions_offset != NONE) {
        vec3 rest = rest_position(instance, vertex);
        precise vec3 moved = along(x, y, z, rest) + vec3(row_x.w, row_y.w, row_z.w);
        uint at = params.positions_offset + instance * params.positions_instance_stride;
        put(at + i * params.positions_stride, moved);
    }
    if (params.normals_offset != NONE) {
        vec3 rest = rest_normal(instance, vertex);
        // By the cofactors.
        vec3 turned = along(cross3(y, z), cross3(z, x), cross3(x, y), rest);
        uint at = params.normals_offset + instance * params.normals_instance_stride;
        put(at + i * params.normals_stride, unit(turned, rest));
    }
    if (params.tangents_offset != NONE) {
        vec4 rest = rest_tangent(instance, vertex);
        uint at = params.tangents_offset + instance * params.tangents_instance_stride
            + i * params.tangents_stride;
        put(at, unit(along(x, y, z, rest.xyz), rest.xyz));
        out_floats[at + 3u] = rest.w;
    }
}
