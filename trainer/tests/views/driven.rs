//! Parameters and weights of key views from points of an object. Points of an instance drive its prototype.

use super::common::{apart, examples, head, most, object, turned, view, yaw_and_pitch};
use sinew_runtime::Model;
use sinew_runtime::format::Space;
use sinew_runtime::kernel::Kernel;
use sinew_trainer::bake::bake;
use sinew_trainer::views::fit::weights;
use sinew_trainer::views::fit::{FitOptions, FittedMap, fit};
use sinew_trainer::views::inverse::starts;
use sinew_trainer::views::model::parts;
use sinew_trainer::views::object::{ObjectMap, centred};
use sinew_trainer::views::player::Player;
use sinew_trainer::views::set::{Parameter, Values, View};
use sinew_trainer::views::train::train;
use sinew_trainer::views::transfer::transfer;

/// Largest error of parameters found from an instance's points, over the training range.
const FOUND: f64 = 1e-4;
/// Tolerance of points in single precision, pixels.
const RUNTIME: f64 = 1e-3;

fn of_map(map: &FittedMap) -> ObjectMap {
    ObjectMap { model: map.model.clone(), outputs: map.outputs, deformations: None }
}

/// Finds the weights of key views for points that are moved, scaled, and in part hidden.
fn weighed(map: &FittedMap, points: &[[f64; 2]], hidden: usize) -> Vec<f64> {
    let moved =
        |(k, [x, y]): (usize, &[f64; 2])| (k != hidden).then_some([0.7 * x + 31.0, 0.7 * y - 12.0]);
    let points: Vec<_> = points.iter().enumerate().map(moved).collect();
    let found = of_map(map).find(&points, &starts(&map.model)).unwrap();
    weights(&map.shown(&found.values).unwrap().scores)
}

fn near(found: &[f64], expected: &[f64], tolerance: f64) {
    let off = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(found.len() == expected.len() && off <= tolerance, "{found:?}, expected {expected:?}");
}

#[test]
fn the_number_of_starts_is_limited() {
    for (parameters, expected) in [(2, 9), (6, 729), (7, 15)] {
        let names: Vec<String> = (0..parameters).map(|at| format!("p{at}")).collect();
        // Each parameter moves its own point, and each training view moves one parameter.
        let at = |moved: Option<usize>| {
            let value = |at| f64::from(u8::from(moved == Some(at)));
            let values: Vec<(&str, f64)> =
                names.iter().enumerate().map(|(at, name)| (name.as_str(), value(at))).collect();
            let point = |at: usize| [10.0 * at as f64, 3.0 * value(at)];
            let still = [[-20.0, 0.0], [-20.0, 40.0]];
            view(&values, still.into_iter().chain((0..parameters).map(point)).collect())
        };
        let train = std::iter::once(None).chain((0..parameters).map(Some)).map(at).collect();
        let inputs = names.iter().cloned().map(Parameter::Scalar).collect();
        let map = fit(&examples(inputs, train), &[Some(0)], FitOptions::default()).unwrap();
        let all = starts(&map.model);
        assert_eq!(all.len(), expected, "{parameters}");
        for (at, values) in all.iter().enumerate() {
            assert!(values.len() == parameters && !all[..at].contains(values));
        }
        let points: Vec<_> = at(Some(1)).points;
        let found = of_map(&map).find(&points, &all).unwrap();
        assert!((found.values["p1"] - 1.0).abs() < 1e-6 && found.values["p0"].abs() < 1e-6);
    }
}

#[test]
fn points_between_two_key_views_weigh_only_these_two() {
    // A square that grows taller, in three key views along one parameter.
    let at = |x: f64| {
        let height = 10.0 * (1.0 + x);
        vec![[0.0, 0.0], [10.0, 0.0], [10.0, height], [0.0, height], [5.0, 0.5 * height]]
    };
    let train = [0.0, 1.0, 2.0].map(|x| view(&[("x", x)], at(x)));
    let set = examples(vec![Parameter::Scalar("x".to_owned())], train.into());
    let keys = [Some(0), Some(1), Some(2)];
    let map = fit(&set, &keys, FitOptions::default()).unwrap();
    for (x, expected) in [
        (0.0, [1.0, 0.0, 0.0]),
        (1.0, [0.0, 1.0, 0.0]),
        (2.0, [0.0, 0.0, 1.0]),
        (0.5, [0.5, 0.5, 0.0]),
        (1.5, [0.0, 0.5, 0.5]),
    ] {
        near(&weighed(&map, &at(x), 2), &expected, 1e-9);
    }
}

#[test]
fn points_of_a_key_view_weigh_that_view_alone() {
    let body = object(3, 12);
    let seen = |yaw: f64, pitch: f64| -> Vec<[f64; 2]> {
        let point = |p: &[f64; 3]| {
            let [x, y, _] = turned(*p, yaw, pitch);
            [100.0 + 80.0 * x, 100.0 + 80.0 * y]
        };
        body.iter().map(point).collect()
    };
    let angles = [
        [0.0, 0.0],
        [40.0, 10.0],
        [-35.0, 20.0],
        [15.0, -30.0],
        [-20.0, -15.0],
        [50.0, -25.0],
        [-50.0, 5.0],
    ];
    let train =
        angles.map(|[yaw, pitch]| view(&[("yaw", yaw), ("pitch", pitch)], seen(yaw, pitch)));
    let set = examples(vec![yaw_and_pitch()], train.into());
    let keys: Vec<_> = (0..angles.len()).map(Some).collect();
    let map = fit(&set, &keys, FitOptions::default()).unwrap();
    let plain = Some(Kernel::Linear);
    assert!(map.choice.points.kernel.is_none(), "{:?}", map.choice.points);
    assert_eq!(map.choice.visibility.kernel.map(|width| width.kernel), plain, "all is seen");
    for (number, [yaw, pitch]) in angles.into_iter().enumerate() {
        let mut expected = [0.0; 7];
        expected[number] = 1.0;
        near(&weighed(&map, &seen(yaw, pitch), 5), &expected, 1e-9);
    }
    let found = weighed(&map, &seen(5.0, 2.0), 5);
    assert!((found.iter().sum::<f64>() - 1.0).abs() < 1e-12 && found[0] > 0.5, "{found:?}");
}

/// Makes a file of the head, and a file of an instance: the head with a different deformation in each key view.
///
/// - `keys`: indices of the training views of the instance.
fn instance(keys: &[usize], by_size: bool) -> Option<[Model<Vec<u8>>; 2]> {
    let set = head()?;
    let file =
        |model| Model::from_bytes(bake(Space::default(), &parts(model).unwrap()).unwrap()).unwrap();
    let trained = train(&set, FitOptions::default()).unwrap();
    let prototype = file(&trained.model);
    let views = keys.iter().map(|&key| {
        let own = &set.maps[0].train[key];
        let wave = |[x, y]: [f64; 2]| {
            let turn = 0.03 * (y + 40.0 * key as f64);
            Some([1.15 * x + 6.0 * turn.sin() - 20.0, 0.95 * y + 5.0 * (0.04 * x).cos()])
        };
        let points = own.known().into_iter().map(wave).collect();
        (trained.model.keys[key].name.clone(), View { points, ..own.clone() })
    });
    let made = transfer(&prototype, "instance", &views.collect::<Vec<_>>(), by_size).unwrap();
    Some([prototype, file(&made)])
}

/// Returns parameters between the head's views.
fn between() -> Vec<Values> {
    let of = |[yaw, pitch, smile, open]: [f64; 4]| {
        [("yaw", yaw), ("pitch", pitch), ("smile", smile), ("jawOpen", open)]
            .map(|(name, value)| (name.to_owned(), value))
            .into()
    };
    vec![
        of([0.0, 0.0, 0.0, 0.0]),
        of([12.0, -5.0, 0.4, 0.2]),
        of([-21.0, 8.0, 0.8, 0.1]),
        of([27.0, 13.0, 0.1, 0.9]),
        of([-3.0, -11.0, 0.6, 0.6]),
    ]
}

#[test]
fn points_of_an_instance_give_its_parameters_back() {
    for (keys, by_size) in [(vec![12], false), (vec![12], true), (vec![2, 12, 22, 26], true)] {
        let Some([_, file]) = instance(&keys, by_size) else { return };
        let player = Player::new(&file, None).unwrap();
        let object = ObjectMap::new(&player);
        assert!(object.deformations.is_some());
        let (mut worst, mut off) = (0.0f64, 0.0f64);
        for values in between() {
            let played = player.play(&values).unwrap();
            let shown: Vec<[f64; 2]> =
                played.points.iter().map(|[x, y, _]| [f64::from(*x), f64::from(*y)]).collect();
            let own = object.points(&values).unwrap();
            off = off.max(most(&apart(&shown, &own)));
            near(
                &played.weights(),
                &weights(&object.outputs.evaluate(&object.model, &values).unwrap().scores),
                1e-4,
            );
            // The points are moved and enlarged, and every third point is hidden.
            let points: Vec<_> = own
                .iter()
                .enumerate()
                .map(|(k, [x, y])| (k % 3 > 0).then_some([1.3 * x - 40.0, 1.3 * y + 9.0]))
                .collect();
            let found = object.find(&points, &starts(&object.model)).unwrap();
            for (name, value) in &values {
                // Training views go from -30 to 30 degrees, and from 0 to 1.
                let range = if name == "yaw" || name == "pitch" { 60.0 } else { 1.0 };
                worst = worst.max((found.values[name] - value).abs() / range);
            }
        }
        println!(
            "{} key views: back to {worst:.1e} of the range, {off:.1e} px from the runtime",
            keys.len()
        );
        assert!(off < RUNTIME, "{off}");
        assert!(worst < FOUND, "{worst}");
    }
}

#[test]
fn one_key_view_places_the_prototype_by_the_closed_form() {
    for by_size in [false, true] {
        let Some([prototype, file]) = instance(&[12], by_size) else { return };
        let player = Player::new(&file, None).unwrap();
        let (views, object) = (player.views(), ObjectMap::new(&player));
        assert!(object.deformations.is_some());
        for values in between() {
            let own = object.points(&values).unwrap();
            let points: Vec<_> = own.iter().copied().map(Some).collect();
            let found = object.find(&points, &starts(&object.model)).unwrap();
            let moved = Player::new(&prototype, None).unwrap().play(&found.values).unwrap();
            let moved: Vec<[f64; 2]> =
                moved.points.iter().map(|[x, y, _]| [f64::from(*x), f64::from(*y)]).collect();
            // O = R + (O' - R') / s, and the centre of O'.
            let (own, centre) = centred(&own);
            let scale = f64::from(views.ratio(0).unwrap());
            let point = |k: usize| {
                let offset = views.offset(0, k).unwrap();
                [0, 1].map(|axis| (own[k][axis] - f64::from(offset[axis])) / scale + centre[axis])
            };
            let expected: Vec<_> = (0..own.len()).map(point).collect();
            let off = most(&apart(&moved, &expected));
            assert!(off < RUNTIME, "{values:?}: {off}");
        }
    }
}
