// Stage 3: palettes to positions, normals and tangents. One thread a vertex.

@group(0) @binding(2) var<storage, read> palettes: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> out_a: array<f32>;
@group(0) @binding(4) var<storage, read_write> out_b: array<f32>;

fn put(buffer: u32, at: u32, v: vec3<f32>) {
    if buffer == 1u {
        out_a[at] = v.x;
        out_a[at + 1u] = v.y;
        out_a[at + 2u] = v.z;
    } else {
        out_b[at] = v.x;
        out_b[at + 1u] = v.y;
        out_b[at + 2u] = v.z;
    }
}

fn cross3(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    return a.yzx * b.zxy - a.zxy * b.yzx;
}

// A vector's direction, or the rest pose's where it has none: its square is not a normal number.
fn unit(v: vec3<f32>, rest: vec3<f32>) -> vec3<f32> {
    let square = v.x * v.x + v.y * v.y + v.z * v.z;
    if square >= 1.17549435e-38 && square <= 3.4028234e+38 {
        return v * (1.0 / sqrt(square));
    }
    return rest;
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let item = (group.y * groups.x + group.x) * 64u + thread;
    let instance = item / params.vertex_len;
    let i = item % params.vertex_len;
    if instance >= params.instance_len {
        return;
    }
    let vertex = params.vertex_first + i;
    let palette = (params.palettes_offset + instance * params.palettes_stride) / 4u;
    var row_x = vec4<f32>(0.0);
    var row_y = vec4<f32>(0.0);
    var row_z = vec4<f32>(0.0);
    for (var k = 0u; k < params.influence_len; k++) {
        let influence = vertex * params.influence_len + k;
        let weight = blob_float(params.influence_weights + influence);
        let at = palette + 3u * blob_half(params.influence_indices, influence);
        row_x += palettes[at] * weight;
        row_y += palettes[at + 1u] * weight;
        row_z += palettes[at + 2u] * weight;
    }
    let x = vec3<f32>(row_x.x, row_y.x, row_z.x);
    let y = vec3<f32>(row_x.y, row_y.y, row_z.y);
    let z = vec3<f32>(row_x.z, row_y.z, row_z.z);

    if params.positions_buffer != 0u {
        let rest = blob_vec3(params.rest_positions + 3u * vertex);
        let moved = (x * rest.x + y * rest.y + z * rest.z) + vec3<f32>(row_x.w, row_y.w, row_z.w);
        let at = params.positions_offset + instance * params.positions_instance_stride
            + i * params.positions_stride;
        put(params.positions_buffer, at, moved);
    }
    if params.normals_buffer != 0u {
        let rest = blob_vec3(params.rest_normals + 3u * vertex);
        // By the cofactors.
        let along = cross3(y, z) * rest.x + cross3(z, x) * rest.y + cross3(x, y) * rest.z;
        let at = params.normals_offset + instance * params.normals_instance_stride
            + i * params.normals_stride;
        put(params.normals_buffer, at, unit(along, rest));
    }
    if params.tangents_buffer != 0u {
        let rest = blob_vec3(params.rest_tangents + 4u * vertex);
        let along = x * rest.x + y * rest.y + z * rest.z;
        let at = params.tangents_offset + instance * params.tangents_instance_stride
            + i * params.tangents_stride;
        put(params.tangents_buffer, at, unit(along, rest));
        let hand = blob_float(params.rest_tangents + 4u * vertex + 3u);
        if params.tangents_buffer == 1u {
            out_a[at + 3u] = hand;
        } else {
            out_b[at + 3u] = hand;
        }
    }
}
