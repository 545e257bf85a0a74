//! Paths of a cartoon tiger, with every second key left out.

use super::common::{apart, examples, rms, view};
use models::shared;
use serde_json::Value;
use sinew_trainer::views::fit::{FitOptions, fit};
use sinew_trainer::views::set::Parameter;

/// Largest RMS error, over that of linear interpolation between keys.
const OVER_LINEAR: f64 = 1.02;

/// A path of a Lottie file whose shape changes at keys.
struct AnimatedPath {
    /// Times of the keys in frames, ascending.
    times: Vec<f64>,
    /// Vertices of each key, then their two tangents: x and y.
    keys: Vec<Vec<[f64; 2]>>,
    /// Number of vertices.
    vertex_len: usize,
}

/// Returns the squared errors of left-out keys: by a map of the others, and by linear interpolation.
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
fn left_out_keys_are_predicted_as_well_as_by_lines() {
    let Some(file) = shared("noto-tiger/Tiger.json") else { return };
    let whole = serde_json::from_slice(&std::fs::read(&file).unwrap()).unwrap();
    let mut paths = Vec::new();
    collect(&whole, &mut paths);
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

/// Collects all animated paths of a value.
fn collect(value: &Value, out: &mut Vec<AnimatedPath>) {
    match value {
        Value::Object(fields) => {
            if fields.get("a").and_then(Value::as_f64) == Some(1.0)
                && let Some(path) = fields.get("k").and_then(animated)
            {
                out.push(path);
            } else {
                fields.values().for_each(|value| collect(value, out));
            }
        }
        Value::Array(all) => all.iter().for_each(|value| collect(value, out)),
        _ => {}
    }
}

fn animated(keys: &Value) -> Option<AnimatedPath> {
    let keys = keys.as_array()?;
    let shape = |key: &Value| -> Option<Vec<[f64; 2]>> {
        let shape = key.get("s")?.get(0)?;
        let rows = ["v", "i", "o"].map(|field| pairs(shape.get(field)?));
        let [vertices, before, after] = rows;
        let (vertices, before, after) = (vertices?, before?, after?);
        let same = vertices.len() == before.len() && before.len() == after.len();
        same.then(|| [vertices, before, after].concat())
    };
    let shapes: Vec<Vec<[f64; 2]>> = keys.iter().map(shape).collect::<Option<_>>()?;
    let times: Vec<f64> = keys.iter().map(|key| key.get("t")?.as_f64()).collect::<Option<_>>()?;
    let len = shapes.first()?.len();
    let whole = shapes.iter().all(|shape| shape.len() == len) && times.is_sorted_by(|a, b| a < b);
    whole.then_some(AnimatedPath { vertex_len: len / 3, times, keys: shapes })
}

fn pairs(value: &Value) -> Option<Vec<[f64; 2]>> {
    let pair = |pair: &Value| Some([pair.get(0)?.as_f64()?, pair.get(1)?.as_f64()?]);
    value.as_array()?.iter().map(pair).collect()
}
