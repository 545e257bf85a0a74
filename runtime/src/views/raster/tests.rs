extern crate std;
use super::*;
use std::vec;
use std::vec::Vec;

const BLACK: [u8; 4] = [0, 0, 0, 255];

/// Corners of an element without borders.
fn corners<const N: usize>(places: [[f32; 2]; N], depth: f32) -> [Corner; N] {
    let corner = |number| Corner { place: places[number], depth, number, soft: 0.0 };
    core::array::from_fn(corner)
}

/// Corners of an element whose edges are all borders.
fn bordered<const N: usize>(places: [[f32; 2]; N]) -> [Corner; N] {
    corners(places, 0.0).map(|corner| Corner { soft: 1.0, ..corner })
}

/// A full texture, with the corners at these places.
fn source<'a, const N: usize>(texture: Texture<'a>, places: [[f32; 2]; N]) -> [Source<'a>; 1] {
    let mut texels = [[0.0; 2]; 4];
    texels[..N].copy_from_slice(&places);
    [Source { texture, texels, share: 1.0 }]
}

/// One colour, with the corners' texture places equal to their screen places.
fn plain<const N: usize>(texel: &[[u8; 4]; 1], places: [[f32; 2]; N]) -> [Source<'_>; 1] {
    source(Texture { width: 1, height: 1, texels: texel }, places)
}

fn blended(width: usize, pixels: &mut [[u8; 4]]) -> Screen<'_> {
    Screen { width, pixels, depths: None, opacity: 1.0, is_group: false }
}

fn random(seed: &mut u64) -> f32 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
    (*seed >> 40) as f32 / (1u64 << 24) as f32
}

#[test]
fn an_element_in_place_shows_its_texture() {
    let (n, mut seed) = (128usize, 5);
    let texels: Vec<[u8; 4]> = (0..n * n)
        .map(|_| [0; 3].map(|_| 255 * u8::from(random(&mut seed) < 0.5)))
        .map(|[r, g, b]| [r, g, b, 255])
        .collect();
    let texture = Texture { width: n, height: n, texels: &texels };
    let cells = 9;
    let cell = n as f32 / cells as f32;
    let place = |x: usize, y: usize| {
        let mut seed = (x * 31 + y) as u64;
        [x, y].map(|i| {
            let inner = if i == 0 || i == cells { 0.0 } else { 0.5 };
            cell * (i as f32 + inner * (random(&mut seed) - 0.5))
        })
    };
    let mut pixels = vec![[9; 4]; n * n];
    let mut screen = blended(n, &mut pixels);
    for (y, x) in (0..cells).flat_map(|y| (0..cells).map(move |x| (y, x))) {
        let ring = [place(x, y), place(x + 1, y), place(x + 1, y + 1), place(x, y + 1)];
        let [a, b, c, d] = corners(ring, 0.0);
        let own = source(texture, ring);
        let screen = &mut screen;
        let flipped = match (x + y) % 3 {
            0 => quad(screen, [a, b, c, d], &own),
            1 => triangle(screen, [a, b, c], &own) | triangle(screen, [c, d, a], &own),
            _ => triangle(screen, [b, a, d], &own) | triangle(screen, [d, c, b], &own),
        };
        assert!(!flipped);
    }
    let apart = pixels.iter().zip(&texels).flat_map(|(a, b)| a.iter().zip(b));
    let worst = apart.map(|(a, b)| a.abs_diff(*b)).max();
    assert!(worst <= Some(1), "{worst:?}");
}

/// Inverts the bilinear map of a quad by Newton steps.
fn inverted(ring: [[f64; 2]; 4], p: [f64; 2]) -> [f64; 2] {
    let [a, b, c, d] = ring;
    let (mut s, mut t) = (0.5, 0.5);
    for _ in 0..60 {
        let at = |i: usize| {
            (1.0 - t) * (a[i] + (b[i] - a[i]) * s) + t * (d[i] + (c[i] - d[i]) * s) - p[i]
        };
        let by_s = |i: usize| (1.0 - t) * (b[i] - a[i]) + t * (c[i] - d[i]);
        let by_t = |i: usize| (1.0 - s) * (d[i] - a[i]) + s * (c[i] - b[i]);
        let (x, y) = (at(0), at(1));
        let det = by_s(0) * by_t(1) - by_s(1) * by_t(0);
        let (ds, dt) = ((x * by_t(1) - y * by_t(0)) / det, (by_s(0) * y - by_s(1) * x) / det);
        (s, t) = (s - ds, t - dt);
    }
    assert!([s, t].iter().all(|x| (-1e-6..=1.0 + 1e-6).contains(x)), "{s} {t}");
    [s, t]
}

#[test]
fn quads_are_inverted_as_in_double_precision() {
    // Texels with a slope in each direction.
    let n = 256;
    let texels: Vec<_> = (0..n * n).map(|i| [(i % n) as u8, (i / n) as u8, 7, 255]).collect();
    let texture = Texture { width: n, height: n, texels: &texels };
    let (size, mut seed, mut seen) = (96, 8, 0);
    for round in 0..40 {
        let mut ring = [[20.0f32, 20.0], [76.0, 20.0], [76.0, 76.0], [20.0, 76.0]].map(|corner| {
            let moved = 30.0 * (1.0 - 1.0 / (1 + round) as f32);
            corner.map(|x| ((x + moved * (random(&mut seed) - 0.5)) * 256.0).round() / 256.0)
        });
        if round % 2 == 1 {
            ring.reverse();
        }
        let ends = [[0.5, 0.5], [255.5, 0.5], [255.5, 255.5], [0.5, 255.5]];
        let mut pixels = vec![[0; 4]; size * size];
        let mut screen = blended(size, &mut pixels);
        let flipped = quad(&mut screen, corners(ring, 0.0), &source(texture, ends));
        assert_eq!(flipped, round % 2 == 1);
        for (at, pixel) in pixels.iter().enumerate().filter(|(_, pixel)| pixel[3] > 0) {
            let p = [at % size, at / size].map(|x| x as f64 + 0.5);
            let share = inverted(ring.map(|place| place.map(f64::from)), p);
            let expected = share.map(|share| 255.0 * share);
            for (found, expected) in pixel.iter().zip(expected) {
                assert!((f64::from(*found) - expected).abs() <= 0.51, "{found} {expected}");
            }
            seen += 1;
        }
    }
    assert!(seen > 100_000);
}

#[test]
fn a_concave_quad_is_covered_once_and_reported() {
    let half = [[0, 0, 0, 128]];
    for first in 0..4 {
        // The corner at 24, 24 points inwards.
        let mut ring = [[8.0, 8.0], [56.0, 8.0], [24.0, 24.0], [8.0, 56.0]];
        ring.rotate_left(first);
        let mut pixels = vec![[0; 4]; 64 * 64];
        let mut screen = blended(64, &mut pixels);
        assert!(quad(&mut screen, corners(ring, 0.0), &plain(&half, ring)));
        let area = pixels.iter().filter(|pixel| pixel[3] == 128).count();
        assert!((700..=840).contains(&area), "{area}");
        assert!(pixels.iter().all(|pixel| pixel[3] == 0 || pixel[3] == 128));
    }
}

#[test]
fn an_element_flipped_against_its_texture_is_reported_and_drawn() {
    let ring = [[1.0, 1.0], [7.0, 1.0], [1.0, 7.0]];
    let [a, b, c] = ring;
    let red = [[255, 0, 0, 255]];
    for (texels, expected) in [([a, b, c], false), ([a, c, b], true)] {
        let mut pixels = vec![BLACK; 64];
        let mut screen = blended(8, &mut pixels);
        let own = plain(&red, texels);
        assert_eq!(triangle(&mut screen, corners(ring, 0.0), &own), expected);
        // The first source decides.
        let both = [own, plain(&red, [a, c, b])].concat();
        assert_eq!(triangle(&mut screen, corners(ring, 0.0), &both), expected);
        assert_eq!(pixels.iter().filter(|pixel| pixel[0] == 255).count(), 15);
    }
    let flat = [a, b, [4.0, 1.0]];
    for corners in [corners(flat, 0.0), bordered(flat)] {
        let mut pixels = vec![BLACK; 64];
        assert!(!triangle(&mut blended(8, &mut pixels), corners, &plain(&red, flat)));
        assert!(pixels.iter().all(|pixel| *pixel == BLACK));
    }
}

const SQUARE: [[f32; 2]; 4] = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]];

#[test]
fn without_depths_elements_are_blended() {
    let mut pixels = vec![[100, 200, 40, 255]; 16];
    let own = plain(&[[200, 100, 0, 51]], SQUARE);
    quad(&mut blended(4, &mut pixels), corners(SQUARE, 0.0), &own);
    // A fifth of the drawn colour and four fifths of the picture.
    assert_eq!(pixels, [[120, 180, 32, 255]; 16]);
}

#[test]
fn sources_are_mixed_by_their_shares() {
    // Equal in triangles and quads. Colours count by their alpha, so the second counts half.
    let [[first], [second]] = [&[[200, 100, 0, 255]], &[[40, 200, 80, 102]]]
        .map(|texel: &[[u8; 4]; 1]| plain(texel, SQUARE));
    for (shares, expected) in [
        ([1.0, 0.0], [200, 100, 0, 255]),
        ([0.75, 0.25], [154, 95, 8, 217]),
        ([0.25, 0.75], [62, 85, 24, 140]),
    ] {
        let sources = [Source { share: shares[0], ..first }, Source { share: shares[1], ..second }];
        let [a, b, c, d] = corners(SQUARE, 0.0);
        let mut pixels = vec![[0; 4]; 16];
        quad(&mut blended(4, &mut pixels), [a, b, c, d], &sources);
        assert_eq!(pixels, [expected; 16]);
        let mut pixels = vec![[0; 4]; 16];
        triangle(&mut blended(4, &mut pixels), [a, b, c], &sources);
        triangle(&mut blended(4, &mut pixels), [a, c, d], &sources);
        assert_eq!(pixels, [expected; 16]);
    }
}

#[test]
fn each_source_has_its_own_corners() {
    // One slope across and one down.
    let n = 16;
    let texels: Vec<_> =
        (0..n * n).map(|i| [16 * (i % n) as u8, 16 * (i / n) as u8, 0, 255]).collect();
    let texture = Texture { width: n, height: n, texels: &texels };
    let size = n as f32;
    let ring = [[0.0, 0.0], [size, 0.0], [size, size], [0.0, size]];
    // The second source is rotated by a quarter turn.
    let turned = [ring[1], ring[2], ring[3], ring[0]];
    let [[first], [second]] = [ring, turned].map(|places| source(texture, places));
    let sources = [Source { share: 0.75, ..first }, Source { share: 0.25, ..second }];
    let mut pixels = vec![[0; 4]; n * n];
    quad(&mut blended(n, &mut pixels), corners(ring, 0.0), &sources);
    for (at, [r, g, ..]) in pixels.iter().enumerate() {
        let [x, y] = [at % n, at / n].map(|x| x as f32);
        let expected = [12.0 * x + 4.0 * (15.0 - y), 12.0 * y + 4.0 * x];
        for (found, expected) in [*r, *g].into_iter().zip(expected) {
            assert!((f32::from(found) - expected).abs() <= 0.51, "{at} {found} {expected}");
        }
    }
}

#[test]
fn borders_are_soft_and_edges_within_are_not() {
    // A square from 2.25 to 9.25, cut along either diagonal or whole, in either direction.
    let (low, high) = (2.25, 9.25);
    let mut ring = [[low, low], [high, low], [high, high], [low, high]];
    let covered = |i: usize| match i {
        0 | 1 | 10.. => 0.0,
        // A quarter of the width lies outside, or inside: from the border to the centre.
        2 => 0.75,
        9 => 0.25,
        _ => 1.0,
    };
    let white = [[255; 4]];
    let inner = |corner: Corner| Corner { soft: 0.0, ..corner };
    for round in 0..8 {
        ring.rotate_left(1);
        if round == 4 {
            ring.reverse();
        }
        let own = plain(&white, ring);
        let [a, b, c, d] = bordered(ring);
        let [mut cut, mut whole] = [(); 2].map(|()| vec![[0; 4]; 144]);
        let screen = &mut blended(12, &mut cut);
        triangle(screen, [a, b, inner(c)], &own);
        triangle(screen, [inner(a), c, d], &own);
        quad(&mut blended(12, &mut whole), [a, b, c, d], &own);
        for (at, (cut, whole)) in cut.iter().zip(&whole).enumerate() {
            let expected = 255.0 * covered(at % 12) * covered(at / 12);
            // At the ends of the cut, a pixel has the border of only one triangle.
            let is_corner = [at % 12, at / 12].iter().all(|i| matches!(i, 2 | 9));
            let most = if is_corner { 64.0 } else { 0.51 };
            for (found, most) in [(cut, most), (whole, 0.51)] {
                let apart = (f32::from(found[3]) - expected).abs();
                assert!(apart <= most, "{at}: {found:?} {expected}");
            }
            assert!(cut.iter().all(|x| *x == cut[3]) && whole.iter().all(|x| *x == whole[3]));
        }
        // A soft inner edge would leave a visible slit.
        let mut slit = vec![[0; 4]; 144];
        let screen = &mut blended(12, &mut slit);
        triangle(screen, [a, b, c], &own);
        triangle(screen, [a, c, d], &own);
        assert!(
            (3..9).any(
                |i| slit[if ring[0][0] == ring[0][1] { 13 * i } else { 11 * (i + 1) }][3] < 250
            )
        );
    }
}

#[test]
fn a_soft_border_has_the_colours_of_its_edge() {
    // Texels outside the quad stay invisible: red grows by 60 per texel from the fourth texel on.
    let n = 16;
    let red = |i: usize| 60 * i.saturating_sub(3).min(4) as u8;
    let texels: Vec<_> = (0..n * n).map(|i| [red((i % n).min(i / n)), 0, 0, 255]).collect();
    let texture = Texture { width: n, height: n, texels: &texels };
    let ring = [[4.7, 4.7], [12.0, 4.7], [12.0, 12.0], [4.7, 12.0]];
    let mut pixels = vec![[0; 4]; n * n];
    quad(&mut blended(n, &mut pixels), bordered(ring), &source(texture, ring));
    for at in [8 * n + 4, 4 * n + 8] {
        let [red, _, _, alpha] = pixels[at].map(f32::from);
        // The edge is at 4.7, 1.2 texels from the centre of the third; the pixel's centre is at
        // 4.5.
        let (found, expected) = (255.0 * red / alpha, 60.0 * 1.2);
        assert!(alpha > 60.0 && (found - expected).abs() < 3.0, "{found} {alpha}");
    }
}

#[test]
fn a_quad_that_is_cut_in_two_has_no_border_within() {
    let white = [[255; 4]];
    for first in 0..4 {
        let mut ring = [[8.0, 8.0], [56.0, 8.0], [24.0, 24.0], [8.0, 56.0]];
        ring.rotate_left(first);
        let mut pixels = vec![[0; 4]; 64 * 64];
        assert!(quad(&mut blended(64, &mut pixels), bordered(ring), &plain(&white, ring)));
        // The cut goes from 8, 8 to 24, 24.
        assert!((9..23).all(|i| pixels[65 * i] == [255; 4]), "{first}");
        let sum: f32 = pixels.iter().map(|pixel| f32::from(pixel[3]) / 255.0).sum();
        assert!((sum - 768.0).abs() < 2.0, "{sum}");
    }
}

#[test]
fn with_depths_the_nearer_wins_then_the_first() {
    // The last colour is nearest, and too translucent to hide the others.
    let colours = [[10, 0, 0, 255], [20, 0, 0, 255], [30, 0, 0, 255], [40, 0, 0, 127]];
    for (order, expected) in [([0, 1, 2, 3], 25), ([1, 0, 3, 2], 30), ([2, 3, 1, 0], 20)] {
        let depths = [5.0, 5.0, 6.0, 1.0];
        let (mut pixels, mut nearest) = (vec![BLACK; 16], vec![f32::INFINITY; 16]);
        for element in order {
            let depths_of = Some(&mut *nearest);
            let mut screen = Screen { depths: depths_of, ..blended(4, &mut pixels) };
            let own = [colours[element]];
            quad(&mut screen, corners(SQUARE, depths[element]), &plain(&own, SQUARE));
        }
        assert_eq!(pixels, [[expected, 0, 0, 255]; 16]);
        assert_eq!(nearest, [5.0; 16]);
    }
}

#[test]
fn from_half_of_alpha_on_a_pixel_hides() {
    for (alpha, hides) in [(127, false), (128, true)] {
        for has_quads in [false, true] {
            let (mut pixels, mut nearest) = (vec![[0; 4]; 16], vec![f32::INFINITY; 16]);
            let depths = Some(&mut *nearest);
            let mut screen = Screen { depths, ..blended(4, &mut pixels) };
            for (depth, texel) in [(1.0, [[0, 0, 0, alpha]]), (2.0, [[255; 4]])] {
                let own = plain(&texel, SQUARE);
                let [a, b, c, d] = corners(SQUARE, depth);
                if has_quads {
                    quad(&mut screen, [a, b, c, d], &own);
                } else {
                    triangle(&mut screen, [a, b, c], &own);
                    triangle(&mut screen, [a, c, d], &own);
                }
            }
            assert!(pixels.iter().all(|pixel| (pixel[0] == 0) == hides), "{alpha}");
        }
    }
}

#[test]
fn depths_lie_on_the_plane_of_their_corners() {
    let place = [[0.0, 0.0], [8.0, 0.0], [0.0, 8.0]];
    let plane = |[x, y]: [f32; 2]| 3.0 + 0.5 * x - 0.25 * y;
    let slanted = corners(place, 0.0).map(|corner| Corner { depth: plane(corner.place), ..corner });
    let (mut pixels, mut nearest) = (vec![BLACK; 64], vec![f32::INFINITY; 64]);
    let depths = Some(&mut *nearest);
    let mut screen = Screen { depths, ..blended(8, &mut pixels) };
    triangle(&mut screen, slanted, &plain(&[[1, 2, 3, 255]], place));
    let mut seen = 0;
    for (at, depth) in nearest.iter().enumerate().filter(|(_, depth)| depth.is_finite()) {
        let centre = [at % 8, at / 8].map(|x| x as f32 + 0.5);
        assert!((depth - plane(centre)).abs() < 1e-5);
        seen += 1;
    }
    assert!(seen >= 28, "{seen}");
}

#[test]
fn opacity_and_clip_scale_what_is_drawn() {
    let layer = [[200, 100, 0, 255]; 3];
    // Nothing, a fifth, and all.
    let clip = [0, 51, 255];
    for (clip, opacity) in [(None, 1.0), (None, 0.5), (Some(clip), 1.0), (Some(clip), 0.5)] {
        let mut pixels = [[100, 200, 40, 255]; 3];
        blend_group(&layer, clip.as_ref().map(|clip| &clip[..]), opacity, &mut pixels);
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
    multiply_mask(&layer, 1.0, &mut clip);
    assert_eq!(clip, [102, 0, 100]);
    multiply_mask(&layer, 0.5, &mut clip);
    assert_eq!(clip, [20, 0, 50]);
}
