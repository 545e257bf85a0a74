//! Stage skin: from the palette to positions, normals and tangents (METHOD §1.8).
//!
//! A loop returns `None` early only if the bytes of the file have changed since loading: the loop then stops at an
//! index that no checked file holds, instead of a panic.

use super::blend::{Fours, Influences, along, moved};
use super::columns::Scratch;
use super::job::{Rest, SkinJob};
use super::normals::{Frame, Vertex, cofactors, side, unit};
use super::output::{Output, put};
use super::simd::{Columns, EIGHT, Posed, Rows, eights};
use super::view::Skin;
use crate::error::{Argument, CallError};
use crate::lanes::{Eight, Lanes};
use crate::linear::{Le, Matrix3x4, floats};
use core::ops::Range;

impl Skin<'_> {
    /// Skins the position of every vertex.
    ///
    /// [`SkinJob`] does ranges, normals, tangents, strided buffers, and rest meshes of the caller.
    ///
    /// - `palette`: [`Skin::palette_len`] transforms.
    /// - `out_positions`: V positions, in model space.
    ///
    /// # Errors
    /// - [`crate::CallErrorKind::Length`]: `palette` has another length.
    /// - [`crate::CallErrorKind::TooShort`]: `out_positions` is too short; lengths are in floats.
    pub fn skin_positions(
        &self,
        palette: &[Matrix3x4],
        out_positions: &mut [[f32; 3]],
    ) -> Result<(), CallError> {
        let vertices = 0..self.vertex_len();
        let out = Output::new(out_positions.as_flattened_mut(), 3);
        Argument::Palette.check_len(self.palette_len(), palette.len())?;
        out.check(vertices.len(), 3, Argument::Positions)?;
        skin_positions_only(self, palette, vertices, &out, Scratch::default());
        Ok(())
    }
}

impl SkinJob<'_> {
    /// Runs the job. The palette's numbers are not checked: a transform that is not finite gives vertices that are not.
    ///
    /// # Errors
    /// - [`crate::CallErrorKind::NoOutput`]: the job has no output.
    /// - [`crate::CallErrorKind::Length`]: `palette` or an array of `rest` has another length.
    /// - [`crate::CallErrorKind::OutOfRange`]: `vertices` is not inside the skin or the remap, or the remap refers to
    ///   a vertex that the skin does not have.
    /// - [`crate::CallErrorKind::NoAttribute`]: the job has an output of tangents, but neither the skin nor `rest` has
    ///   tangents.
    /// - [`crate::CallErrorKind::Stride`]: a stride is shorter than its attribute.
    /// - [`crate::CallErrorKind::TooShort`]: an output is too short for its attribute, or scratch is too short.
    /// - [`crate::CallErrorKind::Overlap`]: two outputs share a float.
    pub fn run(&self) -> Result<(), CallError> {
        self.check()?;
        let Self { skin, palette, remap, .. } = *self;
        let vertices = self.range();
        let influences = Influences::new(&skin, palette);
        match (&self.positions, &self.normals, &self.tangents) {
            (Some(out), None, None) if remap.is_none() && self.rest.positions.is_none() => {
                skin_positions_only(&skin, palette, vertices.clone(), out, self.scratch);
                return Ok(());
            }
            _ => {}
        }
        if skin.has_coefficients() && (self.normals.is_some() || self.tangents.is_some()) {
            let done =
                if Lanes::IN_REGISTERS { self.skin_eights(&influences).unwrap_or(0) } else { 0 };
            self.skin_by_coefficients(&influences, done..vertices.len());
            return Ok(());
        }
        match influences.by_four(vertices.clone()).filter(|_| remap.is_none()) {
            Some(fours) => self.skin_by_blend::<true>(&influences, fours),
            None => self.skin_by_blend::<false>(&influences, Default::default()),
        };
        Ok(())
    }

    /// Skins vertices with tangent coefficients, one at a time.
    ///
    /// - `part`: a part of `0..n`, of the n vertices of the range.
    #[cfg_attr(target_os = "none", inline(never))]
    fn skin_by_coefficients(&self, influences: &Influences<'_>, part: Range<usize>) -> Option<()> {
        let Self { skin, palette, rest, .. } = self;
        let (positions, normals, tangents) = (skin.positions(), skin.normals(), skin.tangents());
        let (coefficients, len) = (skin.coefficients(), skin.influence_len().saturating_sub(1));
        let (side, start) = (side(palette), self.range().start);
        for i in part {
            let at = start + i;
            let vertex = self.remap.map_or(Some(at), |remap| Some(*remap.get(at)? as usize))?;
            let transform = influences.blend(vertex)?;
            let (indices, weights) = influences.of(vertex)?;
            let coefficients = coefficients.get(vertex * len..)?.get(..len)?;
            let own = Vertex { palette, indices, weights, coefficients };
            let x = rest_attribute(rest.positions, positions, vertex)?;
            let n = rest_attribute(rest.normals, normals, vertex)?;
            let tangent = rest_attribute(rest.tangents, tangents, vertex);
            let frame = match tangent.filter(|_| skin.has_tangents()) {
                Some([x, y, z, _]) => Frame::of_tangent(n, [x, y, z]),
                None => Frame::of_normal(n, f32::from_le_bytes(normals.get(vertex)?[2])),
            };
            let blended = [transform.x_axis, transform.y_axis, transform.z_axis];
            let blended = blended.map(|column| column.truncate().to_array());
            let correction = own.frame_correction(x)?;
            if let Some(out) = &self.positions {
                out.put(i, moved(&transform, x))?;
            }
            if let Some(out) = &self.normals {
                out.put(i, own.normal(&blended, &frame, &correction, (n, side)))?;
            }
            if let Some((out, [x, y, z, hand])) = self.tangents.as_ref().zip(tangent) {
                let turned = along(&transform, [x, y, z]).truncate().to_array();
                let turned = correction.apply(&frame, [x, y, z], turned);
                let [x, y, z] = unit(turned, 1.0).unwrap_or([x, y, z]);
                out.put(i, [x, y, z, hand])?;
            }
        }
        Some(())
    }

    /// Skins vertices with tangent coefficients, eight at a time, from the start of the range.
    ///
    /// Returns the number of vertices done; the last few are left to the general loop. `None` if the job needs the general loop, for example for tangents or a remap.
    #[inline(never)]
    fn skin_eights(&self, influences: &Influences<'_>) -> Option<usize> {
        let Self { skin, palette, .. } = self;
        let Rest { positions, normals, tangents } = self.rest;
        let given = positions.is_some() || normals.is_some() || tangents.is_some();
        if given || self.remap.is_some() || self.tangents.is_some() || skin.influence_len() != 4 {
            return None;
        }
        let range = self.range();
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
            if let Some(out) = &self.positions {
                out.put_rows(done, &posed.positions)?;
            }
            if let Some(out) = &self.normals {
                out.put_rows(done, &posed.normals)?;
            }
            if !posed.squared_lengths.iter().all(|square| square.is_normal()) {
                // A normal without a direction needs the general loop.
                self.skin_by_coefficients(influences, done..done + EIGHT)?;
            }
            done += EIGHT;
        }
        Some(done)
    }

    /// Skins vertices without tangent coefficients by their blended transforms.
    ///
    /// - `IS_BY_FOUR`: whether the influences of the range are in `fours`, and there is no remap.
    #[inline(always)]
    fn skin_by_blend<const IS_BY_FOUR: bool>(
        &self,
        influences: &Influences<'_>,
        (indices, weights): Fours<'_>,
    ) -> Option<()> {
        let (skin, rest) = (&self.skin, self.rest);
        let (positions, normals, tangents) = (skin.positions(), skin.normals(), skin.tangents());
        let side = side(self.palette);
        let mut fours = indices.iter().zip(weights);
        for (i, at) in self.range().enumerate() {
            let (vertex, transform) = if IS_BY_FOUR {
                let (indices, weights) = fours.next()?;
                (at, influences.blend_row(indices, weights)?)
            } else {
                let vertex = self.remap.map_or(Some(at), |remap| Some(*remap.get(at)? as usize))?;
                (vertex, influences.blend(vertex)?)
            };
            if let Some(out) = &self.positions
                && let Some(x) = rest_attribute(rest.positions, positions, vertex)
            {
                out.put(i, moved(&transform, x));
            }
            if let Some(out) = &self.normals
                && let Some(n) = rest_attribute(rest.normals, normals, vertex)
            {
                let turned = along(&cofactors(&transform), n).truncate().to_array();
                out.put(i, unit(turned, side).unwrap_or(n));
            }
            if let Some(out) = &self.tangents
                && let Some([x, y, z, hand]) = rest_attribute(rest.tangents, tangents, vertex)
            {
                let turned = along(&transform, [x, y, z]).truncate().to_array();
                let [x, y, z] = unit(turned, 1.0).unwrap_or([x, y, z]);
                out.put(i, [x, y, z, hand]);
            }
        }
        Some(())
    }
}

/// Skins positions of the file's rest mesh. Separate loops, to limit register pressure.
#[cfg_attr(target_os = "none", inline(never))]
fn skin_positions_only(
    skin: &Skin<'_>,
    palette: &[Matrix3x4],
    vertices: Range<usize>,
    out: &Output<'_>,
    scratch: Scratch<'_>,
) {
    let rest = skin.positions().get(vertices.clone()).unwrap_or_default();
    let influences = Influences::new(skin, palette);
    if let Some((indices, weights)) = influences.by_four(vertices.clone()) {
        if scratch.positions(palette, rest, (indices, weights), out).is_some() {
            return;
        }
        // Chunks are faster on the targets of this path, and slower on small processors. The stride is checked to be
        // at least 3; chunks of 0 would panic.
        let chunks = out.floats.chunks(out.stride.max(1));
        for (((rest, out), indices), weights) in rest.iter().zip(chunks).zip(indices).zip(weights) {
            let Some(transform) = influences.blend_row(indices, weights) else { return };
            put(out, moved(&transform, floats(rest)));
        }
        return;
    }
    if skin.envelope_part().is_none() {
        for (i, rest) in rest.iter().enumerate() {
            // Adding 0 turns -0 into +0, as the identity does. The early return prevents unrolling, which is not
            // worth its code size.
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

/// Reads an attribute from the caller's rest mesh, or from the file if the caller has none.
#[inline(always)]
fn rest_attribute<const N: usize>(
    given: Option<&[[f32; N]]>,
    file: &[[Le; N]],
    vertex: usize,
) -> Option<[f32; N]> {
    match given {
        Some(given) => given.get(vertex).copied(),
        None => file.get(vertex).map(floats),
    }
}
