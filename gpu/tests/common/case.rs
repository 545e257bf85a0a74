//! A batch on a device, compared bit by bit with the CPU's results. Both APIs use this code.

use super::{Pose, load, parts, poses};
use models::{Rest, Rng, cells};
use sinew_gpu::headless::{Device, Uploaded};
use sinew_gpu::layout::{Array, Attribute, Batch, DeviceLimits, Plan, Resource, SkinBatch};
use sinew_runtime::skin::Output;
use sinew_runtime::{Envelope, Skin, SkinJob};

/// Initial content of buffers: a NaN that no stage computes.
pub(crate) const POISON: f32 = f32::from_bits(0x7fc0_dead);
const OUTPUTS: [Resource; 3] = [Resource::Palettes, Resource::Confidences, Resource::Out];

/// A batch of an envelope; the first `instance_len` instances are evaluated.
pub(crate) struct Case<'a> {
    pub(crate) bytes: &'a [u8],
    pub(crate) batch: &'a Batch,
    pub(crate) limits: &'a DeviceLimits,
    pub(crate) instance_len: usize,
}

impl Case<'_> {
    /// Asserts that every bit of every output equals the CPU's, and that no other float has
    /// changed; returns the number of chunks.
    pub(crate) fn check(&self, device: &dyn Device) -> usize {
        let (differ, chunks) = self.differing(device, |_| {});
        assert_eq!(differ, 0, "{} of {:?}", self.instance_len, self.batch);
        chunks
    }

    /// Evaluates poses after `change` has edited their buffer. Counts the output floats that differ
    /// from the CPU's results for the unchanged poses, or that should not have changed. Also
    /// returns the number of chunks.
    pub(crate) fn differing(
        &self,
        device: &dyn Device,
        change: impl Fn(&mut [f32]),
    ) -> (usize, usize) {
        let Self { bytes, batch, limits, instance_len } = *self;
        let model = load(bytes);
        let (envelope, skin) = parts(&model);
        let plan = Plan::new(&model, &envelope, batch, limits).unwrap();
        let mut uploaded = device.upload(model.blob(), &plan).unwrap();
        let poisoned = |resource| vec![POISON; plan.bytes(resource) as usize / 4];

        // The number of different poses is prime, so that a mixed-up instance is detected.
        let poses = poses(&envelope, instance_len.min(31));
        let poses: Vec<_> = poses.iter().cycle().take(instance_len).collect();
        let mut flat = poisoned(Resource::Poses);
        let joints = poses.iter().map(|pose| pose.joints.as_flattened().as_flattened());
        put(&mut flat, batch.poses, joints);
        change(&mut flat);
        write(&mut *uploaded, Resource::Poses, &flat);
        let mut flat = poisoned(Resource::Curves);
        put(&mut flat, batch.curves, poses.iter().map(|pose| &pose.curves[..]));
        write(&mut *uploaded, Resource::Curves, &flat);
        let mut host = poisoned(Resource::Host);
        if let Some(own) = &batch.skin {
            draw_host(&mut host, &skin, own, batch.instance_len);
        }
        write(&mut *uploaded, Resource::Host, &host);
        for resource in OUTPUTS.into_iter().chain([Resource::Scratch]) {
            write(&mut *uploaded, resource, &poisoned(resource));
        }
        uploaded.run(instance_len).unwrap();

        let mut expected = OUTPUTS.map(poisoned);
        evaluate(&mut expected, (&envelope, &skin), batch, &poses, &host);
        let mut differ = 0;
        for (resource, expected) in OUTPUTS.into_iter().zip(&expected) {
            if expected.is_empty() {
                continue;
            }
            let found = uploaded.read(resource).unwrap();
            differ += differing(&found, expected, resource.name());
        }
        (differ, plan.chunks().len())
    }
}

/// Copies each instance's floats to their place; a model may have none.
fn put<'a>(out: &mut [f32], array: Array, floats: impl Iterator<Item = &'a [f32]>) {
    for (n, own) in floats.enumerate().filter(|(_, own)| !own.is_empty()) {
        out[array.offset + n * array.stride..][..own.len()].copy_from_slice(own);
    }
}

fn write(uploaded: &mut dyn Uploaded, resource: Resource, floats: &[f32]) {
    if !floats.is_empty() {
        uploaded.write(resource, 0, floats).unwrap();
    }
}

/// Counts the floats whose bits differ, and prints the first.
pub(crate) fn differing(found: &[f32], expected: &[f32], what: &str) -> usize {
    assert_eq!(found.len(), expected.len(), "{what}");
    let pairs = found.iter().zip(expected).map(|(a, b)| (a.to_bits(), b.to_bits()));
    let mut differing = pairs.enumerate().filter(|(_, (found, expected))| found != expected);
    let Some((first, (found, expected))) = differing.next() else { return 0 };
    eprintln!("{what} {first}: {found:#x}, expected {expected:#x}");
    1 + differing.count()
}

/// Draws the host's input for every instance. Every seventh index of a remap is outside the mesh.
fn draw_host(host: &mut [f32], skin: &Skin<'_>, own: &SkinBatch, instance_len: usize) {
    let mut random = Rng(1);
    let vertex_len = skin.vertex_len();
    if let Some(Array { offset, stride }) = own.remap {
        for n in 0..instance_len {
            for i in 0..own.vertices.end {
                let index = (random.next_u64() % vertex_len as u64) as u32;
                let index = if i % 7 == 6 { index + vertex_len as u32 } else { index };
                host[offset + n * stride + i] = f32::from_bits(index);
            }
        }
    }
    let mut put = |array: Option<Array>, of: &dyn Fn(usize, &mut Rng) -> Vec<f32>| {
        let Some(Array { offset, stride }) = array else { return };
        for n in 0..instance_len {
            let all: Vec<f32> = (0..vertex_len).flat_map(|v| of(v, &mut random)).collect();
            host[offset + n * stride..][..all.len()].copy_from_slice(&all);
        }
    };
    let near = |x: [f32; 3], random: &mut Rng| x.map(|x| x + 0.3 * random.unit()).to_vec();
    let unit = |random: &mut Rng| {
        let v = [(); 3].map(|()| random.unit() + 1.5);
        let length = v.iter().map(|x| x * x).sum::<f32>().sqrt();
        v.map(|x| x / length).to_vec()
    };
    put(own.rest.positions, &|v, random| near(skin.rest_position(v).unwrap(), random));
    put(own.rest.normals, &|_, random| unit(random));
    put(own.rest.tangents, &|v, random| {
        let hand = if v % 2 == 0 { 1.0 } else { -1.0 };
        unit(random).into_iter().chain([hand]).collect()
    });
}

/// Writes the CPU's results for the poses to the places of the batch: palettes, confidences, out.
fn evaluate(
    out: &mut [Vec<f32>; 3],
    (envelope, skin): (&Envelope<'_>, &Skin<'_>),
    batch: &Batch,
    poses: &[&Pose],
    host: &[f32],
) {
    let [out_palettes, out_confidences, out] = out;
    let mut scratch = vec![0.0; envelope.scratch_len()];
    let mut palette = vec![[[0.0; 4]; 3]; envelope.palette_len()];
    for (n, pose) in poses.iter().enumerate() {
        let Pose { joints, curves } = pose;
        let confidence = envelope.palette(joints, curves, &mut scratch, &mut palette).unwrap();
        if let Some(array) = batch.confidences {
            out_confidences[array.offset + n * array.stride] = confidence;
        }
        let flat = palette.as_flattened().as_flattened();
        let at = batch.palettes.offset + n * batch.palettes.stride;
        out_palettes[at..at + flat.len()].copy_from_slice(flat);
        let Some(own) = &batch.skin else { continue };
        let out = cells(out);
        let output = |attribute: Option<Attribute>| {
            let Attribute { offset, stride, instance_stride } = attribute?;
            Some(Output::shared(&out[offset + n * instance_stride..], stride))
        };
        let host_array = |array: Option<Array>, len: usize| {
            let Array { offset, stride } = array?;
            Some(&host[offset + n * stride..][..len])
        };
        let v = skin.vertex_len();
        // A CPU refuses an index outside the mesh; a GPU uses the last vertex.
        let last = v as u32 - 1;
        let remap = host_array(own.remap, own.vertices.end);
        let remap: Option<Vec<u32>> =
            remap.map(|remap| remap.iter().map(|index| index.to_bits().min(last)).collect());
        let rest = Rest {
            positions: host_array(own.rest.positions, 3 * v).map(|floats| floats.as_chunks().0),
            normals: host_array(own.rest.normals, 3 * v).map(|floats| floats.as_chunks().0),
            tangents: host_array(own.rest.tangents, 4 * v).map(|floats| floats.as_chunks().0),
        };
        let mut job = rest.of(SkinJob::new(*skin, &palette));
        if let Some(remap) = &remap {
            job = job.remap(remap);
        }
        job.vertices(own.vertices.clone())
            .positions(output(own.positions))
            .normals(output(own.normals))
            .tangents(output(own.tangents))
            .run()
            .unwrap();
    }
}
