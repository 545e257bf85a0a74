// The host's own shader: skins by the palettes in its vertex shader.

@group(0) @binding(2) var<storage, read> palettes: array<vec4<f32>>;
@group(0) @binding(3) var<uniform> world_to_clip: mat4x4<f32>;

struct Skinned {
    @builtin(position) clip: vec4<f32>,
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
}

@vertex
fn vertex(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> Skinned {
    let palette = (params.palettes_offset + instance * params.palettes_stride) / 4u;
    var x = vec4<f32>(0.0);
    var y = vec4<f32>(0.0);
    var z = vec4<f32>(0.0);
    for (var k = 0u; k < params.influence_len; k++) {
        let influence = vertex * params.influence_len + k;
        let weight = blob_float(params.influence_weights + influence);
        let at = palette + 3u * blob_half(params.influence_indices, influence);
        x += weight * palettes[at];
        y += weight * palettes[at + 1u];
        z += weight * palettes[at + 2u];
    }
    let rest = vec4<f32>(blob_vec3(params.rest_positions + 3u * vertex), 1.0);
    let position = vec3<f32>(dot(x, rest), dot(y, rest), dot(z, rest));
    // Normals follow the cofactors of the blended transform.
    let normal = blob_vec3(params.rest_normals + 3u * vertex);
    let cofactors =
        mat3x3<f32>(cross(y.xyz, z.xyz), cross(z.xyz, x.xyz), cross(x.xyz, y.xyz));
    return Skinned(world_to_clip * vec4<f32>(position, 1.0), position, normal * cofactors);
}

const SKIN: vec3<f32> = vec3<f32>(0.72, 0.42, 0.30);
const SUN: vec3<f32> = vec3<f32>(-0.66, 0.44, 0.61);
const LAMP: vec3<f32> = vec3<f32>(0.80, 0.10, 0.59);
const EYE: vec3<f32> = vec3<f32>(1.18, 4.35, 2.75);

@fragment
fn fragment(skinned: Skinned) -> @location(0) vec4<f32> {
    let normal = normalize(skinned.normal);
    let seen = normalize(EYE - skinned.position);
    let sky = mix(vec3<f32>(0.10, 0.09, 0.09), vec3<f32>(0.20, 0.23, 0.28), 0.5 + 0.5 * normal.y);
    let sun = max(dot(normal, SUN), 0.0) * vec3<f32>(1.00, 0.95, 0.87);
    let lamp = max(dot(normal, LAMP), 0.0) * vec3<f32>(0.14, 0.18, 0.26);
    let shine = 0.18 * pow(max(dot(normal, normalize(SUN + seen)), 0.0), 40.0);
    return vec4<f32>(SKIN * (sky + sun + lamp) + shine, 1.0);
}
