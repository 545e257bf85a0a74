// Stage correction: adds the results of the kernel maps to palettes. One workgroup a group of
// helpers; its threads exchange results in the group's scratch.

@group(0) @binding(2) var<storage, read> poses: array<f32>;
@group(0) @binding(3) var<storage, read_write> scratch: array<f32>;
@group(0) @binding(4) var<storage, read_write> palettes: array<f32>;

// Unexplained error where no sample is near.
const UNEXPLAINED = 1.0e30;
// reach over the squared distance from rest where the error's growth turns.
const TURN = 4.0;

fn padded(len: u32) -> u32 {
    return (len + 7u) / 8u * 8u;
}

// e^-s - e^-s0, given s - s0 and s0.
fn gaussian_change(gain: f32, rest: f32) -> f32 {
    if gain < 0.0 {
        return exp_negative(max(rest + gain, 0.0)) * one_minus_exp_negative(-gain);
    }
    return -(exp_negative(max(rest, 0.0)) * one_minus_exp_negative(gain));
}

// Least and greatest sum of the squares of a linear part that is projected.
const LEAST = 1.0e-6;
const MOST = 1.0e6;
// Least determinant, in magnitude, of a projected linear part of the norm of a rotation.
const FLAT = 0.1;

// Column c of a transform of the palette.
fn palette_column(at: u32, c: u32) -> vec3<f32> {
    return vec3<f32>(palettes[at + c], palettes[at + 4u + c], palettes[at + 8u + c]);
}

// Projects the transform of a helper onto the kind of the envelope: kind 1 has a scale, kind 2 none.
fn project(at: u32, place: u32) {
    let x = palette_column(at, 0u);
    let y = palette_column(at, 1u);
    let z = palette_column(at, 2u);
    let square = dot3(x, x) + dot3(y, y) + dot3(z, z);
    if !(square > LEAST && square < MOST) {
        return;
    }
    let unit = normed(mat3x3<f32>(x, y, z));
    if !(abs(dot3(unit[0], cross3(unit[1], unit[2]))) > FLAT) {
        return;
    }
    let turn = nearest_rotation(unit);
    var scale = vec3<f32>(1.0);
    if params.helper_kind == 1u {
        scale = vec3<f32>(dot3(turn[0], x), dot3(turn[1], y), dot3(turn[2], z));
    }
    let a = turn[0] * scale.x;
    let b = turn[1] * scale.y;
    let c = turn[2] * scale.z;
    let centre = vec3<f32>(blob_float(place), blob_float(place + 1u), blob_float(place + 2u));
    for (var r = 0u; r < 3u; r++) {
        let row = at + 4u * r;
        let apart = vec3<f32>(x[r] - a[r], y[r] - b[r], z[r] - c[r]);
        palettes[row] = a[r];
        palettes[row + 1u] = b[r];
        palettes[row + 2u] = c[r];
        palettes[row + 3u] += dot3(apart, centre);
    }
}

// Projects the helpers of a group.
fn project_all(palette: u32, first: u32, proxy_len: u32, thread: u32) {
    for (var helper = thread; helper < proxy_len; helper += 64u) {
        project(palette + 12u * helper, params.helper_places + 9u * (first + helper));
    }
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let instance = workgroup.y;
    let group = workgroup.x;
    let pose = params.poses_offset + instance * params.poses_stride;
    let base = params.scratch_offset + instance * params.scratch_stride;
    let error = base + params.group_confidences + 2u * group;

    let row = params.groups + 8u * group;
    let joint = blob[row] & 0xffffu;
    let kernel = (blob[row] >> 16u) & 0xffu;
    let d = blob[row + 1u] & 0xffffu;
    let n = blob[row + 1u] >> 16u;
    let rank = blob[row + 2u] & 0xffffu;
    let proxy_len = blob[row + 2u] >> 16u;
    let certainty_len = blob[row] >> 24u;
    // The first helper of the group, and its transform.
    var first = 0u;
    for (var before = 0u; before < group; before++) {
        first += blob[params.groups + 8u * before + 2u] >> 16u;
    }
    let palette = params.palettes_offset + instance * params.palettes_stride
        + 12u * (params.palette_len - params.proxy_len + first);
    if n == 0u {
        if thread == 0u {
            scratch[error] = 0.0;
            scratch[error + 1u] = 0.0;
        }
        if params.helper_kind != 0u {
            project_all(palette, first, proxy_len, thread);
        }
        return;
    }
    let inputs = params.corrections + blob[row + 3u];
    let weights = inputs + padded(d);
    let centres = weights + padded(d);
    let rests = centres + padded(n) * d;
    let coefficients = rests + padded(n);
    let outputs = coefficients + padded(rank + certainty_len) * (n + d);

    let x = base + params.group_scratch + group * params.group_stride;
    let basis = x + padded(d);
    let latent = basis + padded(n);

    for (var i = thread; i < d; i += 64u) {
        scratch[x + i] = blob_float(weights + i) * scratch[base + params.features + blob[inputs + i]];
    }
    storageBarrier();

    for (var k = thread; k < n; k += 64u) {
        // The squared distance from t; for a gaussian its excess over the distance from rest, x (x - 2 t).
        var sum = 0.0;
        var at = centres + k / 8u * (8u * d) + k % 8u;
        for (var i = 0u; i < d; i++) {
            let value = scratch[x + i];
            let t = blob_float(at);
            let apart = value - t;
            sum += apart * select(apart, value, kernel == 8u);
            at += 8u;
        }
        let rest = blob_float(rests + k);
        if kernel == 8u {
            scratch[basis + k] = gaussian_change(sum, rest);
        } else {
            scratch[basis + k] = matern(kernel, sum) - rest;
        }
    }
    storageBarrier();

    for (var r = thread; r < rank + certainty_len; r += 64u) {
        var sum = 0.0;
        var at = coefficients + r / 8u * (8u * (n + d)) + r % 8u;
        for (var k = 0u; k < n; k++) {
            sum += blob_float(at) * scratch[basis + k];
            at += 8u;
        }
        for (var i = 0u; i < d; i++) {
            sum += blob_float(at) * scratch[x + i];
            at += 8u;
        }
        scratch[latent + r] = sum;
    }
    storageBarrier();

    if thread == 0u {
        var apart = 0.0;
        for (var i = 0u; i < d; i++) {
            let value = scratch[x + i];
            apart += value * value;
        }
        let change = scratch[basis];
        let prior = max(0.0, -change * (2.0 + change) + blob_float(row + 5u) * apart);
        var explained_error = 0.0;
        var unexplained_error = UNEXPLAINED;
        let reach = blob_float(row + 4u);
        let near = nearness(apart, reach, 4.0 * reach);
        if near > 0.0 {
            var explained = 0.0;
            for (var i = 0u; i < certainty_len; i++) {
                let value = scratch[latent + rank + i];
                explained += value * value;
            }
            explained = near * min(prior, explained);
            let turned = TURN * apart;
            let growth = turned / (turned + reach);
            explained_error = blob_float(row + 6u) * (growth * explained);
            unexplained_error = blob_float(row + 7u) * (growth * (prior - explained));
        }
        scratch[error] = explained_error;
        scratch[error + 1u] = unexplained_error;
    }
    storageBarrier();

    let explained_error = 1.0 + scratch[error];
    let confidence = explained_error / (explained_error + scratch[error + 1u]);
    let w = smooth_step(min(1.0, 8.0 * confidence));
    if w > 0.0 {
        // The identity for an envelope without joints.
        var dominant = mat3x3<f32>(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
        if joint != NO_JOINT {
            dominant = linear_part(pose + 12u * joint);
        }
        // Each thread computes a column of a transform.
        for (var i = thread; i < 4u * proxy_len; i += 64u) {
            var added = vec3<f32>(0.0);
            for (var r = 0u; r < 3u; r++) {
                let output = 12u * (i / 4u) + 4u * r + i % 4u;
                var at = outputs + output / 8u * (8u * rank) + output % 8u;
                var sum = 0.0;
                for (var j = 0u; j < rank; j++) {
                    sum += blob_float(at) * scratch[latent + j];
                    at += 8u;
                }
                added[r] = sum * w;
            }
            let turned = dominant[0] * added.x + dominant[1] * added.y + dominant[2] * added.z;
            for (var r = 0u; r < 3u; r++) {
                palettes[palette + 12u * (i / 4u) + 4u * r + i % 4u] += turned[r];
            }
        }
    }
    if params.helper_kind != 0u {
        storageBarrier();
        project_all(palette, first, proxy_len, thread);
    }
}
