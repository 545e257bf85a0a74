//! A layer that was drawn by itself: over what a picture holds, or as a mask.

use super::raster::over;
use super::texture::ALPHA_MAX;
use glam::Vec4;

/// Blends a layer over a picture.
///
/// - `clip`: how far each pixel of the layer is seen, in 255ths.
/// - `opacity`: from 0 to 1.
pub(super) fn blend(layer: &[[u8; 4]], clip: Option<&[u8]>, opacity: f32, out: &mut [[u8; 4]]) {
    for (at, (own, out)) in layer.iter().zip(out).enumerate().filter(|(_, (own, _))| own[3] > 0) {
        let seen = clip.map_or(1.0, |clip| f32::from(clip.get(at).copied().unwrap_or(0)) / 255.0);
        let colour = Vec4::from(own.map(f32::from)) * 255.0;
        *out = over(colour * (opacity * seen), *out);
    }
}

/// Leaves of a clip what a layer covers.
pub(super) fn mask(layer: &[[u8; 4]], opacity: f32, clip: &mut [u8]) {
    let scale = opacity / ALPHA_MAX * 255.0;
    for ([.., alpha], out) in layer.iter().zip(clip) {
        *out = (f32::from(*out) * f32::from(*alpha) * scale + 0.5) as u8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opacity_and_clip_scale_what_is_drawn() {
        let layer = [[200, 100, 0, 255]; 3];
        // Nothing, a fifth, and all.
        let clip = [0, 51, 255];
        for (clip, opacity) in [(None, 1.0), (None, 0.5), (Some(clip), 1.0), (Some(clip), 0.5)] {
            let mut pixels = [[100, 200, 40, 255]; 3];
            blend(&layer, clip.as_ref().map(|clip| &clip[..]), opacity, &mut pixels);
            for (at, pixel) in pixels.iter().enumerate() {
                let share = opacity * clip.map_or(1.0, |clip| f32::from(clip[at]) / 255.0);
                for (found, [above, below]) in pixel.iter().zip([[200, 100], [100, 200], [0, 40]]) {
                    let expected = below as f32 + share * (above - below) as f32;
                    assert!((f32::from(*found) - expected).abs() <= 0.51, "{at} {share}");
                }
            }
        }
    }

    #[test]
    fn masks_multiply() {
        let layer = [[9, 9, 9, 102], [0; 4], [255; 4]];
        let mut clip = [255, 255, 100];
        mask(&layer, 1.0, &mut clip);
        assert_eq!(clip, [102, 0, 100]);
        mask(&layer, 0.5, &mut clip);
        assert_eq!(clip, [20, 0, 50]);
    }
}
