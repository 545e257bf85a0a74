//! The shader functions of `runtime/examples`, on lavapipe, compared with the runtime's normals.

use crate::common::{load, parts};
use crate::wgpu::lavapipe;
use models::{Pieces, Rng, SMALL, Shape};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::skin::Output;
use sinew_runtime::{Envelope, Matrix3x4, Skin, SkinJob, model_space_pose};
use std::borrow::Cow;
use wgpu::naga::ShaderStage;
use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{
    BindGroupDescriptor, BindGroupEntry, BufferUsages, ComputePassDescriptor,
    ComputePipelineDescriptor, ShaderModuleDescriptor, ShaderSource,
};

/// Floats of a vertex: position, normal, tangent, transforms, weights, coefficients.
const STRIDE: usize = 3 + 3 + 3 + 4 + 4 + 6;

/// Largest angle to the runtime's normal, in degrees.
const DEGREES: f32 = 0.1;

const WGSL: &str = "
@group(0) @binding(0) var<storage, read> vertices: array<f32>;
@group(0) @binding(1) var<storage, read> palette: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> normals: array<f32>;

fn three(at: u32) -> vec3<f32> {
    return vec3<f32>(vertices[at], vertices[at + 1u], vertices[at + 2u]);
}

@compute @workgroup_size(1)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = 23u * id.x;
    let rest = vec4<f32>(three(at), 1.0);
    var moved: array<vec3<f32>, 4>;
    var coefficients: array<vec2<f32>, 3>;
    var blended = mat3x3<f32>();
    for (var k = 0u; k < 4u; k++) {
        let first = 3u * u32(vertices[at + 9u + k]);
        let rows = array<vec4<f32>, 3>(palette[first], palette[first + 1u], palette[first + 2u]);
        moved[k] = vec3<f32>(dot(rows[0], rest), dot(rows[1], rest), dot(rows[2], rest));
        let weight = vertices[at + 13u + k];
        blended += weight * transpose(mat3x3<f32>(rows[0].xyz, rows[1].xyz, rows[2].xyz));
    }
    for (var l = 0u; l < 3u; l++) {
        coefficients[l] = vec2<f32>(vertices[at + 17u + 2u * l], vertices[at + 18u + 2u * l]);
    }
    let found =
        skinned_normal(three(at + 3u), three(at + 6u), blended, moved, coefficients, SIDE);
    for (var c = 0u; c < 3u; c++) {
        normals[3u * id.x + c] = found[c];
    }
}
";

const GLSL: &str = "
void main() {
    uint at = 23u * gl_GlobalInvocationID.x;
    vec4 rest = vec4(three(at), 1.0);
    vec3 moved[4];
    vec2 coefficients[3];
    mat3 blended = mat3(0.0);
    for (uint k = 0u; k < 4u; k++) {
        uint first = 3u * uint(vertices[at + 9u + k]);
        vec4 x = palette[first];
        vec4 y = palette[first + 1u];
        vec4 z = palette[first + 2u];
        moved[k] = vec3(dot(x, rest), dot(y, rest), dot(z, rest));
        blended += vertices[at + 13u + k] * transpose(mat3(x.xyz, y.xyz, z.xyz));
    }
    for (uint l = 0u; l < 3u; l++) {
        coefficients[l] = vec2(vertices[at + 17u + 2u * l], vertices[at + 18u + 2u * l]);
    }
    vec3 found = skinned_normal(three(at + 3u), three(at + 6u), blended, moved, coefficients, SIDE);
    for (uint c = 0u; c < 3u; c++) {
        normals[3u * gl_GlobalInvocationID.x + c] = found[c];
    }
}
";

const GLSL_HEAD: &str = "#version 450
layout(local_size_x = 1) in;
layout(set = 0, binding = 0, std430) readonly buffer A { float vertices[]; };
layout(set = 0, binding = 1, std430) readonly buffer B { vec4 palette[]; };
layout(set = 0, binding = 2, std430) buffer C { float normals[]; };
vec3 three(uint at) { return vec3(vertices[at], vertices[at + 1u], vertices[at + 2u]); }
";

fn snippet(language: &str) -> String {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../runtime/examples");
    std::fs::read_to_string(format!("{folder}/normals.{language}")).unwrap()
}

/// Runs a shader for each vertex and returns the normals.
fn run(source: ShaderSource<'_>, vertices: &[f32], palette: &[Matrix3x4]) -> Vec<f32> {
    let headless = lavapipe();
    let device = headless.device();
    let module = device.create_shader_module(ShaderModuleDescriptor { label: None, source });
    let pipeline = device.create_compute_pipeline(&ComputePipelineDescriptor {
        label: None,
        layout: None,
        module: &module,
        entry_point: Some("main"),
        compilation_options: Default::default(),
        cache: None,
    });
    let vertex_len = vertices.len() / STRIDE;
    let flat = palette.as_flattened().as_flattened();
    let buffers = [vertices, flat, &vec![0.0; 3 * vertex_len]].map(|floats| {
        let bytes: Vec<u8> = floats.iter().flat_map(|x| x.to_le_bytes()).collect();
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        device.create_buffer_init(&BufferInitDescriptor { label: None, contents: &bytes, usage })
    });
    let entries = buffers.each_ref().map(|buffer| buffer.as_entire_binding());
    let entries = entries.into_iter().zip(0..);
    let entries: Vec<_> =
        entries.map(|(resource, binding)| BindGroupEntry { binding, resource }).collect();
    let layout = &pipeline.get_bind_group_layout(0);
    let group =
        device.create_bind_group(&BindGroupDescriptor { label: None, layout, entries: &entries });
    let mut encoder = device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor::default());
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.dispatch_workgroups(vertex_len as u32, 1, 1);
    drop(pass);
    headless.queue().submit([encoder.finish()]);
    headless.read(&buffers[2]).unwrap()
}

/// Lays out the vertices of a skin for the shaders.
fn vertices(skin: &Skin<'_>) -> Vec<f32> {
    let vertex = |v: usize| {
        let [x, y, z, _] = skin.rest_tangent(v).unwrap_or_default();
        let (mut indices, mut weights): (Vec<_>, Vec<_>) =
            skin.influences(v).map(|(index, weight)| (index as f32, weight)).unzip();
        // An influence without weight fills the unused slots.
        indices.resize(4, *indices.last().unwrap());
        weights.resize(4, 0.0);
        let mut coefficients: Vec<_> = skin.tangent_coefficients(v).collect();
        coefficients.resize(3, [0.0; 2]);
        let coefficients = coefficients.into_iter().flatten();
        let position = skin.rest_position(v).unwrap();
        let all = position.into_iter().chain(skin.rest_normal(v).unwrap()).chain([x, y, z]);
        all.chain(indices).chain(weights).chain(coefficients).collect::<Vec<_>>()
    };
    (0..skin.vertex_len()).flat_map(vertex).collect()
}

/// Bends an envelope's joints and returns the palette.
fn palette(envelope: &Envelope<'_>) -> Vec<Matrix3x4> {
    let mut random = Rng(7);
    let local: Vec<_> = (0..envelope.joint_len()).map(|_| random.local(0.4)).collect();
    let mut pose = vec![[[0.0; 4]; 3]; local.len()];
    model_space_pose(envelope, &local, &mut pose).unwrap();
    let (mut scratch, mut out) =
        (vec![0.0; envelope.scratch_len()], vec![[[0.0; 4]; 3]; envelope.palette_len()]);
    let curves = vec![0.0; envelope.curve_len()];
    envelope.palette(&pose, &curves, &mut scratch, &mut out).unwrap();
    out
}

/// Returns the side of a palette by its first transform.
fn side([a, b, c]: &Matrix3x4) -> f32 {
    let minor = |i: usize, j: usize| b[i] * c[j] - b[j] * c[i];
    (a[0] * minor(1, 2) + a[1] * minor(2, 0) + a[2] * minor(0, 1)).signum()
}

/// Returns the largest angle between normals, in degrees.
fn apart(a: &[f32], b: &[f32]) -> f32 {
    let (a, b) = (a.as_chunks::<3>().0, b.as_chunks::<3>().0);
    assert_eq!(a.len(), b.len());
    let angle = |(a, b): (&[f32; 3], &[f32; 3])| {
        let [x, y, z] = [0, 1, 2].map(|c| a[c] - b[c]);
        // Normals have length 1.
        2.0 * (0.5 * (x * x + y * y + z * z).sqrt()).asin().to_degrees()
    };
    a.iter().zip(b).map(angle).fold(0.0, |most, own| if own <= most { most } else { own })
}

#[test]
fn normals_in_a_stock_shader_are_the_runtimes() {
    for (influences, tangents) in [(4, true), (4, false), (3, true), (2, false)] {
        let shape = Shape { vertices: 60, influences, tangents, coefficients: true, ..SMALL };
        let bytes = Pieces::sample(Predictor::Rotational, shape).bytes();
        let model = load(&bytes);
        let (envelope, skin) = parts(&model);
        assert!(skin.has_coefficients() && skin.has_tangents() == tangents);
        let palette = palette(&envelope);
        let mut expected = vec![0.0; 3 * skin.vertex_len()];
        SkinJob::new(skin, &palette).normals(Output::new(&mut expected, 3)).run().unwrap();
        let vertices = vertices(&skin);
        let wgsl = snippet("wgsl") + WGSL;
        let glsl = GLSL_HEAD.to_owned() + &snippet("glsl") + GLSL;
        let side = format!("{:?}", side(&palette[0]));
        let [wgsl, glsl] = [wgsl, glsl].map(|text| Cow::<str>::Owned(text.replace("SIDE", &side)));
        let wgsl = || ShaderSource::Wgsl(wgsl.clone());
        let glsl = ShaderSource::Glsl { shader: glsl, stage: ShaderStage::Compute, defines: &[] };
        for source in [wgsl(), glsl] {
            let found = apart(&run(source, &vertices, &palette), &expected);
            assert!(found < DEGREES, "{found} degrees");
        }
        // Control: without coefficients the normals are others.
        let mut without = vertices.clone();
        without.chunks_mut(STRIDE).for_each(|vertex| vertex[17..].fill(0.0));
        let found = apart(&run(wgsl(), &without, &palette), &expected);
        assert!(found > 10.0 * DEGREES, "the control: {found} degrees");
    }
}
