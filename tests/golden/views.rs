//! The golden objects of key views, and the hash of each over seeded parameters, which is equal on
//! all CPUs.

use super::{Rng, add};
use sinew_runtime::views::{RenderScratch, ViewsCounts};
use sinew_runtime::{CallError, Frame, FrameJob, Model, RenderJob, Views};

/// Files of an object that is not transferred, and of a transferred object.
pub(crate) const VIEWS: [&[u8]; 2] =
    [include_bytes!("views-11.snw"), include_bytes!("views-11-transferred.snw")];

/// Hash of each object, the promise of METHOD §7: change these only with a reason that the commit
/// states.
pub(crate) const BITS: [u64; 2] = [0x881d_e8f3_30b1_11e9, 0x6d89_79b0_2944_33e4];

/// Frames per hash.
const FRAMES: usize = 64;
/// Width and height of a picture.
const SIZE: [usize; 2] = [48, 40];
const POINTS: usize = 9;
const KEY_VIEWS: usize = 3;
const LAYERS: usize = 2;
const VERTICES: usize = 10;
const ELEMENTS: usize = 7;

/// Hashes every map of a model's first object over seeded parameters: points, visibilities, scores,
/// opacities and orders of layers, the characteristic view, and pictures. `nudge` is added to each
/// parameter.
///
/// # Errors
/// Errors of the calls; a length error if the object does not have the golden files' size.
pub(crate) fn hash(
    model: &Model<&[u8]>,
    views: Views<'_>,
    nudge: f32,
    scratch: &mut [f32],
) -> Result<u64, CallError> {
    let ViewsCounts { map_len, .. } = views.counts();
    let mut hash = 0;
    let mut rng = Rng(1992);
    let (mut points, mut vertices) = ([[0.0; 3]; POINTS], [[0.0; 3]; VERTICES]);
    let (mut visibility, mut scores) = ([0.0; POINTS], [0.0; KEY_VIEWS]);
    let (mut layers, mut order) = ([[0.0; 2]; LAYERS], [0; ELEMENTS + LAYERS]);
    for map in (0..map_len as usize).filter_map(|map| model.map_of(&views, map)) {
        for _ in 0..FRAMES {
            let parameters = [(); 2].map(|()| 1.5 * rng.unit() + nudge);
            let mut frame = Frame {
                points: &mut points,
                visibility: &mut visibility,
                scores: &mut scores,
                layers: &mut layers,
            };
            let found =
                FrameJob { views, map, parameters: &parameters }.run(scratch, &mut frame)?;
            for numbers in [points.as_flattened(), &visibility, &scores, layers.as_flattened()] {
                add(&mut hash, numbers);
            }
            let mut pixels = [[40, 80, 120, 255]; SIZE[0] * SIZE[1]];
            let job = RenderJob {
                views,
                points: &points,
                visibility: &visibility,
                scores: &scores,
                layers: &layers,
                width: SIZE[0],
            };
            let scratch = RenderScratch {
                vertices: &mut vertices,
                order: &mut order,
                depths: &mut [f32::MAX; SIZE[0] * SIZE[1]],
                group: &mut [[0; 4]; SIZE[0] * SIZE[1]],
                clips: &mut [0; SIZE[0] * SIZE[1]],
            };
            let drawn = job.run(scratch, &mut pixels)?;
            let told = [found.view, drawn.element_len, drawn.flipped_len].map(|len| len as f32);
            add(&mut hash, &told);
            pixels
                .iter()
                .for_each(|pixel| add(&mut hash, &[f32::from_bits(u32::from_le_bytes(*pixel))]));
        }
    }
    Ok(hash)
}

/// Loads a golden object; `None` on failure.
pub(crate) fn load(file: &'static [u8]) -> Option<Model<&'static [u8]>> {
    Model::from_bytes(file).ok()
}
