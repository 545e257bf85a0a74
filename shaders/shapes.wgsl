// Stage shapes: weights of shapes to the rest mesh of a skin. One thread a vertex, one workgroup a
// block.

@group(0) @binding(2) var<storage, read> weights: array<f32>;
@group(0) @binding(3) var<storage, read_write> out: array<f32>;

fn put(at: u32, v: vec3<f32>) {
    out[at] = v.x;
    out[at + 1u] = v.y;
    out[at + 2u] = v.z;
}

const ELEMENT_F16: u32 = 4u;
const ELEMENT_I8: u32 = 5u;

// Number index of a section of deltas or slopes.
fn number(section: u32, index: u32) -> f32 {
    if params.element == ELEMENT_I8 {
        let word = blob[section + index / 4u];
        return f32(bitcast<i32>(word << (24u - 8u * (index & 3u))) >> 24u);
    }
    if params.element == ELEMENT_F16 {
        return half_float(blob_half(section, index) << 16u);
    }
    return blob_float(section + index);
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(local_invocation_index) own: u32,
) {
    let instance = workgroup.y;
    let block = params.vertex_first / 64u + workgroup.x;
    let vertex = 64u * block + own;
    if vertex < params.vertex_first || vertex - params.vertex_first >= params.vertex_len {
        return;
    }
    let i = vertex - params.vertex_first;
    let tilts = params.normals_offset != NONE || params.tangents_offset != NONE;
    var offset = vec3<f32>(0.0);
    var tilt = vec2<f32>(0.0);
    var entry_first = 0u;
    var entry_end = 0u;
    if params.shape_blocks != NONE {
        entry_first = blob[params.shape_blocks + block];
        entry_end = blob[params.shape_blocks + block + 1u];
    }
    // Bits of a mask below the vertex's own bit.
    var below = vec2<u32>(0xffffffffu, 0u);
    if own < 32u {
        below.x = (1u << own) - 1u;
    } else {
        below.y = (1u << (own - 32u)) - 1u;
    }
    for (var entry = entry_first; entry < entry_end; entry++) {
        let at = params.shape_entries + 4u * entry;
        let mask = vec2<u32>(blob[at], blob[at + 1u]);
        let bits = select(mask.y, mask.x, own < 32u);
        if ((bits >> (own & 31u)) & 1u) == 0u {
            continue;
        }
        let shape = blob[at + 2u];
        let weight = weights[params.weights_offset + instance * params.weights_stride + shape];
        if weight == 0.0 {
            continue;
        }
        let counts = countOneBits(mask & below);
        let delta = blob[at + 3u] + counts.x + counts.y;
        let row = params.shapes + 8u * shape;
        var first = 3u * delta;
        let by = vec3<f32>(
            number(params.shape_deltas, first),
            number(params.shape_deltas, first + 1u),
            number(params.shape_deltas, first + 2u),
        );
        offset += by * (weight * blob_float(row));
        if tilts {
            first = 2u * delta;
            let slopes = vec2<f32>(
                number(params.shape_slopes, first),
                number(params.shape_slopes, first + 1u),
            );
            tilt += slopes * (weight * blob_float(row + 1u));
        }
    }

    if params.positions_offset != NONE {
        let at = params.positions_offset + instance * params.positions_instance_stride;
        let place = vertex_vec3(params.rest_positions, 3u, vertex) + offset;
        put(at + i * params.positions_stride, place);
    }
    if !tilts {
        return;
    }
    let normal = vertex_vec3(params.rest_normals, 3u, vertex);
    var tangent = vec4<f32>(0.0);
    if params.rest_tangents != NONE {
        tangent = vertex_vec4(params.rest_tangents, vertex);
    }
    if params.normals_offset != NONE {
        var frame: Frame;
        if params.rest_tangents == NONE {
            frame = frame_of_normal(normal, normal.z);
        } else {
            frame = frame_of_tangent(normal, tangent.xyz);
        }
        let tilted = (normal - frame.g * tilt.x) - frame.h * tilt.y;
        let at = params.normals_offset + instance * params.normals_instance_stride;
        put(at + i * params.normals_stride, unit(tilted, 1.0, normal));
    }
    if params.tangents_offset != NONE {
        let lifted = tangent.xyz + normal * tilt.x;
        let at = params.tangents_offset + instance * params.tangents_instance_stride
            + i * params.tangents_stride;
        put(at, unit(lifted, 1.0, tangent.xyz));
        out[at + 3u] = tangent.w;
    }
}
