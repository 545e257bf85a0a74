// Stage skin: palettes to positions, normals and tangents. One thread a vertex.

@group(0) @binding(2) var<storage, read> palettes: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> host: array<u32>;
@group(0) @binding(4) var<storage, read_write> out: array<f32>;

fn host_vec3(word: u32) -> vec3<f32> {
    return bitcast<vec3<f32>>(vec3<u32>(host[word], host[word + 1u], host[word + 2u]));
}

// A vertex at rest: as the host's mesh has it where it brings one, or else as the file's has.
fn rest_position(instance: u32, vertex: u32) -> vec3<f32> {
    if params.host_positions_offset == NONE {
        return blob_vec3(params.rest_positions + 3u * vertex);
    }
    let first = params.host_positions_offset + instance * params.host_positions_stride;
    return host_vec3(first + 3u * vertex);
}

fn rest_normal(instance: u32, vertex: u32) -> vec3<f32> {
    if params.host_normals_offset == NONE {
        return blob_vec3(params.rest_normals + 3u * vertex);
    }
    let first = params.host_normals_offset + instance * params.host_normals_stride;
    return host_vec3(first + 3u * vertex);
}

// A direction and, last, the handedness.
fn rest_tangent(instance: u32, vertex: u32) -> vec4<f32> {
    if params.host_tangents_offset == NONE {
        return blob_vec4(params.rest_tangents + 4u * vertex);
    }
    let at = params.host_tangents_offset + instance * params.host_tangents_stride + 4u * vertex;
    return vec4<f32>(host_vec3(at), bitcast<f32>(host[at + 3u]));
}

fn put(at: u32, v: vec3<f32>) {
    out[at] = v.x;
    out[at + 1u] = v.y;
    out[at + 2u] = v.z;
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
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let instance = workgroup.y;
    let i = 64u * workgroup.x + thread;
    if i >= params.vertex_len {
        return;
    }
    var vertex = params.vertex_first + i;
    if params.host_remap_offset != NONE {
        let at = params.host_remap_offset + instance * params.host_remap_stride + vertex;
        // The host's own index: one beyond the mesh must not be followed.
        vertex = min(host[at], params.mesh_len - 1u);
    }
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

    if params.positions_offset != NONE {
        let rest = rest_position(instance, vertex);
        let moved = (x * rest.x + y * rest.y + z * rest.z) + vec3<f32>(row_x.w, row_y.w, row_z.w);
        let at = params.positions_offset + instance * params.positions_instance_stride;
        put(at + i * params.positions_stride, moved);
    }
    if params.normals_offset != NONE {
        let rest = rest_normal(instance, vertex);
        // By the cofactors.
        let along = cross3(y, z) * rest.x + cross3(z, x) * rest.y + cross3(x, y) * rest.z;
        let at = params.normals_offset + instance * params.normals_instance_stride;
        put(at + i * params.normals_stride, unit(along, rest));
    }
    if params.tangents_offset != NONE {
        let rest = rest_tangent(instance, vertex);
        let along = x * rest.x + y * rest.y + z * rest.z;
        let at = params.tangents_offset + instance * params.tangents_instance_stride
            + i * params.tangents_stride;
        put(at, unit(along, rest.xyz));
        out[at + 3u] = rest.w;
    }
}
