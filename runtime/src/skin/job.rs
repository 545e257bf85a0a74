//! Job of the stage `skin`: the arguments and their checks.

use super::output::{Output, Outputs, check_range};
use super::scratch::{CacheLine, Scratch};
use super::view::Skin;
use crate::error::{Argument, CallError, CallErrorKind};
use crate::linear::Matrix3x4;
use core::ops::Range;

/// Job that skins a range of vertices.
///
/// ```
/// # use sinew_runtime::skin::Output;
/// # use sinew_runtime::{CallError, Matrix3x4, Skin, SkinJob};
/// # fn skin(skin: Skin<'_>, palette: &[Matrix3x4], floats: &mut [f32]) -> Result<(), CallError> {
/// let [positions, normals] = Output::interleaved(floats, 8, [0, 3]);
/// SkinJob::new(skin, palette).positions(positions).normals(normals).run()
/// # }
/// ```
///
/// Each vertex blends its K transforms in the file's order, `sum w_k T_k`. The blended transform m moves the position x
/// by columns, `((m_0 x + m_1 y) + m_2 z) + m_3`. Without an envelope the mesh stays at rest, and directions get
/// length 1.
#[derive(Clone, Debug)]
#[must_use = "a job does nothing until it runs"]
pub struct SkinJob<'a> {
    pub(super) skin: Skin<'a>,
    pub(super) palette: &'a [Matrix3x4],
    /// `None` for all.
    vertices: Option<Range<usize>>,
    pub(super) remap: Option<&'a [u32]>,
    pub(super) rest: Rest<'a>,
    pub(super) positions: Option<Output<'a>>,
    pub(super) normals: Option<Output<'a>>,
    pub(super) tangents: Option<Output<'a>>,
    pub(super) scratch: Scratch<'a>,
}

/// Rest mesh of the caller. The file's arrays replace missing arrays.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Rest<'a> {
    pub(super) positions: Option<&'a [[f32; 3]]>,
    pub(super) normals: Option<&'a [[f32; 3]]>,
    pub(super) tangents: Option<&'a [[f32; 4]]>,
}

impl Skin<'_> {
    /// Returns the cache lines of scratch for [`SkinJob::scratch`]; 0 on firmware.
    pub const fn scratch_len(&self) -> usize {
        Scratch::least(self.palette_len())
    }
}

impl<'a> SkinJob<'a> {
    /// Makes a job of all vertices, without outputs.
    ///
    /// - `palette`: [`Skin::palette_len`] transforms, rest to posed.
    pub fn new(skin: Skin<'a>, palette: &'a [Matrix3x4]) -> Self {
        let (vertices, remap, rest) = (None, None, Rest::default());
        let (positions, normals, tangents) = (None, None, None);
        let scratch = Scratch::default();
        Self { skin, palette, vertices, remap, rest, positions, normals, tangents, scratch }
    }

    /// Sets the range of vertices: of the remap if there is one, else of the skin. Jobs of different ranges can run at
    /// the same time.
    pub fn vertices(self, vertices: Range<usize>) -> Self {
        Self { vertices: Some(vertices), ..self }
    }

    /// Sets the remap: for each engine vertex the skin vertex that it copies. Vertices that were split along seams or
    /// reordered then need no second pass.
    pub fn remap(self, remap: &'a [u32]) -> Self {
        Self { remap: Some(remap), ..self }
    }

    /// Sets the rest positions, for another face or body of the same topology: V positions in the skin's order.
    pub fn rest_positions(mut self, positions: &'a [[f32; 3]]) -> Self {
        self.rest.positions = Some(positions);
        self
    }

    /// Sets the rest normals: V normals of length 1, in the skin's order.
    #[cfg(feature = "normals")]
    pub fn rest_normals(mut self, normals: &'a [[f32; 3]]) -> Self {
        self.rest.normals = Some(normals);
        self
    }

    /// Sets the rest tangents: V tangents of length 1, each with its handedness, in the skin's order.
    #[cfg(feature = "normals")]
    pub fn rest_tangents(mut self, tangents: &'a [[f32; 4]]) -> Self {
        self.rest.tangents = Some(tangents);
        self
    }

    /// Writes positions: 3 floats, in model space.
    pub fn positions(self, positions: impl Into<Option<Output<'a>>>) -> Self {
        Self { positions: positions.into(), ..self }
    }

    /// Writes normals: 3 floats of length 1, outward even if the palette mirrors.
    ///
    /// A skin with tangent coefficients uses the coefficients. If these leave no direction, the transform of the
    /// strongest influence turns the rest normal. A skin without tangent coefficients uses the cofactors of the blended
    /// 3x3. If no direction is left, the result is the rest normal, which may be 0.
    #[cfg(feature = "normals")]
    pub fn normals(self, normals: impl Into<Option<Output<'a>>>) -> Self {
        Self { normals: normals.into(), ..self }
    }

    /// Writes tangents: 3 floats of length 1, then the handedness of the rest pose.
    ///
    /// The tangent follows the tangent coefficients, or without them the blended 3x3. If no direction is left, the
    /// result is the rest tangent.
    #[cfg(feature = "normals")]
    pub fn tangents(self, tangents: impl Into<Option<Output<'a>>>) -> Self {
        Self { tangents: tangents.into(), ..self }
    }

    /// Lends scratch, which makes a job of positions faster: [`Skin::scratch_len`] cache lines of any content. The
    /// results are the same without scratch.
    pub fn scratch(self, scratch: &'a mut [CacheLine]) -> Self {
        Self { scratch: Scratch::new(scratch), ..self }
    }

    /// Returns the start of the range of vertices.
    pub(super) fn start(&self) -> usize {
        self.vertices.as_ref().map_or(0, |vertices| vertices.start)
    }

    /// Returns the range of vertices.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(super) fn range(&self) -> Range<usize> {
        let all = || 0..self.remap.map_or(self.skin.vertex_len(), <[_]>::len);
        self.vertices.clone().unwrap_or_else(all)
    }

    /// Checks every argument. The errors are those of [`SkinJob::run`].
    pub(super) fn check(&self) -> Result<(), CallError> {
        let vertex_len = self.skin.vertex_len();
        let outputs = [&self.positions, &self.normals, &self.tangents].map(Option::as_ref);
        let outputs = Outputs::new(outputs)?;
        Argument::Palette.check_len(self.skin.palette_len(), self.palette.len())?;
        self.scratch.check(self.palette.len())?;
        let Rest { positions, normals, tangents } = self.rest;
        for (argument, found) in [
            (Argument::RestPositions, positions.map(<[_]>::len)),
            (Argument::RestNormals, normals.map(<[_]>::len)),
            (Argument::RestTangents, tangents.map(<[_]>::len)),
        ] {
            argument.check_len(vertex_len, found.unwrap_or(vertex_len))?;
        }
        let Range { start, end } = self.range();
        check_range(&(start..end), self.remap.map_or(vertex_len, <[_]>::len))?;
        let remap = self.remap.and_then(|remap| remap.get(start..end)).unwrap_or_default();
        if let Some(at) = remap.iter().position(|vertex| *vertex as usize >= vertex_len) {
            let found = remap.get(at).map_or(0, |vertex| *vertex as usize);
            let error = CallError::new(CallErrorKind::OutOfRange, Argument::Remap).at(start + at);
            return Err(error.values(vertex_len.saturating_sub(1), found));
        }
        if self.tangents.is_some() && tangents.is_none() && !self.skin.has_tangents() {
            return Err(CallError::new(CallErrorKind::NoAttribute, Argument::Tangents));
        }
        outputs.check(end - start)
    }
}
