//! Keys between the keys of a clip, where the motion of helpers is not even.

use nalgebra::{Isometry3, Matrix4, Point3, Vector3};
use rayon::prelude::*;
use sinew_runtime::Envelope;

use super::played::Played;
use super::skeleton::{isometry, parents_first, rows, square, wide};
use super::stretch::Stretch;
use crate::Error;
use crate::envelope::posed::{Pose, palette};
use crate::examples::Matrix3x4;

/// Largest distance of a vertex from its true position between two keys, in diagonals: half the bound in `--help`.
const NEAR: f64 = 5e-4;
/// Largest number of times that the step between two keys is halved.
const HALVINGS: u32 = 6;
/// Parts of the step at which the skin is compared.
const PARTS: [f64; 3] = [0.25, 0.5, 0.75];

/// A key of a clip.
pub(super) struct Key {
    /// Time in seconds.
    pub(super) time: f32,
    /// Maps of the joints from rest to the pose.
    pub(super) pose: Vec<Matrix3x4>,
    /// Curves of the envelope.
    pub(super) curves: Vec<f64>,
    /// The palette that the runtime predicts.
    pub(super) palette: Vec<sinew_runtime::Matrix3x4>,
}

/// The motion of an exported skin between keys. Joints rotate evenly relative to their parents, and stretch evenly.
/// Proxies move and stretch evenly relative to the rigid parts of the joints that carry them.
pub(super) struct Between<'a> {
    /// Predicts the palettes of new keys.
    envelope: Envelope<'a>,
    /// Rest frames of the joints.
    rest: Vec<Matrix4<f64>>,
    parents: Vec<Option<usize>>,
    order: Vec<usize>,
    stretching: Vec<bool>,
    /// Centre of each proxy, and the joint that carries it. Proxies are last in the palette.
    proxies: Vec<(Point3<f64>, usize)>,
    /// Vertices that follow proxies.
    followers: Vec<Follower>,
    /// Largest distance of a vertex from its true position.
    near: f64,
}

/// Rest position of a vertex, and its proxies with weights.
struct Follower {
    rest: Point3<f64>,
    proxies: Vec<(usize, f64)>,
}

impl<'a> Between<'a> {
    /// Prepares the test of a played skin; `diagonal` is that of the rest mesh.
    pub(super) fn new(played: &Played<'a>, diagonal: f64) -> Self {
        let (skeleton, first_proxy) = (&played.skeleton, played.first_proxy());
        let parents = skeleton.own_parents();
        let follower = |(x, list): (&[f64; 3], &Vec<(usize, f64)>)| {
            let proxies =
                list.iter().filter_map(|&(map, w)| Some((map.checked_sub(first_proxy)?, w)));
            Follower { rest: Point3::from(*x), proxies: proxies.collect() }
        };
        let followers = played.rest.iter().zip(&played.influences).map(follower);
        let centres = played.centres.iter().map(|&centre| Point3::from(centre));
        Self {
            envelope: played.character.envelope,
            rest: skeleton.rest.iter().map(square).collect(),
            order: parents_first(&parents),
            parents,
            stretching: played.stretching.clone(),
            proxies: centres.zip(played.carriers.iter().copied()).collect(),
            followers: followers.filter(|follower| !follower.proxies.is_empty()).collect(),
            near: NEAR * diagonal,
        }
    }

    /// Adds keys to a clip until the skin between any two keys is within the bound. A jump has no room for keys.
    ///
    /// # Errors
    /// The runtime refuses a pose; the error names `frame`.
    pub(super) fn refine(&self, keys: Vec<Key>, frame: usize) -> Result<Vec<Key>, Error> {
        let steps = keys.par_windows(2).map(|pair| self.step(&pair[0], &pair[1], frame, HALVINGS));
        let mut steps = steps.collect::<Result<Vec<_>, Error>>()?.into_iter();
        let more = keys.into_iter().map(|key| (key, steps.next().unwrap_or_default()));
        Ok(more.flat_map(|(key, step)| std::iter::once(key).chain(step)).collect())
    }

    fn step(&self, from: &Key, to: &Key, frame: usize, halvings: u32) -> Result<Vec<Key>, Error> {
        let time = 0.5 * (from.time + to.time);
        if halvings == 0 || !(from.time.next_up() < time && time < to.time.next_down()) {
            return Ok(Vec::new());
        }
        let at = |part: f64| -> Result<Key, Error> {
            let pose = self.pose(from, to, part);
            let curves = from.curves.iter().zip(&to.curves);
            let curves: Vec<f64> = curves.map(|(a, b)| a + part * (b - a)).collect();
            let own = Pose::new(&self.envelope, &pose, &curves);
            let (palette, _) = palette(&self.envelope, &own, frame)?;
            Ok(Key { time, pose, curves, palette })
        };
        let is_near = |part| -> Result<bool, Error> {
            Ok(self.deviation(from, to, part, &at(part)?) <= self.near)
        };
        if PARTS.into_iter().try_fold(true, |near, part| Ok::<_, Error>(near && is_near(part)?))? {
            return Ok(Vec::new());
        }
        let middle = at(0.5)?;
        let mut keys = self.step(from, &middle, frame, halvings - 1)?;
        let after = self.step(&middle, to, frame, halvings - 1)?;
        keys.push(middle);
        keys.extend(after);
        Ok(keys)
    }

    /// Interpolates the joints of two keys like linear tracks.
    fn pose(&self, from: &Key, to: &Key, part: f64) -> Vec<Matrix3x4> {
        let keys = [from, to];
        let worlds = |key: &Key| -> Vec<Isometry3<f64>> {
            let maps = key.pose.iter().zip(&self.rest);
            maps.map(|(map, rest)| isometry(&(square(map) * rest))).collect()
        };
        let (from, to) = (worlds(from), worlds(to));
        let mut reached = vec![Isometry3::identity(); from.len()];
        for &joint in &self.order {
            let parent = self.parents[joint];
            let local = |worlds: &[Isometry3<f64>]| {
                parent.map_or(worlds[joint], |parent| worlds[parent].inverse() * worlds[joint])
            };
            let (a, b) = (local(&from), local(&to));
            let turn = a.rotation.try_slerp(&b.rotation, part, 1e-12).unwrap_or(a.rotation);
            let place = a.translation.vector.lerp(&b.translation.vector, part);
            let own = Isometry3::from_parts(place.into(), turn);
            reached[joint] = parent.map_or(own, |parent| reached[parent] * own);
        }
        let map = |(joint, world): (usize, &Isometry3<f64>)| {
            let world = world.to_homogeneous() * self.back(joint);
            if !self.stretching[joint] {
                return rows(&world);
            }
            let stretches = keys.map(|key| {
                let map = square(&key.pose[joint]);
                let rigid = self.rigid(joint, &key.pose[joint]);
                (rigid.try_inverse().unwrap_or_else(Matrix4::identity) * map)
                    .fixed_view::<3, 3>(0, 0)
                    .into_owned()
            });
            // The joint stretches about its origin.
            let mut stretch = Stretch::between(&stretches, part).to_homogeneous();
            let origin = self.rest[joint].fixed_view::<3, 1>(0, 3).into_owned();
            let moved = origin - stretch.fixed_view::<3, 3>(0, 0) * origin;
            stretch.fixed_view_mut::<3, 1>(0, 3).copy_from(&moved);
            rows(&(world * stretch))
        };
        reached.iter().enumerate().map(map).collect()
    }

    /// Returns the inverse of a joint's rest frame.
    fn back(&self, joint: usize) -> Matrix4<f64> {
        self.rest[joint].try_inverse().unwrap_or_else(Matrix4::identity)
    }

    /// Returns the rigid part of a joint's map, which the joint's node holds.
    fn rigid(&self, joint: usize, map: &Matrix3x4) -> Matrix4<f64> {
        let map = square(map);
        match self.stretching[joint] {
            true => isometry(&(map * self.rest[joint])).to_homogeneous() * self.back(joint),
            false => map,
        }
    }

    /// Returns the largest distance of a vertex from its true position, with even motion from key to key.
    fn deviation(&self, from: &Key, to: &Key, part: f64, truth: &Key) -> f64 {
        let first = truth.palette.len() - self.proxies.len();
        let error = |(number, (centre, carrier)): (usize, &(Point3<f64>, usize))| {
            let under = |key: &Key| {
                let joint = self.rigid(*carrier, &key.pose[*carrier]);
                let back = joint.try_inverse().unwrap_or_else(Matrix4::identity);
                (joint, back * wide(&key.palette[first + number]))
            };
            let ((_, a), (_, b), (joint, own)) = (under(from), under(to), under(truth));
            let place = |map: &Matrix4<f64>| map.transform_point(centre).coords;
            let stretches = [&a, &b].map(|map| map.fixed_view::<3, 3>(0, 0).into_owned());
            let mut found = Stretch::between(&stretches, part).to_homogeneous();
            let moved = place(&a).lerp(&place(&b), part) - place(&found);
            found.fixed_view_mut::<3, 1>(0, 3).copy_from(&moved);
            joint * (found - own)
        };
        let errors: Vec<Matrix4<f64>> = self.proxies.iter().enumerate().map(error).collect();
        let off = |Follower { rest, proxies }: &Follower| {
            let moved =
                |&(proxy, w): &(usize, f64)| w * (errors[proxy] * rest.to_homogeneous()).xyz();
            proxies.iter().map(moved).sum::<Vector3<f64>>().norm()
        };
        self.followers.iter().map(off).fold(0.0, f64::max)
    }
}
