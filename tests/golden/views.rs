//! The golden objects of key views, and the bits of each over seeded parameters, which all CPUs agree on.

use super::{Rng, add};
use sinew_runtime::views::{Order, ViewsCounts};
use sinew_runtime::{CallError, Frame, FrameJob, Model, RenderJob, Views};

/// A file of an object that stands alone, and one of an object that is transferred.
pub(crate) const VIEWS: [&[u8]; 2] =
    [include_bytes!("views-7.snw"), include_bytes!("views-7-transferred.snw")];

/// A hash of each of them. Change these only with a reason that the commit states: they are the promise of
/// METHOD §7.
pub(crate) const BITS: [u64; 2] = [0xe6d0_f161_165e_6ecc, 0xeeac_b6a1_b284_066c];

/// Frames of a hash.
const FRAMES: usize = 64;
/// Width and height of a picture.
const SIZE: [usize; 2] = [48, 40];
const POINTS: usize = 9;
const KEY_VIEWS: usize = 3;
const ELEMENTS: usize = 6;

/// Hashes every map of a model's first object over seeded parameters, each of which `nudge` is added to: points,
/// visibilities, scores, the characteristic view, and pictures in either order.
///
/// # Errors
/// Those of the calls; lengths, if the object is not of the golden files' size.
pub(crate) fn hash(
    model: &Model<&[u8]>,
    views: Views<'_>,
    nudge: f32,
    scratch: &mut [f32],
) -> Result<u64, CallError> {
    let ViewsCounts { map_len, .. } = views.counts();
    let mut hash = 0;
    let mut rng = Rng(1992);
    let [mut points, mut visibility, mut scores] =
        [[[0.0; 3]; POINTS], [[0.0; 3]; POINTS], [[0.0; 3]; POINTS]];
    let (visibility, scores) = (visibility.as_flattened_mut(), scores.as_flattened_mut());
    for map in (0..map_len as usize).filter_map(|map| model.map_of(&views, map)) {
        let mut last = None;
        for number in 0..FRAMES {
            let parameters = [(); 2].map(|()| 1.5 * rng.unit() + nudge);
            let margin = views.fit().margin;
            let frame = Frame {
                points: &mut points,
                visibility: visibility.get_mut(..POINTS).unwrap_or_default(),
                scores: scores.get_mut(..KEY_VIEWS).unwrap_or_default(),
            };
            let found = FrameJob { views, map, parameters: &parameters, last, margin }
                .run(scratch, frame)?;
            last = Some(found.view);
            let visibility = visibility.get(..POINTS).unwrap_or_default();
            let scores = scores.get(..KEY_VIEWS).unwrap_or_default();
            add(&mut hash, points.as_flattened());
            add(&mut hash, visibility);
            add(&mut hash, scores);
            let mut pixels = [[40, 80, 120, 255]; SIZE[0] * SIZE[1]];
            let [width, _] = SIZE;
            let job =
                RenderJob { views, points: &points, visibility, scores, view: found.view, width };
            let drawn = if number % 2 == 0 {
                job.run(Order::Painter(&mut [0; ELEMENTS]), &mut pixels)?
            } else {
                job.run(Order::Depth(&mut [f32::MAX; SIZE[0] * SIZE[1]]), &mut pixels)?
            };
            let told = [found.view, drawn.element_len, drawn.flipped_len].map(|len| len as f32);
            add(&mut hash, &told);
            pixels
                .iter()
                .for_each(|pixel| add(&mut hash, &[f32::from_bits(u32::from_le_bytes(*pixel))]));
        }
    }
    Ok(hash)
}

/// Loads a golden object; `None` if that fails.
pub(crate) fn load(file: &'static [u8]) -> Option<Model<&'static [u8]>> {
    Model::from_bytes(file).ok()
}
