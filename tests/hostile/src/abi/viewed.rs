//! What the runtime makes of a file's first object of key views: the inputs of its calls, and what they must give.

use crate::kernels::query;
use sinew_capi::{sinew_drawn, sinew_found};
use sinew_runtime::views::{Drawn, Found, RenderScratch};
use sinew_runtime::{CallError, Frame, FrameJob, Model, RenderJob, Views};

/// Pixels of a picture.
pub(super) const PIXELS: usize = 12 * 10;

/// A file's first object of key views.
pub(super) struct Viewed {
    pub(super) name: String,
    pub(super) maps: Vec<ViewedMap>,
    pub(super) vertex_len: usize,
    pub(super) order_len: usize,
    pub(super) has_depth: bool,
    pub(super) has_groups: bool,
    pub(super) has_clips: bool,
    /// A frame of the first map, of zeros where the runtime refuses one.
    pub(super) points: Vec<[f32; 3]>,
    pub(super) visibility: Vec<f32>,
    pub(super) scores: Vec<f32>,
    pub(super) layers: Vec<[f32; 2]>,
}

/// A map of the object.
pub(super) struct ViewedMap {
    /// Floats of scratch that a frame needs.
    pub(super) scratch_len: usize,
    pub(super) parameters: Vec<f32>,
}

/// What a frame job is asked for.
pub(super) struct AskedFrame {
    pub(super) map: usize,
    pub(super) parameters: Vec<f32>,
}

/// What a frame job gives.
pub(super) struct Given {
    pub(super) points: Vec<[f32; 3]>,
    pub(super) visibility: Vec<f32>,
    pub(super) scores: Vec<f32>,
    pub(super) layers: Vec<[f32; 2]>,
    pub(super) found: Found,
}

/// What a render job is asked for: into pixels that are all alike.
pub(super) struct AskedPicture {
    pub(super) points: Vec<[f32; 3]>,
    pub(super) layers: Vec<[f32; 2]>,
    pub(super) width: usize,
}

impl Viewed {
    pub(super) fn new<B: AsRef<[u8]>>(model: &Model<B>, views: &Views<'_>, number: usize) -> Self {
        let counts = views.counts();
        let maps = (0..counts.map_len as usize).filter_map(|map| model.map_of(views, map));
        let maps = maps.map(|map| ViewedMap {
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
        // Others reach beyond what can be drawn.
        let parameters = model.map_of(views, 0).map(|map| query(&map, 0)).unwrap_or_default();
        let asked = AskedFrame { map: 0, parameters };
        if let Ok(Some(given)) = asked.frame(model.as_bytes()) {
            (own.points, own.visibility) = (given.points, given.visibility);
            (own.scores, own.layers) = (given.scores, given.layers);
        }
        own
    }

    /// Returns the most parameters that a map has.
    pub(super) fn parameter_len(&self) -> usize {
        self.maps.iter().map(|map| map.parameters.len()).max().unwrap_or_default()
    }

    /// Returns the bytes of what its calls write.
    pub(super) fn result_bytes(&self) -> usize {
        let scratch_len = self.maps.iter().map(|map| map.scratch_len).max().unwrap_or_default();
        let layers = 8 * self.layers.len();
        let frame = 16 * self.points.len() + 4 * (self.scores.len() + scratch_len) + layers;
        // Pixels, depths and clips; places; numbers.
        let picture = (4 + 4 + 2) * PIXELS + 12 * self.vertex_len + 2 * self.order_len;
        frame + size_of::<sinew_found>() + picture + size_of::<sinew_drawn>()
    }
}

impl AskedFrame {
    /// Evaluates a map of the first views of a file; `None` where there is no such map.
    ///
    /// # Errors
    /// As the runtime refuses it.
    pub(super) fn frame(&self, file: &[u8]) -> Result<Option<Given>, CallError> {
        let Ok(model) = Model::from_bytes(file) else { return Ok(None) };
        let Some(views) = model.views() else { return Ok(None) };
        let Some(map) = model.map_of(&views, self.map) else { return Ok(None) };
        let mut points = vec![[f32::NAN; 3]; views.point_len()];
        let mut visibility = vec![f32::NAN; views.point_len()];
        let mut scores = vec![f32::NAN; views.view_len()];
        let mut layers = vec![[f32::NAN; 2]; views.layer_len()];
        let out = Frame {
            points: &mut points,
            visibility: &mut visibility,
            scores: &mut scores,
            layers: &mut layers,
        };
        let mut scratch = vec![f32::NAN; views.counts().frame_scratch_len(&map.counts())];
        let parameters = &self.parameters;
        let found = FrameJob { views, map, parameters }.run(&mut scratch, out)?;
        Ok(Some(Given { points, visibility, scores, layers, found }))
    }
}

impl AskedPicture {
    /// Draws the first views of a file over pixels; `None` where there are none.
    ///
    /// # Errors
    /// As the runtime refuses it.
    pub(super) fn draw(
        &self,
        file: &[u8],
        own: &Viewed,
        pixels: &mut [[u8; 4]],
    ) -> Result<Option<Drawn>, CallError> {
        let Ok(model) = Model::from_bytes(file) else { return Ok(None) };
        let Some(views) = model.views() else { return Ok(None) };
        let Viewed { visibility, scores, vertex_len, order_len, .. } = own;
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
