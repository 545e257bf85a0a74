//! A simulated device: the runtime behind the trait of the headless devices. It finds all arrays by
//! a plan's spans and params, as a shader does, and can inject faults.

use conformance::backend::Loaded;
use models::cells;
use sinew_gpu::headless::{Device, DeviceInfo, HeadlessError, Uploaded};
use sinew_gpu::layout::{Chunk, DeviceLimits, Plan, Resource, Stage};
use sinew_runtime::envelope::ScratchLayout;
use sinew_runtime::filter::Samples;
use sinew_runtime::skin::Output;
use sinew_runtime::{
    CallError, Filter, KernelMap, Matrix3x4, Model, ShapesJob, Skin, SkinJob, stages,
};
use std::ops::Range;
use std::time::Duration;

/// A fault in a stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Fault {
    /// The lowest bit of this float of the resource is flipped.
    Bit(Stage, Resource, usize),
    /// The stage does nothing.
    Idle(Stage),
    /// The stage writes a float that it must not write.
    Stray(Stage, Resource, usize),
}

pub(crate) struct Software<'a> {
    pub(crate) bytes: &'a [u8],
    pub(crate) fault: Option<Fault>,
    pub(crate) info: DeviceInfo,
}

impl<'a> Software<'a> {
    pub(crate) fn new(bytes: &'a [u8], fault: Option<Fault>) -> Self {
        let text = |text: &str| text.to_owned();
        let [name, driver, driver_info] = ["the runtime", "software", "of this test"].map(text);
        Self {
            bytes,
            fault,
            info: DeviceInfo { api: "none", name, driver, driver_info, software: true },
        }
    }
}

impl Device for Software<'_> {
    fn info(&self) -> &DeviceInfo {
        &self.info
    }

    fn limits(&self) -> DeviceLimits {
        DeviceLimits::DOWNLEVEL
    }

    fn upload(&self, blob: &[u8], plan: &Plan) -> Result<Box<dyn Uploaded + '_>, HeadlessError> {
        let model = Model::from_bytes(self.bytes).expect("a baked model loads");
        assert_eq!(model.blob(), blob, "the device was made for another model");
        let part = if plan.stages().eq([Stage::Kernel]) {
            let kernel = model
                .first::<KernelMap>()
                .and_then(|kernel| kernel.layout().open::<KernelMap>(self.bytes));
            Part::Kernel(kernel.expect("it holds a kernel"))
        } else if plan.stages().eq([Stage::Shapes]) {
            let skin =
                model.first::<Skin>().and_then(|skin| skin.layout().open::<Skin>(self.bytes));
            Part::Shapes(skin.expect("it holds a skin"))
        } else if plan.stages().eq([Stage::Filter]) {
            let filter = model
                .first::<Filter>()
                .and_then(|filter| filter.layout().open::<Filter>(self.bytes));
            Part::Filter(filter.expect("it holds a filter"))
        } else {
            Part::Envelope(Box::new(Loaded::new(self.bytes)))
        };
        let floats = |resource| vec![0.0; (plan.bytes(resource) / 4) as usize];
        let buffers = Resource::ALL.map(floats);
        Ok(Box::new(Batch { part, plan: plan.clone(), buffers, fault: self.fault }))
    }

    fn message_len(&self) -> Option<usize> {
        None
    }
}

/// The part to evaluate.
#[derive(Clone)]
enum Part<'a> {
    Envelope(Box<Loaded<'a>>),
    Kernel(KernelMap<'a>),
    Shapes(Skin<'a>),
    Filter(Filter<'a>),
}

struct Batch<'a> {
    part: Part<'a>,
    plan: Plan,
    buffers: [Vec<f32>; Resource::ALL.len()],
    fault: Option<Fault>,
}

impl Uploaded for Batch<'_> {
    fn write(
        &mut self,
        resource: Resource,
        first: usize,
        floats: &[f32],
    ) -> Result<(), HeadlessError> {
        self.buffers[resource as usize][first..][..floats.len()].copy_from_slice(floats);
        Ok(())
    }

    fn run(&mut self, instance_len: usize) -> Result<(), HeadlessError> {
        for stage in self.plan.stages().collect::<Vec<_>>() {
            self.run_stage(stage, instance_len)?;
        }
        Ok(())
    }

    fn run_stage(&mut self, stage: Stage, instance_len: usize) -> Result<(), HeadlessError> {
        self.plan.check_instances(instance_len)?;
        if self.fault == Some(Fault::Idle(stage)) {
            return Ok(());
        }
        for chunk in self.plan.chunks().to_vec() {
            let here = chunk.instances.start..chunk.instances.end.min(instance_len);
            for local in 0..here.len() {
                let part = self.part.clone();
                let mut instance = Instance { batch: self, chunk: &chunk, local };
                let ran = match part {
                    Part::Envelope(loaded) => instance.run(stage, &loaded),
                    Part::Kernel(kernel) => instance.kernel(&kernel),
                    Part::Shapes(skin) => instance.shapes(skin),
                    Part::Filter(filter) => instance.filter(&filter),
                };
                let doing = stage.name();
                ran.map_err(|e| HeadlessError::Refused { doing, detail: e.to_string() })?;
            }
        }
        match self.fault {
            Some(Fault::Bit(own, resource, float)) if own == stage => {
                let value = &mut self.buffers[resource as usize][float];
                *value = f32::from_bits(value.to_bits() ^ 1);
            }
            Some(Fault::Stray(own, resource, float)) if own == stage => {
                // Some batches lack the buffer.
                if let Some(value) = self.buffers[resource as usize].get_mut(float) {
                    *value = 7.0;
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn time_stage(&mut self, _: Stage, _: usize, _: usize) -> Result<Duration, HeadlessError> {
        Ok(Duration::ZERO)
    }

    fn read(&mut self, resource: Resource) -> Result<Vec<f32>, HeadlessError> {
        Ok(self.buffers[resource as usize].clone())
    }
}

/// One instance of a chunk.
struct Instance<'a, 'b> {
    batch: &'a mut Batch<'b>,
    chunk: &'a Chunk,
    local: usize,
}

impl Instance<'_, '_> {
    fn param(&self, name: &str) -> usize {
        let found = self.chunk.params().iter().find(|(own, _)| *own == name);
        found.unwrap_or_else(|| panic!("no {name}")).1 as usize
    }

    /// Returns the first float of this instance's part of an array.
    fn place(&self, resource: Resource, name: &str) -> usize {
        let bound = self.chunk.span(resource).expect("it is bound").offset as usize / 4;
        let [offset, stride] =
            ["offset", "stride"].map(|what| self.param(&format!("{name}_{what}")));
        bound + offset + self.local * stride
    }

    fn take<T: Copy>(&self, resource: Resource, at: usize, len: usize) -> Vec<T>
    where
        [f32]: Cut<T>,
    {
        self.batch.buffers[resource as usize][at..][..len].cut().to_vec()
    }

    fn put(&mut self, resource: Resource, at: usize, floats: &[f32]) {
        self.batch.buffers[resource as usize][at..][..floats.len()].copy_from_slice(floats);
    }

    fn run(&mut self, stage: Stage, loaded: &Loaded<'_>) -> Result<(), CallError> {
        let envelope = loaded.envelope;
        let (j, p) = (envelope.joint_len(), envelope.proxy_len());
        let scratch = ScratchLayout::at_once(&envelope);
        // A kernel model without helpers needs no scratch, one without joints no poses.
        let place = |resource: Resource, name: &str| {
            self.chunk.span(resource).map_or(0, |_| self.place(resource, name))
        };
        let own = place(Resource::Scratch, "scratch");
        let (at_poses, at_curves) =
            (place(Resource::Poses, "poses"), place(Resource::Curves, "curves"));
        let poses: Vec<Matrix3x4> = self.take(Resource::Poses, at_poses, 12 * j);
        let curves: Vec<f32> = self.take(Resource::Curves, at_curves, envelope.curve_len());
        let palette_at = self.place(Resource::Palettes, "palettes");
        let palette_floats = 12 * envelope.palette_len();
        let (at_turns, at_strains) = (own + scratch.turns, own + scratch.strains);
        let splits = if self.batch.plan.stages().any(|own| own == Stage::Polar) { j } else { 0 };
        let feature_len = envelope.counts().feature_len();
        match stage {
            Stage::Polar => {
                let (mut turns, mut strains) = (vec![[[0.0; 3]; 3]; j], vec![[0.0; 6]; j]);
                stages::polar(&envelope, &poses, &mut turns, &mut strains)?;
                self.put(Resource::Scratch, at_turns, turns.as_flattened().as_flattened());
                self.put(Resource::Scratch, at_strains, strains.as_flattened());
            }
            Stage::Gradients => {
                let turns: Vec<[[f32; 3]; 3]> = self.take(Resource::Scratch, at_turns, 9 * splits);
                let strains: Vec<[f32; 6]> = self.take(Resource::Scratch, at_strains, 6 * splits);
                let (mut q, mut theta, mut d) =
                    (vec![[0.0; 3]; 4 * j], vec![[0.0; 3]; j], vec![[0.0; 3]; 3 * p]);
                let split = (&turns[..], &strains[..]);
                stages::gradients(&envelope, &poses, split, &mut q, &mut theta, &mut d)?;
                self.put(Resource::Scratch, own + scratch.relative, q.as_flattened());
                self.put(Resource::Scratch, own + scratch.rotations, theta.as_flattened());
                self.put(Resource::Scratch, own + scratch.gradients, d.as_flattened());
            }
            Stage::Palette => {
                let q: Vec<[f32; 3]> = self.take(Resource::Scratch, own + scratch.relative, 12 * j);
                let d: Vec<[f32; 3]> = self.take(Resource::Scratch, own + scratch.gradients, 9 * p);
                let mut out = vec![[[0.0; 4]; 3]; envelope.palette_len()];
                let root = &poses[envelope.root()];
                stages::palette(&envelope, root, &q, &d, &mut out)?;
                self.put(Resource::Palettes, palette_at, out.as_flattened().as_flattened());
            }
            Stage::Joints => {
                let mut out = vec![[[0.0; 4]; 3]; envelope.palette_len()];
                stages::joints(&envelope, &poses, &mut out)?;
                self.put(Resource::Palettes, palette_at, out.as_flattened().as_flattened());
            }
            Stage::Features => {
                let turns: Vec<[[f32; 3]; 3]> = self.take(Resource::Scratch, at_turns, 9 * splits);
                let at = own + scratch.features;
                // Stage polar has written the strains.
                let mut out: Vec<f32> = self.take(Resource::Scratch, at, feature_len);
                stages::features(&envelope, &poses, &curves, &turns, &mut out)?;
                self.put(Resource::Scratch, at, &out);
            }
            Stage::Correction => {
                let phi: Vec<f32> =
                    self.take(Resource::Scratch, own + scratch.features, feature_len);
                let mut out: Vec<Matrix3x4> =
                    self.take(Resource::Palettes, palette_at, palette_floats);
                let mut own_scratch = vec![0.0; envelope.correction_len()];
                let least =
                    stages::correction(&envelope, &poses, &phi, &mut own_scratch, &mut out)?;
                self.put(Resource::Palettes, palette_at, out.as_flattened().as_flattened());
                // The groups' own confidences are unknown here; the stage confidence only uses
                // their minimum.
                let confidences = vec![least; envelope.group_len()];
                self.put(Resource::Scratch, own + scratch.confidences, &confidences);
            }
            Stage::Confidence => {
                let value = if envelope.predictor().corrects() {
                    let at = own + scratch.confidences;
                    let all: Vec<f32> = self.take(Resource::Scratch, at, envelope.group_len());
                    all.into_iter().fold(1.0, f32::min)
                } else {
                    let theta: Vec<[f32; 3]> =
                        self.take(Resource::Scratch, own + scratch.rotations, 3 * j);
                    let strains: Vec<[f32; 6]> =
                        self.take(Resource::Scratch, at_strains, 6 * splits);
                    stages::confidence(&envelope, &poses, &theta, &strains)?
                };
                let at = self.place(Resource::Confidences, "confidences");
                self.put(Resource::Confidences, at, &[value]);
            }
            Stage::Skin => self.skin(loaded.skin, palette_at, palette_floats)?,
            Stage::Kernel | Stage::Shapes | Stage::Filter => panic!("an envelope has none"),
        }
        Ok(())
    }

    fn kernel(&mut self, kernel: &KernelMap<'_>) -> Result<(), CallError> {
        let at = self.place(Resource::Queries, "queries");
        let query: Vec<f32> = self.take(Resource::Queries, at, kernel.query_len());
        let mut scratch = vec![0.0; kernel.counts().scratch_len()];
        let mut out = vec![0.0; kernel.result_len()];
        let confidence = kernel.evaluate(&query, &mut scratch, &mut out)?;
        self.put(Resource::Out, self.place(Resource::Out, "outputs"), &out);
        self.put(Resource::Out, self.place(Resource::Out, "confidences"), &[confidence]);
        Ok(())
    }

    fn skin(
        &mut self,
        skin: Skin<'_>,
        palette_at: usize,
        palette_floats: usize,
    ) -> Result<(), CallError> {
        let palette: Vec<Matrix3x4> = self.take(Resource::Palettes, palette_at, palette_floats);
        let ([positions, normals, tangents], vertices) = self.outputs();
        SkinJob::new(skin, &palette)
            .vertices(vertices)
            .positions(positions)
            .normals(normals)
            .tangents(tangents)
            .run()
    }

    fn shapes(&mut self, skin: Skin<'_>) -> Result<(), CallError> {
        let at = self.place(Resource::Weights, "weights");
        let weights: &[f32] = &self.take::<f32>(Resource::Weights, at, skin.shape_len());
        let ([positions, normals, tangents], vertices) = self.outputs();
        ShapesJob::new(skin, weights)
            .vertices(vertices)
            .positions(positions)
            .normals(normals)
            .tangents(tangents)
            .run()
    }

    fn filter(&mut self, filter: &Filter<'_>) -> Result<(), CallError> {
        let [sample_len, lane_len] = ["sample_len", "lane_len"].map(|name| self.param(name));
        let at = self.place(Resource::Samples, "samples");
        let samples: Vec<f32> = self.take(Resource::Samples, at, sample_len * lane_len);
        let mut out = vec![0.0; samples.len() * filter.factor()];
        filter.apply(Samples { signal_len: 1, sample_len, lane_len }, &samples, &mut out)?;
        self.put(Resource::Out, self.place(Resource::Out, "outputs"), &out);
        Ok(())
    }

    /// Returns the places of this instance's attributes, and the range of vertices.
    fn outputs(&mut self) -> ([Option<Output<'_>>; 3], Range<usize>) {
        let first = self.param("vertex_first");
        let vertices = first..first + self.param("vertex_len");
        let bound = self.chunk.span(Resource::Out).expect("it is bound").offset as usize / 4;
        let place = |name: &str| {
            let of = |what: &str| self.param(&format!("{name}_{what}"));
            let is_there = of("offset") != u32::MAX as usize;
            let start = bound + of("offset") + self.local * of("instance_stride");
            is_there.then(|| (start, of("stride")))
        };
        let places = ["positions", "normals", "tangents"].map(place);
        let out = cells(&mut self.batch.buffers[Resource::Out as usize]);
        let output = |(start, stride)| Output::shared(&out[start..], stride);
        (places.map(|place| place.map(output)), vertices)
    }
}

/// Groups floats into wider values.
trait Cut<T> {
    fn cut(&self) -> &[T];
}

impl Cut<f32> for [f32] {
    fn cut(&self) -> &[f32] {
        self
    }
}

impl<const N: usize> Cut<[f32; N]> for [f32] {
    fn cut(&self) -> &[[f32; N]] {
        self.as_chunks().0
    }
}

impl Cut<[[f32; 3]; 3]> for [f32] {
    fn cut(&self) -> &[[[f32; 3]; 3]] {
        self.as_chunks::<3>().0.as_chunks().0
    }
}

impl Cut<Matrix3x4> for [f32] {
    fn cut(&self) -> &[Matrix3x4] {
        self.as_chunks::<4>().0.as_chunks().0
    }
}
