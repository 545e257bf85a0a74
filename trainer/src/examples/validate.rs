//! Final checks of every importer. Fits rely on them and do not check again.

use super::distortion::{Distortion, REPAIRABLE, RIGID, deviation};
use super::{Element, Examples, ExamplesError, Matrix3x4, Split, Warning};
use crate::space::SpaceRequest;
use nalgebra::Vector3;
use sinew_runtime::format::MAGNITUDE_MAX;

/// Least height of a triangle relative to its longest side. Below this ratio an f32 normal is noise, so the triangle
/// counts as having no area.
const LEAST_HEIGHT: f64 = 1e-7;

impl Examples {
    /// Checks counts, joints, finiteness, faces and rigidity, in this order.
    ///
    /// A map within 1e-4 of rigid passes. A map within 1e-2 gives a warning, and a fit uses the nearest rotation.
    /// Beyond 1e-2 a training frame gives an error. Other frames, which no fit reads, give a warning.
    ///
    /// # Errors
    /// - [`ExamplesError::Mismatch`] and [`ExamplesError::Empty`] for counts that differ or are 0,
    ///   [`ExamplesError::NothingTrains`] without a training frame.
    /// - [`ExamplesError::DuplicateJoint`], [`ExamplesError::MissingParent`] and [`ExamplesError::JointCycle`] if the
    ///   skeleton is not a tree.
    /// - [`ExamplesError::Space`] for parallel axes, [`ExamplesError::Range`] for a named range.
    /// - [`ExamplesError::NotFinite`] for NaN and infinity in any frame, [`ExamplesError::TooLarge`] for numbers
    ///   outside the range of a model.
    /// - [`ExamplesError::JointWeight`] for a joint weight that is negative or not finite.
    /// - [`ExamplesError::VertexOutOfRange`] and [`ExamplesError::NoArea`] for faces.
    /// - [`ExamplesError::VertexOutOfRange`], [`ExamplesError::Mismatch`], [`ExamplesError::NotFinite`],
    ///   [`ExamplesError::NoCopy`] and [`ExamplesError::OtherCopy`] for engine vertices.
    /// - [`ExamplesError::NonRigidJoint`] for a map that is not rigid.
    pub fn validate(&self) -> Result<Vec<Warning>, ExamplesError> {
        self.check_counts()?;
        self.check_joints()?;
        self.check_numbers()?;
        let mut warnings = self.check_faces()?;
        self.check_engine()?;
        for (map, name) in self.skeleton.rest.iter().zip(&self.skeleton.names) {
            if deviation(map) > REPAIRABLE {
                let (joint, distortion) = (name.clone(), Distortion::of(map));
                return Err(ExamplesError::NonRigidJoint { frame: None, joint, distortion });
            }
        }
        self.check_rigid_in(&self.frames_of(Split::Train))?;
        self.report_rigidity(&self.skeleton.rest, false, &mut warnings);
        self.report_rigidity(&self.transforms, true, &mut warnings);
        Ok(warnings)
    }

    /// Checks that the joints of some frames are within 1e-2 of rigid. [`Examples::validate`] checks the training
    /// frames.
    ///
    /// # Errors
    /// [`ExamplesError::NonRigidJoint`]
    pub fn check_rigid_in(&self, frames: &[usize]) -> Result<(), ExamplesError> {
        for &frame in frames {
            for (map, joint) in self.pose(frame).iter().zip(&self.skeleton.names) {
                if deviation(map) > REPAIRABLE {
                    let (frame, joint, distortion) =
                        (Some(frame as i64), joint.clone(), Distortion::of(map));
                    return Err(ExamplesError::NonRigidJoint { frame, joint, distortion });
                }
            }
        }
        Ok(())
    }

    /// Returns the triangles with an area in the rest pose. Only these enter the equations of a fit.
    pub fn solid_triangles(&self) -> Vec<[usize; 3]> {
        (0..self.triangles.len())
            .filter(|&triangle| self.has_area(triangle))
            .map(|triangle| self.triangles[triangle])
            .collect()
    }

    /// Lists the triangles without area in the rest pose, which do not enter the equations of a fit.
    pub fn degenerate_triangles(&self) -> Vec<usize> {
        (0..self.triangles.len()).filter(|&triangle| !self.has_area(triangle)).collect()
    }

    fn check_counts(&self) -> Result<(), ExamplesError> {
        for (array, len) in [
            ("rest", self.vertex_len()),
            ("triangles", self.triangles.len()),
            ("bone_names", self.joint_len()),
            ("vertices", self.frame_len()),
        ] {
            if len == 0 {
                return Err(ExamplesError::Empty { array });
            }
        }
        let (vertices, joints) = (self.vertex_len(), self.joint_len());
        same("joints", "bone_names", joints, "bone_parents", self.skeleton.parents.len())?;
        same("joints", "bone_names", joints, "joint_world_rest", self.skeleton.rest.len())?;
        let expected = self.frame_len() * vertices;
        same("positions", "split and rest", expected, "vertices", self.vertices.len())?;
        let expected = self.frame_len() * joints;
        same("maps", "split and bone_names", expected, "bone_transforms", self.transforms.len())?;
        SpaceRequest::all_of(&self.space).of(self.space)?;
        self.check_ranges()?;
        if let Some(weights) = &self.joint_weights {
            let expected = vertices * joints;
            same("joint weights", "rest and bone_names", expected, "joint_weights", weights.len())?;
        }
        if let Some(importance) = &self.importance {
            same("vertices", "rest", vertices, "importance", importance.len())?;
        }
        if !self.split.contains(&Split::Train) {
            return Err(ExamplesError::NothingTrains { frame_len: self.frame_len() });
        }
        Ok(())
    }

    /// Checks that the named ranges of vertices are within the mesh and do not overlap.
    fn check_ranges(&self) -> Result<(), ExamplesError> {
        let vertex_len = self.vertex_len();
        let mut least = 0;
        for (name, range) in &self.ranges {
            if range.start < least || range.end < range.start || range.end > vertex_len {
                let (name, range) = (name.clone(), range.clone());
                return Err(ExamplesError::Range { name, range, least, vertex_len });
            }
            least = range.end;
        }
        Ok(())
    }

    fn check_joints(&self) -> Result<(), ExamplesError> {
        let names = &self.skeleton.names;
        for (second, name) in names.iter().enumerate() {
            if let Some(first) = names[..second].iter().position(|other| other == name) {
                return Err(ExamplesError::DuplicateJoint { name: name.clone(), first, second });
            }
        }
        let parents = &self.skeleton.parents;
        for (joint, parent) in parents.iter().enumerate() {
            if parent.is_some_and(|parent| parent >= parents.len()) {
                let parent = parent.map(|parent| parent.to_string()).unwrap_or_default();
                return Err(ExamplesError::MissingParent { joint: names[joint].clone(), parent });
            }
        }
        for start in 0..parents.len() {
            let mut chain = vec![start];
            let mut joint = start;
            while let Some(parent) = parents[joint] {
                if let Some(begin) = chain.iter().position(|&seen| seen == parent) {
                    chain.drain(..begin);
                    chain.push(parent);
                    let joints = chain.iter().map(|&joint| names[joint].clone()).collect();
                    return Err(ExamplesError::JointCycle { joints });
                }
                chain.push(parent);
                joint = parent;
            }
        }
        let mut roots = (0..parents.len()).filter(|&joint| parents[joint].is_none());
        if let (Some(_), Some(second)) = (roots.next(), roots.next()) {
            let (joint, parent) = (names[second].clone(), "none".to_owned());
            return Err(ExamplesError::MissingParent { joint, parent });
        }
        Ok(())
    }

    /// Checks that all numbers are finite, and that the rest pose and training frames are within the range of a model.
    fn check_numbers(&self) -> Result<(), ExamplesError> {
        let vertex = |number: usize| Element::Vertex(number);
        let joint = |number: usize| Element::Joint(self.skeleton.names[number].clone());
        let trained = |frame: usize| self.split[frame] == Split::Train;
        let rest = |_| true;
        numbers("rest", self.rest.iter().map(<[_; 3]>::as_slice), None, vertex, rest)?;
        let count = Some(self.vertex_len());
        let vertices = self.vertices.iter().map(<[_; 3]>::as_slice);
        numbers("vertices", vertices, count, vertex, trained)?;
        let frames = self.skeleton.rest.iter().map(|map| map.as_flattened());
        numbers("joint_world_rest", frames, None, joint, rest)?;
        let maps = self.transforms.iter().map(|map| map.as_flattened());
        numbers("bone_transforms", maps, Some(self.joint_len()), joint, trained)?;
        self.check_joint_weights()
    }

    fn check_joint_weights(&self) -> Result<(), ExamplesError> {
        let mut all = self.joint_weights.iter().flatten().enumerate();
        let Some((place, &number)) = all.find(|(_, number)| !is_weight(**number)) else {
            return Ok(());
        };
        let (vertex, joint) = (place / self.joint_len(), place % self.joint_len());
        let joint = self.skeleton.names[joint].clone();
        Err(ExamplesError::JointWeight { vertex, joint, number })
    }

    fn check_faces(&self) -> Result<Vec<Warning>, ExamplesError> {
        let vertex_len = self.vertex_len();
        for (face, triangle) in self.triangles.iter().enumerate() {
            if let Some(&vertex) = triangle.iter().find(|&&vertex| vertex >= vertex_len) {
                let vertex = vertex.try_into().unwrap_or(i64::MAX);
                return Err(ExamplesError::VertexOutOfRange {
                    array: "triangle",
                    face,
                    vertex,
                    vertex_len,
                });
            }
        }
        let (repeated, flat): (Vec<_>, Vec<_>) =
            self.degenerate_triangles().into_iter().partition(|&triangle| {
                let [a, b, c] = self.triangles[triangle];
                a == b || b == c || c == a
            });
        if repeated.len() + flat.len() == self.triangles.len() {
            return Err(ExamplesError::NoArea { triangle_len: self.triangles.len() });
        }
        let mut warnings = Vec::new();
        if !repeated.is_empty() {
            warnings.push(Warning::RepeatedVertex { triangles: repeated });
        }
        if !flat.is_empty() {
            warnings.push(Warning::ZeroArea { triangles: flat });
        }
        Ok(warnings)
    }

    /// Checks the engine vertices: every vertex has a copy, the triangles match the mesh, and all numbers are finite.
    fn check_engine(&self) -> Result<(), ExamplesError> {
        let Some(engine) = &self.engine else { return Ok(()) };
        let (engine_len, vertex_len) = (engine.copy_of.len(), self.vertex_len());
        for (array, len) in [
            ("normals", engine.normals.as_ref().map(Vec::len)),
            ("tangents", engine.tangents.as_ref().map(Vec::len)),
            ("uv", engine.uv.as_ref().map(Vec::len)),
        ] {
            let len = len.unwrap_or(engine_len);
            same("vertices", "the engine's mesh", engine_len, array, len)?;
        }
        let mut has_copy = vec![false; vertex_len];
        for (face, &vertex) in engine.copy_of.iter().enumerate() {
            let outside = ExamplesError::VertexOutOfRange {
                array: "engine vertex",
                face,
                vertex: vertex.try_into().unwrap_or(i64::MAX),
                vertex_len,
            };
            *has_copy.get_mut(vertex).ok_or(outside)? = true;
        }
        if let Some(vertex) = has_copy.iter().position(|has| !has) {
            return Err(ExamplesError::NoCopy { vertex });
        }
        let (mesh, own) = (self.triangles.len(), engine.triangles.len());
        same("triangles", "rest", mesh, "the engine's mesh", own)?;
        for (triangle, (&expected, corners)) in
            self.triangles.iter().zip(&engine.triangles).enumerate()
        {
            if let Some(&corner) = corners.iter().find(|&&corner| corner >= engine_len) {
                return Err(ExamplesError::VertexOutOfRange {
                    array: "engine triangle",
                    face: triangle,
                    vertex: corner.try_into().unwrap_or(i64::MAX),
                    vertex_len: engine_len,
                });
            }
            let found = corners.map(|corner| engine.copy_of[corner]);
            if found != expected {
                return Err(ExamplesError::OtherCopy { triangle, expected, found });
            }
        }
        let vertex = |number: usize| Element::Vertex(number);
        let all = |_| true;
        let normals = engine.normals.iter().flatten().map(<[_; 3]>::as_slice);
        numbers("normals", normals, None, vertex, all)?;
        let tangents = engine.tangents.iter().flatten().map(<[_; 4]>::as_slice);
        numbers("tangents", tangents, None, vertex, all)?;
        let uv = engine.uv.iter().flatten().map(<[_; 2]>::as_slice);
        numbers("uv", uv, None, vertex, all)
    }

    fn has_area(&self, triangle: usize) -> bool {
        let [a, b, c] = self.triangles[triangle].map(|vertex| Vector3::from(self.rest[vertex]));
        let longest =
            [b - a, c - b, a - c].map(|side| side.norm_squared()).into_iter().fold(0.0, f64::max);
        (b - a).cross(&(c - a)).norm() > LEAST_HEIGHT * longest
    }

    /// Adds a warning for each joint with maps that are not quite rigid.
    ///
    /// - `maps`: frame-major, or one per joint for the rest pose.
    fn report_rigidity(&self, maps: &[Matrix3x4], posed: bool, warnings: &mut Vec<Warning>) {
        for (number, joint) in self.skeleton.names.iter().enumerate() {
            let deviations =
                maps.chunks_exact(self.joint_len()).map(|maps| deviation(&maps[number]));
            let off = deviations.enumerate().filter(|&(_, deviation)| deviation > RIGID);
            let Some((worst, deviation)) = off.clone().max_by(|a, b| a.1.total_cmp(&b.1)) else {
                continue;
            };
            warnings.push(Warning::NonRigidJoint {
                joint: joint.clone(),
                matrix_len: off.count(),
                worst_frame: posed.then_some(worst as i64),
                deviation,
            });
        }
    }
}

/// Returns whether a number is a valid weight.
pub(super) fn is_weight(number: f64) -> bool {
    number.is_finite() && number >= 0.0
}

pub(super) fn same(
    what: &'static str,
    first: &'static str,
    first_len: usize,
    second: &'static str,
    second_len: usize,
) -> Result<(), ExamplesError> {
    if first_len == second_len {
        return Ok(());
    }
    Err(ExamplesError::Mismatch { what, first, first_len, second, second_len })
}

pub(super) fn numbers<'a>(
    array: &'static str,
    rows: impl Iterator<Item = &'a [f64]>,
    per_frame: Option<usize>,
    element: impl Fn(usize) -> Element,
    bounded: impl Fn(usize) -> bool,
) -> Result<(), ExamplesError> {
    for (number, row) in rows.enumerate() {
        let frame = per_frame.map(|len| number / len);
        let place = || element(per_frame.map_or(number, |len| number % len));
        let within = |x: &f64| x.abs() <= f64::from(MAGNITUDE_MAX);
        let fits = row.iter().all(within) || !frame.is_none_or(&bounded);
        let frame = frame.map(|frame| frame as i64);
        if !row.iter().all(|x| x.is_finite()) {
            return Err(ExamplesError::NotFinite { array, frame, element: place() });
        }
        if !fits {
            return Err(ExamplesError::TooLarge { array, frame, element: place() });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::testing::triangle;
    use crate::mesh::EngineMesh;

    #[test]
    fn invalid_engine_vertices_are_refused() {
        let good = EngineMesh {
            copy_of: vec![0, 1, 1, 2],
            triangles: vec![[0, 2, 3]],
            normals: Some(vec![[0.0, 0.0, 1.0]; 4]),
            tangents: Some(vec![[1.0, 0.0, 0.0, 1.0]; 4]),
            uv: Some(vec![[0.0; 2]; 4]),
        };
        let fault = |spoil: &dyn Fn(&mut EngineMesh)| {
            let mut examples = triangle(1);
            let mut engine = good.clone();
            spoil(&mut engine);
            examples.engine = Some(engine);
            examples.validate().err().map(|error| error.to_string()).unwrap_or_default()
        };
        assert_eq!(fault(&|_| ()), "");
        for (spoil, words) in [
            (
                &(|m: &mut EngineMesh| m.uv = Some(Vec::new())) as &dyn Fn(&mut EngineMesh),
                "the engine's mesh has 4 vertices, uv has 0",
            ),
            (&|m| m.copy_of[3] = 3, "engine vertex 3 names vertex 3 of 3"),
            (&|m| m.copy_of[3] = 1, "vertex 2 has no copy among the engine's vertices"),
            (&|m| m.triangles.clear(), "rest has 1 triangles, the engine's mesh has 0"),
            (&|m| m.triangles[0][1] = 4, "engine triangle 0 names vertex 4 of 4"),
            (
                &|m| m.triangles[0][1] = 3,
                "triangle 0 has the vertices [0, 1, 2], but its engine vertices are copies of [0, 2, 2]",
            ),
            (&|m| m.uv.as_mut().unwrap()[2][1] = f64::NAN, "array uv is not finite at vertex 2"),
            (
                &|m| m.tangents.as_mut().unwrap()[1][3] = f64::INFINITY,
                "array tangents is not finite at vertex 1",
            ),
        ] {
            assert_eq!(fault(spoil), words);
        }
    }
}
