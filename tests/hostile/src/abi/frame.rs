//! Inputs of calls on a file, and the results that the runtime gives for them.

use super::expected::{FilterCase, PriorCase, ViewsCase};
use crate::parts::query;
use crate::poses;
use models::{Rest, cells};
use sinew_capi::{sinew_attribute, sinew_error};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::skin::{Bounds, Output};
use sinew_runtime::{
    CallError, Envelope, Filter, KernelMap, LocalTransform, Matrix3x4, Model, PartLayout, Prior,
    ShapesJob, Skin, SkinJob, Views,
};
use std::ops::Range;

/// Inputs for the first part of each kind of a file, and results of its calls.
#[derive(Default)]
pub(super) struct Frame {
    /// Reason why the file is refused.
    pub(super) refusal: Option<sinew_error>,
    /// Whether the file has an envelope, a skin and a kernel.
    pub(super) has_envelope: bool,
    pub(super) has_skin: bool,
    pub(super) has_kernel: bool,

    pub(super) envelope_name: String,
    pub(super) predictor: Option<Predictor>,
    pub(super) scratch_len: usize,
    pub(super) skin_scratch_len: usize,
    pub(super) local: Vec<LocalTransform>,
    pub(super) pose: Vec<Matrix3x4>,
    pub(super) curves: Vec<f32>,
    pub(super) palette: Vec<Matrix3x4>,
    pub(super) proxy_len: usize,
    pub(super) confidence: f32,

    pub(super) skin_name: String,
    layout: Option<PartLayout>,
    pub(super) vertex_len: usize,
    pub(super) influence_len: usize,
    pub(super) range_len: usize,
    pub(super) has_tangents: bool,
    pub(super) has_coefficients: bool,
    /// Weights of the skin's shapes.
    pub(super) weights: Vec<f32>,
    /// Palette of the skin's envelope.
    pub(super) skin_palette: Vec<Matrix3x4>,
    /// A remap, and a rest mesh of a different shape.
    pub(super) remap: Vec<u32>,
    pub(super) rest_positions: Vec<[f32; 3]>,
    pub(super) rest_normals: Vec<[f32; 3]>,
    pub(super) rest_tangents: Vec<[f32; 4]>,

    pub(super) kernel_name: String,
    pub(super) input_len: usize,
    pub(super) output_len: usize,
    pub(super) query: Vec<f32>,
    /// An evaluation, a Jacobian and a variance.
    pub(super) ways: [Evaluated; 3],

    pub(super) prior: Option<PriorCase>,
    pub(super) views: Option<ViewsCase>,
    pub(super) filter: Option<FilterCase>,
}

/// Result of one way to evaluate a kernel.
#[derive(Default)]
pub(super) struct Evaluated {
    /// Length of the scratch, in floats.
    pub(super) scratch_len: usize,
    /// Result; NaN if the runtime refuses the call.
    pub(super) found: Vec<f32>,
    pub(super) refusal: Option<sinew_error>,
}

/// Arguments of a skin job.
pub(super) struct SkinArguments {
    pub(super) vertices: Range<usize>,
    pub(super) has_remap: bool,
    /// Whether the caller gives rest positions, normals and tangents.
    pub(super) has_rest: [bool; 3],
    /// First float and stride of each requested attribute.
    pub(super) outputs: [Option<(usize, usize)>; 3],
}

impl Frame {
    /// Loads a file and evaluates a pose.
    ///
    /// # Panics
    /// If the runtime refuses a call.
    pub(super) fn new(file: &[u8], pose_number: usize) -> Self {
        let model = match Model::from_bytes(file) {
            Ok(model) => model,
            Err(error) => return Self { refusal: Some(error.into()), ..Self::default() },
        };
        let mut frame = Self::default();
        if let Some(envelope) = model.first::<Envelope>() {
            frame.add_envelope(&envelope, pose_number);
        }
        if let Some(skin) = model.first::<Skin>() {
            let envelope = model.envelope_of(&skin);
            let palette = envelope.map(|envelope| {
                let local = poses::local(&envelope, pose_number);
                let curves = poses::curves(&envelope, pose_number);
                palette(&envelope, &poses::from_local(&envelope, &local), &curves).0
            });
            frame.add_skin(&skin, palette.unwrap_or_default());
        }
        if let Some(map) = model.first::<KernelMap>() {
            frame.add_kernel(&map, pose_number);
        }
        frame.prior = model.first::<Prior>().map(|prior| PriorCase::new(&prior));
        frame.views =
            model.first::<Views>().map(|views| ViewsCase::new(&model, &views, pose_number));
        frame.filter = model.first::<Filter>().map(|filter| FilterCase::new(&filter));
        frame
    }

    /// Lists the names of the parts.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        let names = [&self.envelope_name, &self.skin_name, &self.kernel_name].into_iter();
        let prior = self.prior.as_ref().map(|prior| &prior.name);
        let views = self.views.as_ref().map(|views| &views.name);
        let filter = self.filter.as_ref().map(|filter| &filter.name);
        names.chain(prior).chain(views).chain(filter).map(String::as_str)
    }

    fn add_envelope(&mut self, envelope: &Envelope<'_>, pose_number: usize) {
        self.has_envelope = true;
        self.envelope_name = envelope.name().to_owned();
        self.predictor = Some(envelope.predictor());
        self.scratch_len = envelope.scratch_len();
        self.proxy_len = envelope.proxy_len();
        self.local = poses::local(envelope, pose_number);
        self.pose = poses::from_local(envelope, &self.local);
        self.curves = poses::curves(envelope, pose_number);
        (self.palette, self.confidence) = palette(envelope, &self.pose, &self.curves);
    }

    fn add_skin(&mut self, skin: &Skin<'_>, palette: Vec<Matrix3x4>) {
        let v = skin.vertex_len();
        self.has_skin = true;
        self.skin_name = skin.name().to_owned();
        self.layout = Some(skin.layout());
        self.vertex_len = v;
        self.influence_len = skin.influence_len();
        // Cache lines at any address.
        self.skin_scratch_len = match skin.scratch_len() {
            0 => 0,
            len => 16 * len + 15,
        };
        self.range_len = skin.ranges().count();
        self.has_tangents = skin.has_tangents();
        self.has_coefficients = skin.has_coefficients();
        self.skin_palette = palette;
        self.weights = (0..skin.shape_len()).map(|shape| 0.75 - 0.5 * shape as f32).collect();
        // Every vertex twice, in reverse order.
        self.remap = (0..v as u32).rev().flat_map(|vertex| [vertex; 2]).collect();
        let positions = (0..v).filter_map(|vertex| skin.rest_position(vertex));
        self.rest_positions = positions.map(|[x, y, z]| [0.5 * y, x, z]).collect();
        self.rest_normals = (0..v).filter_map(|vertex| skin.rest_normal(vertex)).collect();
        self.rest_tangents = vec![[0.0, 1.0, 0.0, -1.0]; v];
    }

    fn add_kernel(&mut self, map: &KernelMap<'_>, number: usize) {
        let counts = map.counts();
        let (query, m) = (query(map, number), counts.value_len as usize);
        self.ways = [
            Evaluated::new(counts.scratch_len(), map.result_len(), |scratch, out| {
                map.evaluate(&query, scratch, out).map(|_| ())
            }),
            Evaluated::new(counts.jacobian_scratch_len(), m * query.len(), |scratch, out| {
                map.jacobian(&query, scratch, out)
            }),
            Evaluated::new(counts.variance_scratch_len(), m, |scratch, out| {
                map.variance(&query, scratch, out)
            }),
        ];
        self.has_kernel = true;
        self.kernel_name = map.name().to_owned();
        self.input_len = counts.input_len as usize;
        self.output_len = counts.output_len as usize;
        self.query = query;
    }

    /// Lists an attribute of vertices.
    pub(super) fn attribute(
        &self,
        file: &[u8],
        attribute: sinew_attribute,
        vertices: Range<usize>,
    ) -> Vec<f32> {
        let Some(skin) = self.layout.and_then(|layout| layout.open::<Skin>(file)) else {
            return Vec::new();
        };
        match attribute {
            sinew_attribute::Position => {
                vertices.filter_map(|v| skin.rest_position(v)).flatten().collect()
            }
            sinew_attribute::Normal => {
                vertices.filter_map(|v| skin.rest_normal(v)).flatten().collect()
            }
            sinew_attribute::Tangent => {
                vertices.filter_map(|v| skin.rest_tangent(v)).flatten().collect()
            }
            sinew_attribute::TangentCoefficients => {
                vertices.flat_map(|v| skin.tangent_coefficients(v)).flatten().collect()
            }
        }
    }

    /// Skins into floats that already have content.
    ///
    /// # Panics
    /// If the runtime refuses the job.
    pub(super) fn skin(&self, file: &[u8], arguments: &SkinArguments, floats: &mut [f32]) {
        let Some(skin) = self.layout.and_then(|layout| layout.open::<Skin>(file)) else { return };
        let floats = cells(floats);
        let [positions, normals, tangents] = arguments.outputs.map(|output| {
            let (first, stride) = output?;
            Some(Output::shared(floats.get(first..).unwrap_or_default(), stride))
        });
        let [has_positions, has_normals, has_tangents] = arguments.has_rest;
        let rest = Rest {
            positions: has_positions.then_some(&self.rest_positions),
            normals: has_normals.then_some(&self.rest_normals),
            tangents: has_tangents.then_some(&self.rest_tangents),
        };
        let mut job = rest.of(SkinJob::new(skin, &self.skin_palette));
        if arguments.has_remap {
            job = job.remap(&self.remap);
        }
        let job = job
            .vertices(arguments.vertices.clone())
            .positions(positions)
            .normals(normals)
            .tangents(tangents);
        if let Err(error) = job.run() {
            panic!("the runtime refuses a job without a fault: {error}");
        }
    }

    /// Applies shapes to vertices, into floats that already have content.
    ///
    /// # Panics
    /// If the runtime refuses the job.
    pub(super) fn shape(
        &self,
        file: &[u8],
        vertices: Range<usize>,
        outputs: [Option<(usize, usize)>; 3],
        floats: &mut [f32],
    ) {
        let Some(skin) = self.layout.and_then(|layout| layout.open::<Skin>(file)) else { return };
        let floats = cells(floats);
        let [positions, normals, tangents] = outputs.map(|output| {
            let (first, stride) = output?;
            Some(Output::shared(floats.get(first..).unwrap_or_default(), stride))
        });
        let weights = &self.weights;
        let job = ShapesJob::new(skin, weights)
            .vertices(vertices)
            .positions(positions)
            .normals(normals)
            .tangents(tangents);
        if let Err(error) = job.run() {
            panic!("the runtime refuses a job without a fault: {error}");
        }
    }

    /// Computes the bounds of the shaped skin.
    pub(super) fn shaped_bounds(&self, file: &[u8]) -> Option<Bounds> {
        let skin = self.layout?.open::<Skin>(file)?;
        skin.shaped_bounds(&self.skin_palette, &self.weights).ok()?
    }

    /// Computes the bounds of the skin.
    pub(super) fn bounds(&self, file: &[u8], rest_offset: f32) -> Option<Bounds> {
        let skin = self.layout?.open::<Skin>(file)?;
        skin.bounds(&self.skin_palette, rest_offset).ok()?
    }
}

impl Evaluated {
    fn new(
        scratch_len: usize,
        len: usize,
        way: impl FnOnce(&mut [f32], &mut [f32]) -> Result<(), CallError>,
    ) -> Self {
        let mut found = vec![f32::NAN; len];
        let done = way(&mut vec![f32::NAN; scratch_len], &mut found);
        Self { scratch_len, found, refusal: done.err().map(sinew_error::from) }
    }
}

fn palette(envelope: &Envelope<'_>, pose: &[Matrix3x4], curves: &[f32]) -> (Vec<Matrix3x4>, f32) {
    let mut scratch = vec![f32::NAN; envelope.scratch_len()];
    let mut palette = vec![[[f32::NAN; 4]; 3]; envelope.palette_len()];
    match envelope.palette(pose, curves, &mut scratch, &mut palette) {
        Ok(confidence) => (palette, confidence),
        Err(error) => panic!("the runtime refuses its own file's pose: {error}"),
    }
}
