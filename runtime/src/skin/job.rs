//! The stage `skin`: from the palette to positions, normals and tangents (METHOD §1.8).

use super::view::Skin;
use crate::error::{Argument, CallError, CallErrorKind};
use crate::linear::{Le, Matrix3x4, dot, floats};
use crate::numeric::sqrt;
use core::cell::Cell;
use core::iter;
use core::ops::Range;
use glam::{Mat4, Vec4, Vec4Swizzles};

/// Where an attribute is written: the i-th vertex *of the range* at `i * stride`.
#[derive(Clone, Copy, Debug)]
pub struct Output<'a> {
    /// Floats of the caller, by [`cells`]. Attributes may share them, each from its own first float
    /// on: so a vertex can be interleaved.
    pub floats: &'a [Cell<f32>],
    /// Floats from one vertex to the next; at least the attribute's own, 3 or 4.
    pub stride: usize,
}

/// Lends floats to several attributes of a [`SkinJob`]; they are written and never read.
pub fn cells(floats: &mut [f32]) -> &[Cell<f32>] {
    Cell::from_mut(floats).as_slice_of_cells()
}

/// A rest mesh of the caller's: another face or body of the same topology. What is not given is the
/// file's.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rest<'a> {
    /// V positions.
    pub positions: Option<&'a [[f32; 3]]>,
    /// V normals of length 1.
    pub normals: Option<&'a [[f32; 3]]>,
    /// V tangents of length 1, and the handedness.
    pub tangents: Option<&'a [[f32; 4]]>,
}

/// Skins a range of vertices.
///
/// Each vertex blends its K transforms in the file's order, `sum w_k T_k`, and then moves by columns,
/// `((m_0 x + m_1 y) + m_2 z) + m_3`. Without an envelope it stays at rest, directions made of length 1. Floats between
/// attributes are left alone; where attributes overlap, the later field of this job wins.
#[derive(Clone, Debug)]
pub struct SkinJob<'a> {
    /// The skin.
    pub skin: Skin<'a>,
    /// [`Skin::palette_len`] transforms, rest to posed.
    pub palette: &'a [Matrix3x4],
    /// The vertices: of the remap where there is one, else of the skin. Ranges can run at the same time.
    pub vertices: Range<usize>,
    /// For each vertex of the engine's the skin's that it is a copy of: so that vertices which were
    /// split along seams, or put into another order, need no second pass.
    pub remap: Option<&'a [u32]>,
    /// What stands for the file's rest mesh, by the skin's own vertices.
    pub rest: Rest<'a>,
    /// Where to put positions: 3 floats, model space.
    pub positions: Option<Output<'a>>,
    /// Where to put normals: 3 floats of length 1, by the cofactors of the blended 3x3. Where that
    /// leaves a normal no direction, the rest normal, which may be 0.
    pub normals: Option<Output<'a>>,
    /// Where to put tangents: 3 floats of length 1, by the blended 3x3 (the rest tangent where it
    /// leaves no direction), then the rest pose's handedness.
    pub tangents: Option<Output<'a>>,
}

impl Skin<'_> {
    /// Skins every vertex's position.
    ///
    /// - `palette`: [`Skin::palette_len`] transforms.
    /// - `out_positions`: V positions, in model space.
    ///
    /// [`SkinJob`] does ranges, normals, tangents, strided buffers, and meshes of the caller's.
    ///
    /// # Errors
    /// - [`CallErrorKind::Length`]: `palette` has another length.
    /// - [`CallErrorKind::TooShort`]: `out_positions` is too short; counted in floats.
    pub fn skin_positions(
        &self,
        palette: &[Matrix3x4],
        out_positions: &mut [[f32; 3]],
    ) -> Result<(), CallError> {
        let vertices = 0..self.vertex_len();
        let out = Output { floats: cells(out_positions.as_flattened_mut()), stride: 3 };
        Argument::Palette.check_len(self.palette_len(), palette.len())?;
        out.check(vertices.len(), 3, Argument::Positions)?;
        positions_alone(self, palette, vertices, out);
        Ok(())
    }
}

impl SkinJob<'_> {
    /// Runs the job.
    ///
    /// # Errors
    /// - [`CallErrorKind::NoOutput`]: there is no attribute to write.
    /// - [`CallErrorKind::Length`]: `palette` or an array of `rest` has another length.
    /// - [`CallErrorKind::OutOfRange`]: `vertices` is not inside the skin or the remap, or the remap
    ///   names a vertex that the skin does not have.
    /// - [`CallErrorKind::NoAttribute`]: tangents are asked for, and neither skin nor `rest` has them.
    /// - [`CallErrorKind::Stride`]: a stride is shorter than its attribute.
    /// - [`CallErrorKind::TooShort`]: an output is too short for its attribute.
    pub fn run(&self) -> Result<(), CallError> {
        self.check()?;
        let Self { skin, palette, ref vertices, remap, .. } = *self;
        let influences = Influences::new(&skin, palette);
        match (self.positions, self.normals, self.tangents) {
            (Some(out), None, None) if remap.is_none() && self.rest.positions.is_none() => {
                positions_alone(&skin, palette, vertices.clone(), out);
                return Ok(());
            }
            _ => {}
        }
        if remap.is_none()
            && let Some(transforms) = influences.blend_by_four(vertices.clone())
        {
            self.skin(vertices.clone().zip(transforms));
            return Ok(());
        }
        self.skin(vertices.clone().map_while(|at| {
            let vertex = remap.map_or(Some(at), |remap| Some(*remap.get(at)? as usize))?;
            Some((vertex, influences.blend(vertex)?))
        }));
        Ok(())
    }

    fn check(&self) -> Result<(), CallError> {
        let vertex_len = self.skin.vertex_len();
        let outputs = [
            (self.positions, 3, Argument::Positions),
            (self.normals, 3, Argument::Normals),
            (self.tangents, 4, Argument::Tangents),
        ];
        if outputs.iter().all(|(output, ..)| output.is_none()) {
            return Err(CallError::new(CallErrorKind::NoOutput, Argument::Call));
        }
        Argument::Palette.check_len(self.skin.palette_len(), self.palette.len())?;
        let Rest { positions, normals, tangents } = self.rest;
        for (argument, found) in [
            (Argument::RestPositions, positions.map(<[_]>::len)),
            (Argument::RestNormals, normals.map(<[_]>::len)),
            (Argument::RestTangents, tangents.map(<[_]>::len)),
        ] {
            argument.check_len(vertex_len, found.unwrap_or(vertex_len))?;
        }
        let Range { start, end } = self.vertices;
        let most = self.remap.map_or(vertex_len, <[_]>::len);
        if start > end || end > most {
            let error = CallError::new(CallErrorKind::OutOfRange, Argument::Vertices);
            return Err(error.at(start).values(most, end));
        }
        let remap = self.remap.and_then(|remap| remap.get(start..end)).unwrap_or_default();
        if let Some(at) = remap.iter().position(|vertex| *vertex as usize >= vertex_len) {
            let found = remap.get(at).map_or(0, |vertex| *vertex as usize);
            let error = CallError::new(CallErrorKind::OutOfRange, Argument::Remap).at(start + at);
            return Err(error.values(vertex_len.saturating_sub(1), found));
        }
        if self.tangents.is_some() && tangents.is_none() && !self.skin.has_tangents() {
            return Err(CallError::new(CallErrorKind::NoAttribute, Argument::Tangents));
        }
        for (output, len, argument) in outputs {
            if let Some(output) = output {
                output.check(end - start, len, argument)?;
            }
        }
        Ok(())
    }

    /// Moves vertices by their blended transforms.
    #[inline(always)]
    fn skin(&self, transforms: impl Iterator<Item = (usize, Mat4)>) {
        let (skin, rest) = (&self.skin, self.rest);
        let (positions, normals, tangents) = (skin.positions(), skin.normals(), skin.tangents());
        for (i, (vertex, transform)) in transforms.enumerate() {
            if let Some(out) = self.positions
                && let Some(x) = of(rest.positions, positions, vertex)
            {
                out.put(i, moved(&transform, x));
            }
            if let Some(out) = self.normals
                && let Some(n) = of(rest.normals, normals, vertex)
            {
                out.put(i, unit(along(&cofactors(&transform), n), n));
            }
            if let Some(out) = self.tangents
                && let Some([x, y, z, hand]) = of(rest.tangents, tangents, vertex)
            {
                let [x, y, z] = unit(along(&transform, [x, y, z]), [x, y, z]);
                out.put(i, [x, y, z, hand]);
            }
        }
    }
}

/// Skins positions of the file's rest mesh: a loop of its own, which fits the registers.
#[cfg_attr(target_os = "none", inline(never))]
fn positions_alone(
    skin: &Skin<'_>,
    palette: &[Matrix3x4],
    vertices: Range<usize>,
    out: Output<'_>,
) {
    let rest = skin.positions().get(vertices.clone()).unwrap_or_default();
    let influences = Influences::new(skin, palette);
    if let Some(transforms) = influences.blend_by_four(vertices.clone()) {
        // By chunks: faster where this path is taken, and slower on small processors. A stride is at
        // least that of its attribute; chunks of zero would panic.
        let chunks = out.floats.chunks(out.stride.max(1));
        for ((rest, out), transform) in rest.iter().zip(chunks).zip(transforms) {
            put(out, moved(&transform, floats(rest)));
        }
        return;
    }
    if skin.envelope_part().is_none() {
        for (i, rest) in rest.iter().enumerate() {
            // What the identity makes of it: -0 becomes 0. A way out of the loop, which else would be
            // unrolled and is not worth it.
            if out.put(i, floats(rest).map(|x| x + 0.0)).is_none() {
                return;
            }
        }
        return;
    }
    for (i, (rest, transform)) in rest.iter().zip(influences.blend_each(vertices)).enumerate() {
        out.put(i, moved(&transform, floats(rest)));
    }
}

/// Reads an attribute of the caller's rest mesh, or else of the file's.
#[inline(always)]
fn of<const N: usize>(
    given: Option<&[[f32; N]]>,
    file: &[[Le; N]],
    vertex: usize,
) -> Option<[f32; N]> {
    match given {
        Some(given) => given.get(vertex).copied(),
        None => file.get(vertex).map(floats),
    }
}

impl Output<'_> {
    fn check(&self, vertex_len: usize, len: usize, argument: Argument) -> Result<(), CallError> {
        if self.stride < len {
            let error = CallError::new(CallErrorKind::Stride, argument);
            return Err(error.values(len, self.stride));
        }
        let Some(last) = vertex_len.checked_sub(1) else { return Ok(()) };
        let least = last.checked_mul(self.stride).and_then(|at| at.checked_add(len));
        argument.check_least(least.unwrap_or(usize::MAX), self.floats.len())
    }

    /// Writes the attribute of the i-th vertex of the range.
    #[inline(always)]
    fn put<const N: usize>(&self, i: usize, value: [f32; N]) -> Option<()> {
        put(self.floats.get(i * self.stride..)?, value)
    }
}

/// Writes an attribute to its first floats.
#[inline(always)]
fn put<const N: usize>(out: &[Cell<f32>], value: [f32; N]) -> Option<()> {
    out.first_chunk::<N>()?.iter().zip(value).for_each(|(out, value)| out.set(value));
    Some(())
}

/// The influences of all vertices, and the palette that they refer to.
struct Influences<'a> {
    palette: &'a [Matrix3x4],
    indices: &'a [[u8; 2]],
    weights: &'a [Le],
    /// How many a vertex has; 0 without an envelope.
    len: usize,
}

/// Whether the usual number of influences gets code of its own: a quarter faster on x86-64, but small
/// processors have too few registers for it (31 instructions a vertex more on a Cortex-M4F).
const UNROLL: bool = cfg!(any(target_pointer_width = "64", target_family = "wasm"));

impl<'a> Influences<'a> {
    fn new(skin: &Skin<'a>, palette: &'a [Matrix3x4]) -> Self {
        let (indices, weights) = (skin.indices(), skin.weights());
        Self { palette, indices, weights, len: skin.influence_len() }
    }

    /// Blends the transforms of vertices of which each has four; `None` where they have not.
    #[inline(always)]
    fn blend_by_four(&self, vertices: Range<usize>) -> Option<impl Iterator<Item = Mat4>> {
        if !UNROLL || self.len != 4 {
            return None;
        }
        let indices = self.indices.as_chunks::<4>().0.get(vertices.clone())?;
        let weights = self.weights.as_chunks::<4>().0.get(vertices)?;
        Some(indices.iter().zip(weights).map_while(|(i, w)| blend(self.palette, i, w)))
    }

    /// Blends the transforms of vertices; of none where they have no influences.
    #[inline(always)]
    fn blend_each(&self, vertices: Range<usize>) -> impl Iterator<Item = Mat4> {
        let all = vertices.start * self.len..vertices.end * self.len;
        let influences = self.indices.get(all.clone()).zip(self.weights.get(all));
        let (mut indices, mut weights) = influences.unwrap_or_default();
        // At least one, so that the loop over a vertex's influences needs no way around it.
        let len = self.len.max(1);
        iter::from_fn(move || {
            let (first_indices, more_indices) = indices.split_at_checked(len)?;
            let (first_weights, more_weights) = weights.split_at_checked(len)?;
            (indices, weights) = (more_indices, more_weights);
            blend(self.palette, first_indices, first_weights)
        })
    }

    /// Blends the transforms of a vertex; the identity without influences. `None` as by [`blend`], or
    /// for a vertex beyond the mesh.
    #[inline(always)]
    fn blend(&self, vertex: usize) -> Option<Mat4> {
        if UNROLL && self.len == 4 {
            let indices = self.indices.as_chunks::<4>().0.get(vertex)?;
            return blend(self.palette, indices, self.weights.as_chunks::<4>().0.get(vertex)?);
        }
        if self.len == 0 {
            return Some(Mat4::IDENTITY);
        }
        let start = vertex * self.len;
        let indices = self.indices.get(start..).and_then(|rest| rest.get(..self.len))?;
        blend(self.palette, indices, self.weights.get(start..)?)
    }
}

/// Blends the transforms of a vertex, first to last, and returns the columns of the sum. `None` stands
/// for an index beyond the palette, which a loaded skin does not have.
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

/// Returns the linear part of a transform times a vector, column by column.
#[inline(always)]
fn along(m: &Mat4, [x, y, z]: [f32; 3]) -> Vec4 {
    m.x_axis * x + m.y_axis * y + m.z_axis * z
}

/// Returns the cofactors of a transform's 3x3: cross products of its columns.
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
