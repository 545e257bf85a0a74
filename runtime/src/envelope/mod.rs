//! Enveloping: from a pose to a palette of maps, and from the palette to the skin (METHOD §1.8).
//!
//! Stages, each callable alone; the methods of [`Envelope`] compose those of its predictor:
//!
//! | predictor | base of the palette | correction | confidence |
//! |---|---|---|---|
//! | rotational | [`gradients`], [`palette`] | none | [`confidence`] |
//! | kernel | [`joints`] | [`crate::pose::features`], [`correction`] | of the correction |
//! | hybrid | [`gradients`], [`palette`] | [`crate::pose::features`], [`correction`] | of the correction |
//!
//! [`skin`] takes the palette of any of them.

mod bounds;
pub mod confidence;
pub mod correction;
pub mod gradients;
mod group;
pub mod joints;
pub mod palette;
pub mod skin;
mod view;

pub use bounds::Bounds;
pub use group::Group;
pub use skin::{Attribute, Buffer, SkinJob};

use crate::Matrix3x4;
use crate::error::{Argument, EvalError};
use crate::format::{Certificate, EnvelopeCounts, GroupRow, KEY_WORDS, NO_JOINT, Predictor};
use crate::linear::{Le, block_entry, floats};
use crate::pose::features;
use core::fmt;

/// A skin that follows J joints by P proxies, borrowed from a loaded model.
///
/// Accessors by number return `None` beyond their range.
#[derive(Clone, Copy)]
pub struct Envelope<'a> {
    pub(crate) part: usize,
    pub(crate) predictor: Predictor,
    pub(crate) counts: EnvelopeCounts,
    pub(crate) certificate: Certificate,
    pub(crate) names: Names<'a>,
    pub(crate) parents: &'a [[u8; 2]],
    pub(crate) order: &'a [[u8; 2]],
    pub(crate) ranks: &'a [[u8; 2]],
    pub(crate) inverse_binds: &'a [[Le; 12]],
    pub(crate) positions: &'a [[Le; 3]],
    pub(crate) normals: &'a [[Le; 3]],
    pub(crate) tangents: Option<&'a [[Le; 4]]>,
    pub(crate) indices: &'a [[u8; 2]],
    pub(crate) weights: &'a [Le],
    pub(crate) keys: &'a [[Le; KEY_WORDS]],
    pub(crate) c1: &'a [[Le; 8]],
    pub(crate) c2: &'a [[Le; 8]],
    pub(crate) boxes: &'a [[Le; 6]],
    pub(crate) pose_ranges: &'a [Le],
    pub(crate) origins: &'a [[Le; 3]],
    pub(crate) groups: &'a [[u8; GroupRow::BYTES]],
    pub(crate) corrections: &'a [u8],
}

/// The end of each name in the text that follows: the part's, then each joint's.
#[derive(Clone, Copy)]
pub(crate) struct Names<'a> {
    pub(crate) ends: &'a [Le],
    pub(crate) text: &'a [u8],
}

/// A key predictor: `D = Q_p exp(twist . theta_b) [exp(residual . theta_c)] (I + sym(H [theta_b; theta_p]))`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key {
    /// The joint b that it follows; p is its parent.
    pub joint: usize,
    /// A = u W, rows (METHOD §1.4).
    pub twist: [[f32; 3]; 3],
    /// The residual joint c and its A', rows.
    pub residual: Option<(usize, [[f32; 3]; 3])>,
    /// H: a row for each of S - I's xx, xy, xz, yy, yz, zz; columns theta_b, then theta_p.
    pub shear: [[f32; 6]; 6],
}

/// Returns the floats of scratch that [`Envelope::palette`] needs: the greater of 12 J + 3 J + 9 P
/// for the base, and, with a correction, 12 J and [`Envelope::scratch_len`] for it.
pub const fn workspace_len(joint_len: usize, proxy_len: usize, scratch_len: usize) -> usize {
    let base = 15 * joint_len + 9 * proxy_len;
    let correction = if scratch_len > 0 { 12 * joint_len + scratch_len } else { 0 };
    if base > correction { base } else { correction }
}

impl<'a> Envelope<'a> {
    /// Computes the palette of a pose, and returns the confidence in it, in [0, 1]: 1 within what
    /// was seen in training, 0 far from it.
    ///
    /// Where a kernel map is not confident it fades, and its proxies tend to their base. A
    /// rotational model has nothing to fade: its confidence tells only how far joints turn beyond
    /// their trained ranges. A model without any kernel map is certain.
    ///
    /// - `pose`: J skinning matrices, rest to posed, in model space; rigid to 1e-4.
    /// - `workspace`: at least [`Envelope::workspace_len`] floats, of any content.
    /// - `out_palette`: [`Envelope::palette_len`] maps, rest to posed, in model space: what an
    ///   engine's own skinning shader takes together with [`Envelope::influences`].
    ///
    /// # Errors
    /// - [`EvalError::Length`]: `pose` or `out_palette` has another length.
    /// - [`EvalError::TooShort`]: `workspace` is too short.
    /// - [`EvalError::NonFinite`]: a joint's matrix is not finite.
    pub fn palette(
        &self,
        pose: &[Matrix3x4],
        workspace: &mut [f32],
        out_palette: &mut [Matrix3x4],
    ) -> Result<f32, EvalError> {
        self.check_lengths(pose, workspace, out_palette)?;
        let mut confidence = 1.0;
        if self.predictor.reconstructs() {
            confidence = self.reconstruct(pose, workspace, out_palette)?;
        } else {
            joints::evaluate(self, pose, out_palette)?;
        }
        if self.group_len() > 0 {
            // What the base needed of the workspace is free again.
            let (features, scratch) = split(workspace, 12 * self.joint_len());
            let features = features.as_chunks_mut::<4>().0.as_chunks_mut::<3>().0;
            features::evaluate(self, pose, features)?;
            confidence = correction::evaluate(self, pose, features, scratch, out_palette)?;
        }
        Ok(confidence)
    }

    /// Computes what [`Envelope::palette`] does, of a rotational model alone. A program that calls this
    /// and not the other is linked without kernel maps: on a Cortex-M4F 6 kB less at opt-level s, 15 kB
    /// at 3.
    ///
    /// # Errors
    /// - [`EvalError::Predictor`]: the model is not rotational.
    /// - Those of [`Envelope::palette`].
    pub fn rotational_palette(
        &self,
        pose: &[Matrix3x4],
        workspace: &mut [f32],
        out_palette: &mut [Matrix3x4],
    ) -> Result<f32, EvalError> {
        if self.predictor != Predictor::Rotational {
            return Err(EvalError::Predictor { found: self.predictor });
        }
        self.check_lengths(pose, workspace, out_palette)?;
        self.reconstruct(pose, workspace, out_palette)
    }

    fn check_lengths(
        &self,
        pose: &[Matrix3x4],
        workspace: &[f32],
        palette: &[Matrix3x4],
    ) -> Result<(), EvalError> {
        Argument::Pose.check_len(self.joint_len(), pose.len())?;
        Argument::Palette.check_len(self.palette_len(), palette.len())?;
        Argument::Workspace.check_least(self.workspace_len(), workspace.len())
    }

    /// Computes the palette by rotational regression, and the confidence in it, which is 1 where a
    /// correction follows.
    fn reconstruct(
        &self,
        pose: &[Matrix3x4],
        workspace: &mut [f32],
        out_palette: &mut [Matrix3x4],
    ) -> Result<f32, EvalError> {
        let (columns, _) = workspace.as_chunks_mut::<3>();
        let (relative, columns) = split(columns, 4 * self.joint_len());
        let (rotations, columns) = split(columns, self.joint_len());
        let (gradients, _) = split(columns, 3 * self.proxy_len());
        gradients::evaluate(self, pose, relative, rotations, gradients)?;
        let root = pose.get(self.root()).unwrap_or(&[[0.0; 4]; 3]);
        palette::evaluate(self, root, relative, gradients, out_palette)?;
        if self.predictor.corrects() { Ok(1.0) } else { confidence::evaluate(self, rotations) }
    }

    /// Skins every vertex's position.
    ///
    /// - `palette`: [`Envelope::palette_len`] maps.
    /// - `out_positions`: V positions, in model space.
    ///
    /// [`SkinJob`] does ranges, normals, tangents and strided buffers.
    ///
    /// # Errors
    /// - [`EvalError::Length`]: `palette` has another length.
    /// - [`EvalError::TooShort`]: `out_positions` is too short; counted in floats.
    pub fn skin_positions(
        &self,
        palette: &[Matrix3x4],
        out_positions: &mut [[f32; 3]],
    ) -> Result<(), EvalError> {
        SkinJob {
            envelope: *self,
            palette,
            vertices: 0..self.vertex_len(),
            positions: Some(Attribute { buffer: Buffer::A, offset: 0, stride: 3 }),
            normals: None,
            tangents: None,
            out_a: out_positions.as_flattened_mut(),
            out_b: &mut [],
        }
        .run()
    }

    /// Returns the part's name.
    pub fn name(&self) -> &'a str {
        self.names.get(0).unwrap_or_default()
    }

    /// Returns its place in [`crate::Model::parts`], by which [`crate::Model::sections`] are told
    /// apart.
    pub fn part(&self) -> usize {
        self.part
    }

    /// Returns V, the number of vertices.
    pub fn vertex_len(&self) -> usize {
        self.counts.vertex_len as usize
    }

    /// Returns J, the number of joints.
    pub fn joint_len(&self) -> usize {
        self.counts.joint_len as usize
    }

    /// Returns P, the number of proxies: for the kernel predictor, of helpers beside the joints.
    pub fn proxy_len(&self) -> usize {
        self.counts.proxy_len as usize
    }

    /// Returns the number of maps in the palette: P, or J + P for the kernel predictor.
    pub fn palette_len(&self) -> usize {
        self.counts.palette_len(self.predictor)
    }

    /// Returns how the palette is predicted.
    pub fn predictor(&self) -> Predictor {
        self.predictor
    }

    /// Returns G, the number of groups of proxies that share a kernel map.
    pub fn group_len(&self) -> usize {
        self.counts.group_len as usize
    }

    /// Returns the floats of scratch that [`correction::evaluate`] needs; 0 without groups.
    pub fn scratch_len(&self) -> usize {
        self.counts.scratch_len as usize
    }

    /// Returns K, the number of influences of a vertex.
    pub fn influence_len(&self) -> usize {
        self.counts.influence_len as usize
    }

    /// Returns the floats of scratch that [`Envelope::palette`] needs.
    pub fn workspace_len(&self) -> usize {
        workspace_len(self.joint_len(), self.proxy_len(), self.scratch_len())
    }

    /// Returns the reference root: the joint without a parent.
    pub fn root(&self) -> usize {
        self.counts.root as usize
    }

    /// Returns what the fit was measured to reach.
    pub fn certificate(&self) -> Certificate {
        self.certificate
    }

    /// Returns a joint's name.
    pub fn joint_name(&self, joint: usize) -> Option<&'a str> {
        self.names.get(joint.checked_add(1)?)
    }

    /// Returns a joint's parent; `None` for the root.
    pub fn parent(&self, joint: usize) -> Option<usize> {
        self.parents.get(joint).and_then(joint_index)
    }

    /// Lists the J joints so that each comes after its parent.
    pub fn evaluation_order(&self) -> impl ExactSizeIterator<Item = usize> + use<'a> {
        self.order.iter().map(|le| usize::from(u16::from_le_bytes(*le)))
    }

    /// Returns a joint's inverse bind matrix: model space to the joint's rest frame.
    pub fn inverse_bind(&self, joint: usize) -> Option<Matrix3x4> {
        self.inverse_binds.get(joint).map(|m| rows(&floats(m)))
    }

    /// Returns a joint's origin in the rest pose, in model space; a rotational model holds none.
    pub fn origin(&self, joint: usize) -> Option<[f32; 3]> {
        self.origins.get(joint).map(floats)
    }

    /// Returns the largest |theta| of a joint in training, in radians.
    pub fn pose_range(&self, joint: usize) -> Option<f32> {
        self.pose_ranges.get(joint).map(|le| f32::from_le_bytes(*le))
    }

    /// Returns a vertex's rest position.
    pub fn rest_position(&self, vertex: usize) -> Option<[f32; 3]> {
        self.positions.get(vertex).map(floats)
    }

    /// Returns a vertex's rest normal.
    pub fn rest_normal(&self, vertex: usize) -> Option<[f32; 3]> {
        self.normals.get(vertex).map(floats)
    }

    /// Returns a vertex's rest tangent and, last, its handedness.
    pub fn rest_tangent(&self, vertex: usize) -> Option<[f32; 4]> {
        self.tangents?.get(vertex).map(floats)
    }

    /// Whether the model has tangents.
    pub fn has_tangents(&self) -> bool {
        self.tangents.is_some()
    }

    /// Lists a vertex's K influences: palette index and weight. Unused ones weigh 0.
    pub fn influences(
        &self,
        vertex: usize,
    ) -> impl ExactSizeIterator<Item = (usize, f32)> + use<'a> {
        let k = self.influence_len();
        let span = vertex.checked_mul(k).and_then(|start| Some(start..start.checked_add(k)?));
        let indices = span.clone().and_then(|span| self.indices.get(span)).unwrap_or_default();
        let weights = span.and_then(|span| self.weights.get(span)).unwrap_or_default();
        indices.iter().zip(weights).map(|(index, weight)| {
            (usize::from(u16::from_le_bytes(*index)), f32::from_le_bytes(*weight))
        })
    }

    /// Returns the box of the rest positions that a map of the palette moves; `None` if it moves
    /// none.
    pub fn rest_box(&self, index: usize) -> Option<Bounds> {
        let [x0, y0, z0, x1, y1, z1] = floats(self.boxes.get(index)?);
        (x0 <= x1).then_some(Bounds { min: [x0, y0, z0], max: [x1, y1, z1] })
    }

    /// Returns the key predictor of a proxy; a kernel model has none.
    pub fn key(&self, proxy: usize) -> Option<Key> {
        let (joints, matrices) = self.keys.get(proxy)?.split_first()?;
        let [b0, b1, c0, c1] = *joints;
        let (twist, matrices) = matrices.split_first_chunk::<9>()?;
        let (residual, shear) = matrices.split_first_chunk::<9>()?;
        let shear = shear.first_chunk::<36>()?;
        Some(Key {
            joint: usize::from(u16::from_le_bytes([b0, b1])),
            twist: rows(&floats(twist)),
            residual: joint_index(&[c0, c1]).map(|joint| (joint, rows(&floats(residual)))),
            shear: rows(&floats(shear)),
        })
    }

    /// Returns a coefficient of c1 (4 P x 3 P).
    pub fn c1(&self, row: usize, column: usize) -> Option<f32> {
        let shape = (4 * self.proxy_len(), 3 * self.proxy_len());
        block_entry(self.c1, shape, row, column)
    }

    /// Returns a coefficient of c2 (4 P x 4 J).
    pub fn c2(&self, row: usize, column: usize) -> Option<f32> {
        let shape = (4 * self.proxy_len(), 4 * self.joint_len());
        block_entry(self.c2, shape, row, column)
    }

    /// Checks that a stage is part of the predictor.
    pub(crate) fn check_stage(&self, is_part: bool) -> Result<(), EvalError> {
        if is_part { Ok(()) } else { Err(EvalError::Predictor { found: self.predictor }) }
    }
}

impl fmt::Debug for Envelope<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, counts) = (self.name(), self.counts);
        f.debug_struct("Envelope").field("name", &name).field("counts", &counts).finish()
    }
}

impl<'a> Names<'a> {
    fn get(&self, index: usize) -> Option<&'a str> {
        let end = |i: usize| self.ends.get(i).map(|le| u32::from_le_bytes(*le) as usize);
        let start = if index == 0 { 0 } else { end(index - 1)? };
        core::str::from_utf8(self.text.get(start..end(index)?)?).ok()
    }
}

fn joint_index(le: &[u8; 2]) -> Option<usize> {
    let index = u16::from_le_bytes(*le);
    (index != NO_JOINT).then_some(usize::from(index))
}

/// Cuts N = R C floats into R rows.
fn rows<const N: usize, const C: usize, const R: usize>(flat: &[f32; N]) -> [[f32; C]; R] {
    const { assert!(N == R * C) };
    let mut out = [[0.0; C]; R];
    for (row, values) in out.iter_mut().zip(flat.as_chunks().0) {
        *row = *values;
    }
    out
}

/// Splits scratch whose length has been checked.
fn split<T>(scratch: &mut [T], len: usize) -> (&mut [T], &mut [T]) {
    scratch.split_at_mut(len.min(scratch.len()))
}
