// Stage skin: palettes to positions, normals and tangents. One thread a vertex.

@group(0) @binding(2) var<storage, read> palettes: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> host: array<u32>;
@group(0) @binding(4) var<storage, read_write> out: array<f32>;

fn host_vec3(word: u32) -> vec3<f32> {
    return bitcast<vec3<f32>>(vec3<u32>(host[word], host[word + 1u], host[word + 2u]));
}

// Rest position of a vertex: from the host's mesh if there is one, else from the file.
fn rest_position(instance: u32, vertex: u32) -> vec3<f32> {
    if params.host_positions_offset == NONE {
        return vertex_vec3(params.rest_positions, 3u, vertex);
    }
    let first = params.host_positions_offset + instance * params.host_positions_stride;
    return host_vec3(first + 3u * vertex);
}

fn rest_normal(instance: u32, vertex: u32) -> vec3<f32> {
    if params.host_normals_offset == NONE {
        return vertex_vec3(params.rest_normals, 3u, vertex);
    }
    let first = params.host_normals_offset + instance * params.host_normals_stride;
    return host_vec3(first + 3u * vertex);
}

// Rest tangent: a direction, then the handedness.
fn rest_tangent(instance: u32, vertex: u32) -> vec4<f32> {
    if params.host_tangents_offset == NONE {
        return vertex_vec4(params.rest_tangents, vertex);
    }
    let at = params.host_tangents_offset + instance * params.host_tangents_stride + 4u * vertex;
    return vec4<f32>(host_vec3(at), bitcast<f32>(host[at + 3u]));
}

fn put(at: u32, v: vec3<f32>) {
    out[at] = v.x;
    out[at + 1u] = v.y;
    out[at + 2u] = v.z;
}

// The matrix with columns x, y, z, times a vector.
fn along(x: vec3<f32>, y: vec3<f32>, z: vec3<f32>, v: vec3<f32>) -> vec3<f32> {
    return x * v.x + y * v.y + z * v.z;
}

// -1 if the palette's first transform mirrors, else 1.
fn mirror(palette: u32) -> f32 {
    let x = palettes[palette].xyz;
    let y = palettes[palette + 1u].xyz;
    let z = palettes[palette + 2u].xyz;
    return select(1.0, -1.0, dot3(x, cross3(y, z)) < 0.0);
}

// Index of the first row of the transform for a vertex's k-th influence.
fn transform_of(palette: u32, vertex: u32, k: u32) -> u32 {
    let influence = word_of(0u, params.influence_len, vertex, k);
    return palette + 3u * blob_half(params.influence_indices, influence);
}

// Weight of a vertex's k-th influence.
fn weight_of(vertex: u32, k: u32) -> f32 {
    return blob_float(word_of(params.influence_weights, params.influence_len, vertex, k));
}

// Image of a point under a transform.
fn transformed(at: u32, point: vec3<f32>) -> vec3<f32> {
    let a = palettes[at];
    let b = palettes[at + 1u];
    let c = palettes[at + 2u];
    let x = vec3<f32>(a.x, b.x, c.x);
    let y = vec3<f32>(a.y, b.y, c.y);
    let z = vec3<f32>(a.z, b.z, c.z);
    return along(x, y, z, point) + vec3<f32>(a.w, b.w, c.w);
}

// Correction of the skinned frame by tangent coefficients: sums of g (y - y_first) and h (y -
// y_first), where y are the images of the vertex under its transforms.
fn corrected_frame(palette: u32, vertex: u32, rest: vec3<f32>) -> Frame {
    let others = params.influence_len - 1u;
    let first = transformed(transform_of(palette, vertex, 0u), rest);
    var g = vec3<f32>(0.0);
    var h = vec3<f32>(0.0);
    for (var k = 0u; k < others; k++) {
        let word = blob[word_of(params.tangent_coefficients, others, vertex, k)];
        if word == 0u {
            continue;
        }
        let difference = transformed(transform_of(palette, vertex, k + 1u), rest) - first;
        g += difference * half_float(word << 16u);
        h += difference * half_float(word);
    }
    return Frame(g, h);
}

// A normal, transformed by the vertex's strongest influence (the first of equal ones).
fn turned_by_strongest(palette: u32, vertex: u32, normal: vec3<f32>) -> vec3<f32> {
    var most = -1.0;
    var strongest = 0u;
    for (var k = 0u; k < params.influence_len; k++) {
        let weight = weight_of(vertex, k);
        if weight > most {
            most = weight;
            strongest = k;
        }
    }
    let at = transform_of(palette, vertex, strongest);
    let a = palettes[at];
    let b = palettes[at + 1u];
    let c = palettes[at + 2u];
    let x = vec3<f32>(a.x, b.x, c.x);
    let y = vec3<f32>(a.y, b.y, c.y);
    let z = vec3<f32>(a.z, b.z, c.z);
    return along(x, y, z, normal);
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
        // Clamps the host's index, which may be outside the mesh.
        vertex = min(host[at], params.mesh_len - 1u);
    }
    let palette = (params.palettes_offset + instance * params.palettes_stride) / 4u;
    var row_x = vec4<f32>(0.0);
    var row_y = vec4<f32>(0.0);
    var row_z = vec4<f32>(0.0);
    for (var k = 0u; k < params.influence_len; k++) {
        let weight = weight_of(vertex, k);
        let at = transform_of(palette, vertex, k);
        row_x += palettes[at] * weight;
        row_y += palettes[at + 1u] * weight;
        row_z += palettes[at + 2u] * weight;
    }
    let x = vec3<f32>(row_x.x, row_y.x, row_z.x);
    let y = vec3<f32>(row_x.y, row_y.y, row_z.y);
    let z = vec3<f32>(row_x.z, row_y.z, row_z.z);

    if params.positions_offset != NONE {
        let rest = rest_position(instance, vertex);
        let place = along(x, y, z, rest) + vec3<f32>(row_x.w, row_y.w, row_z.w);
        let at = params.positions_offset + instance * params.positions_instance_stride;
        put(at + i * params.positions_stride, place);
    }
    if params.normals_offset == NONE && params.tangents_offset == NONE {
        return;
    }
    let has_coefficients = params.tangent_coefficients != NONE;
    let normal = rest_normal(instance, vertex);
    var frame: Frame;
    var sums: Frame;
    if has_coefficients {
        if params.rest_tangents == NONE {
            frame = frame_of_normal(normal, blob_float(word_of(params.rest_normals, 3u, vertex, 2u)));
        } else {
            frame = frame_of_tangent(normal, rest_tangent(instance, vertex).xyz);
        }
        sums = corrected_frame(palette, vertex, rest_position(instance, vertex));
    }
    if params.normals_offset != NONE {
        var side = mirror(palette);
        var turned: vec3<f32>;
        if has_coefficients {
            let g = along(x, y, z, frame.g) + sums.g;
            let h = along(x, y, z, frame.h) + sums.h;
            turned = cross3(g, h);
            if !has_direction(turned) {
                turned = turned_by_strongest(palette, vertex, normal);
                side = 1.0;
            }
        } else {
            // By the cofactors of the blended matrix.
            turned = along(cross3(y, z), cross3(z, x), cross3(x, y), normal);
        }
        let at = params.normals_offset + instance * params.normals_instance_stride;
        put(at + i * params.normals_stride, unit(turned, side, normal));
    }
    if params.tangents_offset != NONE {
        let rest = rest_tangent(instance, vertex);
        var turned = along(x, y, z, rest.xyz);
        if has_coefficients {
            turned += sums.g * dot3(rest.xyz, frame.g);
            turned += sums.h * dot3(rest.xyz, frame.h);
        }
        let at = params.tangents_offset + instance * params.tangents_instance_stride
            + i * params.tangents_stride;
        put(at, unit(turned, 1.0, rest.xyz));
        out[at + 3u] = rest.w;
    }
}
