//! The negative control: networks over pixels, compared with points and warping.

use super::common::{apart, cross, head, hull, is_inside, random, rms};
use models::shared;
use sinew_trainer::views::control::{Control, NETWORKS, control, mixed, network_weights};
use sinew_trainer::views::fit::{FitOptions, fit};
use sinew_trainer::views::set::{Element, Image, LayerView, View, ViewSet, read, triangulated};
use std::f64::consts::TAU;

const SIDE: usize = 256;
/// Smallest MSE of the best network, over that of points and warping.
const WORSE: f64 = 4.0;
/// Largest share of the hull that elements leave uncovered.
const BARE: f64 = 0.01;

/// Loads a picture as numbers from 0 to 1, four for each pixel.
fn picture(image: &Image) -> Vec<f64> {
    let picture = image.load([SIDE; 2]).unwrap();
    picture.rgba.iter().map(|byte| f64::from(*byte) / 255.0).collect()
}

/// Samples a picture at a place, bilinearly.
fn sampled(picture: &[f64], [x, y]: [f64; 2]) -> [f64; 4] {
    let most = (SIDE - 1) as f64;
    let [x, y] = [x, y].map(|at| (at - 0.5).clamp(0.0, most));
    let (i, j) = ((x as usize).min(SIDE - 2), (y as usize).min(SIDE - 2));
    let (s, t) = (x - i as f64, y - j as f64);
    let at = |i: usize, j: usize, c: usize| picture[4 * (j * SIDE + i) + c];
    [0, 1, 2, 3].map(|c| {
        let above = at(i, j, c) * (1.0 - s) + at(i + 1, j, c) * s;
        let below = at(i, j + 1, c) * (1.0 - s) + at(i + 1, j + 1, c) * s;
        above * (1.0 - t) + below * t
    })
}

/// Warps a picture from reference points to other points. Pixels outside the elements are `None`.
fn warped(
    elements: &[Element],
    picture: &[f64],
    from: &[[f64; 2]],
    to: &[[f64; 2]],
    depths: &[f64],
) -> Vec<Option<[f64; 4]>> {
    let mut out = vec![None; SIDE * SIDE];
    let mut nearest = vec![f64::INFINITY; SIDE * SIDE];
    for element in elements {
        let &[a, b, c] = element.vertices() else { panic!("triangles are made of points") };
        let corners = [to[a], to[b], to[c]];
        let area = cross(corners[0], corners[1], corners[2]);
        let end = |axis: usize, least: bool| {
            let all = corners.map(|corner| corner[axis]);
            let end = if least {
                all.iter().copied().fold(f64::MAX, f64::min)
            } else {
                all.iter().copied().fold(0.0, f64::max)
            };
            (end.max(0.0) as usize).min(SIDE - 1)
        };
        for y in end(1, true)..=end(1, false) {
            for x in end(0, true)..=end(0, false) {
                let p = [x as f64 + 0.5, y as f64 + 0.5];
                let share = |u: usize, v: usize| cross(p, corners[u], corners[v]) / area;
                let shares = [share(1, 2), share(2, 0), share(0, 1)];
                if shares.iter().any(|share| *share < 0.0) {
                    continue;
                }
                let sum = |of: [f64; 3]| (0..3).map(|k| shares[k] * of[k]).sum::<f64>();
                let depth = sum([depths[a], depths[b], depths[c]]);
                if depth < nearest[y * SIDE + x] {
                    nearest[y * SIDE + x] = depth;
                    let place =
                        [0, 1].map(|axis| sum([from[a][axis], from[b][axis], from[c][axis]]));
                    out[y * SIDE + x] = Some(sampled(picture, place));
                }
            }
        }
    }
    out
}

#[test]
fn the_best_network_over_pixels_is_far_behind_points_and_warping() {
    let Some(set) = head() else { return };
    let whole = &set.maps[0];
    let pictures: Vec<Vec<f64>> =
        whole.train.iter().map(|view| picture(view.image.as_ref().unwrap())).collect();
    // Points hidden in front are part of the side. All points are triangulated at their front positions.
    let front = View { visible: vec![true; set.point_len()], ..whole.train[12].clone() };
    assert!(front.values["yaw"] == 0.0 && front.values["pitch"] == 0.0);
    let elements = triangulated(&front, &[], "front").unwrap();
    let (mut own, mut networks) = (0.0, [0.0; NETWORKS.len()]);
    let (mut inside, mut bare) = (0, 0);
    for left_out in 0..whole.train.len() {
        let mut rest = whole.clone();
        let view = rest.train.remove(left_out);
        let others: Vec<&[f64]> = (0..pictures.len())
            .filter(|&i| i != left_out)
            .map(|i| pictures[i].as_slice())
            .collect();
        let keys: Vec<Option<usize>> = (0..rest.train.len()).map(Some).collect();
        let shown = fit(&rest, &keys, FitOptions::default()).unwrap().shown(&view.values).unwrap();
        let source = shown.view().unwrap();
        let from = rest.train[source].known();
        let image = warped(&elements, others[source], &from, &shown.points, &shown.depths);
        let views: Vec<&View> = rest.train.iter().collect();
        let naive = NETWORKS.map(|network| {
            mixed(&network_weights(network, &whole.parameters, &views, &view).unwrap(), &others)
        });
        let known = view.known();
        let seen: Vec<[f64; 2]> =
            (0..known.len()).filter(|&k| view.visible[k]).map(|k| known[k]).collect();
        let hull = hull(&seen);
        for pixel in 0..SIDE * SIDE {
            if !is_inside(&hull, [(pixel % SIDE) as f64 + 0.5, (pixel / SIDE) as f64 + 0.5]) {
                continue;
            }
            inside += 1;
            let Some(found) = image[pixel] else {
                bare += 1;
                continue;
            };
            let truth = &pictures[left_out][4 * pixel..4 * pixel + 4];
            let off =
                |of: &[f64]| truth.iter().zip(of).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
            own += off(&found);
            for (sum, naive) in networks.iter_mut().zip(&naive) {
                *sum += off(&naive[4 * pixel..4 * pixel + 4]);
            }
        }
    }
    let best = networks.iter().copied().fold(f64::INFINITY, f64::min);
    println!(
        "pixels: {:.1}x the MSE (all {:?}); {bare} of {inside} pixels bare",
        best / own,
        networks.map(|sum| sum / own)
    );
    assert!(best >= WORSE * own, "{}", best / own);
    assert!(f64::from(bare) < BARE * f64::from(inside), "{bare} of {inside}");
}

fn printed(found: &Control) {
    for row in &found.rows {
        println!("{:<40} {:?} {:?}", row.name, row.psnr, row.psnr_opaque);
    }
}

#[test]
fn the_control_finds_the_same_by_the_runtimes_pictures() {
    let Some(set) = head() else { return };
    let found = control(&set, FitOptions::default()).unwrap();
    printed(&found);
    assert_eq!((found.views, found.is_left_out, found.rows.len()), (27, true, NETWORKS.len() + 2));
    let opaque = found.rows.iter().map(|row| row.psnr_opaque.unwrap()).collect::<Vec<_>>();
    let best = opaque[1..].iter().copied().fold(0.0, f64::max);
    assert!(opaque[0] - best >= 10.0 * WORSE.log10(), "{opaque:?}");
}

#[test]
fn test_views_are_predicted_where_there_are_some() {
    let Some(file) = shared("character-2d/character.json") else { return };
    let found = control(&read(&file, None).unwrap(), FitOptions::default()).unwrap();
    printed(&found);
    assert_eq!((found.views, found.is_left_out), (3, false));
    // Linear interpolation of pixels has 22.1, 21.6 and 21.1 dB on the three views, by another implementation.
    let error = |psnr: f64| 10f64.powf(-0.1 * psnr);
    let expected = -10.0 * ([22.1, 21.6, 21.1].map(error).iter().sum::<f64>() / 3.0).log10();
    let linear = &found.rows[2];
    assert!((linear.psnr.unwrap() - expected).abs() < 0.1, "{linear:?}, expected {expected}");
}

#[test]
fn sets_without_enough_whole_pictures_are_refused() {
    let Some(mut set) = head() else { return };
    let refused = |set: &ViewSet| control(set, FitOptions::default()).unwrap_err().to_string();
    set.maps[0].train.truncate(3);
    assert_eq!(refused(&set), "\"main\": expected 4 key views or more, found 3");
    let view = &mut set.maps[0].train[1];
    view.layers = vec![LayerView { image: view.image.take(), ..LayerView::default() }];
    assert_eq!(
        refused(&set),
        "main, train view 1: expected an `image` of the whole, found pictures of layers alone"
    );
    set.maps[0].train.iter_mut().for_each(|view| (view.image, view.layers) = (None, Vec::new()));
    assert_eq!(refused(&set), "there are no pictures");
}

/// Returns the discrete Fourier transform of a square picture with one channel, by definition.
fn transformed(picture: &[[f64; 2]], side: usize, sign: f64) -> Vec<[f64; 2]> {
    let rows = |of: &[[f64; 2]]| {
        let mut out = vec![[0.0; 2]; of.len()];
        for (place, out) in out.iter_mut().enumerate() {
            // The transpose of the transformed rows, so that two calls transform both axes.
            let (row, k) = (place % side, place / side);
            for x in 0..side {
                let (s, c) = (sign * TAU * ((k * x) % side) as f64 / side as f64).sin_cos();
                let [re, im] = of[row * side + x];
                out[0] += re * c - im * s;
                out[1] += re * s + im * c;
            }
        }
        out
    };
    rows(&rows(picture))
}

#[test]
fn a_fourier_transform_changes_nothing() {
    let Some(set) = head() else { return };
    const SMALL: usize = 32;
    let views: Vec<&View> = set.maps[0].train.iter().skip(1).collect();
    let mut number = random(17);
    let pictures: Vec<Vec<f64>> =
        views.iter().map(|_| (0..SMALL * SMALL).map(|_| number()).collect()).collect();
    let spectra: Vec<Vec<f64>> = pictures
        .iter()
        .map(|picture| {
            let complex: Vec<[f64; 2]> = picture.iter().map(|x| [*x, 0.0]).collect();
            transformed(&complex, SMALL, -1.0).into_flattened()
        })
        .collect();
    for network in NETWORKS {
        let at = &set.maps[0].train[0];
        let own = network_weights(network, &set.maps[0].parameters, &views, at).unwrap();
        let direct = mixed(&own, &pictures.iter().map(Vec::as_slice).collect::<Vec<_>>());
        let spectrum = mixed(&own, &spectra.iter().map(Vec::as_slice).collect::<Vec<_>>());
        let (spectrum, _) = spectrum.as_chunks::<2>();
        let back = transformed(spectrum, SMALL, 1.0);
        let count = (SMALL * SMALL) as f64;
        let off = direct
            .iter()
            .zip(&back)
            .map(|(a, [re, im])| (a - re / count).abs().max(im.abs() / count));
        let off = off.fold(0.0, f64::max);
        assert!(off < 1e-9, "{network:?}: {off}");
    }
}

#[test]
fn a_network_gives_back_its_own_pictures() {
    let Some(set) = head() else { return };
    let views: Vec<&View> = set.maps[0].train.iter().collect();
    for network in NETWORKS {
        let found = network_weights(network, &set.maps[0].parameters, &views, views[4]).unwrap();
        let own: Vec<[f64; 2]> = found.iter().map(|weight| [*weight, 0.0]).collect();
        let mut expected = vec![[0.0; 2]; 27];
        expected[4] = [1.0, 0.0];
        assert!(rms(&apart(&own, &expected)) < 1e-6, "{network:?}");
    }
}
