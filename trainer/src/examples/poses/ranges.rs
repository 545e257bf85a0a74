//! Ranges of joints and curves, and poses by joint.

use crate::examples::{Examples, Matrix3x4, Split};
use crate::numeric::affine::{joined, parts, to_rows};
use crate::numeric::so3::{exp, log, polar};
use nalgebra::{Matrix3, Vector3};

/// Share of a clip's range that is added on either side. An end that is this near to the rest pose stays: an elbow must
/// not bend back, and many curves never go below 0.
const MARGIN: f64 = 0.1;
/// Smallest range that counts as motion: rotation in radians, offset in diagonals, stretch. Rounding stays below.
const LEAST: [f64; 3] = [0.01, 1e-3, 0.01];
/// Smallest range of a curve that counts as motion.
const LEAST_CURVE: f64 = 1e-3;
/// Distance in diagonals below which two joints carry a third equally well.
const CARRIES: f64 = 1e-6;

/// Motion of a joint against its carrier, in the axes of the joint's rest frame: rotation vector in radians, offset,
/// and the stretch S - I as xx, xy, xz, yy, yz, zz. The curve's value comes first for a curve.
pub(super) type Local = [f64; 12];

/// Numbers of a joint or curve that vary, each with its range. The other numbers are 0.
#[derive(Clone, Debug, Default)]
pub(super) struct Freedoms(Vec<(usize, [f64; 2])>);

impl Freedoms {
    /// Returns the number of freedoms.
    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    /// Returns whether the range of each freedom begins, and whether it ends, at rest.
    pub(super) fn rests(&self) -> Vec<[bool; 2]> {
        self.0.iter().map(|(_, range)| range.map(|end| end == 0.0)).collect()
    }

    /// Returns the numbers at some places of their ranges.
    ///
    /// - `places`: from 0 to 1, one for each freedom; `None` at rest.
    pub(super) fn values(&self, places: &[Option<f64>]) -> Local {
        let mut values = [0.0; 12];
        for ((number, [least, most]), place) in self.0.iter().zip(places) {
            values[*number] = place.map_or(0.0, |place| least + (most - least) * place);
        }
        values
    }

    /// Adds a freedom with the range of `values` and of the rest pose, if it moves.
    fn widened(&mut self, number: usize, values: impl Iterator<Item = f64>, least: f64) {
        let [low, high] = values
            .fold([0.0, 0.0], |[low, high]: [f64; 2], value| [low.min(value), high.max(value)]);
        let margin = MARGIN * (high - low);
        if high - low > least {
            let end = |end: f64| match end.abs() {
                far if far > margin => end + margin * end.signum(),
                far if far > least => end,
                _ => 0.0,
            };
            self.0.push((number, [end(low), end(high)]));
        }
    }
}

/// Returns the freedoms of every joint and curve in the training frames. Values stay finite if a frame hides a joint.
pub(super) fn of_clips(rig: &Examples, carried: &Carried<'_>) -> (Vec<Freedoms>, Vec<Freedoms>) {
    let frames = rig.frames_of(Split::Train);
    let locals: Vec<Vec<Local>> =
        frames.iter().map(|&frame| carried.locals(rig.pose(frame))).collect();
    let diagonal = rig.diagonal();
    let of_joint = |joint: usize| {
        let mut freedoms = Freedoms::default();
        for number in 0..12 {
            let least = [LEAST[0], LEAST[1] * diagonal, LEAST[2], LEAST[2]][number / 3];
            let is_removed = joint == carried.root && number < 6;
            if !is_removed {
                freedoms.widened(number, locals.iter().map(|own| own[joint][number]), least);
            }
        }
        freedoms
    };
    let of_curve = |curve: usize| {
        let mut freedoms = Freedoms::default();
        let values = frames.iter().map(|&frame| rig.curves_of(frame)[curve]);
        freedoms.widened(0, values, LEAST_CURVE);
        freedoms
    };
    let joints = (0..rig.joint_len()).map(of_joint).collect();
    (joints, (0..rig.curve_names.len()).map(of_curve).collect())
}

/// Returns freedoms without clips: every joint but the root turns by up to `degrees` about each axis, and curves go
/// from 0 to 1.
pub(super) fn of_degrees(
    rig: &Examples,
    carried: &Carried<'_>,
    degrees: f64,
) -> (Vec<Freedoms>, Vec<Freedoms>) {
    let most = degrees.to_radians();
    let of_joint = |joint| match joint == carried.root {
        true => Freedoms::default(),
        false => Freedoms([0, 1, 2].map(|axis| (axis, [-most, most])).to_vec()),
    };
    let curve = Freedoms(vec![(0, [0.0, 1.0])]);
    let joints = (0..rig.joint_len()).map(of_joint).collect();
    (joints, vec![curve; rig.curve_names.len()])
}

/// Joints of a rig, each on the joint that carries it.
pub(super) struct Carried<'a> {
    /// Rest frame of each joint, J.
    rest: &'a [Matrix3x4],
    /// Carrier of each joint, J; `None` for the root.
    pub(super) parents: Vec<Option<usize>>,
    root: usize,
    /// Joints, carriers first.
    order: Vec<usize>,
}

impl<'a> Carried<'a> {
    /// Finds the joint that carries each joint: its parent; for a further root of the source, the joint whose motion
    /// keeps the root's origin nearest to its place, over the training frames. Rigs often have deforming joints
    /// under controls that are not exported.
    pub(super) fn new(rig: &'a Examples) -> Self {
        let skeleton = &rig.skeleton;
        let (root, mut parents) = (skeleton.root(), skeleton.own_parents());
        for &joint in &skeleton.roots {
            parents[joint] = Some(carrier(rig, joint, root, &parents));
        }
        let mut order: Vec<usize> = (0..parents.len()).collect();
        order.sort_by_key(|&joint| upwards(joint, &parents).count());
        Self { rest: &skeleton.rest, parents, root, order }
    }

    /// Returns the motion of each joint in a pose, J.
    fn locals(&self, pose: &[Matrix3x4]) -> Vec<Local> {
        let polars: Vec<_> = pose.iter().map(|map| polar(&parts(map).0)).collect();
        let local = |joint: usize| {
            let (axes, origin) = parts(&self.rest[joint]);
            let (turn, stretch) = polars[joint]?;
            let (carrier_turn, inverse, shift) = match self.parents[joint] {
                Some(parent) => {
                    let (linear, shift) = parts(&pose[parent]);
                    (polars[parent]?.0, linear.try_inverse()?, shift)
                }
                None => (Matrix3::identity(), Matrix3::identity(), Vector3::zeros()),
            };
            let (linear, offset) = parts(&pose[joint]);
            let turn = log(&(axes.transpose() * carrier_turn.transpose() * turn * axes));
            let offset = axes.transpose() * (inverse * (linear * origin + offset - shift) - origin);
            let s = axes.transpose() * stretch * axes - Matrix3::identity();
            let stretch = [s.m11, s.m12, s.m13, s.m22, s.m23, s.m33];
            let mut values = [0.0; 12];
            let all = turn.iter().chain(&offset).chain(&stretch);
            values.iter_mut().zip(all).for_each(|(value, number)| *value = *number);
            Some(values)
        };
        (0..pose.len()).map(|joint| local(joint).unwrap_or_default()).collect()
    }

    /// Returns the map of each joint, J, from its motion.
    pub(super) fn pose(&self, locals: &[Local]) -> Vec<Matrix3x4> {
        let mut turns = vec![Matrix3::identity(); self.order.len()];
        let mut maps = vec![joined(&Matrix3::identity(), &Vector3::zeros()); self.order.len()];
        for &joint in &self.order {
            let (axes, origin) = parts(&self.rest[joint]);
            let [x, y, z, dx, dy, dz, xx, xy, xz, yy, yz, zz] = locals[joint];
            let stretch = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) + Matrix3::identity();
            let placed = origin + axes * Vector3::new(dx, dy, dz);
            let turn = axes * exp(&Vector3::new(x, y, z)) * axes.transpose();
            let (turn, placed) = match self.parents[joint] {
                Some(parent) => (turns[parent] * turn, maps[parent] * placed.push(1.0)),
                None => (turn, placed),
            };
            let linear = turn * axes * stretch * axes.transpose();
            turns[joint] = turn;
            maps[joint] = joined(&linear, &(placed - linear * origin));
        }
        maps.iter().map(to_rows).collect()
    }
}

/// Lists a joint and its ancestors.
pub(super) fn upwards(joint: usize, parents: &[Option<usize>]) -> impl Iterator<Item = usize> {
    std::iter::successors(Some(joint), |&joint| parents[joint])
}

/// Returns the joint that carries a further root of the source. `default` wins ties.
fn carrier(rig: &Examples, joint: usize, default: usize, parents: &[Option<usize>]) -> usize {
    let origin = Vector3::from(rig.skeleton.rest[joint].map(|row| row[3]));
    let frames = rig.frames_of(Split::Train);
    let drift = |carrier: usize| -> Option<f64> {
        let squares = frames.iter().map(|&frame| {
            let pose = rig.pose(frame);
            let [(own, offset), (linear, shift)] = [&pose[joint], &pose[carrier]].map(parts);
            let seen = linear.try_inverse()? * (own * origin + offset - shift);
            Some((seen - origin).norm_squared())
        });
        Some((squares.sum::<Option<f64>>()? / frames.len().max(1) as f64).sqrt())
    };
    let is_free = |&other: &usize| upwards(other, parents).all(|above| above != joint);
    let least = CARRIES * rig.diagonal();
    let mut best = (default, drift(default).unwrap_or(f64::INFINITY));
    for other in (0..rig.joint_len()).filter(is_free) {
        match drift(other) {
            Some(drift) if drift + least < best.1 => best = (other, drift),
            _ => {}
        }
    }
    best.0
}
