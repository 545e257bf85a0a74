//! Poses and surface trajectories with the reference root's motion removed (METHOD §1.1).

use crate::examples::{Examples, RIGID};
use crate::numeric::affine::{
    Strain, after, from_rows, homogeneous, joined, linear, strain, strain_norm,
};
use crate::numeric::{columns, so3};
use faer::Mat;
use nalgebra::{Matrix3, Matrix3x4, Vector3};

/// Smallest number of training poses: one row of H has six unknowns.
pub const MIN_POSES: usize = 6;
/// Entries of joint transforms, with lengths in diagonals, are equal if they differ by at most this: such a motion is
/// invisible. So are curves whose values differ by at most this.
pub const EQUAL: f64 = 1e-4;

/// n poses of J joints, relative to the reference root.
#[derive(Clone, Debug)]
pub struct Poses {
    joint_len: usize,
    root: usize,
    maps: Vec<Matrix3x4<f64>>,
    angles: Vec<Vector3<f64>>,
    parent_rotations: Vec<Matrix3<f64>>,
    /// Strains, n x J; empty if no joint stretches.
    strains: Vec<Strain>,
    roots: Vec<Matrix3x4<f64>>,
    /// Curves, n x C.
    curves: Vec<f64>,
    /// Range of each curve over the poses, C.
    curve_ranges: Vec<[f64; 2]>,
    times: Vec<Time>,
}

/// Clip and frame of a pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Time {
    /// Index of the clip.
    pub clip: usize,
    /// Index of the frame.
    pub frame: usize,
}

impl Poses {
    /// Reads the given frames of the examples.
    pub fn new(examples: &Examples, frames: &[usize]) -> Self {
        let skeleton = &examples.skeleton;
        let mut poses = Self {
            joint_len: skeleton.names.len(),
            root: skeleton.root(),
            maps: Vec::new(),
            angles: Vec::new(),
            parent_rotations: Vec::new(),
            strains: Vec::new(),
            roots: Vec::new(),
            curves: Vec::new(),
            curve_ranges: vec![[f64::INFINITY, f64::NEG_INFINITY]; examples.curve_names.len()],
            times: Vec::new(),
        };
        let stretching = examples.stretching_joints();
        let stretches = stretching.contains(&true);
        for &frame in frames {
            let pose: Vec<_> = examples.pose(frame).iter().map(from_rows).collect();
            let inverse = inverse(&pose[poses.root], stretching[poses.root]);
            let maps: Vec<_> = pose.iter().map(|b| after(&inverse, b)).collect();
            let turns: Vec<_> = pose.iter().map(nearest_rotation).collect();
            let rotation = |joint: usize| turns[poses.root].transpose() * turns[joint];
            for (joint, parent) in skeleton.parents.iter().enumerate() {
                let frame_of_parent = parent.map_or(Matrix3::identity(), rotation);
                let relative = parent.map(|p| turns[p].transpose() * turns[joint]);
                poses.angles.push(relative.map_or(Vector3::zeros(), |turn| so3::log(&turn)));
                poses.parent_rotations.push(frame_of_parent);
            }
            if stretches {
                let all = pose.iter().zip(&stretching);
                poses.strains.extend(all.map(|(map, stretches)| {
                    if *stretches { strain(&linear(map)) } else { Strain::default() }
                }));
            }
            poses.maps.extend(maps);
            poses.roots.push(pose[poses.root]);
            poses.curves.extend(examples.curves_of(frame));
            for (range, value) in poses.curve_ranges.iter_mut().zip(examples.curves_of(frame)) {
                *range = [range[0].min(*value), range[1].max(*value)];
            }
            poses.times.push(Time { clip: examples.clip_of(frame), frame });
        }
        poses
    }

    /// Returns n.
    pub fn len(&self) -> usize {
        self.roots.len()
    }

    /// Returns whether there is no pose.
    pub fn is_empty(&self) -> bool {
        self.roots.is_empty()
    }

    /// Returns J.
    pub fn joint_len(&self) -> usize {
        self.joint_len
    }

    /// Returns r, the reference root.
    pub fn root(&self) -> usize {
        self.root
    }

    /// Returns clip and frame of each of the n poses, in order.
    pub fn times(&self) -> &[Time] {
        &self.times
    }

    /// Lists the frames of the n poses.
    pub fn frames(&self) -> Vec<usize> {
        self.times.iter().map(|time| time.frame).collect()
    }

    /// Returns `B_r⁻¹ B_j` of a pose.
    pub fn map(&self, pose: usize, joint: usize) -> &Matrix3x4<f64> {
        &self.maps[pose * self.joint_len + joint]
    }

    /// Returns the J maps of a pose in a space where the root's stretch is as in the examples, and the map from there to
    /// the root's frame. Rotations of joints are defined before the root's stretch is removed.
    pub fn in_model_space(&self, pose: usize) -> (Vec<Matrix3x4<f64>>, Matrix3x4<f64>) {
        if !self.stretch() {
            return (self.pose(pose).to_vec(), Matrix3x4::identity());
        }
        let root = &self.roots[pose];
        let inverse = inverse(root, true);
        (self.pose(pose).iter().map(|map| after(root, map)).collect(), inverse)
    }

    /// Returns the J maps `B_r⁻¹ B_j` of a pose.
    pub fn pose(&self, pose: usize) -> &[Matrix3x4<f64>] {
        &self.maps[pose * self.joint_len..][..self.joint_len]
    }

    /// Returns θ_j of a pose: the joint's rotation relative to its parent's, as axis times angle.
    pub fn angle(&self, pose: usize, joint: usize) -> &Vector3<f64> {
        &self.angles[pose * self.joint_len + joint]
    }

    /// Returns Q_p of a pose: the rotation of the joint's parent, I for the root.
    pub fn parent_rotation(&self, pose: usize, joint: usize) -> &Matrix3<f64> {
        &self.parent_rotations[pose * self.joint_len + joint]
    }

    /// Returns whether a joint stretches.
    pub fn stretch(&self) -> bool {
        !self.strains.is_empty()
    }

    /// Returns the strain of a joint in a pose; 0 if the joint does not stretch.
    pub fn strain(&self, pose: usize, joint: usize) -> Strain {
        self.strains.get(pose * self.joint_len + joint).copied().unwrap_or_default()
    }

    /// Returns the largest norm of each joint's strain over the poses, J; `None` if no joint stretches.
    pub fn strain_ranges(&self) -> Option<Vec<f64>> {
        let norm = |pose: usize, joint: usize| strain_norm(&self.strain(pose, joint));
        let range = |joint| (0..self.len()).map(|pose| norm(pose, joint)).fold(0.0, f64::max);
        self.stretch().then(|| (0..self.joint_len).map(range).collect())
    }

    /// Returns C.
    pub fn curve_len(&self) -> usize {
        self.curve_ranges.len()
    }

    /// Returns the C curves of a pose.
    pub fn curves(&self, pose: usize) -> &[f64] {
        &self.curves[pose * self.curve_len()..][..self.curve_len()]
    }

    /// Returns the least and the greatest value of each curve over the poses, C.
    pub fn curve_ranges(&self) -> &[[f64; 2]] {
        &self.curve_ranges
    }

    /// Returns the inverse of a joint's linear part in a pose: `(B_r⁻¹ B_j)⁻¹`.
    pub fn inverse(&self, pose: usize, joint: usize) -> Matrix3<f64> {
        let linear = linear(self.map(pose, joint));
        let inverse = if self.stretch() { linear.try_inverse() } else { None };
        inverse.unwrap_or(linear.transpose())
    }

    /// Returns whether all poses are equal up to invisible motions. A skeleton of one joint is compared by the motion
    /// of that joint itself.
    pub fn are_equal(&self) -> bool {
        let mut roots = self.roots.iter().map(|root| (root - self.roots[0]).amax());
        let mut curves =
            (0..self.len()).flat_map(|pose| self.curves(pose).iter().zip(self.curves(0)));
        self.joints_are_still()
            && (self.joint_len > 1 || roots.all(|difference| difference <= EQUAL))
            && curves.all(|(a, b)| (a - b).abs() <= EQUAL)
    }

    /// Returns whether no joint moves relative to the root, up to invisible motions.
    pub fn joints_are_still(&self) -> bool {
        let joints = self.maps.chunks(self.joint_len);
        let mut all = joints.flat_map(|pose| pose.iter().zip(&self.maps));
        all.all(|(a, b)| (a - b).amax() <= EQUAL)
    }

    /// Returns whether two joints have equal rotations in all poses, up to invisible motions.
    pub fn turn_together(&self, a: usize, b: usize) -> bool {
        let difference = |pose| self.map(pose, a) - self.map(pose, b);
        (0..self.len()).all(|pose| difference(pose).fixed_columns::<3>(0).amax() <= EQUAL)
    }

    /// Returns whether two poses are close.
    ///
    /// - `most`: largest difference between entries of joint transforms.
    /// - `share`: largest difference between values of a curve, over the curve's range.
    pub fn are_close(&self, a: usize, b: usize, (most, share): (f64, f64)) -> bool {
        let curves = self.curves(a).iter().zip(self.curves(b)).zip(&self.curve_ranges);
        self.pose(a).iter().zip(self.pose(b)).all(|(a, b)| (a - b).amax() <= most)
            && curves
                .into_iter()
                .all(|((a, b), [least, most])| (a - b).abs() <= share * (most - least))
    }

    /// Returns the largest difference between an entry of a joint transform and that entry in the first pose.
    pub fn largest_difference(&self) -> f64 {
        let all = self.maps.chunks(self.joint_len).flat_map(|pose| pose.iter().zip(&self.maps));
        all.map(|(a, b)| (a - b).amax()).fold(0.0, f64::max)
    }

    /// Returns the largest |θ_j| over the poses, J values in radians.
    pub fn angle_ranges(&self) -> Vec<f64> {
        (0..self.joint_len)
            .map(|j| (0..self.len()).map(|i| self.angle(i, j).norm()).fold(0.0, f64::max))
            .collect()
    }

    /// Returns the gap between a joint's origin and the place where its parent carries this origin, in the root's
    /// frame.
    ///
    /// - `origin`: the joint's origin in the rest pose.
    pub fn gap(
        &self,
        pose: usize,
        [joint, parent]: [usize; 2],
        origin: &Vector3<f64>,
    ) -> Vector3<f64> {
        (self.map(pose, joint) - self.map(pose, parent)) * origin.push(1.0)
    }

    /// Returns the [`Poses::gap`] of a joint in the frame of its parent, as the runtime sees it.
    pub fn gap_at_parent(
        &self,
        pose: usize,
        [joint, parent]: [usize; 2],
        origin: &Vector3<f64>,
    ) -> Vector3<f64> {
        let gap = self.gap(pose, [joint, parent], origin);
        let root = linear(&self.roots[pose]);
        let gap = if self.stretch() {
            nearest_rotation(&self.roots[pose]).transpose() * root * gap
        } else {
            gap
        };
        self.parent_rotation(pose, joint).transpose() * gap
    }

    /// Returns the largest length of each joint's [`Poses::gap`] over the poses, J lengths; 0 for the root.
    ///
    /// - `origins`: origins of the joints in the rest pose, J, in the unit and about the centre of the poses.
    pub fn gaps(&self, parents: &[Option<usize>], origins: &[Vector3<f64>]) -> Vec<f64> {
        let of_joint = |(joint, parent): (usize, &Option<usize>)| {
            let Some(parent) = *parent else { return 0.0 };
            let gap = |pose| self.gap(pose, [joint, parent], &origins[joint]).norm();
            (0..self.len()).map(gap).fold(0.0, f64::max)
        };
        parents.iter().enumerate().map(of_joint).collect()
    }

    /// Measures positions from a centre in a unit, as [`local`] does.
    pub fn local(mut self, (centre, unit): ([f64; 3], f64)) -> Self {
        let centre = Vector3::from(centre);
        for map in self.maps.iter_mut().chain(&mut self.roots) {
            let shifted = map.fixed_columns::<3>(0) * centre + map.column(3) - centre;
            map.set_column(3, &shifted.unscale(unit));
        }
        self
    }

    /// Stacks the joint transforms of all poses: 3n x 4J, columns 4j..4j+4 are joint j.
    pub fn stacked(&self) -> Mat<f64> {
        Mat::from_fn(3 * self.len(), 4 * self.joint_len, |row, column| {
            self.map(row / 3, column / 4)[(row % 3, column % 4)]
        })
    }

    /// Returns some of the poses.
    #[must_use]
    pub fn only(&self, poses: &[usize]) -> Self {
        fn some<T: Copy>(all: &[T], width: usize, poses: &[usize]) -> Vec<T> {
            poses.iter().flat_map(|&pose| &all[pose * width..][..width]).copied().collect()
        }
        let joints = self.joint_len;
        Self {
            joint_len: joints,
            root: self.root,
            maps: some(&self.maps, joints, poses),
            angles: some(&self.angles, joints, poses),
            parent_rotations: some(&self.parent_rotations, joints, poses),
            strains: if self.stretch() { some(&self.strains, joints, poses) } else { Vec::new() },
            roots: some(&self.roots, 1, poses),
            curves: some(&self.curves, self.curve_len(), poses),
            curve_ranges: self.curve_ranges.clone(),
            times: some(&self.times, 1, poses),
        }
    }
}

/// Gathers the vertices' trajectories relative to the root: 3n x V, column v is
/// `[x y z]` of vertex v over the frames.
pub fn trajectories(examples: &Examples, frames: &[usize], poses: &Poses) -> Mat<f64> {
    let mut all = Mat::zeros(3 * frames.len(), examples.vertex_len());
    let stretches = examples.stretching_joints()[poses.root];
    let inverses: Vec<_> = poses.roots.iter().map(|root| inverse(root, stretches)).collect();
    columns::fill(&mut all, |v, column| {
        for (i, &frame) in frames.iter().enumerate() {
            let y = inverses[i] * homogeneous(&examples.frame(frame)[v]);
            column[3 * i..3 * i + 3].copy_from_slice(y.as_slice());
        }
    });
    all
}

/// Measures a position from a centre in a unit.
pub fn local(x: &[f64; 3], (centre, unit): ([f64; 3], f64)) -> [f64; 3] {
    std::array::from_fn(|axis| (x[axis] - centre[axis]) / unit)
}

/// Gathers poses and [`trajectories`], with positions measured from a centre in a unit.
pub fn seen_from(
    examples: &Examples,
    frames: &[usize],
    space: ([f64; 3], f64),
) -> (Poses, Mat<f64>) {
    let poses = Poses::new(examples, frames);
    let mut trajectories = trajectories(examples, frames, &poses);
    for vertex in 0..trajectories.ncols() {
        for y in trajectories.col_as_slice_mut(vertex).as_chunks_mut::<3>().0 {
            *y = local(y, space);
        }
    }
    (poses.local(space), trajectories)
}

/// Inverts the map of a root. A root that does not stretch is taken as rigid.
fn inverse(m: &Matrix3x4<f64>, stretches: bool) -> Matrix3x4<f64> {
    let inverse = if stretches { linear(m).try_inverse() } else { None };
    let inverse = inverse.unwrap_or_else(|| nearest_rotation(m).transpose());
    joined(&inverse, &(-inverse * m.column(3)))
}

fn nearest_rotation(m: &Matrix3x4<f64>) -> Matrix3<f64> {
    let q = linear(m);
    let deviation = (q.transpose() * q - Matrix3::identity()).amax();
    if deviation <= RIGID {
        return q;
    }
    so3::polar(&q).map_or(Matrix3::identity(), |(rotation, _)| rotation)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::examples::demo::{DemoOptions, demo};
    use crate::numeric::affine::to_rows;

    #[test]
    fn gaps_do_not_depend_on_unit_and_centre() {
        let options = DemoOptions { vertices: 200, poses: 6, held_out: 0, seed: 3 };
        let mut parted = demo(&options);
        let origin = |joint: usize| parted.skeleton.rest[joint].map(|row| row[3]);
        let origins: Vec<_> = (0..parted.joint_len()).map(|j| Vector3::from(origin(j))).collect();
        let parents = parted.skeleton.parents.clone();
        let frames: Vec<usize> = (0..parted.frame_len()).collect();
        let still = Poses::new(&parted, &frames).gaps(&parents, &origins);
        let leaf = (0..parents.len()).rfind(|joint| !parents.contains(&Some(*joint))).unwrap();
        let at = 2 * parted.joint_len() + leaf;
        parted.transforms[at][1][3] += 0.75;
        let poses = Poses::new(&parted, &frames);
        let found = poses.gaps(&parents, &origins);
        for (joint, (found, still)) in found.iter().zip(&still).enumerate() {
            let expected = if joint == leaf { 0.75 } else { *still };
            assert!((found - expected).abs() < 1e-9 + still, "{joint}: {found} {expected}");
        }
        let centre = Vector3::new(0.5, -2.0, 1.0);
        let shifted = poses.local((centre.into(), 4.0));
        let origins: Vec<_> = origins.iter().map(|origin| (origin - centre) / 4.0).collect();
        for (a, b) in shifted.gaps(&parents, &origins).iter().zip(&found) {
            assert!((4.0 * a - b).abs() < 1e-9);
        }
    }

    #[test]
    fn poses_are_equal_if_neither_joints_nor_curves_differ() {
        let options = DemoOptions { vertices: 200, poses: 6, held_out: 0, seed: 3 };
        let mut examples = demo(&options);
        let rest = to_rows(&Matrix3x4::identity());
        let joints = examples.joint_len();
        examples.transforms[joints..].fill(rest);
        examples.curve_names = vec!["open".to_owned()];
        examples.curves = vec![0.0, 0.0, 0.0, 0.0, 0.0, 0.5];
        let poses = Poses::new(&examples, &Vec::from_iter(0..6));
        let judged = |frames: &[usize]| {
            let some = poses.only(frames);
            [some.joints_are_still(), some.are_equal()]
        };
        assert_eq!(judged(&[1, 2, 3]), [true, true]);
        assert_eq!(judged(&[1, 2, 5]), [true, false]);
        assert_eq!(judged(&[0, 1, 2]), [false, false]);
    }

    #[test]
    fn a_global_motion_of_each_frame_does_not_matter() {
        let options = DemoOptions { vertices: 200, poses: 6, held_out: 0, seed: 3 };
        let still = demo(&options);
        let mut moved = still.clone();
        for frame in 0..moved.frame_len() {
            let angle = 0.7 * frame as f64;
            let turn = so3::exp(&Vector3::new(0.3, angle, -0.5));
            let mut global = Matrix3x4::zeros();
            global.fixed_columns_mut::<3>(0).copy_from(&turn);
            global.set_column(3, &Vector3::new(angle, 2.0, -1.0));
            for v in 0..moved.vertex_len() {
                let at = frame * moved.vertex_len() + v;
                moved.vertices[at] = (global * homogeneous(&moved.vertices[at])).into();
            }
            for j in 0..moved.joint_len() {
                let at = frame * moved.joint_len() + j;
                let joint = after(&global, &from_rows(&moved.transforms[at]));
                moved.transforms[at] = to_rows(&joint);
            }
        }
        let frames: Vec<usize> = (0..still.frame_len()).collect();
        let (a, b) = (Poses::new(&still, &frames), Poses::new(&moved, &frames));
        let difference = a.stacked() - b.stacked();
        assert!(difference.norm_max() < 1e-12);
        let difference = trajectories(&still, &frames, &a) - trajectories(&moved, &frames, &b);
        assert!(difference.norm_max() < 1e-12);
        for joint in 0..a.joint_len() {
            assert!((a.angle(5, joint) - b.angle(5, joint)).norm() < 1e-12);
        }
    }

    #[test]
    fn a_sheared_joint_turns_by_its_polar_rotation() {
        let mut examples = demo(&DemoOptions { vertices: 200, poses: 6, held_out: 0, seed: 3 });
        let clean = Poses::new(&examples, &[2]);
        let joint = (0..examples.joint_len()).find(|&j| clean.angle(0, j).norm() > 0.1).unwrap();
        let at = 2 * examples.joint_len() + joint;
        let q: Matrix3<f64> = from_rows(&examples.transforms[at]).fixed_columns::<3>(0).into();
        let stretched = q * Matrix3::from_diagonal(&Vector3::new(1.005, 1.0, 0.995));
        for r in 0..3 {
            for c in 0..3 {
                examples.transforms[at][r][c] = stretched[(r, c)];
            }
        }
        let poses = Poses::new(&examples, &[2]);
        assert!((poses.angle(0, joint) - clean.angle(0, joint)).norm() < 1e-12);
    }
}
