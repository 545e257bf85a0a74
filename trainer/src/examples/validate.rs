//! Final checks of every importer. Fits rely on them and do not check again.

use super::distortion::{Distortion, REPAIRABLE, RIGID, deviation, fault};
use super::{Examples, Matrix3x4, Split, Warning};
use crate::Error;
use crate::space::SpaceRequest;
use nalgebra::Vector3;
use sinew_runtime::format::MAGNITUDE_MAX;
use std::fmt::Display;
use std::path::Path;

/// Least height of a triangle relative to its longest side. Below this ratio an f32 normal is noise, so the triangle
/// counts as having no area.
const LEAST_HEIGHT: f64 = 1e-7;

/// Origin of examples, for errors: names of the checked numbers, and the file of the posed positions.
#[derive(Clone, Copy)]
pub(super) struct Origin<'a> {
    /// The rest positions.
    pub(super) rest: &'a str,
    /// The posed positions.
    pub(super) vertices: &'a str,
    /// The rest frames of the joints.
    pub(super) rest_pose: &'a str,
    /// The posed joints.
    pub(super) pose: &'a str,
    pub(super) normals: &'a str,
    pub(super) tangents: &'a str,
    pub(super) uv: &'a str,
    /// File of the posed positions, if it is not that of the joints.
    pub(super) posed_file: Option<&'a Path>,
}

impl Origin<'_> {
    /// Arrays.
    const ARRAYS: Self = Self {
        rest: "array rest",
        vertices: "array vertices",
        rest_pose: "array joint_world_rest",
        pose: "array bone_transforms",
        normals: "array normals",
        tangents: "array tangents",
        uv: "array uv",
        posed_file: None,
    };
    /// A scene, which has no arrays.
    pub(super) const SCENE: Self = Self {
        rest: "the rest mesh",
        vertices: "the posed mesh",
        rest_pose: "the rest pose",
        pose: "the animated pose",
        normals: "the normal of the mesh",
        tangents: "the tangent of the mesh",
        uv: "the texture coordinate of the mesh",
        posed_file: None,
    };
}

impl Examples {
    /// Checks counts, joints, finiteness, faces and the joints' maps, in this order.
    ///
    /// A rest frame within 1e-4 of rigid passes, and within 1e-2 gives a warning. A joint that is more than 1e-3 off a
    /// rotation in a training frame stretches.
    ///
    /// # Errors
    /// - [`Mismatch`](crate::ErrorKind::Mismatch): counts differ, a vertex has no engine vertex, or an engine triangle
    ///   differs from the mesh's.
    /// - [`Missing`](crate::ErrorKind::Missing): a count is 0, no frame trains, or a joint's parent does not exist.
    /// - [`Value`](crate::ErrorKind::Value): two joints have one name, or joints are their own ancestors; axes are
    ///   parallel; a named range is wrong; a number is not finite in any frame, or outside the range of a model; a
    ///   joint weight is negative or not finite; a face names a vertex that does not exist; no face has an area; a map
    ///   is not rigid.
    pub fn validate(&self) -> Result<Vec<Warning>, Error> {
        self.validate_of(&Origin::ARRAYS)
    }

    /// Checks as [`Examples::validate`] does; errors name the parts of the origin.
    pub(super) fn validate_of(&self, origin: &Origin<'_>) -> Result<Vec<Warning>, Error> {
        self.check_counts()?;
        self.check_joints()?;
        self.check_numbers(origin)?;
        let mut warnings = self.check_faces()?;
        self.check_engine(origin)?;
        let mut rest = self.skeleton.rest.iter().zip(&self.skeleton.names);
        if let Some((map, joint)) = rest.find(|(map, _)| deviation(map) > REPAIRABLE) {
            return Err(distorted(joint, &Distortion::of(map), None));
        }
        self.check_poses(&self.frames_of(Split::Train))?;
        self.report_rigidity(&self.skeleton.rest, false, &mut warnings);
        self.report_rigidity(&self.transforms, true, &mut warnings);
        Ok(warnings)
    }

    /// Checks that no joint is mirrored or scaled to 0 in some frames. [`Examples::validate`] checks the training
    /// frames.
    ///
    /// # Errors
    /// A joint is mirrored or scaled to 0 in a frame.
    pub fn check_poses(&self, frames: &[usize]) -> Result<(), Error> {
        frames.iter().try_for_each(|&frame| {
            let mut joints = self.pose(frame).iter().zip(&self.skeleton.names);
            let found = joints.find_map(|(map, joint)| Some((fault(map)?, joint)));
            found.map_or(Ok(()), |(fault, joint)| Err(distorted(joint, &fault, Some(frame))))
        })
    }

    /// Returns the triangles with an area in the rest pose. Only these enter the equations of a fit.
    pub fn solid_triangles(&self) -> Vec<[usize; 3]> {
        let all = (0..self.triangles.len()).filter(|&triangle| self.has_area(triangle));
        all.map(|triangle| self.triangles[triangle]).collect()
    }

    /// Lists the triangles without area in the rest pose, which do not enter the equations of a fit.
    pub fn degenerate_triangles(&self) -> Vec<usize> {
        (0..self.triangles.len()).filter(|&triangle| !self.has_area(triangle)).collect()
    }

    fn check_counts(&self) -> Result<(), Error> {
        for (array, len) in [
            ("rest", self.vertex_len()),
            ("triangles", self.triangles.len()),
            ("bone_names", self.joint_len()),
            ("vertices", self.frame_len()),
        ] {
            if len == 0 {
                return Err(empty(array));
            }
        }
        let (vertices, joints) = (self.vertex_len(), self.joint_len());
        same("joints", "bone_names", joints, "bone_parents", self.skeleton.parents.len())?;
        same("joints", "bone_names", joints, "joint_world_rest", self.skeleton.rest.len())?;
        let expected = self.frame_len() * vertices;
        same("positions", "split and rest", expected, "vertices", self.vertices.len())?;
        let expected = self.frame_len() * joints;
        same("maps", "split and bone_names", expected, "bone_transforms", self.transforms.len())?;
        let expected = self.frame_len() * self.curve_names.len();
        same("values", "split and curve_names", expected, "curves", self.curves.len())?;
        SpaceRequest::all_of(&self.space).of(self.space)?;
        self.check_ranges()?;
        if let Some(weights) = &self.joint_weights {
            let expected = vertices * joints;
            same("joint weights", "rest and bone_names", expected, "joint_weights", weights.len())?;
        }
        if let Some(importance) = &self.importance {
            same("vertices", "rest", vertices, "importance", importance.len())?;
        }
        if self.split.contains(&Split::Train) {
            return Ok(());
        }
        Err(Error::missing(format!(
            "every frame of {} is held out or extreme: none is left to train",
            self.frame_len()
        )))
    }

    /// Checks that the named ranges of vertices are within the mesh and do not overlap.
    fn check_ranges(&self) -> Result<(), Error> {
        let vertex_len = self.vertex_len();
        let mut least = 0;
        for (name, range) in &self.ranges {
            if range.start < least || range.end < range.start || range.end > vertex_len {
                return Err(Error::value(format!(
                    "mesh {name} has the vertices {} to {} (exclusive), expected them from {least} to {vertex_len}",
                    range.start, range.end
                )));
            }
            least = range.end;
        }
        Ok(())
    }

    fn check_joints(&self) -> Result<(), Error> {
        let names = &self.skeleton.names;
        for (what, names) in [("joints", names), ("curves", &self.curve_names)] {
            for (second, name) in names.iter().enumerate() {
                if let Some(first) = names[..second].iter().position(|other| other == name) {
                    return Err(Error::value(format!(
                        "{what} {first} and {second} are both called {name}"
                    )));
                }
            }
        }
        let parents = &self.skeleton.parents;
        for (joint, parent) in parents.iter().enumerate() {
            if let Some(parent) = parent.filter(|&parent| parent >= parents.len()) {
                return Err(missing_parent(&names[joint], parent));
            }
        }
        for start in 0..parents.len() {
            let mut chain = vec![start];
            while let Some(parent) = parents[chain[chain.len() - 1]] {
                let begin = chain.iter().position(|&seen| seen == parent);
                chain.push(parent);
                if let Some(begin) = begin {
                    let joints = chain[begin..].iter().map(|&joint| names[joint].as_str());
                    let joints = joints.collect::<Vec<_>>().join(" -> ");
                    return Err(Error::value(format!("joints are their own ancestors: {joints}")));
                }
            }
        }
        let mut roots = (0..parents.len()).filter(|&joint| parents[joint].is_none());
        if let (Some(_), Some(second)) = (roots.next(), roots.next()) {
            return Err(missing_parent(&names[second], "none"));
        }
        Ok(())
    }

    /// Checks that all numbers are finite, that the rest pose and training frames are within the range of a model, and
    /// that joint weights are not negative.
    fn check_numbers(&self, origin: &Origin<'_>) -> Result<(), Error> {
        let joint = |number: usize| format!("joint {}", self.skeleton.names[number]);
        let trained: &dyn Fn(usize) -> bool = &|frame| self.split[frame] == Split::Train;
        numbers(origin.rest, &self.rest, None, vertex)?;
        let posed = Some((self.vertex_len(), trained));
        let posed = numbers(origin.vertices, &self.vertices, posed, vertex);
        posed.map_err(|error| match origin.posed_file {
            Some(file) => error.in_file(file),
            None => error,
        })?;
        let frames = self.skeleton.rest.iter().map(|map| map.as_flattened());
        numbers(origin.rest_pose, frames, None, joint)?;
        let maps = self.transforms.iter().map(|map| map.as_flattened());
        numbers(origin.pose, maps, Some((self.joint_len(), trained)), joint)?;
        let curve = |number: usize| format!("curve {}", self.curve_names[number]);
        let values = self.curves.chunks(1);
        numbers("array curves", values, Some((self.curve_names.len(), trained)), curve)?;
        let mut all = self.joint_weights.iter().flatten().enumerate();
        let Some((place, &number)) = all.find(|(_, number)| !is_weight(**number)) else {
            return Ok(());
        };
        let (vertex, joint) = (place / self.joint_len(), place % self.joint_len());
        let joint = &self.skeleton.names[joint];
        Err(Error::value(format!(
            "array joint_weights has {number} at vertex {vertex}, joint {joint}, expected a number that is finite and not \
             negative"
        )))
    }

    fn check_faces(&self) -> Result<Vec<Warning>, Error> {
        let vertex_len = self.vertex_len();
        for (face, triangle) in self.triangles.iter().enumerate() {
            if let Some(vertex) = triangle.iter().find(|&&vertex| vertex >= vertex_len) {
                return Err(out_of_range("triangle", face, vertex, vertex_len));
            }
        }
        let (repeated, flat): (Vec<_>, Vec<_>) =
            self.degenerate_triangles().into_iter().partition(|&triangle| {
                let [a, b, c] = self.triangles[triangle];
                a == b || b == c || c == a
            });
        if repeated.len() + flat.len() == self.triangles.len() {
            let triangle_len = self.triangles.len();
            return Err(Error::value(format!(
                "none of the {triangle_len} rest triangles has an area"
            )));
        }
        let repeated = (!repeated.is_empty()).then_some(Warning::RepeatedVertex(repeated));
        let flat = (!flat.is_empty()).then_some(Warning::ZeroArea(flat));
        Ok(repeated.into_iter().chain(flat).collect())
    }

    /// Checks the engine vertices: every vertex has a copy, the triangles match the mesh, and all numbers are finite.
    fn check_engine(&self, origin: &Origin<'_>) -> Result<(), Error> {
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
            let outside = || out_of_range("engine vertex", face, vertex, vertex_len);
            *has_copy.get_mut(vertex).ok_or_else(outside)? = true;
        }
        if let Some(vertex) = has_copy.iter().position(|has| !has) {
            return Err(Error::mismatch(format!(
                "vertex {vertex} has no copy among the engine's vertices"
            )));
        }
        let (mesh, own) = (self.triangles.len(), engine.triangles.len());
        same("triangles", "rest", mesh, "the engine's mesh", own)?;
        for (triangle, (&expected, corners)) in
            self.triangles.iter().zip(&engine.triangles).enumerate()
        {
            if let Some(corner) = corners.iter().find(|&&corner| corner >= engine_len) {
                return Err(out_of_range("engine triangle", triangle, corner, engine_len));
            }
            let found = corners.map(|corner| engine.copy_of[corner]);
            if found != expected {
                return Err(Error::mismatch(format!(
                    "triangle {triangle} has the vertices {expected:?}, but its engine vertices are copies of {found:?}"
                )));
            }
        }
        numbers(origin.normals, engine.normals.iter().flatten(), None, vertex)?;
        numbers(origin.tangents, engine.tangents.iter().flatten(), None, vertex)?;
        numbers(origin.uv, engine.uv.iter().flatten(), None, vertex)
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
        let stretching = self.stretching_joints();
        for (number, joint) in self.skeleton.names.iter().enumerate() {
            let deviations =
                maps.chunks_exact(self.joint_len()).map(|maps| deviation(&maps[number]));
            let off = deviations.enumerate().filter(|&(_, deviation)| deviation > RIGID);
            let Some((worst, deviation)) = off.clone().max_by(|a, b| a.1.total_cmp(&b.1)) else {
                continue;
            };
            if deviation > REPAIRABLE && stretching[number] {
                // The joint stretches by design.
                continue;
            }
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

/// Checks that two arrays have as many items.
pub(super) fn same(
    what: &str,
    first: &str,
    first_len: usize,
    second: &str,
    second_len: usize,
) -> Result<(), Error> {
    if first_len == second_len {
        return Ok(());
    }
    Err(Error::mismatch(format!("{first} has {first_len} {what}, {second} has {second_len}")))
}

/// Checks that numbers are finite, and within the range of a model.
///
/// - `name`: name of the numbers in errors.
/// - `frames`: number of rows of a frame, and whether the numbers of a frame must be within the range; `None` for
///   numbers without frames, which must be within it.
/// - `element`: names the element of a row in errors, by its number in the frame.
pub(super) fn numbers(
    name: &str,
    rows: impl IntoIterator<Item: AsRef<[f64]>>,
    frames: Option<(usize, &dyn Fn(usize) -> bool)>,
    element: impl Fn(usize) -> String,
) -> Result<(), Error> {
    for (number, row) in rows.into_iter().enumerate() {
        let row = row.as_ref();
        let (frame, place) =
            frames.map_or((None, number), |(len, _)| (Some(number / len), number % len));
        let within = |x: &f64| x.abs() <= f64::from(MAGNITUDE_MAX);
        let bounded = || frames.zip(frame).is_none_or(|((_, bounded), frame)| bounded(frame));
        let fault = if !row.iter().all(|x| x.is_finite()) {
            "is not finite".to_owned()
        } else if !row.iter().all(within) && bounded() {
            format!("exceeds {MAGNITUDE_MAX:e}, the most a model can hold,")
        } else {
            continue;
        };
        let error = Error::value(format!("{name} {fault} at {}", element(place)));
        return Err(match frame {
            Some(frame) => error.in_frame(frame),
            None => error,
        });
    }
    Ok(())
}

/// Names a vertex in errors.
pub(super) fn vertex(number: usize) -> String {
    format!("vertex {number}")
}

/// Creates the error of an empty array.
pub(super) fn empty(array: &str) -> Error {
    Error::missing(format!("array {array} is empty"))
}

/// Creates the error of a face with a vertex number out of range.
pub(super) fn out_of_range(
    array: &str,
    face: usize,
    vertex: impl Display,
    vertex_len: usize,
) -> Error {
    Error::value(format!("{array} {face} names vertex {vertex} of {vertex_len}"))
}

/// Creates the error of a joint whose parent does not exist.
pub(super) fn missing_parent(joint: &str, parent: impl Display) -> Error {
    Error::missing(format!("joint {joint} has parent {parent}, which does not exist"))
}

/// Creates the error of a joint whose map is wrong in a frame, or in the rest pose.
pub(super) fn distorted(joint: &str, distortion: &Distortion, frame: Option<usize>) -> Error {
    match frame {
        Some(frame) => Error::value(format!("joint {joint} {distortion}")).in_frame(frame),
        None => Error::value(format!("in the rest pose, joint {joint} {distortion}")),
    }
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
