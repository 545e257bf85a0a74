//! A Lottie file's animated paths: keys are examples, time is the parameter.

use super::error::SetError;
use crate::formats::FormatError;
use serde_json::Value;
use std::path::Path;

/// A path whose shape changes at keys.
#[derive(Clone, Debug, PartialEq)]
pub struct AnimatedPath {
    /// Its keys' times, in frames, ascending.
    pub times: Vec<f64>,
    /// Vertices and both of their tangents at each key: x and y of as many in all.
    pub keys: Vec<Vec<[f64; 2]>>,
    /// How many of them are vertices; they stand first.
    pub vertex_len: usize,
    /// The share of the way from a key to the next that lies behind at a share of the time: control points
    /// of a Bézier curve from (0, 0) to (1, 1).
    pub easing: Vec<[[f64; 2]; 2]>,
}

/// Reads all animated paths, in the order of the file.
///
/// # Errors
/// [`SetError`]: no JSON, or no such path.
pub fn read_lottie(path: &Path) -> Result<Vec<AnimatedPath>, SetError> {
    let whole: Value = serde_json::from_slice(&std::fs::read(path).map_err(FormatError::Read)?)?;
    let mut out = Vec::new();
    collect(&whole, &mut out);
    if out.is_empty() { Err(SetError::Lottie("it has no animated path")) } else { Ok(out) }
}

impl AnimatedPath {
    /// Returns the share of the way behind at a time between a key and the next, by the key's easing.
    pub fn eased(&self, key: usize, time: f64) -> f64 {
        let [from, to] = [self.times[key], self.times[key + 1]];
        let x = ((time - from) / (to - from)).clamp(0.0, 1.0);
        let [[x1, y1], [x2, y2]] = self.easing[key];
        let bezier = |a: f64, b: f64, t: f64| {
            let u = 1.0 - t;
            3.0 * u * u * t * a + 3.0 * u * t * t * b + t * t * t
        };
        let (mut low, mut high) = (0.0, 1.0);
        // x grows with t: sixty halvings leave nothing of f64.
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if bezier(x1, x2, middle) < x { low = middle } else { high = middle }
        }
        bezier(y1, y2, 0.5 * (low + high))
    }
}

/// Looks for paths in whatever holds them.
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
    whole.then(|| AnimatedPath {
        vertex_len: len / 3,
        easing: keys.iter().map(|key| [control(key, "o", 0.0), control(key, "i", 1.0)]).collect(),
        times,
        keys: shapes,
    })
}

fn pairs(value: &Value) -> Option<Vec<[f64; 2]>> {
    let pair = |pair: &Value| Some([pair.get(0)?.as_f64()?, pair.get(1)?.as_f64()?]);
    value.as_array()?.iter().map(pair).collect()
}

/// Reads a control point of a key's easing, on the diagonal where there is none.
fn control(key: &Value, field: &str, default: f64) -> [f64; 2] {
    let part = |axis: &str| {
        let value = key.get(field)?.get(axis)?;
        value.as_f64().or_else(|| value.get(0)?.as_f64())
    };
    [part("x").unwrap_or(default), part("y").unwrap_or(default)]
}
