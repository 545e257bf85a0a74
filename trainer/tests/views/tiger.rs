//! A cartoon tiger's paths, every second key left out.

use super::common::{apart, examples, rms, view};
use super::shared::shared;
use sinew_trainer::views::fit::{FitOptions, fit};
use sinew_trainer::views::set::{AnimatedPath, Parameter, read_lottie};

/// RMS over that of linear in-betweening.
const OVER_LINEAR: f64 = 1.02;

/// Squares of what left-out keys are missed by: by a map of the others, and by lines between them.
fn left_out(path: &AnimatedPath) -> [Vec<f64>; 2] {
    let last = path.times.len() - 1;
    let kept: Vec<usize> = (0..=last).filter(|key| key % 2 == 0 || *key == last).collect();
    let of = |key: usize| view(&[("time", path.times[key])], path.keys[key].clone());
    let train = kept.iter().map(|&key| of(key)).collect();
    let set = examples(vec![Parameter::Scalar("time".to_owned())], train);
    let map = fit(&set, &[], FitOptions { exact: true }).unwrap();
    let (mut own, mut linear) = (Vec::new(), Vec::new());
    for key in (1..last).step_by(2) {
        let found = map.shown(&of(key).values).unwrap().points;
        own.extend(apart(&found, &path.keys[key])[..path.vertex_len].to_vec());
        let after = kept.iter().position(|&other| other > key).unwrap();
        let [a, b] = [kept[after - 1], kept[after]];
        let share = (path.times[key] - path.times[a]) / (path.times[b] - path.times[a]);
        let between = path.keys[a].iter().zip(&path.keys[b]);
        let line: Vec<[f64; 2]> = between
            .map(|(a, b)| [0, 1].map(|axis| a[axis] + share * (b[axis] - a[axis])))
            .collect();
        linear.extend(apart(&line, &path.keys[key])[..path.vertex_len].to_vec());
    }
    [own, linear]
}

#[test]
fn keys_that_are_left_out_are_no_farther_than_from_lines_between_the_others() {
    let Some(file) = shared("noto-tiger/Tiger.json") else { return };
    let paths = read_lottie(&file).unwrap();
    let vertices: usize = paths.iter().map(|path| path.vertex_len).sum();
    let keys: usize = paths.iter().map(|path| path.vertex_len * path.times.len()).sum();
    assert_eq!((paths.len(), vertices, keys), (97, 743, 6406));
    let (mut own, mut linear) = (Vec::new(), Vec::new());
    for path in paths.iter().filter(|path| path.times.len() >= 4) {
        let [a, b] = left_out(path);
        own.extend(a);
        linear.extend(b);
    }
    println!("tiger: {:.3}, linear {:.3}", rms(&own), rms(&linear));
    assert!(rms(&own) <= OVER_LINEAR * rms(&linear), "{} {}", rms(&own), rms(&linear));
}

#[test]
fn keys_keep_their_own_easing() {
    let Some(file) = shared("noto-tiger/Tiger.json") else { return };
    for path in read_lottie(&file).unwrap() {
        for key in 0..path.times.len() - 1 {
            let [from, to] = [path.times[key], path.times[key + 1]];
            assert!(path.eased(key, from).abs() < 1e-9 && (path.eased(key, to) - 1.0).abs() < 1e-9);
            // x and y of the curve at its own middle, by de Casteljau.
            let [[x1, y1], [x2, y2]] = path.easing[key];
            let middle = |a: f64, b: f64| (3.0 * a + 3.0 * b + 1.0) / 8.0;
            let found = path.eased(key, from + middle(x1, x2) * (to - from));
            assert!((found - middle(y1, y2)).abs() < 1e-9, "{found}");
        }
    }
}
