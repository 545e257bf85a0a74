//! Keys between the keys of a clip, where the motion of helpers is not even.

use nalgebra::{Isometry3, Matrix4, Point3, Vector3};
use rayon::prelude::*;

use super::skeleton::{isometry, parents_first, square};
use super::stretch::Stretch;
use crate::envelope::levels::Influences;
use crate::examples::{Matrix3x4, Skeleton};

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
    /// The palette that the runtime predicts.
    pub(super) palette: Vec<sinew_runtime::Matrix3x4>,
}

/// The motion of an exported skin between keys. Joints rotate evenly relative to their parents. Proxies move and
/// stretch evenly relative to the joints that carry them.
pub(super) struct Between {
    /// Rest frames of the joints.
    rest: Vec<Matrix4<f64>>,
    parents: Vec<Option<usize>>,
    order: Vec<usize>,
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

impl Between {
    /// Prepares the test of a skin.
    ///
    /// - the proxies: their centres, and the joints that carry them.
    /// - `mesh`: rest positions and influences on the palette.
    /// - `first_proxy`: index of the first proxy in the palette.
    pub(super) fn new(
        skeleton: &Skeleton,
        (centres, carriers): (&[[f64; 3]], &[usize]),
        mesh: (&[[f64; 3]], &Influences),
        first_proxy: usize,
        diagonal: f64,
    ) -> Self {
        let parents = skeleton.own_parents();
        let follower = |(x, list): (&[f64; 3], &Vec<(usize, f64)>)| {
            let proxies =
                list.iter().filter_map(|&(map, w)| Some((map.checked_sub(first_proxy)?, w)));
            Follower { rest: Point3::from(*x), proxies: proxies.collect() }
        };
        let followers = mesh.0.iter().zip(mesh.1).map(follower);
        Self {
            rest: skeleton.rest.iter().map(square).collect(),
            order: parents_first(&parents),
            parents,
            proxies: centres.iter().map(|&c| c.into()).zip(carriers.iter().copied()).collect(),
            followers: followers.filter(|follower| !follower.proxies.is_empty()).collect(),
            near: NEAR * diagonal,
        }
    }

    /// Adds keys to a clip until the skin between any two keys is within the bound. A jump has no room for keys.
    ///
    /// # Errors
    /// The errors of `palette`, which predicts the palette of a pose.
    pub(super) fn refine<E: Send>(
        &self,
        keys: Vec<Key>,
        palette: impl Fn(&[Matrix3x4]) -> Result<Vec<sinew_runtime::Matrix3x4>, E> + Sync,
    ) -> Result<Vec<Key>, E> {
        let steps =
            keys.par_windows(2).map(|pair| self.step(&pair[0], &pair[1], &palette, HALVINGS));
        let mut steps = steps.collect::<Result<Vec<_>, E>>()?.into_iter();
        let more = keys.into_iter().map(|key| (key, steps.next().unwrap_or_default()));
        Ok(more.flat_map(|(key, step)| std::iter::once(key).chain(step)).collect())
    }

    fn step<E>(
        &self,
        from: &Key,
        to: &Key,
        palette: &impl Fn(&[Matrix3x4]) -> Result<Vec<sinew_runtime::Matrix3x4>, E>,
        halvings: u32,
    ) -> Result<Vec<Key>, E> {
        let time = 0.5 * (from.time + to.time);
        if halvings == 0 || !(from.time.next_up() < time && time < to.time.next_down()) {
            return Ok(Vec::new());
        }
        let at = |part: f64| {
            let pose = self.pose(from, to, part);
            let palette = palette(&pose)?;
            Ok(Key { time, pose, palette })
        };
        let is_near = |part| Ok(self.deviation(from, to, part, &at(part)?) <= self.near);
        if PARTS.into_iter().try_fold(true, |near, part| Ok(near && is_near(part)?))? {
            return Ok(Vec::new());
        }
        let middle = at(0.5)?;
        let mut keys = self.step(from, &middle, palette, halvings - 1)?;
        let after = self.step(&middle, to, palette, halvings - 1)?;
        keys.push(middle);
        keys.extend(after);
        Ok(keys)
    }

    /// Interpolates the joints of two keys like linear tracks.
    fn pose(&self, from: &Key, to: &Key, part: f64) -> Vec<Matrix3x4> {
        let worlds = |key: &Key| -> Vec<Isometry3<f64>> {
            key.pose
                .iter()
                .zip(&self.rest)
                .map(|(map, rest)| isometry(&(square(map) * rest)))
                .collect()
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
        let map = |(world, rest): (&Isometry3<f64>, &Matrix4<f64>)| {
            let back = rest.try_inverse().unwrap_or_else(Matrix4::identity);
            let map = world.to_homogeneous() * back;
            [0, 1, 2].map(|row| [0, 1, 2, 3].map(|column| map[(row, column)]))
        };
        reached.iter().zip(&self.rest).map(map).collect()
    }

    /// Returns the largest distance of a vertex from its true position, with even motion from key to key.
    fn deviation(&self, from: &Key, to: &Key, part: f64, truth: &Key) -> f64 {
        let first = truth.palette.len() - self.proxies.len();
        let error = |(number, (centre, carrier)): (usize, &(Point3<f64>, usize))| {
            let under = |key: &Key| {
                let joint = square(&key.pose[*carrier]);
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

fn wide(map: &sinew_runtime::Matrix3x4) -> Matrix4<f64> {
    square(&map.map(|row| row.map(f64::from)))
}
