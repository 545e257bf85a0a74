//! A rigged character as a scene file holds it, and how it becomes examples.

use nalgebra::{Matrix3, Matrix4};
use sinew_runtime::format::Space;
use std::ops::Range;

use super::align::{self, Similarity};
use super::error::ImportError;
use super::sampling::Sampling;
use super::times::check_even;
use crate::examples::targets::Targets;
use crate::examples::{Clip, Examples, Matrix3x4, RIGID, Skeleton, Split, Warning, roots};

/// A rigged character as a scene file holds it, sampled: what an importer of scene files returns.
pub(in crate::examples) struct Rig {
    /// Rest positions, V, in the space in which the joints are bound.
    pub(in crate::examples) rest: Vec<[f64; 3]>,
    /// Vertex numbers of each triangle.
    pub(in crate::examples) triangles: Vec<[usize; 3]>,
    /// Texture coordinates, one per vertex, where the file has them so.
    pub(in crate::examples) uv: Option<Vec<[f64; 2]>>,
    /// The meshes that were joined, by name; none where there is one.
    pub(in crate::examples) ranges: Vec<(String, Range<usize>)>,
    /// Axes and unit of the scene.
    pub(in crate::examples) space: Space,
    /// J names.
    pub(in crate::examples) names: Vec<String>,
    /// Parent of each joint; several may have none.
    pub(in crate::examples) parents: Vec<Option<usize>>,
    /// World frame of each joint where the rest mesh is bound, J.
    pub(in crate::examples) binds: Vec<Matrix4<f64>>,
    /// World frame of each joint in each frame, N x J, frame-major.
    pub(in crate::examples) frames: Vec<Matrix4<f64>>,
    /// Posed positions as the file itself shows them, N x V; none without a skin, or where they are not
    /// wanted.
    pub(in crate::examples) shapes: Option<Vec<[f64; 3]>>,
    /// Whether blendshapes move in them: without, they are plain LBS.
    pub(in crate::examples) morphs: bool,
    /// The clips that the frames come from.
    pub(in crate::examples) clips: Vec<Clip>,
    /// What was left out.
    pub(in crate::examples) warnings: Vec<Warning>,
}

impl Rig {
    /// Moves the poses alone into the form of examples: maps from the rest pose, rigid where the
    /// scene's are, about a skeleton of one root.
    ///
    /// A scene may hold mesh and joints in different units; the scale between them goes into the rest
    /// mesh.
    ///
    /// # Errors
    /// [`ImportError::SingularBind`]
    fn poses(&mut self) -> Result<(Skeleton, Vec<Matrix3x4>), ImportError> {
        let mut inverses = Vec::with_capacity(self.binds.len());
        for (bind, name) in self.binds.iter().zip(&self.names) {
            let singular = || ImportError::SingularBind { joint: name.clone() };
            inverses.push(bind.try_inverse().ok_or_else(singular)?);
        }
        let joint_len = self.binds.len().max(1);
        let maps = self.frames.iter().enumerate();
        let mut maps: Vec<_> =
            maps.map(|(number, frame)| frame * inverses[number % joint_len]).collect();
        let scale = common_scale(&maps);
        for position in self.rest.as_flattened_mut() {
            *position *= scale;
        }
        for map in &mut maps {
            map.fixed_view_mut::<3, 3>(0, 0).unscale_mut(scale);
        }
        let parents = roots::joined(&self.names, self.parents.clone(), &mut self.warnings);
        let rest = self.binds.iter().map(|bind| rows(&rest_frame(bind, scale))).collect();
        let skeleton = Skeleton { names: self.names.clone(), parents, rest };
        Ok((skeleton, maps.iter().map(rows).collect()))
    }

    /// Joins poses and posed meshes, those of `targets` where they are given, else the scene's own.
    ///
    /// Targets that bring a rest mesh of their own decide space and units, and the joints are moved
    /// there; targets without one are moved to the joints.
    ///
    /// # Errors
    /// [`ImportError::NoShapes`]; and for targets [`ImportError::UnevenKeys`],
    /// [`ImportError::TargetVertices`], [`ImportError::TargetFrames`] and
    /// [`ImportError::TargetsApart`].
    pub(in crate::examples) fn examples(
        mut self,
        targets: Option<Targets>,
        sampling: &Sampling<'_>,
    ) -> Result<(Examples, Vec<Clip>, Vec<Warning>), ImportError> {
        let (mut skeleton, mut transforms) = self.poses()?;
        let frame_len = self.clips.iter().map(|clip| clip.times.len()).sum();
        let mut split = None;
        let vertices = match targets {
            None => {
                if !self.morphs {
                    self.warnings.push(Warning::PlainSkin);
                }
                self.shapes.take().ok_or(ImportError::NoShapes)?
            }
            Some(mut targets) => {
                if sampling.fps.is_none() {
                    check_even(&self.clips)?;
                }
                self.check_counts(&targets, frame_len)?;
                split = targets.split.take();
                match targets.rest.take() {
                    Some(rest) => {
                        let similarity = align::meshes(&self.rest, &rest)
                            .map_err(|percent| ImportError::TargetsApart { percent })?;
                        similarity.move_joints(&mut skeleton, &mut transforms);
                        self.space = similarity.space(&self.space);
                        self.tell(&similarity, "joints");
                        self.rest = rest;
                        self.triangles = targets.triangles.unwrap_or(self.triangles);
                    }
                    None => {
                        let similarity = align::poses(&self.rest, &transforms, &targets.vertices)?;
                        similarity.move_points(&mut targets.vertices);
                        self.tell(&similarity, "targets");
                    }
                }
                targets.vertices
            }
        };
        let split = split.unwrap_or_else(|| vec![Split::Train; frame_len]);
        Ok(self.joined(skeleton, transforms, vertices, split))
    }

    /// Gives the poses, with the rest mesh in place of every posed one.
    ///
    /// # Errors
    /// [`ImportError::SingularBind`]
    pub(in crate::examples) fn still(
        mut self,
    ) -> Result<(Examples, Vec<Clip>, Vec<Warning>), ImportError> {
        let (skeleton, transforms) = self.poses()?;
        let frame_len = self.clips.iter().map(|clip| clip.times.len()).sum();
        let vertices = self.rest.repeat(frame_len);
        Ok(self.joined(skeleton, transforms, vertices, vec![Split::Train; frame_len]))
    }

    fn joined(
        self,
        skeleton: Skeleton,
        transforms: Vec<Matrix3x4>,
        vertices: Vec<[f64; 3]>,
        split: Vec<Split>,
    ) -> (Examples, Vec<Clip>, Vec<Warning>) {
        let Self { rest, triangles, uv, ranges, space, clips, warnings, .. } = self;
        let examples = Examples {
            rest,
            triangles,
            uv,
            skeleton,
            vertices,
            transforms,
            split,
            ranges,
            space,
            importance: None,
        };
        (examples, clips, warnings)
    }

    fn check_counts(&self, targets: &Targets, frame_len: usize) -> Result<(), ImportError> {
        let (expected, found) = (self.rest.len(), targets.vertex_len);
        if expected != found {
            return Err(ImportError::TargetVertices { expected, found });
        }
        let found = targets.vertices.len() / targets.vertex_len.max(1);
        if frame_len != found {
            let clips: Vec<_> = self.clips.iter().map(Clip::describe).collect();
            let (expected, clips) = (frame_len, clips.join(", "));
            return Err(ImportError::TargetFrames { expected, found, clips });
        }
        Ok(())
    }

    fn tell(&mut self, similarity: &Similarity, what: &'static str) {
        if !similarity.is_identity() {
            self.warnings.push(Warning::Moved { what, how: similarity.to_string() });
        }
    }
}

/// The scale that all maps share, as 1 where they share none or are rigid: what is left is for the
/// examples' own checks to judge.
fn common_scale(maps: &[Matrix4<f64>]) -> f64 {
    let scale = |map: &Matrix4<f64>| map.fixed_view::<3, 3>(0, 0).determinant().abs().cbrt();
    let Some(first) = maps.first().map(scale) else { return 1.0 };
    let shared = maps.iter().all(|map| (scale(map) / first - 1.0).abs() < RIGID);
    if shared && (first - 1.0).abs() > RIGID && first.is_normal() { first } else { 1.0 }
}

/// The rigid part of a joint's bind matrix, in the units of the scaled rest mesh.
fn rest_frame(bind: &Matrix4<f64>, scale: f64) -> Matrix4<f64> {
    let mut frame = Matrix4::identity();
    let svd = bind.fixed_view::<3, 3>(0, 0).into_owned().svd(true, true);
    if let (Some(u), Some(v)) = (svd.u, svd.v_t) {
        let turn: Matrix3<f64> = u * v;
        frame.fixed_view_mut::<3, 3>(0, 0).copy_from(&(turn * turn.determinant().signum()));
    }
    let origin = bind.fixed_view::<3, 1>(0, 3) * scale;
    frame.fixed_view_mut::<3, 1>(0, 3).copy_from(&origin);
    frame
}

fn rows(map: &Matrix4<f64>) -> Matrix3x4 {
    std::array::from_fn(|row| std::array::from_fn(|column| map[(row, column)]))
}
