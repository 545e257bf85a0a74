//! The animations of a glTF file: keys of nodes and morph weights, and their interpolation.

use super::file::{Parsed, numbers, other_count, unnamed_clip};
use super::nodes::Local;
use crate::Error;
use crate::formats::scene::faults;
use gltf::Animation;
use gltf::animation::{Interpolation, Property};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// An animation.
pub(super) struct ClipKeys {
    /// Name of the animation; made up if the file has none.
    pub(super) name: String,
    channels: Vec<Channel>,
}

impl ClipKeys {
    /// Reads every animation.
    ///
    /// # Errors
    /// An accessor cannot be read, counts of keys and values differ, or key times are not ascending.
    pub(super) fn read(file: &Parsed) -> Result<Vec<Self>, Error> {
        file.document.animations().map(|animation| Self::read_one(&animation, file)).collect()
    }

    fn read_one(animation: &Animation<'_>, file: &Parsed) -> Result<Self, Error> {
        let name = match animation.name() {
            Some(name) => name.to_owned(),
            None => unnamed_clip(animation.index()),
        };
        let mut channels = Vec::new();
        for channel in animation.channels() {
            let (target, sampler) = (channel.target(), channel.sampler());
            let (node, property) = (target.node(), target.property());
            let (width, components) = match property {
                Property::Translation | Property::Scale => (3, 3),
                Property::Rotation => (4, 4),
                // Weights are stored one number at a time.
                Property::MorphTargetWeights => {
                    let primitives = node.mesh().and_then(|mesh| mesh.primitives().next());
                    (primitives.map_or(0, |primitive| primitive.morph_targets().len()), 1)
                }
            };
            let times = numbers(&sampler.input(), &file.buffers, 1)?;
            let values = numbers(&sampler.output(), &file.buffers, components)?;
            let interpolation = sampler.interpolation();
            let per_key =
                if interpolation == Interpolation::CubicSpline { 3 * width } else { width };
            let (expected, found) = (per_key * times.len(), values.len());
            if expected != found || times.is_empty() {
                let place = format!("clip {name}, channel {}", channel.index());
                return Err(other_count(place, "numbers", expected, found));
            }
            if !times.is_sorted_by(|a, b| a < b) {
                return Err(faults::key_times(&name));
            }
            let node = node.index();
            channels.push(Channel { node, property, times, width, values, interpolation });
        }
        Ok(Self { name, channels })
    }

    /// Lists the key times of the channels that move a node of one set or shape a node of another set.
    pub(super) fn times(
        &self,
        moves: impl Fn(usize) -> bool,
        shapes: impl Fn(usize) -> bool,
    ) -> Vec<f64> {
        let matters = |channel: &&Channel| match channel.property {
            Property::MorphTargetWeights => shapes(channel.node),
            _ => moves(channel.node),
        };
        let channels = self.channels.iter().filter(matters);
        channels.flat_map(|channel| channel.times.iter().copied()).collect()
    }

    /// Returns whether the animation changes morph weights of one of some nodes.
    pub(super) fn shapes(&self, nodes: impl Fn(usize) -> bool) -> bool {
        let weights = |c: &Channel| c.property == Property::MorphTargetWeights && nodes(c.node);
        self.channels.iter().any(weights)
    }

    /// Sets the animated transforms of nodes and the animated weights of morph targets to their values at a time.
    pub(super) fn apply(&self, time: f64, locals: &mut [Local], weights: &mut [Vec<f64>]) {
        for channel in &self.channels {
            let value = channel.at(time);
            match (channel.property, &mut locals[channel.node]) {
                (Property::MorphTargetWeights, _) => weights[channel.node] = value,
                (_, Local::Matrix(_)) => {}
                (Property::Rotation, Local::Parts { rotation, .. }) => {
                    *rotation = quaternion(&value)
                }
                (Property::Translation, Local::Parts { translation: vector, .. })
                | (Property::Scale, Local::Parts { scale: vector, .. }) => {
                    *vector = Vector3::from_column_slice(&value);
                }
            }
        }
    }
}

/// The keys of one property of one node.
struct Channel {
    node: usize,
    property: Property,
    times: Vec<f64>,
    /// Numbers in a value: 3, 4, or the number of morph targets of the node's mesh.
    width: usize,
    /// Values; for cubic splines, the in-tangent, value and out-tangent of each key.
    values: Vec<f64>,
    interpolation: Interpolation,
}

impl Channel {
    /// Interpolates as glTF 2.0, appendix C, specifies.
    fn at(&self, time: f64) -> Vec<f64> {
        let after = self.times.partition_point(|&key| key <= time);
        let Some(before) = after.checked_sub(1) else { return self.key(0).to_vec() };
        if after == self.times.len() {
            return self.key(before).to_vec();
        }
        let step = self.times[after] - self.times[before];
        let t = (time - self.times[before]) / step;
        let (a, b) = (self.key(before), self.key(after));
        match self.interpolation {
            Interpolation::Step => a.to_vec(),
            Interpolation::Linear if self.property == Property::Rotation => {
                let [a, b] = [a, b].map(|key| UnitQuaternion::from_quaternion(quaternion(key)));
                a.try_slerp(&b, t, 1e-12).unwrap_or(a).coords.as_slice().to_vec()
            }
            Interpolation::Linear => a.iter().zip(b).map(|(a, b)| a + t * (b - a)).collect(),
            Interpolation::CubicSpline => {
                let (out, into) = (self.tangents(before).1, self.tangents(after).0);
                let (t2, t3) = (t * t, t * t * t);
                let value = |i: usize| {
                    (2.0 * t3 - 3.0 * t2 + 1.0) * a[i]
                        + step * (t3 - 2.0 * t2 + t) * out[i]
                        + (3.0 * t2 - 2.0 * t3) * b[i]
                        + step * (t3 - t2) * into[i]
                };
                (0..self.width).map(value).collect()
            }
        }
    }

    /// Returns the value of a key.
    fn key(&self, key: usize) -> &[f64] {
        match self.interpolation {
            Interpolation::CubicSpline => &self.values[(3 * key + 1) * self.width..][..self.width],
            _ => &self.values[key * self.width..][..self.width],
        }
    }

    /// Returns the tangents into a key and out of it.
    fn tangents(&self, key: usize) -> (&[f64], &[f64]) {
        let key = &self.values[3 * key * self.width..][..3 * self.width];
        (&key[..self.width], &key[2 * self.width..])
    }
}

fn quaternion(xyzw: &[f64]) -> Quaternion<f64> {
    Quaternion::new(xyzw[3], xyzw[0], xyzw[1], xyzw[2])
}
