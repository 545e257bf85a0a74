//! The stage `skin`: from the palette to positions, normals and tangents (METHOD §1.8).

use super::blend::{Fours, Influences, along, cofactors, moved, side, unit};
use super::coefficients::{Frame, Vertex};
use super::eight::{Columns, EIGHT, Posed, Rows};
use super::output::{Output, cells, put};
use super::view::Skin;
use crate::error::{Argument, CallError, CallErrorKind};
use crate::lanes::{Eight, Lanes};
use crate::linear::{Le, Matrix3x4, floats};
use core::ops::Range;

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
    /// Where to put normals: 3 floats of length 1, outward also where the palette mirrors. By the skin's tangent
    /// coefficients; where they leave a normal no direction, the rest normal turned by the strongest influence. Of a
    /// skin without, by the cofactors of the blended 3x3. Where neither gives a direction, the rest normal, which
    /// may be 0.
    pub normals: Option<Output<'a>>,
    /// Where to put tangents: 3 floats of length 1, by the skin's tangent coefficients, or else by the blended 3x3
    /// (the rest tangent where it leaves no direction), then the rest pose's handedness.
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
        if skin.has_coefficients() && (self.normals.is_some() || self.tangents.is_some()) {
            let done =
                if Lanes::IN_REGISTERS { self.turn_eights(&influences).unwrap_or(0) } else { 0 };
            self.turn(&influences, done..vertices.len());
            return Ok(());
        }
        match influences.by_four(vertices.clone()).filter(|_| remap.is_none()) {
            Some(fours) => self.skin::<true>(&influences, fours),
            None => self.skin::<false>(&influences, Default::default()),
        };
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

    /// Moves vertices of a skin with tangent coefficients, some of the range. `None` stands for what a loaded skin does
    /// not have.
    #[cfg_attr(target_os = "none", inline(never))]
    fn turn(&self, influences: &Influences<'_>, some: Range<usize>) -> Option<()> {
        let Self { skin, palette, rest, .. } = self;
        let (positions, normals, tangents) = (skin.positions(), skin.normals(), skin.tangents());
        let (coefficients, len) = (skin.coefficients(), skin.influence_len().saturating_sub(1));
        let side = side(palette);
        for i in some {
            let at = self.vertices.start + i;
            let vertex = self.remap.map_or(Some(at), |remap| Some(*remap.get(at)? as usize))?;
            let transform = influences.blend(vertex)?;
            let (indices, weights) = influences.of(vertex)?;
            let coefficients = coefficients.get(vertex * len..)?.get(..len)?;
            let own = Vertex { palette, indices, weights, coefficients };
            let x = of(rest.positions, positions, vertex)?;
            let n = of(rest.normals, normals, vertex)?;
            let tangent = of(rest.tangents, tangents, vertex);
            let frame = match tangent.filter(|_| skin.has_tangents()) {
                Some([x, y, z, _]) => Frame::of_tangent(n, [x, y, z]),
                None => Frame::of_normal(n, f32::from_le_bytes(normals.get(vertex)?[2])),
            };
            let blended = [transform.x_axis, transform.y_axis, transform.z_axis];
            let blended = blended.map(|column| column.truncate().to_array());
            let parted = own.parted(x)?;
            if let Some(out) = self.positions {
                out.put(i, moved(&transform, x))?;
            }
            if let Some(out) = self.normals {
                out.put(i, own.normal(&blended, &frame, &parted, (n, side)))?;
            }
            if let Some((out, [x, y, z, hand])) = self.tangents.zip(tangent) {
                let turned = along(&transform, [x, y, z]).truncate().to_array();
                let turned = parted.add(&frame, [x, y, z], turned);
                let [x, y, z] = unit(turned, 1.0).unwrap_or([x, y, z]);
                out.put(i, [x, y, z, hand])?;
            }
        }
        Some(())
    }

    /// Moves vertices of a skin with tangent coefficients side by side, and returns how many of the range's first;
    /// `None` of those that go one by one.
    #[inline(never)]
    fn turn_eights(&self, influences: &Influences<'_>) -> Option<usize> {
        let Self { skin, palette, .. } = self;
        let Rest { positions, normals, tangents } = self.rest;
        let given = positions.is_some() || normals.is_some() || tangents.is_some();
        if given || self.remap.is_some() || self.tangents.is_some() || skin.influence_len() != 4 {
            return None;
        }
        let range = self.vertices.clone();
        let mut tangents = match skin.has_tangents() {
            true => Some(eights(skin.tangents(), &range)?),
            false => None,
        };
        let all = eights(skin.positions(), &range)?
            .zip(eights(skin.normals(), &range)?)
            .zip(eights(skin.indices().as_chunks().0, &range)?)
            .zip(eights(skin.weights().as_chunks().0, &range)?)
            .zip(eights(skin.coefficients().as_chunks().0, &range)?);
        let side = side(palette);
        let (mut columns, mut posed) = (Columns::NONE, Posed::NONE);
        let mut done = 0;
        for ((((positions, normals), indices), weights), coefficients) in all {
            let tangents = match &mut tangents {
                Some(tangents) => Some(tangents.next()?),
                None => None,
            };
            let rows = Rows { positions, normals, tangents, indices, weights, coefficients };
            columns.read(&rows, palette)?;
            columns.pose(tangents.is_some(), side, &mut posed);
            if let Some(out) = self.positions {
                out.put_rows(done, &posed.positions)?;
            }
            if let Some(out) = self.normals {
                out.put_rows(done, &posed.normals)?;
            }
            if !posed.squares.iter().all(|square| square.is_normal()) {
                self.turn(influences, done..done + EIGHT)?;
            }
            done += EIGHT;
        }
        Some(done)
    }

    /// Moves vertices of a skin without tangent coefficients by their blended transforms. `None` is an index beyond the
    /// palette, which loading excludes.
    ///
    /// - `IS_BY_FOUR`: whether the influences are `fours`, vertex by vertex of the range, and there is no remap.
    #[inline(always)]
    fn skin<const IS_BY_FOUR: bool>(
        &self,
        influences: &Influences<'_>,
        (indices, weights): Fours<'_>,
    ) -> Option<()> {
        let (skin, rest) = (&self.skin, self.rest);
        let (positions, normals, tangents) = (skin.positions(), skin.normals(), skin.tangents());
        let side = side(self.palette);
        let mut fours = indices.iter().zip(weights);
        for (i, at) in self.vertices.clone().enumerate() {
            let (vertex, transform) = if IS_BY_FOUR {
                let (indices, weights) = fours.next()?;
                (at, influences.blend_row(indices, weights)?)
            } else {
                let vertex = self.remap.map_or(Some(at), |remap| Some(*remap.get(at)? as usize))?;
                (vertex, influences.blend(vertex)?)
            };
            if let Some(out) = self.positions
                && let Some(x) = of(rest.positions, positions, vertex)
            {
                out.put(i, moved(&transform, x));
            }
            if let Some(out) = self.normals
                && let Some(n) = of(rest.normals, normals, vertex)
            {
                let turned = along(&cofactors(&transform), n).truncate().to_array();
                out.put(i, unit(turned, side).unwrap_or(n));
            }
            if let Some(out) = self.tangents
                && let Some([x, y, z, hand]) = of(rest.tangents, tangents, vertex)
            {
                let turned = along(&transform, [x, y, z]).truncate().to_array();
                let [x, y, z] = unit(turned, 1.0).unwrap_or([x, y, z]);
                out.put(i, [x, y, z, hand]);
            }
        }
        Some(())
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
    if let Some((indices, weights)) = influences.by_four(vertices.clone()) {
        // By chunks: faster where this path is taken, and slower on small processors. A stride is at
        // least that of its attribute; chunks of zero would panic.
        let chunks = out.floats.chunks(out.stride.max(1));
        for (((rest, out), indices), weights) in rest.iter().zip(chunks).zip(indices).zip(weights) {
            let Some(transform) = influences.blend_row(indices, weights) else { return };
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

/// Returns a range's attribute by eights, without the last few.
fn eights<'a, T>(all: &'a [T], range: &Range<usize>) -> Option<core::slice::Iter<'a, [T; EIGHT]>> {
    Some(all.get(range.clone())?.as_chunks().0.iter())
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
