//! Stage skin: from the palette to positions, normals and tangents (METHOD §1.8).
//!
//! A loop returns `None` early only if the bytes of the file have changed since loading: the loop then stops at an
//! index that no checked file holds, instead of a panic.

use super::blend::{Influences, along, moved};
use super::counts::EIGHT;
use super::job::SkinJob;
use super::normals::{Frame, Vertex, cofactors, side, unit};
use super::output::{Output, put};
use super::view::{Row, Skin, float, of_vertex, rows_of};
use crate::error::{Argument, CallError};
use crate::linear::Matrix3x4;
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
        skin_positions_only(self, palette, vertices, &out);
        Ok(())
    }
}

impl SkinJob<'_> {
    /// Runs the job.
    ///
    /// The palette's numbers are not checked. A transform that is not finite gives such vertices, also among their
    /// neighbours: a vertex can have the transform with weight 0.
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
        // Small processors have no vector units.
        #[cfg(not(target_os = "none"))]
        if super::vectors::run(self).is_some() {
            return Ok(());
        }
        let Self { skin, palette, remap, rest, .. } = self;
        match (&self.positions, &self.normals, &self.tangents) {
            (Some(out), None, None) if remap.is_none() && rest.positions.is_none() => {
                skin_positions_only(skin, palette, self.range(), out);
            }
            _ => {
                self.one_by_one(0..self.range().len());
            }
        }
        Ok(())
    }

    /// Skins vertices, one at a time, without vector units. Checks nothing.
    ///
    /// - `part`: a part of `0..n`, of the n vertices of the range.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(super) fn one_by_one(&self, part: Range<usize>) -> Option<()> {
        match self.skin.has_coefficients() && (self.normals.is_some() || self.tangents.is_some()) {
            true => self.skin_by_coefficients(part),
            false => self.skin_by_blend(part),
        }
    }

    /// Returns the skin vertex of the i-th vertex of the range.
    #[inline(always)]
    pub(super) fn vertex(&self, i: usize) -> Option<usize> {
        let at = self.start() + i;
        self.remap.map_or(Some(at), |remap| Some(*remap.get(at)? as usize))
    }

    /// Skins vertices with tangent coefficients, one at a time.
    #[cfg_attr(target_os = "none", inline(never))]
    fn skin_by_coefficients(&self, part: Range<usize>) -> Option<()> {
        let Self { skin, palette, rest, .. } = self;
        let influences = Influences::new(skin, palette);
        let (positions, normals, tangents) = (skin.positions(), skin.normals(), skin.tangents());
        let (coefficients, len) = (skin.coefficients(), skin.influence_len().saturating_sub(1));
        let side = side(palette);
        for i in part {
            let vertex = self.vertex(i)?;
            let (indices, weights) = influences.rows(vertex)?;
            let transform = influences.blend_rows((indices, weights), vertex)?;
            let coefficients = rows_of(coefficients, len, vertex)?;
            let own = Vertex { palette, vertex, indices, weights, coefficients };
            let x = rest_attribute(rest.positions, positions, vertex)?;
            let n = rest_attribute(rest.normals, normals, vertex)?;
            let tangent = rest_attribute(rest.tangents, tangents, vertex);
            let frame = match tangent.filter(|_| skin.has_tangents()) {
                Some([x, y, z, _]) => Frame::of_tangent(n, [x, y, z]),
                None => Frame::of_normal(n, of_vertex(normals, vertex)?[2]),
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

    /// Skins vertices without tangent coefficients by their blended transforms.
    #[inline(always)]
    fn skin_by_blend(&self, part: Range<usize>) -> Option<()> {
        let Self { skin, palette, rest, .. } = self;
        let influences = Influences::new(skin, palette);
        let (positions, normals, tangents) = (skin.positions(), skin.normals(), skin.tangents());
        let side = side(palette);
        for i in part {
            let vertex = self.vertex(i)?;
            let transform = influences.blend(vertex)?;
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

/// Skins positions of the file's rest mesh. A separate loop, to limit register pressure.
#[cfg_attr(target_os = "none", inline(never))]
fn skin_positions_only(
    skin: &Skin<'_>,
    palette: &[Matrix3x4],
    vertices: Range<usize>,
    out: &Output<'_>,
) -> Option<()> {
    let (influences, positions) = (Influences::new(skin, palette), skin.positions());
    let (mut vertex, mut at) = (vertices.start, 0);
    while vertex < vertices.end {
        // The vertices of a block share their rows.
        let (rest, rows) = (positions.get(vertex / EIGHT)?, influences.rows(vertex)?);
        for lane in vertex % EIGHT..EIGHT.min(vertex % EIGHT + vertices.end - vertex) {
            let transform = influences.blend_rows(rows, lane)?;
            let rest = [float(&rest[0], lane), float(&rest[1], lane), float(&rest[2], lane)];
            put(out.floats.get(at..)?, moved(&transform, rest))?;
            at += out.stride;
        }
        vertex += EIGHT - vertex % EIGHT;
    }
    Some(())
}

/// Reads an attribute from the caller's rest mesh, or from the file if the caller has none.
#[inline(always)]
fn rest_attribute<const N: usize>(
    given: Option<&[[f32; N]]>,
    file: &[[Row; N]],
    vertex: usize,
) -> Option<[f32; N]> {
    match given {
        Some(given) => given.get(vertex).copied(),
        None => of_vertex(file, vertex),
    }
}
