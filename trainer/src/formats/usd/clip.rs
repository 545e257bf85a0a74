//! Animations of a document as `SkelAnimation`.

use ::gltf::Animation;
use ::gltf::animation::Interpolation;
use ::gltf::animation::util::ReadOutputs;
use half::f16;
use serde_json::Value;

use super::rig::{Arrays, Local, Rig};
use super::text::{Text, list, quoted, texts, tuple};
use crate::formats::gltf::write::before_jumps;

/// An animation: the transform of every joint at every key.
pub(super) struct Clip {
    pub(super) name: String,
    /// Key times in seconds.
    pub(super) times: Vec<f32>,
    /// Transforms of the joints at each key.
    keys: Vec<Vec<Local>>,
    /// Names of the curves.
    curves: Vec<String>,
    /// Values of the curves at each key.
    values: Vec<Vec<f64>>,
}

/// Conversion of seconds to time codes.
pub(super) struct TimeCodes {
    /// Time codes a second.
    pub(super) rate: f64,
}

/// Relative distance of a time code from an integer below which it is the integer: the rounding of single precision.
const WHOLE: f64 = 1e-6;
/// Relative distance of a key before a jump from the jump.
const JUMP: f64 = 1e-7;

impl TimeCodes {
    /// Returns the time codes of keys. They ascend, with a key right before each jump.
    fn of(&self, times: &[f32]) -> Vec<f64> {
        let code = |&time: &f32| {
            let code = f64::from(time) * self.rate;
            let whole = code.round();
            if (code - whole).abs() <= WHOLE * whole.max(1.0) { whole } else { code }
        };
        let mut codes: Vec<f64> = times.iter().map(code).collect();
        for key in before_jumps(times) {
            codes[key] = codes[key + 1] * (1.0 - JUMP);
        }
        codes
    }

    /// Returns the first and the last time code of keys.
    pub(super) fn range(&self, times: &[f32]) -> Option<[f64; 2]> {
        let codes = self.of(times);
        Some([*codes.first()?, *codes.last()?])
    }
}

impl Clip {
    /// Reads the keys of an animation. Values that hold get a further key before each step.
    pub(super) fn read(animation: &Animation<'_>, rig: &Rig, arrays: Arrays<'_>) -> Self {
        let mut times: Vec<f32> = Vec::new();
        let mut steps: Vec<f32> = Vec::new();
        for channel in animation.channels() {
            let own = channel.reader(arrays).read_inputs().into_iter().flatten();
            match channel.sampler().interpolation() {
                Interpolation::Step => steps.extend(own.flat_map(|t| [t.next_down(), t])),
                _ => times.extend(own),
            }
        }
        if times.is_empty() {
            times = steps.into_iter().filter(|&time| time >= 0.0).collect();
        }
        times.sort_by(f32::total_cmp);
        times.dedup();
        let rest: Vec<Local> = rig.joints.iter().map(|joint| joint.rest).collect();
        let mut keys = vec![rest; times.len()];
        for channel in animation.channels() {
            let Some(&joint) = rig.of_node.get(&channel.target().node().index()) else { continue };
            let reader = channel.reader(arrays);
            let own: Vec<f32> = reader.read_inputs().into_iter().flatten().collect();
            // The last key at or before each time; tracks that do not hold have a key at every time.
            let at = times.iter().map(|time| own.partition_point(|own| own <= time).max(1) - 1);
            let keys = keys.iter_mut().map(|key| &mut key[joint]).zip(at);
            match reader.read_outputs() {
                Some(ReadOutputs::Translations(all)) => {
                    let all: Vec<_> = all.collect();
                    keys.for_each(|(key, at)| key.translation = all[at]);
                }
                Some(ReadOutputs::Rotations(all)) => {
                    let all: Vec<_> = all.into_f32().collect();
                    keys.for_each(|(key, at)| key.rotation = all[at]);
                }
                Some(ReadOutputs::Scales(all)) => {
                    let all: Vec<_> = all.collect();
                    keys.for_each(|(key, at)| key.scale = all[at]);
                }
                _ => {}
            }
        }
        let (curves, values) = curves(animation).unwrap_or_default();
        Self { name: animation.name().unwrap_or("clip").to_owned(), times, keys, curves, values }
    }

    /// Writes the animation; `joints` is the list of the skeleton's joints.
    pub(super) fn write(&self, text: &mut Text, joints: &str, codes: &TimeCodes, name: &str) {
        text.open(
            &format!("def SkelAnimation {}", quoted(name)),
            &[&format!("displayName = {}", quoted(&self.name))],
        );
        text.line(&format!("uniform token[] joints = {joints}"));
        let codes = codes.of(&self.times);
        let mut samples = |attribute: &str, value: &dyn Fn(usize) -> String| {
            text.line(&format!("{attribute}.timeSamples = {{"));
            for (key, code) in codes.iter().enumerate() {
                text.line(&format!("    {code}: {},", value(key)));
            }
            text.line("}");
        };
        let all = |key: usize, write: fn(&Local) -> String| list(self.keys[key].iter().map(write));
        samples("float3[] translations", &|key| all(key, |local| tuple(local.translation)));
        samples("quatf[] rotations", &|key| {
            all(key, |&Local { rotation: [x, y, z, w], .. }| tuple([w, x, y, z]))
        });
        samples("half3[] scales", &|key| {
            all(key, |local| tuple(local.scale.map(|factor| f16::from_f32(factor).to_f32())))
        });
        if !self.curves.is_empty() {
            samples("custom float[] sinew:curveValues", &|key| list(self.values[key].iter()));
            let names: Vec<&str> = self.curves.iter().map(String::as_str).collect();
            text.line(&format!("custom uniform token[] sinew:curves = {}", texts(&names)));
        }
        text.close();
    }
}

/// Reads names and values of the curves from an animation's extras.
fn curves(animation: &Animation<'_>) -> Option<(Vec<String>, Vec<Vec<f64>>)> {
    let extras = animation.extras().as_ref()?;
    let mut extras: Value = serde_json::from_str(extras.get()).ok()?;
    let curves = extras.get_mut("curves")?;
    let names = serde_json::from_value(curves.get_mut("names")?.take()).ok()?;
    let values = serde_json::from_value(curves.get_mut("values")?.take()).ok()?;
    Some((names, values))
}
