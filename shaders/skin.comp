#version 450
#extension GL_GOOGLE_include_directive : require
// Stage skin: palettes to positions, normals and tangents. One thread a vertex.

#include "params.glsl"
#include "blob.glsl"
#include "frame.glsl"

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

// Rest position of a vertex: from the host's mesh if there is one, else from the file.
vec3 rest_position(uint instance, uint vertex) {
    if (params.host_positions_offset == NONE) {
        return vertex_vec3(params.rest_positions, 3u, vertex);
    }
    uint first = params.host_positions_offset + instance * params.host_positions_stride;
    return host_vec3(first + 3u * vertex);
}

vec3 rest_normal(uint instance, uint vertex) {
    if (params.host_normals_offset == NONE) {
        return vertex_vec3(params.rest_normals, 3u, vertex);
    }
    uint first = params.host_normals_offset + instance * params.host_normals_stride;
    return host_vec3(first + 3u * vertex);
}

// Rest tangent: a direction, then the handedness.
vec4 rest_tangent(uint instance, uint vertex) {
    if (params.host_tangents_offset == NONE) {
        return vertex_vec4(params.rest_tangents, vertex);
    }
    uint at = params.host_tangents_offset + instance * params.host_tangents_stride + 4u * vertex;
    return vec4(host_vec3(at), uintBitsToFloat(host[at + 3u]));
}

void put(uint at, vec3 v) {
    out_floats[at] = v.x;
    out_floats[at + 1u] = v.y;
    out_floats[at + 2u] = v.z;
}

// The matrix with columns x, y, z, times a vector.
vec3 along(vec3 x, vec3 y, vec3 z, vec3 v) {
    precise vec3 sum = x * v.x + y * v.y + z * v.z;
    return sum;
}

// -1 if the palette's first transform mirrors, else 1.
float mirror(uint palette) {
    vec3 x = palettes[palette].xyz;
    vec3 y = palettes[palette + 1u].xyz;
    vec3 z = palettes[palette + 2u].xyz;
    return dot3(x, cross3(y, z)) < 0.0 ? -1.0 : 1.0;
}

// Index of the first row of the transform for a vertex's k-th influence.
uint transform_of(uint palette, uint vertex, uint k) {
    uint influence = word_of(0u, params.influence_len, vertex, k);
    return palette + 3u * blob_half(params.influence_indices, influence);
}

// Weight of a vertex's k-th influence.
float weight_of(uint vertex, uint k) {
    return blob_float(word_of(params.influence_weights, params.influence_len, vertex, k));
}

// Image of a point under a transform.
vec3 transformed(uint at, vec3 point) {
    vec4 a = palettes[at];
    vec4 b = palettes[at + 1u];
    vec4 c = palettes[at + 2u];
    vec3 x = vec3(a.x, b.x, c.x);
    vec3 y = vec3(a.y, b.y, c.y);
    vec3 z = vec3(a.z, b.z, c.z);
    precise vec3 place = along(x, y, z, point) + vec3(a.w, b.w, c.w);
    return place;
}

// Correction of the skinned frame by tangent coefficients: sums of g (y - y_first) and h (y -
// y_first), where y are the images of the vertex under its transforms.
Frame corrected_frame(uint palette, uint vertex, vec3 rest) {
    uint others = params.influence_len - 1u;
    vec3 first = transformed(transform_of(palette, vertex, 0u), rest);
    precise vec3 g = vec3(0.0);
    precise vec3 h = vec3(0.0);
    for (uint k = 0u; k < others; k++) {
        uint word = blob[word_of(params.tangent_coefficients, others, vertex, k)];
        if (word == 0u) {
            continue;
        }
        precise vec3 difference = transformed(transform_of(palette, vertex, k + 1u), rest) - first;
        g += difference * half_float(word << 16u);
        h += difference * half_float(word);
    }
    return Frame(g, h);
}

// A normal, transformed by the vertex's strongest influence (the first of equal ones).
vec3 turned_by_strongest(uint palette, uint vertex, vec3 normal) {
    float most = -1.0;
    uint strongest = 0u;
    for (uint k = 0u; k < params.influence_len; k++) {
        float weight = weight_of(vertex, k);
        if (weight > most) {
            most = weight;
            strongest = k;
        }
    }
    uint at = transform_of(palette, vertex, strongest);
    vec4 a = palettes[at];
    vec4 b = palettes[at + 1u];
    vec4 c = palettes[at + 2u];
    return along(vec3(a.x, b.x, c.x), vec3(a.y, b.y, c.y), vec3(a.z, b.z, c.z), normal);
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
        // Clamps the host's index, which may be outside the mesh.
        vertex = min(host[at], params.mesh_len - 1u);
    }
    uint palette = (params.palettes_offset + instance * params.palettes_stride) / 4u;
    precise vec4 row_x = vec4(0.0);
    precise vec4 row_y = vec4(0.0);
    precise vec4 row_z = vec4(0.0);
    for (uint k = 0u; k < params.influence_len; k++) {
        float weight = weight_of(vertex, k);
        uint at = transform_of(palette, vertex, k);
        row_x += palettes[at] * weight;
        row_y += palettes[at + 1u] * weight;
        row_z += palettes[at + 2u] * weight;
    }
    vec3 x = vec3(row_x.x, row_y.x, row_z.x);
    vec3 y = vec3(row_x.y, row_y.y, row_z.y);
    vec3 z = vec3(row_x.z, row_y.z, row_z.z);

    if (params.positions_offset != NONE) {
        vec3 rest = rest_position(instance, vertex);
        precise vec3 place = along(x, y, z, rest) + vec3(row_x.w, row_y.w, row_z.w);
        uint at = params.positions_offset + instance * params.positions_instance_stride;
        put(at + i * params.positions_stride, place);
    }
    if (params.normals_offset == NONE && params.tangents_offset == NONE) {
        return;
    }
    bool has_coefficients = params.tangent_coefficients != NONE;
    vec3 normal = rest_normal(instance, vertex);
    Frame frame = Frame(vec3(0.0), vec3(0.0));
    Frame sums = frame;
    if (has_coefficients) {
        if (params.rest_tangents == NONE) {
            frame = frame_of_normal(normal, blob_float(word_of(params.rest_normals, 3u, vertex, 2u)));
        } else {
            frame = frame_of_tangent(normal, rest_tangent(instance, vertex).xyz);
        }
        sums = corrected_frame(palette, vertex, rest_position(instance, vertex));
    }
    if (params.normals_offset != NONE) {
        float side = mirror(palette);
        vec3 turned;
        if (has_coefficients) {
            precise vec3 g = along(x, y, z, frame.g) + sums.g;
            precise vec3 h = along(x, y, z, frame.h) + sums.h;
            turned = cross3(g, h);
            if (!has_direction(turned)) {
                turned = turned_by_strongest(palette, vertex, normal);
                side = 1.0;
            }
        } else {
            // By the cofactors of the blended matrix.
            turned = along(cross3(y, z), cross3(z, x), cross3(x, y), normal);
        }
        uint at = params.normals_offset + instance * params.normals_instance_stride;
        put(at + i * params.normals_stride, unit(turned, side, normal));
    }
    if (params.tangents_offset != NONE) {
        vec4 rest = rest_tangent(instance, vertex);
        uint at = params.tangents_offset + instance * params.tangents_instance_stride
            + i * params.tangents_stride;
        precise vec3 turned = along(x, y, z, rest.xyz);
        if (has_coefficients) {
            turned += sums.g * dot3(rest.xyz, frame.g);
            turned += sums.h * dot3(rest.xyz, frame.h);
        }
        put(at, unit(turned, 1.0, rest.xyz));
        out_floats[at + 3u] = rest.w;
    }
}
