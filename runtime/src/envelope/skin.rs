//! Stage 3: from the palette to positions, normals and tangents (METHOD §1.8).

use super::Envelope;
use crate::Matrix3x4;
use crate::error::{Argument, EvalError};
use crate::linear::{Le, dot, floats};
use crate::numeric::sqrt;
use core::ops::Range;
use glam::{Mat4, Vec4, Vec4Swizzles};

/// One of the two output buffers of a [`SkinJob`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Buffer {
    /// `out_a`.
    A,
    /// `out_b`.
    B,
}

/// Where an attribute is written: the i-th vertex *of the range* at `offset + i * stride`, in floats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Attribute {
    /// The buffer.
    pub buffer: Buffer,
    /// Where the range's first vertex goes, in floats.
    pub offset: usize,
    /// Floats from one vertex to the next; at least the attribute's own, 3 or 4.
    pub stride: usize,
}

/// Skins a range of vertices.
///
/// Each vertex blends its K maps in the file's order, `sum w_k T_k`, and then moves by columns,
/// `((m_0 x + m_1 y) + m_2 z) + m_3`. Floats between attributes are left alone; where attributes
/// overlap, the later field of this job wins.
#[derive(Debug)]
pub struct SkinJob<'a> {
    /// The model.
    pub envelope: Envelope<'a>,
    /// [`Envelope::palette_len`] maps, rest to posed.
    pub palette: &'a [Matrix3x4],
    /// The vertices, within `0..vertex_len`. Ranges of one skin can run at the same time.
    pub vertices: Range<usize>,
    /// Where to put positions: 3 floats, model space.
    pub positions: Option<Attribute>,
    /// Where to put normals: 3 floats of length 1, by the cofactors of the blended 3x3. Where the
    /// map leaves a normal no direction, the rest normal.
    pub normals: Option<Attribute>,
    /// Where to put tangents: 3 floats of length 1, by the blended 3x3 (the rest tangent where it
    /// leaves no direction), then the rest pose's handedness.
    pub tangents: Option<Attribute>,
    /// Buffer A; as long as its attributes need. Empty if none is in it.
    pub out_a: &'a mut [f32],
    /// Buffer B; as long as its attributes need. Empty if none is in it.
    pub out_b: &'a mut [f32],
}

impl SkinJob<'_> {
    /// Runs the job.
    ///
    /// # Errors
    /// - [`EvalError::Length`]: `palette` has another length.
    /// - [`EvalError::VertexRange`]: `vertices` is not inside the mesh.
    /// - [`EvalError::NoTangents`]: tangents are asked for and the model has none.
    /// - [`EvalError::Stride`]: a stride is shorter than its attribute.
    /// - [`EvalError::TooShort`]: a buffer is too short for an attribute.
    pub fn run(self) -> Result<(), EvalError> {
        self.check()?;
        let Self { envelope, palette, ref vertices, .. } = self;
        let k = envelope.influence_len();
        let influences = vertices.start * k..vertices.end * k;
        let indices = envelope.indices.get(influences.clone()).unwrap_or_default();
        let weights = envelope.weights.get(influences).unwrap_or_default();
        if UNROLL && k == 4 {
            // The usual number: arrays of it are unrolled.
            let influences = indices.as_chunks::<4>().0.iter().zip(weights.as_chunks::<4>().0);
            self.skin(influences.map_while(|(indices, weights)| blend(palette, indices, weights)));
        } else {
            // K of a loaded model is at least one; chunks of zero would panic.
            let influences = indices.chunks_exact(k.max(1)).zip(weights.chunks_exact(k.max(1)));
            self.skin(influences.map_while(|(indices, weights)| blend(palette, indices, weights)));
        }
        Ok(())
    }

    fn check(&self) -> Result<(), EvalError> {
        let vertex_len = self.envelope.vertex_len();
        let Range { start, end } = self.vertices;
        Argument::Palette.check_len(self.envelope.palette_len(), self.palette.len())?;
        if start > end || end > vertex_len {
            return Err(EvalError::VertexRange { start, end, vertex_len });
        }
        if self.tangents.is_some() && !self.envelope.has_tangents() {
            return Err(EvalError::NoTangents);
        }
        let attributes = [(self.positions, 3), (self.normals, 3), (self.tangents, 4)];
        for (attribute, len) in attributes {
            let Some(attribute) = attribute else { continue };
            let (argument, found) = match attribute.buffer {
                Buffer::A => (Argument::OutA, self.out_a.len()),
                Buffer::B => (Argument::OutB, self.out_b.len()),
            };
            attribute.check(end - start, len, argument, found)?;
        }
        Ok(())
    }

    /// Moves the range's vertices by their blended maps.
    #[inline(always)]
    fn skin(self, maps: impl Iterator<Item = Mat4>) {
        let Self { envelope, vertices, positions, normals, tangents, out_a, out_b, .. } = self;
        let mut out = Outputs { a: out_a, b: out_b };
        if let (Some(attribute), None, None) = (positions, normals, tangents) {
            // Positions alone get a loop of their own, which fits the registers.
            let rest = envelope.positions.get(vertices).unwrap_or_default();
            for (i, (rest, map)) in rest.iter().zip(maps).enumerate() {
                out.put(attribute, i, moved(&map, floats(rest)));
            }
            return;
        }
        for (i, (vertex, map)) in vertices.zip(maps).enumerate() {
            if let (Some(attribute), Some(rest)) = (positions, envelope.rest_position(vertex)) {
                out.put(attribute, i, moved(&map, rest));
            }
            if let (Some(attribute), Some(rest)) = (normals, envelope.rest_normal(vertex)) {
                out.put(attribute, i, unit(along(&cofactors(&map), rest), rest));
            }
            if let (Some(attribute), Some(rest)) = (tangents, envelope.rest_tangent(vertex)) {
                let [x, y, z, hand] = rest;
                let [x, y, z] = unit(along(&map, [x, y, z]), [x, y, z]);
                out.put(attribute, i, [x, y, z, hand]);
            }
        }
    }
}

struct Outputs<'a> {
    a: &'a mut [f32],
    b: &'a mut [f32],
}

impl Outputs<'_> {
    #[inline(always)]
    fn put<const N: usize>(&mut self, attribute: Attribute, i: usize, value: [f32; N]) {
        let out = match attribute.buffer {
            Buffer::A => &mut *self.a,
            Buffer::B => &mut *self.b,
        };
        let at = attribute.offset + i * attribute.stride;
        if let Some(out) = out.get_mut(at..).and_then(<[f32]>::first_chunk_mut) {
            *out = value;
        }
    }
}

impl Attribute {
    fn check(
        &self,
        vertex_len: usize,
        len: usize,
        argument: Argument,
        found: usize,
    ) -> Result<(), EvalError> {
        if self.stride < len {
            return Err(EvalError::Stride { least: len, found: self.stride });
        }
        let Some(last) = vertex_len.checked_sub(1) else { return Ok(()) };
        let least = last
            .checked_mul(self.stride)
            .and_then(|at| at.checked_add(self.offset)?.checked_add(len))
            .unwrap_or(usize::MAX);
        argument.check_least(least, found)
    }
}

/// Whether the usual number of influences gets code of its own: a quarter faster on x86-64, but small
/// processors have too few registers for it (31 instructions a vertex more on a Cortex-M4F).
const UNROLL: bool = cfg!(any(target_pointer_width = "64", target_family = "wasm"));

/// Blends the maps of a vertex, first to last, and returns the columns of the sum. `None` stands
/// for an index beyond the palette, which a loaded model does not have.
#[inline(always)]
fn blend(palette: &[Matrix3x4], indices: &[[u8; 2]], weights: &[Le]) -> Option<Mat4> {
    let [mut x, mut y, mut z] = [Vec4::ZERO; 3];
    for (index, weight) in indices.iter().zip(weights) {
        let [a, b, c] = palette.get(usize::from(u16::from_le_bytes(*index)))?;
        let weight = f32::from_le_bytes(*weight);
        x += Vec4::from_array(*a) * weight;
        y += Vec4::from_array(*b) * weight;
        z += Vec4::from_array(*c) * weight;
    }
    Some(Mat4::from_cols(x, y, z, Vec4::ZERO).transpose())
}

#[inline(always)]
fn moved(m: &Mat4, rest: [f32; 3]) -> [f32; 3] {
    (along(m, rest) + m.w_axis).truncate().to_array()
}

/// Returns the linear part of a map times a vector, column by column.
#[inline(always)]
fn along(m: &Mat4, [x, y, z]: [f32; 3]) -> Vec4 {
    m.x_axis * x + m.y_axis * y + m.z_axis * z
}

/// Returns the cofactors of a map's 3x3: cross products of its columns.
#[inline(always)]
fn cofactors(m: &Mat4) -> Mat4 {
    let Mat4 { x_axis: x, y_axis: y, z_axis: z, .. } = *m;
    Mat4::from_cols(cross(y, z), cross(z, x), cross(x, y), Vec4::ZERO)
}

#[inline(always)]
fn cross(a: Vec4, b: Vec4) -> Vec4 {
    (a * b.yzxw() - a.yzxw() * b).yzxw()
}

/// Returns a vector's direction, or the rest pose's where it has none.
#[inline(always)]
fn unit(v: Vec4, rest: [f32; 3]) -> [f32; 3] {
    let v = v.truncate().to_array();
    let square = dot(v, v);
    if !square.is_normal() {
        return rest;
    }
    let scale = 1.0 / sqrt(square);
    v.map(|x| x * scale)
}
