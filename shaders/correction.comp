#version 450
#extension GL_GOOGLE_include_directive : require
// Stage correction: adds the results of the kernel maps to palettes. One workgroup a group of
// helpers; its threads exchange results in the group's scratch.

#include "params.glsl"
#include "blob.glsl"
#include "numeric.glsl"

layout(local_size_x = 64) in;
layout(set = 0, binding = 2, std430) readonly buffer Poses {
    float poses[];
};
layout(set = 0, binding = 3, std430) coherent buffer Scratch {
    float scratch[];
};
layout(set = 0, binding = 4, std430) coherent buffer Palettes {
    float palettes[];
};

#include "joint.glsl"
#include "nearest.glsl"

// Unexplained error where no sample is near.
const float UNEXPLAINED = 1.0e30;
// reach over the squared distance from rest where the error's growth turns.
const float TURN = 4.0;

uint padded(uint len) {
    return (len + 7u) / 8u * 8u;
}

// e^-s - e^-s0, given s - s0 and s0.
float gaussian_change(float gain, float rest) {
    bool nearer = gain < 0.0;
    precise float least = nearer ? max(rest + gain, 0.0) : max(rest, 0.0);
    float greater = exp_negative(least);
    precise float change = greater * one_minus_exp_negative(nearer ? -gain : gain);
    return nearer ? change : -change;
}

// Least and greatest sum of the squares of a linear part that is projected.
const float LEAST = 1.0e-6;
const float MOST = 1.0e6;
// Least determinant, in magnitude, of a projected linear part of the norm of a rotation.
const float FLAT = 0.1;

// Column c of a transform of the palette.
vec3 palette_column(uint at, uint c) {
    return vec3(palettes[at + c], palettes[at + 4u + c], palettes[at + 8u + c]);
}

// Projects the transform of a helper onto the kind of the envelope: kind 1 has a scale, kind 2 none.
void project(uint at, uint place) {
    vec3 x = palette_column(at, 0u);
    vec3 y = palette_column(at, 1u);
    vec3 z = palette_column(at, 2u);
    precise float square = dot3(x, x) + dot3(y, y) + dot3(z, z);
    if (!(square > LEAST && square < MOST)) {
        return;
    }
    mat3 unit = normed(mat3(x, y, z));
    if (!(abs(dot3(unit[0], cross3(unit[1], unit[2]))) > FLAT)) {
        return;
    }
    mat3 turn = nearest_rotation(unit);
    vec3 scale = vec3(1.0);
    if (params.helper_kind == 1u) {
        scale = vec3(dot3(turn[0], x), dot3(turn[1], y), dot3(turn[2], z));
    }
    precise vec3 a = turn[0] * scale.x;
    precise vec3 b = turn[1] * scale.y;
    precise vec3 c = turn[2] * scale.z;
    vec3 centre = vec3(blob_float(place), blob_float(place + 1u), blob_float(place + 2u));
    for (uint r = 0u; r < 3u; r++) {
        uint row = at + 4u * r;
        precise vec3 apart = vec3(x[r] - a[r], y[r] - b[r], z[r] - c[r]);
        precise float shift = palettes[row + 3u] + dot3(apart, centre);
        palettes[row] = a[r];
        palettes[row + 1u] = b[r];
        palettes[row + 2u] = c[r];
        palettes[row + 3u] = shift;
    }
}

// Projects the helpers of a group.
void project_all(uint palette, uint first, uint proxy_len, uint thread) {
    for (uint helper = thread; helper < proxy_len; helper += 64u) {
        project(palette + 12u * helper, params.helper_places + 9u * (first + helper));
    }
}

void main() {
    uint thread = gl_LocalInvocationIndex;
    uint instance = gl_WorkGroupID.y;
    uint group = gl_WorkGroupID.x;
    uint pose = params.poses_offset + instance * params.poses_stride;
    uint base = params.scratch_offset + instance * params.scratch_stride;
    uint error = base + params.group_confidences + 2u * group;

    uint row = params.groups + 8u * group;
    uint joint = blob[row] & 0xffffu;
    uint kernel = (blob[row] >> 16u) & 0xffu;
    uint d = blob[row + 1u] & 0xffffu;
    uint n = blob[row + 1u] >> 16u;
    uint rank = blob[row + 2u] & 0xffffu;
    uint proxy_len = blob[row + 2u] >> 16u;
    uint certainty_len = blob[row] >> 24u;
    // The first helper of the group, and its transform.
    uint first = 0u;
    for (uint before = 0u; before < group; before++) {
        first += blob[params.groups + 8u * before + 2u] >> 16u;
    }
    uint palette = params.palettes_offset + instance * params.palettes_stride
        + 12u * (params.palette_len - params.proxy_len + first);
    if (n == 0u) {
        if (thread == 0u) {
            scratch[error] = 0.0;
            scratch[error + 1u] = 0.0;
        }
        if (params.helper_kind != 0u) {
            project_all(palette, first, proxy_len, thread);
        }
        return;
    }
    uint inputs = params.corrections + blob[row + 3u];
    uint weights = inputs + padded(d);
    uint centres = weights + padded(d);
    uint rests = centres + padded(n) * d;
    uint coefficients = rests + padded(n);
    uint outputs = coefficients + padded(rank + certainty_len) * (n + d);

    uint x = base + params.group_scratch + group * params.group_stride;
    uint basis = x + padded(d);
    uint latent = basis + padded(n);

    for (uint i = thread; i < d; i += 64u) {
        precise float value =
            blob_float(weights + i) * scratch[base + params.features + blob[inputs + i]];
        scratch[x + i] = value;
    }
    memoryBarrierBuffer();
    barrier();

    for (uint k = thread; k < n; k += 64u) {
        // The squared distance from t; for a gaussian its excess over the distance from rest, x (x - 2 t).
        precise float sum = 0.0;
        uint at = centres + k / 8u * (8u * d) + k % 8u;
        for (uint i = 0u; i < d; i++) {
            float value = scratch[x + i];
            float t = blob_float(at);
            precise float apart = value - t;
            sum += apart * (kernel == 8u ? value : apart);
            at += 8u;
        }
        float rest = blob_float(rests + k);
        precise float change = kernel == 8u
            ? gaussian_change(sum, rest)
            : matern(kernel, sum) - rest;
        scratch[basis + k] = change;
    }
    memoryBarrierBuffer();
    barrier();

    for (uint r = thread; r < rank + certainty_len; r += 64u) {
        precise float sum = 0.0;
        uint at = coefficients + r / 8u * (8u * (n + d)) + r % 8u;
        for (uint k = 0u; k < n; k++) {
            sum += blob_float(at) * scratch[basis + k];
            at += 8u;
        }
        for (uint i = 0u; i < d; i++) {
            sum += blob_float(at) * scratch[x + i];
            at += 8u;
        }
        scratch[latent + r] = sum;
    }
    memoryBarrierBuffer();
    barrier();

    if (thread == 0u) {
        precise float apart = 0.0;
        for (uint i = 0u; i < d; i++) {
            float value = scratch[x + i];
            apart += value * value;
        }
        float change = scratch[basis];
        precise float variance = -change * (2.0 + change) + blob_float(row + 5u) * apart;
        float prior = max(0.0, variance);
        float explained_error = 0.0;
        float unexplained_error = UNEXPLAINED;
        float reach = blob_float(row + 4u);
        float near = nearness(apart, reach, 4.0 * reach);
        if (near > 0.0) {
            precise float explained = 0.0;
            for (uint i = 0u; i < certainty_len; i++) {
                float value = scratch[latent + rank + i];
                explained += value * value;
            }
            explained = near * min(prior, explained);
            precise float turned = TURN * apart;
            precise float growth = turned / (turned + reach);
            precise float left = prior - explained;
            precise float grown = growth * explained;
            precise float grown_left = growth * left;
            explained_error = blob_float(row + 6u) * grown;
            unexplained_error = blob_float(row + 7u) * grown_left;
        }
        scratch[error] = explained_error;
        scratch[error + 1u] = unexplained_error;
    }
    memoryBarrierBuffer();
    barrier();

    precise float explained_error = 1.0 + scratch[error];
    precise float confidence = explained_error / (explained_error + scratch[error + 1u]);
    precise float w = smooth_step(min(1.0, 8.0 * confidence));
    if (w > 0.0) {
        // The identity for an envelope without joints.
        mat3 dominant = mat3(1.0);
        if (joint != NO_JOINT) {
            dominant = linear_part(pose + 12u * joint);
        }
        // Each thread computes a column of a transform.
        for (uint i = thread; i < 4u * proxy_len; i += 64u) {
            precise vec3 added = vec3(0.0);
            for (uint r = 0u; r < 3u; r++) {
                uint row_of = 12u * (i / 4u) + 4u * r + i % 4u;
                uint at = outputs + row_of / 8u * (8u * rank) + row_of % 8u;
                precise float sum = 0.0;
                for (uint j = 0u; j < rank; j++) {
                    sum += blob_float(at) * scratch[latent + j];
                    at += 8u;
                }
                added[r] = sum * w;
            }
            precise vec3 turned =
                dominant[0] * added.x + dominant[1] * added.y + dominant[2] * added.z;
            for (uint r = 0u; r < 3u; r++) {
                uint to = palette + 12u * (i / 4u) + 4u * r + i % 4u;
                precise float value = palettes[to] + turned[r];
                palettes[to] = value;
            }
        }
    }
    if (params.helper_kind != 0u) {
        memoryBarrierBuffer();
        barrier();
        project_all(palette, first, proxy_len, thread);
    }
}
