//! Calls of a file's first prior, views and filter: inputs, and the results that the runtime gives.

use crate::parts::query;
use sinew_capi::{SINEW_PINS_MAX, sinew_drawn, sinew_edit, sinew_found, sinew_pin};
use sinew_runtime::prior::{Anchor, Edit, PriorCounts, Temporal};
use sinew_runtime::views::{Drawn, Found, RenderScratch};
use sinew_runtime::{
    CallError, Filter, Frame, FrameJob, Matrix3x4, Model, Pin, PinJob, Pins, Prior, RenderJob,
    Skin, Views,
};

/// Largest arguments of a call: signals, samples outside the window, lanes.
pub(super) const SAMPLES_MAX: [usize; 3] = [2, 2, 9];

/// A file's first filter.
pub(super) struct FilterCase {
    pub(super) name: String,
    pub(super) factor: usize,
    pub(super) tap_len: usize,
}

impl FilterCase {
    pub(super) fn new(filter: &Filter<'_>) -> Self {
        let (name, factor) = (filter.name().to_owned(), filter.factor());
        Self { name, factor, tap_len: filter.tap_len() }
    }

    /// Returns the bytes of the largest samples that a call takes.
    pub(super) fn sample_bytes(&self) -> usize {
        let [signals, more, lanes] = SAMPLES_MAX;
        4 * signals * (self.tap_len + more) * lanes
    }

    /// Returns the bytes that a call writes.
    pub(super) fn result_bytes(&self) -> usize {
        self.factor * self.sample_bytes()
    }
}

/// Number of pins for which an arena has room: one more than a job may have.
pub(super) const PINS: usize = SINEW_PINS_MAX + 1;

/// Number of pins for which a job is given scratch.
pub(super) const FEW_PINS: usize = 3;

/// A file's first prior.
pub(super) struct PriorCase {
    pub(super) name: String,
    pub(super) counts: PriorCounts,
    pub(super) beta: f32,
}

/// Arguments of a pin job; its arrays are the frame's unless a field says otherwise.
pub(super) struct PinArguments {
    pub(super) pins: Vec<sinew_pin>,
    pub(super) is_from_mean: bool,
    pub(super) is_bounded: bool,
    pub(super) cancels: bool,
    pub(super) beta: f32,
    pub(super) symmetry: f32,
    pub(super) temporal: f32,
    pub(super) last: Option<Vec<f32>>,
    pub(super) weights: Vec<f32>,
}

impl PriorCase {
    pub(super) fn new(prior: &Prior<'_>) -> Self {
        Self { name: prior.name().to_owned(), counts: prior.counts(), beta: prior.fit().beta }
    }

    /// Returns the maximum scratch of a job of few pins, in f64 numbers.
    pub(super) fn scratch_len(&self) -> usize {
        self.counts.pin_scratch_len(3 * FEW_PINS)
    }

    /// Returns the bytes that a call writes.
    pub(super) fn result_bytes(&self) -> usize {
        4 * self.counts.shape_len as usize + size_of::<sinew_edit>() + 8 * self.scratch_len()
    }
}

impl PinArguments {
    /// Counts the f64 numbers of scratch that the job needs; for too many pins, the count for few
    /// pins.
    pub(super) fn scratch_len(&self, prior: &PriorCase) -> usize {
        let rows = self.pins.iter().take(FEW_PINS).flat_map(|pin| pin.rows);
        prior.counts.pin_scratch_len(rows.filter(|[x, y, z, _]| [*x, *y, *z] != [0.0; 3]).count())
    }

    /// Solves with the first prior and the first skin of a file; returns nothing if either is
    /// missing.
    ///
    /// # Errors
    /// The refusal of the runtime.
    pub(super) fn solve(
        &self,
        file: &[u8],
        palette: &[Matrix3x4],
    ) -> Result<(Vec<f32>, Edit), CallError> {
        let nothing = Ok((Vec::new(), Edit::default()));
        let Ok(model) = Model::from_bytes(file) else { return nothing };
        let Some((prior, skin)) = model.first::<Prior>().zip(model.first::<Skin>()) else {
            return nothing;
        };
        let mut pins = Pins::<SINEW_PINS_MAX>::new();
        for pin in &self.pins {
            let sinew_pin { vertex, rows, target, stiffness } = *pin;
            pins.add(Pin { vertex, rows, target, stiffness })?;
        }
        let job = PinJob {
            palette,
            anchor: if self.is_from_mean { Anchor::Mean } else { Anchor::Current },
            beta: self.beta,
            is_bounded: self.is_bounded,
            temporal: self
                .last
                .as_ref()
                .map(|weights| Temporal { weights, stiffness: self.temporal }),
            symmetry: self.symmetry,
            cancels: self.cancels,
            ..PinJob::new(prior, skin, pins.list())
        };
        let mut scratch = vec![f64::NAN; prior.counts().pin_scratch_len(3 * self.pins.len())];
        let mut weights = self.weights.clone();
        job.run(&mut scratch, &mut weights).map(|edit| (weights, edit))
    }
}

/// Pixels of a picture.
pub(super) const PIXELS: usize = 12 * 10;

/// A file's first object of key views.
pub(super) struct ViewsCase {
    pub(super) name: String,
    pub(super) maps: Vec<MapCase>,
    pub(super) vertex_len: usize,
    pub(super) order_len: usize,
    pub(super) has_depth: bool,
    pub(super) has_groups: bool,
    pub(super) has_clips: bool,
    /// Frame of the first map; zeros if the runtime refuses the frame.
    pub(super) points: Vec<[f32; 3]>,
    pub(super) visibility: Vec<f32>,
    pub(super) scores: Vec<f32>,
    pub(super) layers: Vec<[f32; 2]>,
}

/// A map of the object.
pub(super) struct MapCase {
    /// Length of the scratch for a frame, in floats.
    pub(super) scratch_len: usize,
    pub(super) parameters: Vec<f32>,
}

/// Arguments of a frame job.
pub(super) struct FrameArguments {
    pub(super) map: usize,
    pub(super) parameters: Vec<f32>,
}

/// Result of a frame job.
pub(super) struct FrameResult {
    pub(super) points: Vec<[f32; 3]>,
    pub(super) visibility: Vec<f32>,
    pub(super) scores: Vec<f32>,
    pub(super) layers: Vec<[f32; 2]>,
    pub(super) found: Found,
}

/// Arguments of a render job, into pixels of one colour.
pub(super) struct PictureArguments {
    pub(super) points: Vec<[f32; 3]>,
    pub(super) layers: Vec<[f32; 2]>,
    pub(super) width: usize,
}

impl ViewsCase {
    pub(super) fn new<B: AsRef<[u8]>>(model: &Model<B>, views: &Views<'_>, number: usize) -> Self {
        let counts = views.counts();
        let maps = (0..counts.map_len as usize).filter_map(|map| model.map_of(views, map));
        let maps = maps.map(|map| MapCase {
            scratch_len: counts.frame_scratch_len(&map.counts()),
            parameters: query(&map, number),
        });
        let mut own = Self {
            name: views.name().to_owned(),
            maps: maps.collect(),
            vertex_len: views.vertex_len(),
            order_len: views.order_len(),
            has_depth: views.has_depth(),
            has_groups: views.has_groups(),
            has_clips: views.has_clips(),
            points: vec![[0.0; 3]; views.point_len()],
            visibility: vec![0.0; views.point_len()],
            scores: vec![0.0; views.view_len()],
            layers: vec![[0.0; 2]; views.layer_len()],
        };
        // Other queries reach outside the range that can be drawn.
        let parameters = model.map_of(views, 0).map(|map| query(&map, 0)).unwrap_or_default();
        let arguments = FrameArguments { map: 0, parameters };
        if let Ok(Some(given)) = arguments.frame(model.as_bytes()) {
            (own.points, own.visibility) = (given.points, given.visibility);
            (own.scores, own.layers) = (given.scores, given.layers);
        }
        own
    }

    /// Returns the largest number of parameters of a map.
    pub(super) fn parameter_len(&self) -> usize {
        self.maps.iter().map(|map| map.parameters.len()).max().unwrap_or_default()
    }

    /// Returns the bytes that a call writes.
    pub(super) fn result_bytes(&self) -> usize {
        let scratch_len = self.maps.iter().map(|map| map.scratch_len).max().unwrap_or_default();
        let layers = 8 * self.layers.len();
        let frame = 16 * self.points.len() + 4 * (self.scores.len() + scratch_len) + layers;
        // Colours, depths and clips of the pixels; places of the vertices; numbers of the order.
        let picture = (4 + 4 + 2) * PIXELS + 12 * self.vertex_len + 2 * self.order_len;
        frame + size_of::<sinew_found>() + picture + size_of::<sinew_drawn>()
    }
}

impl FrameArguments {
    /// Evaluates a map of the first views of a file; `None` if the map is missing.
    ///
    /// # Errors
    /// The refusal of the runtime.
    pub(super) fn frame(&self, file: &[u8]) -> Result<Option<FrameResult>, CallError> {
        let Ok(model) = Model::from_bytes(file) else { return Ok(None) };
        let Some(views) = model.first::<Views>() else { return Ok(None) };
        let Some(map) = model.map_of(&views, self.map) else { return Ok(None) };
        let mut points = vec![[f32::NAN; 3]; views.point_len()];
        let mut visibility = vec![f32::NAN; views.point_len()];
        let mut scores = vec![f32::NAN; views.view_len()];
        let mut layers = vec![[f32::NAN; 2]; views.layer_len()];
        let mut out = Frame {
            points: &mut points,
            visibility: &mut visibility,
            scores: &mut scores,
            layers: &mut layers,
        };
        let mut scratch = vec![f32::NAN; views.counts().frame_scratch_len(&map.counts())];
        let parameters = &self.parameters;
        let found = FrameJob { views, map, parameters }.run(&mut scratch, &mut out)?;
        Ok(Some(FrameResult { points, visibility, scores, layers, found }))
    }
}

impl PictureArguments {
    /// Draws the first views of a file over pixels; `None` if the file has no views.
    ///
    /// # Errors
    /// The refusal of the runtime.
    pub(super) fn draw(
        &self,
        file: &[u8],
        own: &ViewsCase,
        pixels: &mut [[u8; 4]],
    ) -> Result<Option<Drawn>, CallError> {
        let Ok(model) = Model::from_bytes(file) else { return Ok(None) };
        let Some(views) = model.first::<Views>() else { return Ok(None) };
        let ViewsCase { visibility, scores, vertex_len, order_len, .. } = own;
        let &Self { ref points, ref layers, width } = self;
        let job = RenderJob { views, points, visibility, scores, layers, width };
        let scratch = RenderScratch {
            vertices: &mut vec![[f32::NAN; 3]; *vertex_len],
            order: &mut vec![0; *order_len],
            depths: &mut vec![f32::NAN; pixels.len()],
            group: &mut vec![[0; 4]; pixels.len()],
            clips: &mut vec![0; pixels.len()],
        };
        job.run(scratch, pixels).map(Some)
    }
}
