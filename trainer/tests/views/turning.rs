//! Objects that turn: rigidly, in perspective, and all the way round.

use super::common::{
    apart, examples, fitted, most, object, points, random, rms, squares, turned, view,
    yaw_and_pitch,
};
use sinew_runtime::format::Space;
use sinew_runtime::{KernelMap, Model};
use sinew_trainer::bake::bake;
use sinew_trainer::scattered::bake::part;
use sinew_trainer::scattered::model::query_numbers;
use sinew_trainer::views::fit::{FitOptions, FittedMap, fit_each, given};
use sinew_trainer::views::set::{Examples, Parameter, View};

/// Largest error of the chosen map, over that of the best candidate in hindsight.
const OVER_BEST: f64 = 1.01;
/// Distance of the eye from an object of side 2.
const EYE: f64 = 6.0;

fn orthographic(object: &[[f64; 3]], yaw: f64, pitch: f64) -> View {
    let point = |p: &[f64; 3]| {
        let [x, y, _] = turned(*p, yaw, pitch);
        [x, -y]
    };
    view(&[("yaw", yaw), ("pitch", pitch)], object.iter().map(point).collect())
}

fn perspective(object: &[[f64; 3]], yaw: f64, pitch: f64) -> View {
    let point = |p: &[f64; 3]| {
        let [x, y, z] = turned(*p, yaw, pitch);
        [x, -y].map(|x| x * EYE / (EYE - z))
    };
    view(&[("yaw", yaw), ("pitch", pitch)], object.iter().map(point).collect())
}

#[test]
fn seven_scattered_views_of_a_rigid_object_give_all_others() {
    let object = object(7, 20);
    let mut number = random(3);
    let views = (0..7).map(|_| orthographic(&object, 60.0 * number(), 40.0 * number())).collect();
    let map = fitted(&examples(vec![yaw_and_pitch()], views));
    let mut all = Vec::new();
    for _ in 0..50 {
        all.extend(squares(&map, &orthographic(&object, 170.0 * number(), 85.0 * number())));
    }
    println!("rigid: {:.1e} of a size of 1, {:?}", most(&all), map.choice.points);
    assert!(most(&all) < 1e-10, "{}", most(&all));
    let mut all = Vec::new();
    for _ in 0..50 {
        let truth = orthographic(&object, 170.0 * number(), 85.0 * number());
        all.extend(apart(&by_the_runtime(&map, &truth), &truth.known()));
    }
    println!("  at run time: {:.1e}", most(&all));
    assert!(most(&all) < 1e-5, "{}", most(&all));
}

/// Returns the points of a map in a file, in single precision.
fn by_the_runtime(map: &FittedMap, view: &View) -> Vec<[f64; 2]> {
    let bytes = bake(Space::default(), &[part(&map.model).unwrap()]).unwrap();
    let file = Model::from_bytes(bytes).unwrap();
    let kernel = file.first::<KernelMap>().unwrap();
    let inputs = &map.model.inputs;
    let query = query_numbers(inputs, &given(inputs, &view.values).unwrap()).unwrap();
    let query: Vec<f32> = query.into_iter().map(|x| x as f32).collect();
    let mut scratch = vec![0.0; kernel.counts().scratch_len()];
    let mut out = vec![0.0; kernel.result_len()];
    kernel.evaluate(&query, &mut scratch, &mut out).unwrap();
    let (points, _) = out[..3 * view.points.len()].as_chunks::<3>();
    points.iter().map(|[x, y, _]| [*x, *y].map(f64::from)).collect()
}

/// Interpolates the points of a grid of views, bilinearly in both angles.
fn bilinear(
    yaws: &[f64],
    pitches: &[f64],
    of: impl Fn(f64, f64) -> View,
    yaw: f64,
    pitch: f64,
) -> Vec<[f64; 2]> {
    let cell = |places: &[f64], at: f64| {
        let last = places.len() - 2;
        let low = (0..=last).rev().find(|&i| places[i] <= at).unwrap_or(0);
        (low, (at - places[low]) / (places[low + 1] - places[low]))
    };
    let ((i, s), (j, t)) = (cell(yaws, yaw), cell(pitches, pitch));
    let mut out = vec![[0.0; 2]; of(0.0, 0.0).points.len()];
    for (a, b, weight) in [
        (i, j, (1.0 - s) * (1.0 - t)),
        (i + 1, j, s * (1.0 - t)),
        (i, j + 1, (1.0 - s) * t),
        (i + 1, j + 1, s * t),
    ] {
        for (out, point) in out.iter_mut().zip(of(yaws[a], pitches[b]).known()) {
            (0..2).for_each(|axis| out[axis] += weight * point[axis]);
        }
    }
    out
}

#[test]
fn perspective_is_met_better_than_by_a_bilinear_grid_of_equal_size() {
    let object = object(11, 30);
    let of = |yaw, pitch| perspective(&object, yaw, pitch);
    let pitches = [-25.0, 0.0, 25.0];
    for (yaws, better) in [(&[-40.0, 0.0, 40.0][..], 6.0), (&[-40.0, -20.0, 0.0, 20.0, 40.0], 10.0)]
    {
        let grid = yaws.iter().flat_map(|&yaw| pitches.map(|pitch| of(yaw, pitch))).collect();
        let set = examples(vec![yaw_and_pitch()], grid);
        let map = fitted(&set);
        let (mut own, mut other) = (Vec::new(), Vec::new());
        let places = || {
            let all = (0..13).flat_map(|i| (0..9).map(move |j| (i, j)));
            all.map(|(i, j)| (-39.0 + 6.5 * f64::from(i), -24.0 + 6.0 * f64::from(j)))
        };
        for (yaw, pitch) in places() {
            let truth = of(yaw, pitch);
            own.extend(squares(&map, &truth));
            other.extend(apart(&bilinear(yaws, &pitches, of, yaw, pitch), &truth.known()));
        }
        let gain = rms(&other) / rms(&own);
        println!(
            "{} x 3: {:.5}, bilinear {:.5}: {gain:.1}x; {:?}",
            yaws.len(),
            rms(&own),
            rms(&other),
            map.choice.points
        );
        assert!(gain >= better, "{gain}");
        let each = fit_each(&set, &[], FitOptions::default()).unwrap();
        assert!(each.len() > 20);
        let error = |map: &FittedMap| {
            let truths = places().map(|(yaw, pitch)| of(yaw, pitch));
            rms(&truths.flat_map(|truth| squares(map, &truth)).collect::<Vec<_>>())
        };
        let best = each.iter().min_by(|a, b| error(a).total_cmp(&error(b))).unwrap();
        let over = rms(&own) / error(best);
        println!("  {over:.3}x the best of {}: {:?}", each.len(), best.choice.points);
        assert!(over <= OVER_BEST, "{over}");
    }
}

/// Returns a head in twelve views all the way round.
fn round() -> (Vec<[f64; 3]>, Examples) {
    let object = object(5, 24);
    let angles = [None, Some("yaw".to_owned()), None];
    let parameter = Parameter::Rotation { angles, order: None };
    let views = (0..12).map(|step| at(&object, 30.0 * f64::from(step))).collect();
    let set = examples(vec![parameter], views);
    (object, set)
}

fn at(object: &[[f64; 3]], yaw: f64) -> View {
    View { values: [("yaw".to_owned(), yaw)].into(), ..perspective(object, yaw, 0.0) }
}

#[test]
fn a_head_turns_through_360_degrees_without_a_seam() {
    let (object, set) = round();
    let map = fitted(&set);
    let error = |yaw: f64| rms(&squares(&map, &at(&object, yaw)));
    let errors: Vec<f64> = (0..360).map(|yaw| error(f64::from(yaw))).collect();
    let seam = (330..360).map(|yaw| errors[yaw]).fold(0.0, f64::max);
    let elsewhere = (0..330).map(|yaw| errors[yaw]).fold(0.0, f64::max);
    let of = |yaw: f64| points(&map, &[("yaw".to_owned(), yaw)].into());
    let step = |yaw: f64| most(&apart(&of(yaw), &of(yaw + 0.5)));
    let jump = step(359.5).max(step(359.75));
    let largest = (0..719).map(|half| step(0.5 * f64::from(half))).fold(0.0, f64::max);
    println!("seam {seam:.2e}, elsewhere {elsewhere:.2e}; step {jump:.2e} of {largest:.2e}");
    assert!(seam <= 1.01 * elsewhere && elsewhere < 0.01, "{seam} {elsewhere}");
    assert!(jump <= 1.01 * largest, "{jump} {largest}");
    assert!(most(&apart(&of(0.0), &of(360.0))) < 1e-12, "one place");
}
